//! Shadow rays are put in the order in which their light sees them where that pays, and no answer
//! depends on it.

use fearless_simd::dispatch;
use reflet_accel::{
    Accel, HitCode, Hits, Isa, PrimId, Question, RayCounts, Rays, Scratch, Structure, Way, Work,
    brute,
};
use reflet_pack::Geometry;

/// Numbers in 0..1, the same on every machine.
fn dice() -> impl FnMut() -> f32 {
    let mut state = 1u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963);
        (state >> 40) as f32 / (1 << 24) as f32
    }
}

/// Balls in a cube from -1 to 1.
fn balls() -> Geometry {
    let (mut geometry, mut next) = (Geometry::default(), dice());
    for _ in 0..20_000 {
        let at = [next(), next(), next()].map(|x| 2.0 * x - 1.0);
        geometry.push_sphere(at, 0.01);
    }
    geometry
}

/// Rays from anywhere in the cube to a light: neighbours have nothing in common but their end. One
/// of so many is odd, if any.
fn to(light: [f32; 3], count: usize, odd: Option<usize>) -> Rays {
    let (mut rays, mut next) = (Rays::default(), dice());
    for i in 0..count {
        let mut from = [next(), next(), next()].map(|x| 2.0 * x - 1.0);
        let way: [f32; 3] = std::array::from_fn(|k| light[k] - from[k]);
        let length = way.iter().map(|x| x * x).sum::<f32>().sqrt();
        let mut dir = way.map(|x| x / length);
        let mut end = length;
        if odd.is_some_and(|every| i % every == every - 1) {
            match i / odd.unwrap_or(1) % 4 {
                0 => dir = [0.0; 3],
                1 => from[1] = f32::NAN,
                2 => end = -1.0,
                _ => from[0] = f32::INFINITY,
            }
        }
        let last = PrimId((next() * 20_000.0) as u32);
        rays.push(from, dir, end, HitCode::outside(last));
        if i % 5 == 0 {
            rays.t_min[i] = next();
        }
    }
    rays.pad();
    rays
}

/// How many rays of a stream are put in order at once, and some that are left over.
const MANY: usize = (1 << 16) + 4_500;

/// Streams, and whether their rays are to be put in order: those of a sun, which end nowhere; towards
/// a light, another beside the corner of its cube map, and with odd rays among them; so few that they
/// have hardly other neighbours; and towards two lights.
fn streams() -> Vec<(&'static str, Rays, bool)> {
    let far = [3.0, 9.0, 2.0];
    let mut lights = to(far, MANY / 2, None);
    let other = to([-9.0, 1.0, 2.0], MANY / 2, None);
    (0..other.len()).for_each(|i| lights.push_from(&other, i));
    lights.pad();
    let mut sun = to([300.0, 900.0, 200.0], MANY, None);
    sun.t_max.fill(f32::INFINITY);
    vec![
        ("a sun", sun, false),
        ("one light", to(far, MANY, None), true),
        ("a corner", to([20.0, 20.0, 20.0], MANY, None), true),
        ("odd rays", to(far, MANY, Some(50)), true),
        ("few rays", to(far, 500, None), false),
        ("two lights", lights, false),
    ]
}

#[test]
fn the_order_of_shadow_rays_changes_no_answer() {
    let (geometry, mut scratch) = (balls(), Scratch::default());
    let (mut hits, mut counts) = (Hits::default(), RayCounts::default());
    for (name, rays, in_order) in streams() {
        let level = Isa::Auto.level().unwrap();
        let mut accel = Accel::build(&geometry, level, Structure::Tree);
        let work = accel.count(&rays, Question::Any, &mut hits, &mut scratch);
        let mut found = Vec::new();
        accel.any(&rays, &mut found, &mut scratch, &mut counts);
        let share = found.iter().filter(|occluded| **occluded).count() as f64 / rays.len() as f64;
        assert!((0.2..0.8).contains(&share), "{name}: {share}");
        let hit = hits.code[..rays.len()].iter().map(|code| !code.is_none());
        assert!(hit.eq(found.iter().copied()), "{name}: counted");
        for i in (0..rays.len()).step_by(97) {
            let at = |c: &[Vec<f32>; 3]| [c[0][i], c[1][i], c[2][i]];
            let ends = (rays.t_min[i], rays.t_max[i]);
            let ray = (at(&rays.origin), at(&rays.dir));
            let (_, code) = brute::closest(&geometry, ray, ends, rays.last[i]);
            assert_eq!(found[i], !code.is_none(), "{name}: ray {i}");
        }
        // Each ray on its own way, in the order of the stream.
        accel.cast_by(Way::Singly);
        let mut alone = Vec::new();
        accel.any(&rays, &mut alone, &mut scratch, &mut counts);
        assert!(found == alone, "{name}");
        let single = accel.count(&rays, Question::Any, &mut hits, &mut scratch);
        assert_eq!(2 * work.nodes < single.nodes, in_order, "{name}: {work:?} {single:?}");
        accel.cast_by(Way::Auto);
        for isa in Isa::available() {
            let level = isa.level().unwrap();
            let mut again = Vec::new();
            let accel = Accel::build(&geometry, level, Structure::Tree);
            accel.any(&rays, &mut again, &mut scratch, &mut counts);
            assert!(found == again, "{name}: {}", isa.name());
            let steps: Work = dispatch!(level, simd => {
                accel.count_on(simd, &rays, Question::Any, &mut hits, &mut scratch)
            });
            assert_eq!(steps, work, "{name}: {}", isa.name());
        }
    }
}
