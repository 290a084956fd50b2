//! Spheres a million radii away, held against the same roots in `f64`.
//!
//! With r the radius and D the distance of the centre, the centre relative to the ray errs by a unit
//! of D; so does what the direction leaves of it across the ray (a unit vector in `f32` is off by
//! 2^-24 or so a component). The discriminant r² - a² of the way a across the ray then errs by about
//! 2 a D 2^-22, its root by that over twice the root, and t besides by some units of D. That is the
//! bound held here; where the root is smaller than that error no `f32` can tell a hit from a miss.

use reflet_accel::{Accel, HitCode, Hits, Isa, RayCounts, Rays, Scratch, Structure};
use reflet_pack::Geometry;

/// A small generator of its own: the same rays on every machine.
struct Dice(u64);

impl Dice {
    /// -1..1.
    fn float(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / f64::from(1 << 23) - 1.0
    }

    fn unit(&mut self) -> [f64; 3] {
        loop {
            let v = [self.float(), self.float(), self.float()];
            let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
            if (0.1..1.0).contains(&length) {
                return v.map(|x| x / length);
            }
        }
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// What is found of rays at one distance, over the radius.
#[derive(Debug, Default)]
struct Found {
    rays: usize,
    /// Decided otherwise than in `f64`.
    wrong: usize,
    /// The greatest error of t, over the radius.
    worst: f64,
    /// The greatest error over the bound.
    over_bound: f64,
}

fn at(ratio: f64) -> Found {
    const COUNT: usize = 20_000;
    let mut dice = Dice(17);
    let mut found = Found::default();
    let (mut g, mut rays, mut wide) = (Geometry::default(), Rays::default(), Vec::new());
    g.push_sphere([0.25, -0.5, 0.125], 1.0);
    let center = [0.25, -0.5, 0.125];
    for _ in 0..COUNT {
        let from = dice.unit();
        let o = [0, 1, 2].map(|k| (center[k] + ratio * from[k]) as f32);
        // Across the whole sphere and a little beyond its rim.
        let rim = dice.unit();
        let to = [0, 1, 2].map(|k| center[k] + 1.1 * rim[k] * dice.float().abs().sqrt());
        let way = [0, 1, 2].map(|k| to[k] - f64::from(o[k]));
        let length = dot(way, way).sqrt();
        let d = way.map(|x| (x / length) as f32);
        rays.push(o, d, f32::INFINITY, HitCode::NONE);
        wide.push((o.map(f64::from), d.map(f64::from)));
    }
    rays.pad();
    let accel = Accel::build(&g, Isa::Auto.level().expect("always"), Structure::Auto);
    let mut hits = Hits::default();
    accel.closest(&rays, &mut hits, &mut Scratch::default(), &mut RayCounts::default());
    for (i, (o, d)) in wide.into_iter().enumerate() {
        found.rays += 1;
        // The very ray of the columns; its direction need not be quite a unit vector.
        let l = [0, 1, 2].map(|k| center[k] - o[k]);
        let (a, b) = (dot(d, d), dot(l, d));
        let across = [0, 1, 2].map(|k| l[k] - b / a * d[k]);
        let disc = (1.0 - dot(across, across)) / a;
        let unit = f64::from(f32::EPSILON);
        let error = 4.0 * ratio * unit * dot(across, across).sqrt().max(unit * ratio);
        if disc.abs() <= 2.0 * error {
            continue;
        }
        let is_hit = !hits.code[i].is_none();
        found.wrong += usize::from(is_hit != (disc > 0.0));
        if is_hit && disc > 0.0 {
            let want = b / a - disc.sqrt();
            let off = (f64::from(hits.t[i]) - want).abs();
            // The boxes' outward rounding may enter in place of the sphere's own root.
            let bound = error / disc.sqrt() + 8.0 * ratio * unit + 1e-6;
            found.worst = found.worst.max(off);
            found.over_bound = found.over_bound.max(off / bound);
        }
    }
    found
}

#[test]
fn spheres_are_hit_as_far_as_f32_goes() {
    for power in 0..=6 {
        let ratio = 2.0 * 10f64.powi(power);
        let found = at(ratio);
        println!(
            "distance/radius {ratio:9}: {} rays, {} wrong, t off by {:.1e} radii at most, {:.2} of the bound",
            found.rays, found.wrong, found.worst, found.over_bound
        );
        assert_eq!(found.wrong, 0, "{ratio}: {found:?}");
        assert!(found.over_bound <= 1.0, "{ratio}: {found:?}");
    }
}
