//! What a cast takes does not depend on the SIMD level, and counting it changes no hit.

use fearless_simd::dispatch;
use reflet_accel::{
    Accel, HitCode, Hits, Isa, Question, RayCounts, Rays, Scratch, Structure, Way, Work,
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

fn geometry(n: usize) -> Geometry {
    let (mut geometry, mut next) = (Geometry::default(), dice());
    for i in 0..n {
        let at = [next(), next(), next()];
        if i % 3 == 0 {
            let mut corner = || at.map(|x| x + 0.05 * next());
            geometry.push_triangle([corner(), corner(), corner()]);
        } else {
            geometry.push_sphere(at, 0.01 + 0.01 * next().abs());
        }
    }
    geometry
}

/// From one eye, towards one place, and every way.
fn streams() -> [Rays; 3] {
    let mut next = dice();
    let (mut eye, mut end, mut wild) = (Rays::default(), Rays::default(), Rays::default());
    for i in 0..1000 {
        let at = [next(), next(), next()];
        let over = [(i % 32) as f32 / 16.0 - 1.0, (i / 32) as f32 / 16.0 - 1.0, 0.0];
        for (rays, from, to, share) in [
            (&mut eye, [0.1, 0.2, 4.0], over, f32::INFINITY),
            (&mut end, over, [0.0, 3.0, 0.5], 1.0),
            (&mut wild, at, [next(), next(), next()], f32::INFINITY),
        ] {
            let way: [f32; 3] = std::array::from_fn(|k| to[k] - from[k]);
            let length = way.iter().map(|x| x * x).sum::<f32>().sqrt();
            rays.push(from, way.map(|x| x / length), share * length, HitCode::NONE);
        }
    }
    [eye, end, wild].map(|mut rays| {
        rays.pad();
        rays
    })
}

#[test]
fn every_level_takes_the_same_steps_to_the_same_hits() {
    let streams = streams();
    let (mut scratch, mut counts) = (Scratch::default(), RayCounts::default());
    for (n, structure) in [(20, Structure::List), (3000, Structure::Tree)] {
        let geometry = geometry(n);
        let level = Isa::Auto.level().unwrap();
        let mut accel = Accel::build(&geometry, level, structure);
        for way in [Way::Auto, Way::Bundles, Way::Singly] {
            accel.cast_by(way);
            for (rays, question) in
                streams.iter().flat_map(|r| [Question::Closest, Question::Any].map(|q| (r, q)))
            {
                let mut hits = Hits::default();
                let work = accel.count(rays, question, &mut hits, &mut scratch);
                assert!(work.tests > 0 && (0.0..=1.0).contains(&work.occupancy()), "{work:?}");
                assert_eq!(work.nodes == 0, structure == Structure::List, "{work:?}");
                match question {
                    Question::Closest => {
                        let mut plain = Hits::default();
                        accel.closest(rays, &mut plain, &mut scratch, &mut counts);
                        assert_eq!((hits.t, hits.code), (plain.t, plain.code));
                    }
                    Question::Any => {
                        let mut plain = Vec::new();
                        accel.any(rays, &mut plain, &mut scratch, &mut counts);
                        let codes = hits.code[..rays.len()].iter();
                        assert!(codes.map(|code| !code.is_none()).eq(plain));
                    }
                }
                for isa in Isa::available() {
                    let (level, hits) = (isa.level().unwrap(), &mut Hits::default());
                    let again: Work = dispatch!(level, simd => {
                        accel.count_on(simd, rays, question, hits, &mut scratch)
                    });
                    assert_eq!(again, work, "{} {way:?} {question:?} {structure:?}", isa.name());
                }
            }
        }
    }
}

#[test]
fn a_ray_alone_is_held_against_the_primitives_of_a_block() {
    let mut geometry = Geometry::default();
    for z in [0.0, -3.0, -6.0] {
        geometry.push_sphere([0.0, 0.0, z], 1.0);
    }
    let mut accel = Accel::build(&geometry, Isa::Scalar.level().unwrap(), Structure::Tree);
    accel.cast_by(Way::Singly);
    let mut rays = Rays::default();
    rays.push([0.0, 0.0, 5.0], [0.0, 0.0, -1.0], f32::INFINITY, HitCode::NONE);
    rays.pad();
    let (mut hits, mut scratch) = (Hits::default(), Scratch::default());
    let work = accel.count(&rays, Question::Closest, &mut hits, &mut scratch);
    assert_eq!(work, Work { nodes: 1, kernels: 1, lanes: 8, tests: 3 });
    assert_eq!(work.occupancy(), 3.0 / 8.0);
    assert_eq!(work.steps(), 4);
}

/// A ball fills the view of four groups of sixteen; a leaf of eight is held against so few rays that
/// each goes alone.
#[test]
fn a_bundle_is_held_against_a_primitive_by_groups_or_by_ray() {
    let (mut rays, mut hits, mut scratch) = (Rays::default(), Hits::default(), Scratch::default());
    for i in 0..64 {
        let [x, y] = [i % 8, i / 8].map(|k| (k as f32 - 3.5) / 80.0);
        let length = (x * x + y * y + 1.0).sqrt();
        let dir = [x, y, -1.0].map(|c| c / length);
        rays.push([0.0, 0.0, 5.0], dir, f32::INFINITY, HitCode::NONE);
    }
    rays.pad();
    let level = Isa::Scalar.level().unwrap();
    let mut one = Geometry::default();
    one.push_sphere([0.0; 3], 1.0);
    // Small, and in a row behind one pixel.
    let mut eight = Geometry::default();
    for i in 0..8 {
        let way = 5.0 + 0.1 * i as f32;
        eight.push_sphere([way * 0.5 / 80.0, way * 0.5 / 80.0, 5.0 - way], 0.01);
    }
    for (geometry, lanes) in [(one, 4 * 16), (eight, 8)] {
        let mut accel = Accel::build(&geometry, level, Structure::Tree);
        accel.cast_by(Way::Bundles);
        let work = accel.count(&rays, Question::Closest, &mut hits, &mut scratch);
        assert_eq!(work.lanes % lanes, 0, "{work:?}");
        assert_eq!(work.lanes / work.kernels.max(1), lanes.min(16), "{work:?}");
    }
}

/// Balls in a row are behind each other for a ray along it: whichever way it runs, it needs no
/// more than the leaf that it meets first. A row along a diagonal, so that each octant counts.
#[test]
fn rays_alone_visit_what_is_nearest_first() {
    let (mut scratch, mut hits) = (Scratch::default(), Hits::default());
    for octant in 0..8 {
        let sign = [0, 1, 2].map(|k| if octant >> k & 1 == 1 { -1.0 } else { 1.0 });
        let mut geometry = Geometry::default();
        for i in 0..64 {
            geometry.push_sphere(sign.map(|s| s * (i as f32 - 31.5)), 0.25);
        }
        let mut accel = Accel::build(&geometry, Isa::Scalar.level().unwrap(), Structure::Tree);
        accel.cast_by(Way::Singly);
        let mut rays = Rays::default();
        let dir = sign.map(|s| s / 3f32.sqrt());
        rays.push(sign.map(|s| s * -40.0), dir, f32::INFINITY, HitCode::NONE);
        rays.pad();
        let work = accel.count(&rays, Question::Closest, &mut hits, &mut scratch);
        assert_eq!((hits.code[0].prim().map(|p| p.0), work.kernels), (Some(0), 1), "{octant}");
    }
}
