//! Rays and primitives that are none, or nearly none: no false hit, the same on every level, and no
//! more work than ordinary ones.

use reflet_accel::{
    Accel, HitCode, Hits, Isa, Question, Rays, Scratch, Structure, Way, Work, brute,
};
use reflet_pack::Geometry;

/// A small generator of its own: the same scenes on every machine.
struct Dice(u64);

impl Dice {
    /// -1..1.
    fn float(&mut self) -> f32 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 23) as f32 - 1.0
    }

    fn point(&mut self) -> [f32; 3] {
        [self.float(), self.float(), self.float()]
    }
}

const PRIMS: usize = 3000;
const RAYS: usize = 4096;

/// Spheres and triangles; if `odd`, half of the triangles have no area: a line or a point.
fn geometry(odd: bool) -> Geometry {
    let (mut dice, mut g) = (Dice(3), Geometry::default());
    for i in 0..PRIMS {
        let a = dice.point();
        let [b, c] = [(); 2].map(|()| {
            let way = dice.point();
            [0, 1, 2].map(|k| a[k] + 0.05 * way[k])
        });
        match i % 4 {
            0 => g.push_sphere(a, 0.02),
            1 if odd => g.push_triangle([a, b, b]),
            2 if odd => g.push_triangle([a, a, a]),
            _ => g.push_triangle([a, b, c]),
        };
    }
    g
}

/// Ordinary rays; if `odd`, each has something the matter with it.
fn rays(odd: bool) -> Rays {
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, -0.0, 1e-40, -1e-40, f32::MAX];
    let (mut dice, mut rays) = (Dice(4), Rays::default());
    for i in 0..RAYS {
        let (mut o, d) = (dice.point(), dice.point());
        let length = d.iter().map(|x| x * x).sum::<f32>().sqrt();
        let mut d = d.map(|x| x / length);
        let mut end = f32::INFINITY;
        let x = bad[i / 8 % bad.len()];
        if odd {
            match i % 8 {
                0 => d[0] = x,
                1 => d = [x; 3],
                2 => o[1] = x,
                3 => end = x,
                4 => (d[0], d[1]) = (x, x),
                5 => o = [x; 3],
                6 => d = d.map(|y| y * 1e-30),
                _ => d = d.map(|y| y * 1e-23),
            }
        }
        rays.push(o, d, end, HitCode::NONE);
    }
    rays.pad();
    rays
}

fn work(g: &Geometry, rays: &Rays, question: Question) -> Work {
    let accel = Accel::build(g, Isa::Auto.level().expect("always"), Structure::Tree);
    accel.count(rays, question, &mut Hits::default(), &mut Scratch::default())
}

#[test]
fn odd_rays_and_flat_triangles_hit_the_same_on_every_level() {
    for g in [geometry(false), geometry(true)] {
        for rays in [rays(false), rays(true)] {
            let want: Vec<_> = (0..rays.len())
                .map(|i| {
                    let at = |columns: &[Vec<f32>; 3]| [0, 1, 2].map(|k| columns[k][i]);
                    let (o, d) = (at(&rays.origin), at(&rays.dir));
                    brute::closest(&g, (o, d), (rays.t_min[i], rays.t_max[i]), rays.last[i])
                })
                .collect();
            for isa in Isa::available() {
                let level = isa.level().expect("available");
                for structure in [Structure::List, Structure::Tree] {
                    let mut accel = Accel::build(&g, level, structure);
                    for way in [Way::Auto, Way::Bundles, Way::Singly] {
                        accel.cast_by(way);
                        let (hits, scratch) = (&mut Hits::default(), &mut Scratch::default());
                        accel.closest(&rays, hits, scratch, &mut Default::default());
                        for (i, (t, code)) in want.iter().enumerate() {
                            let got = (hits.t[i].to_bits(), hits.code[i]);
                            let how = format!("ray {i}, {} {structure:?} {way:?}", isa.name());
                            assert_eq!(got, (t.to_bits(), *code), "{how}");
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn what_is_no_number_hits_nothing() {
    let (g, rays) = (geometry(true), rays(true));
    let accel = Accel::build(&g, Isa::Auto.level().expect("always"), Structure::Tree);
    let mut hits = Hits::default();
    accel.closest(&rays, &mut hits, &mut Scratch::default(), &mut Default::default());
    let mut hit = 0;
    for i in 0..rays.len() {
        let numbers = [0, 1, 2].map(|k| [rays.origin[k][i], rays.dir[k][i]]);
        let is_ray = numbers.iter().flatten().all(|x| x.is_finite()) && !rays.t_max[i].is_nan();
        hit += usize::from(!hits.code[i].is_none());
        assert!(is_ray || hits.code[i].is_none(), "ray {i} hit {:?}", hits.code[i]);
        if let Some(prim) = hits.code[i].prim() {
            // Triangles without area have no inside.
            let flat = matches!(prim.0 % 4, 1 | 2);
            assert!(!flat, "ray {i} hit {prim:?}");
        }
    }
    assert!(hit > 0);
}

/// Counted, not timed, so that the test says the same on every machine.
#[test]
fn odd_ones_take_no_more_work() {
    for question in [Question::Closest, Question::Any] {
        let ordinary = work(&geometry(false), &rays(false), question).steps() as f64;
        let odd_rays = work(&geometry(false), &rays(true), question).steps() as f64;
        let flat = work(&geometry(true), &rays(false), question).steps() as f64;
        assert!(odd_rays <= 1.2 * ordinary, "{odd_rays} {ordinary}");
        assert!(flat <= 1.2 * ordinary, "{flat} {ordinary}");
    }
}
