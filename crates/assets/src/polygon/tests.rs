//! Polygons of every kind, covered.

use super::*;

fn cut(corners: &[[f32; 3]]) -> (Vec<[usize; 3]>, Cut) {
    let mut triangles = Vec::new();
    let cut = triangulate(corners, &mut |triangle| triangles.push(triangle));
    (triangles, cut)
}

/// All triangles face the way of the polygon, and they are as many as it takes. So they cover it
/// and nothing else: of each point the number of triangles that it is in is its winding number.
fn covers(corners: &[[f32; 3]], triangles: usize) {
    let (found, cut) = cut(corners);
    let spanned: Vec<[f64; 3]> = found.iter().map(|t| area(t.map(|i| corners[i]))).collect();
    let sum = |parts: &[[f64; 3]]| {
        parts.iter().fold([0.0; 3], |sum, part| [0, 1, 2].map(|k| sum[k] + part[k]))
    };
    let fan: Vec<[f64; 3]> =
        (1..corners.len() - 1).map(|i| area([corners[0], corners[i], corners[i + 1]])).collect();
    let whole = sum(&fan);
    assert!(spanned.iter().all(|part| dot(*part, whole) > 0.0), "{found:?}");
    assert_eq!((found.len(), cut), (triangles, Cut::Whole));
    // Sums of up to 10^5 products in another order: 2^-53 each, and far less than a triangle.
    let off = [0, 1, 2].map(|k| sum(&spanned)[k] - whole[k]);
    assert!(dot(off, off).sqrt() <= 1e-10 * dot(whole, whole).sqrt());
}

fn flat(points: &[[f32; 2]]) -> Vec<[f32; 3]> {
    points.iter().map(|[x, y]| [*x, *y, 0.0]).collect()
}

#[test]
fn convex_polygons_are_fans() {
    let square = flat(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    assert_eq!(cut(&square).0, [[0, 1, 2], [0, 2, 3]]);
    let hexagon: Vec<[f32; 2]> =
        (0..6).map(|i| f64::from(i) * 1.047).map(|a| [a.cos() as f32, a.sin() as f32]).collect();
    assert_eq!(cut(&flat(&hexagon)).0, [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]);
}

#[test]
fn a_dart_splits_at_its_reflex_corner_wherever_it_begins() {
    let dart = flat(&[[-1.0, -1.0], [0.0, 0.0], [1.0, -1.0], [0.0, 2.0]]);
    for first in 0..4 {
        let mut turned = dart.clone();
        turned.rotate_left(first);
        covers(&turned, 2);
        let reflex = (5 - first) % 4;
        assert!(cut(&turned).0.iter().all(|triangle| triangle.contains(&reflex)));
        turned.reverse();
        covers(&turned, 2);
    }
}

#[test]
fn corners_on_straight_edges_stay_corners_of_triangles() {
    let square = flat(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [0.0, 1.0]]);
    for first in 0..6 {
        let mut turned = square.clone();
        turned.rotate_left(first);
        covers(&turned, 4);
    }
}

#[test]
fn corners_at_one_place_and_ways_back_span_nothing() {
    let twice =
        [[0.0, 0.0], [0.0, 0.0], [2.0, 0.0], [1.0, 1.0], [1.0, 1.0], [2.0, 2.0], [0.0, 2.0]];
    covers(&flat(&twice), 3);
    let spike = [[0.0, 0.0], [2.0, 0.0], [4.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
    covers(&flat(&spike), 2);
}

#[test]
fn a_hole_is_reached_by_an_edge_that_is_passed_twice() {
    let holed = [
        [0.0, 0.0],
        [4.0, 0.0],
        [4.0, 4.0],
        [0.0, 4.0],
        [0.0, 0.0],
        [1.0, 1.0],
        [1.0, 3.0],
        [3.0, 3.0],
        [3.0, 1.0],
        [1.0, 1.0],
    ];
    for first in 0..10 {
        let mut turned = flat(&holed);
        turned.rotate_left(first);
        covers(&turned, 8);
    }
}

#[test]
fn it_lies_in_any_plane() {
    let comb = [[0.0, 0.0], [5.0, 0.0], [5.0, 3.0], [4.0, 1.0], [3.0, 3.0], [2.0, 1.0], [1.0, 3.0]];
    for [u, v] in [
        [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0]],
        [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [[0.3, 0.7, -0.2], [0.5, -0.1, 0.4]],
        [[3e12, 1e12, 2e12], [-1e12, 5e12, 0.0]],
        [[3e-12, 1e-12, 2e-12], [-1e-12, 5e-12, 0.0]],
    ] {
        let corners: Vec<[f32; 3]> =
            comb.iter().map(|[x, y]| [0, 1, 2].map(|k| x * u[k] + y * v[k])).collect();
        covers(&corners, 5);
    }
}

/// Polygons for which looking at every corner for every ear would take minutes.
#[test]
fn large_polygons_are_quick() {
    let n = 50_000;
    let ring = |radius: &dyn Fn(usize) -> f64| -> Vec<[f32; 3]> {
        let corner = |i: usize| {
            let (sin, cos) = (std::f64::consts::TAU * i as f64 / n as f64).sin_cos();
            [(radius(i) * cos) as f32, (radius(i) * sin) as f32, 0.0]
        };
        (0..n).map(corner).collect()
    };
    covers(&ring(&|i| if i % 2 == 0 { 1000.0 } else { 10.0 }), n - 2);
    covers(&ring(&|i| 1000.0 + ((i * 7919) % 1009) as f64), n - 2);
    // A comb, whose ears are long, and a spiral that winds in and out.
    let comb: Vec<[f32; 2]> = (0..n - 2)
        .map(|i| [i as f32, if i % 2 == 0 { 1e4 } else { 1.0 }])
        .chain([[n as f32, 0.0], [-1.0, 0.0]])
        .collect();
    covers(&flat(&comb), n - 2);
    let spiral = |i: usize, inset: f64| {
        let angle = i as f64 * 0.01;
        let radius = 10.0 + angle - inset;
        [(radius * angle.cos()) as f32, (radius * angle.sin()) as f32]
    };
    let half = n / 2;
    let arms: Vec<[f32; 2]> =
        (0..half).map(|i| spiral(i, 0.0)).chain((0..half).rev().map(|i| spiral(i, 2.0))).collect();
    covers(&flat(&arms), n - 2);
}

#[test]
fn what_crosses_itself_ends_in_bounded_time() {
    // Corners here and there.
    let mut state = 1_u32;
    let mut number = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32
    };
    let tangle: Vec<[f32; 2]> = (0..20_000).map(|_| [number(), number()]).collect();
    assert_eq!(cut(&flat(&tangle)).1, Cut::Crossed);
    let bow_tie = flat(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]]);
    assert_eq!(cut(&bow_tie).0.len(), 2);
}
