//! Rays of a bundle that go singly set out from their own entry points, and no hit depends on it.

use fearless_simd::dispatch;
use reflet_accel::{
    Accel, HitCode, Hits, Isa, Question, RayCounts, Rays, Scratch, Structure, Way, Work, brute,
};
use reflet_pack::Geometry;

/// Numbers in -1..1, the same on every machine.
fn dice() -> impl FnMut() -> f32 {
    let mut state = 1u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963);
        (state >> 40) as f32 / (1 << 23) as f32 - 1.0
    }
}

/// Balls in a cube from -1 to 1.
fn cloud() -> Geometry {
    let (mut geometry, mut next) = (Geometry::default(), dice());
    for _ in 0..20_000 {
        geometry.push_sphere([next(), next(), next()], 0.01);
    }
    geometry
}

/// Balls in a row along x, hardly apart.
fn row() -> Geometry {
    let mut geometry = Geometry::default();
    for i in 0..4096 {
        geometry.push_sphere([i as f32, 0.0, 0.0], 0.45);
    }
    geometry
}

/// Rays from near some place along a direction or, without one, every way.
fn rays(at: [f32; 3], apart: f32, dir: Option<[f32; 3]>, end: f32) -> Rays {
    let (mut rays, mut next) = (Rays::default(), dice());
    for i in 0..2000 {
        let from = at.map(|x| x + apart * next());
        let way = dir.unwrap_or_else(|| [next(), next(), next()]);
        let length = way.iter().map(|x| x * x).sum::<f32>().sqrt();
        // Some are odd.
        let dir = if i % 50 == 49 { [0.0; 3] } else { way.map(|x| x / length) };
        rays.push(from, dir, end * (1.5 + next()), HitCode::NONE);
    }
    rays.pad();
    rays
}

/// The same rays, each with so many beside it that hit nothing that it is alone in its bundle.
fn lonely(rays: &Rays) -> Rays {
    let mut lonely = Rays::default();
    for i in 0..rays.len() {
        lonely.push_from(rays, i);
        (1..64).for_each(|_| lonely.push([0.0; 3], [0.0; 3], -1.0, HitCode::NONE));
    }
    lonely.pad();
    lonely
}

#[test]
fn rays_that_start_together_share_the_upper_levels_of_the_tree() {
    let (mut scratch, mut counts) = (Scratch::default(), RayCounts::default());
    let inf = f32::INFINITY;
    for (name, geometry, rays) in [
        ("amid a cloud", cloud(), rays([0.1, 0.2, 0.3], 0.01, None, inf)),
        ("short", cloud(), rays([0.1, 0.2, 0.3], 0.01, None, 0.1)),
        ("beside it", cloud(), rays([0.0, 1.1, 0.0], 0.02, None, inf)),
        // Each bundle meets more boxes than it can have entry points, and hits nothing.
        ("along a row", row(), rays([-9.0, 0.42, 0.42], 0.01, Some([1.0, 0.0, 0.0]), 5000.0)),
    ] {
        for question in [Question::Closest, Question::Any] {
            let level = Isa::Auto.level().unwrap();
            let mut accel = Accel::build(&geometry, level, Structure::Tree);
            accel.cast_by(Way::Singly);
            let (mut hits, mut apart) = (Hits::default(), Hits::default());
            let together = accel.count(&rays, question, &mut hits, &mut scratch);
            let alone = accel.count(&lonely(&rays), question, &mut apart, &mut scratch);
            // The root is the least that they share.
            let spared = together.nodes + rays.len() as u64 * 9 / 10;
            assert!(spared < alone.nodes, "{name}: {together:?} {alone:?}");
            for i in 0..rays.len() {
                let (t, code) = (hits.t[i], hits.code[i]);
                match question {
                    Question::Closest => {
                        assert_eq!((t, code), (apart.t[64 * i], apart.code[64 * i]), "{name}: {i}")
                    }
                    Question::Any => {
                        assert_eq!(code.is_none(), apart.code[64 * i].is_none(), "{name}: {i}")
                    }
                }
                if i % 49 == 0 {
                    let at = |c: &[Vec<f32>; 3]| [c[0][i], c[1][i], c[2][i]];
                    let (ray, ends) = ((at(&rays.origin), at(&rays.dir)), (0.0, rays.t_max[i]));
                    let own = brute::closest(&geometry, ray, ends, HitCode::NONE);
                    assert_eq!(own.1.is_none(), code.is_none(), "{name}: {i}");
                    assert!(question == Question::Any || own == (t, code), "{name}: {i}");
                }
            }
            for isa in Isa::available() {
                let mut again = Hits::default();
                let steps: Work = dispatch!(isa.level().unwrap(), simd => {
                    accel.count_on(simd, &rays, question, &mut again, &mut scratch)
                });
                assert_eq!(steps, together, "{name}: {}", isa.name());
                assert_eq!((&again.t, &again.code), (&hits.t, &hits.code), "{name}");
            }
            let mut plain = Hits::default();
            if question == Question::Closest {
                accel.closest(&rays, &mut plain, &mut scratch, &mut counts);
                assert_eq!((&plain.t, &plain.code), (&hits.t, &hits.code), "{name}");
            }
        }
    }
}
