//! Trees do not depend on the number of threads, nor hits on the quality of a tree.

use reflet_accel::{
    Accel, HitCode, Hits, Isa, Quality, Question, RayCounts, Rays, Refit, Scratch, Slot, Structure,
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

/// So many that the largest branches are sorted by several threads.
const MANY: usize = 150_000;

fn geometry(shift: f32) -> Geometry {
    let (mut g, mut next) = (Geometry::default(), dice());
    for i in 0..MANY {
        let at = [next() + shift, next(), next()];
        if i % 5 == 0 {
            let mut corner = || at.map(|x| x + 0.01 * next());
            g.push_triangle([corner(), corner(), corner()]);
        } else {
            g.push_sphere(at, 0.005);
        }
    }
    g
}

fn rays() -> Rays {
    let (mut rays, mut next) = (Rays::default(), dice());
    for _ in 0..4096 {
        let (o, d) = ([next(), next(), next()], [next(), next(), next()]);
        let length = d.iter().map(|x| x * x).sum::<f32>().sqrt();
        rays.push(o, d.map(|x| x / length), f32::INFINITY, HitCode::NONE);
    }
    rays.pad();
    rays
}

fn cast(accel: &Accel, rays: &Rays) -> (Vec<u32>, Vec<HitCode>) {
    let mut hits = Hits::default();
    accel.closest(rays, &mut hits, &mut Scratch::default(), &mut RayCounts::default());
    (hits.t.iter().map(|t| t.to_bits()).collect(), hits.code)
}

fn build(g: &Geometry, threads: usize, quality: Quality) -> Accel {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let level = Isa::Auto.level().expect("always");
    pool.install(|| Accel::build_as(g, level, Structure::Auto, quality))
}

#[test]
fn trees_are_the_same_on_any_number_of_threads() {
    let (g, rays) = (geometry(0.0), rays());
    let measure = |threads| {
        let accel = build(&g, threads, Quality::Balanced);
        let work =
            accel.count(&rays, Question::Closest, &mut Hits::default(), &mut Scratch::default());
        (accel.sah_cost().to_bits(), accel.bytes(), work)
    };
    let alone = measure(1);
    for threads in [2, 5] {
        assert_eq!(measure(threads), alone, "{threads} threads");
    }
}

#[test]
fn hits_do_not_depend_on_the_quality() {
    let (g, rays) = (geometry(0.0), rays());
    let balanced = build(&g, 2, Quality::Balanced);
    let want = cast(&balanced, &rays);
    for quality in [Quality::Fast, Quality::High] {
        let accel = build(&g, 2, quality);
        assert_eq!(cast(&accel, &rays), want, "{quality:?}");
    }
    let high = build(&g, 2, Quality::High).sah_cost();
    assert!(high <= 1.02 * balanced.sah_cost(), "{high} {}", balanced.sah_cost());
}

#[test]
fn shapes_in_one_place_or_without_end_are_built() {
    let (mut g, rays) = (Geometry::default(), rays());
    for i in 0..2000 {
        let size = if i % 3 == 0 { 1e30 } else { 0.5 };
        g.push_sphere([0.25, 0.5, if i % 3 == 1 { 3e38 } else { 0.125 }], size);
    }
    let level = Isa::Auto.level().expect("always");
    let tree = Accel::build(&g, level, Structure::Tree);
    let list = Accel::build(&g, level, Structure::List);
    assert_eq!(cast(&tree, &rays), cast(&list, &rays));
}

#[test]
fn boxes_whose_centres_are_no_numbers_are_sorted() {
    for many in [100, MANY] {
        let (mut g, mut next) = (Geometry::default(), dice());
        for i in 0..many {
            g.push_sphere([next(), next(), next()], 0.001);
            if i % 7 == 3 {
                g.bounds[i].lo[i % 3] = f32::NAN;
            }
        }
        for quality in [Quality::Fast, Quality::Balanced, Quality::High] {
            assert_eq!(build(&g, 1, quality).bytes(), build(&g, 2, quality).bytes());
        }
    }
}

#[test]
fn a_tree_most_of_which_has_moved_is_built_anew() {
    let (from, to, rays) = (geometry(0.0), geometry(0.001), rays());
    let mut accel = build(&from, 2, Quality::Balanced);
    let some: Vec<Slot> = (0..MANY as u32 / 2).map(Slot).collect();
    assert_eq!(accel.refit(&from, &some), Refit::Refitted);
    let all: Vec<Slot> = (0..MANY as u32).map(Slot).collect();
    assert_eq!(accel.refit(&to, &all), Refit::Rebuilt);
    assert_eq!(cast(&accel, &rays), cast(&build(&to, 1, Quality::Balanced), &rays));
}
