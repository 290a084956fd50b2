//! Several samples a pixel: pictures stay where they are whatever their number, and `adaptive` shows
//! either the centre or the mean of all.

mod oracle;

use oracle::binary::rendered;
use oracle::filter::PixelFilter;
use oracle::hand::ROUNDING;
use oracle::vec3::Vec3;
use oracle::view::{Picture, sample_positions};

/// A picture of `n` x `n` pixels, each a unit wide, around the origin.
fn flat(name: &str, n: usize, keys: &str, things: &str) -> Picture {
    let script = format!(
        "image(#{{ width: {n}, height: {n}, {keys} }});
settings(#{{ attenuation: \"none\" }});
camera(#{{ eye: [0, 0, 5], look_at: [0, 0, 0], ortho: {n} }});
{things}"
    );
    rendered(name, &script).picture
}

/// All numbers of samples up to 16 through each filter: a name, and the keys of `image`.
fn samplings() -> impl Iterator<Item = (String, String)> {
    let counts = PixelFilter::ALL.into_iter().flat_map(|filter| (1..=16).map(move |n| (filter, n)));
    counts.map(|(filter, n)| {
        let filter = filter.name();
        (format!("{filter}-{n}"), format!("samples: {n}, filter: \"{filter}\""))
    })
}

/// How far the middle of a picture's light lies from that of the picture, in pixels.
fn off_centre(picture: &Picture) -> f64 {
    let (mut sum, mut moment) = (0.0, [0.0; 2]);
    for (i, pixel) in picture.pixels.iter().enumerate() {
        let at = [i % picture.width, i / picture.width];
        let middle = picture.width as f64 / 2.0;
        sum += pixel[0];
        moment = [0, 1].map(|k| moment[k] + pixel[0] * (at[k] as f64 + 0.5 - middle));
    }
    moment.map(|m| (m / sum).abs()).into_iter().fold(0.0, f64::max)
}

#[test]
fn a_disc_stays_in_the_middle() {
    // A hard edge takes or leaves whole positions, which moves the middle by some of its own even
    // where positions are centred: by 0.019 at most at this radius, by 0.24 to 0.41 where they are not.
    let disc = "disc(#{ center: [0, 0, 0], normal: [0, 0, 1], radius: 60.5,
    material: #{ ambient: 1 } });";
    for (name, keys) in samplings() {
        for adaptive in [false, true] {
            let keys = format!("{keys}, adaptive: {adaptive}");
            let off = off_centre(&flat(&format!("disc-{name}-{adaptive}"), 129, &keys, disc));
            assert!(off <= 0.02, "{keys}: off by {off}");
        }
    }
}

#[test]
fn a_soft_spot_stays_exactly_in_the_middle() {
    // (1 - r^2 / 64)^3, which is symmetric, and smooth up to where it ends. The sum over all pixels
    // of a function so smooth does not depend on where in them it is taken, but for what is left of
    // its spectrum at a period of one pixel; this falls as (pi 8)^-4 and moves the middle by less than
    // 1e-4. f32 adds 441 roundings of 2^-24 at a lever of 10, 3e-4 if all went one way.
    let spot = "let soft = |p| { let d = max(0, 1 - (p.x * p.x + p.y * p.y) / 64); d * d * d };
quad(#{ corner: [-12, -12, 0], u: [24, 0, 0], v: [0, 24, 0],
    material: shader(#{ base: material(#{ ambient: 1 }), ambient: soft }) });";
    //
    // And a pixel differs little from its mirror image through the middle. By Taylor's theorem around
    // the centre the terms of even order are the same in both, and that of the first order is 0, as
    // positions are centred. What is left is a sixth of the third derivative along the way to each
    // position, which nowhere exceeds 0.1, in each of the two; and 8 roundings.
    for filter in PixelFilter::ALL {
        for samples in 1..=16 {
            let keys = format!("samples: {samples}, filter: \"{}\"", filter.name());
            let picture = flat(&format!("spot-{}-{samples}", filter.name()), 21, &keys, spot);
            let off = off_centre(&picture);
            assert!(off <= 4e-4, "{keys}: off by {off}");
            let cubes = sample_positions(samples, filter).into_iter().map(|(a, b)| {
                let (a, b) = (a - 0.5, b - 0.5);
                (a * a + b * b).powf(1.5)
            });
            let third = cubes.sum::<f64>() / samples as f64 * 2.0 * 0.1 / 6.0;
            let bound = third + 8.0 * ROUNDING;
            for (pixel, mirrored) in picture.pixels.iter().zip(picture.pixels.iter().rev()) {
                assert!((pixel[0] - mirrored[0]).abs() <= bound, "{keys}: {pixel:?} {mirrored:?}");
            }
        }
    }
}

#[test]
fn a_ramp_has_its_middle_in_each_pixel() {
    // The mean of a linear function over centred positions is its value at the centre. x / 32 is
    // exact at no position, but to two roundings of 1/4 each; a mean of n rounds n times at most.
    let ramp = "quad(#{ corner: [-40, -40, 0], u: [80, 0, 0], v: [0, 80, 0],
    material: shader(#{ base: material(#{ ambient: 1 }), ambient: |p| p.x / 32 + p.y / 16 }) });";
    for (name, keys) in samplings() {
        let picture = flat(&format!("ramp-{name}"), 8, &keys, ramp);
        for (i, pixel) in picture.pixels.iter().enumerate() {
            let [x, y] = [i % 8, i / 8].map(|k| k as f64 + 0.5);
            let want = (x - 4.0) / 32.0 + (4.0 - y) / 16.0;
            assert!((pixel[0] - want).abs() <= 40.0 * ROUNDING, "{keys}: {pixel:?}");
        }
    }
}

#[test]
fn flat_parts_are_the_same_for_all_samples() {
    // Halves and quarters: sums of up to 16 equal ones and their means are exact.
    let things =
        "plane(#{ point: [0, 0, 0], normal: [0, 0, 1], material: #{ ambient: [0.5, 3, -0.25] } });";
    for (name, keys) in samplings() {
        for adaptive in [false, true] {
            let keys = format!("{keys}, adaptive: {adaptive}");
            let picture = flat(&format!("even-{name}-{adaptive}"), 4, &keys, things);
            let want = oracle::vec3::v3(0.5, 3.0, -0.25);
            assert!(picture.pixels.iter().all(|pixel| *pixel == want), "{keys}");
        }
    }
}

/// Mirrors, shadows, a checker and a texture's kin: edges of all kinds.
const EDGES: &str = "
camera(#{ eye: [2, 3, 8], look_at: [0, 0.5, 0] });
light(#{ at: [3, 5, 5], emissivity: 20 });
let k = checker(#{ even: #{ specular: 0.7, diffuse: 0.2 }, odd: #{ ambient: 0.1 }, size: [0.4, 0.4] });
plane(#{ point: [0, 0, 0], normal: [0, 1, 0], material: k });
sphere(#{ center: [0, 1, 0], radius: 1, material: #{ diffuse: 0.6, specular: 0.3 } });
sphere(#{ center: [-2, 0.5, 1], radius: 0.5, material: shader(#{
    base: material(#{ ambient: 0.2 }), diffuse: |p| p.x * p.x }) });
";

#[test]
fn adaptive_shows_the_centre_or_the_mean_of_all() {
    for filter in PixelFilter::ALL {
        let name = filter.name();
        let picture = |how: &str| {
            let script = format!(
                "image(#{{ width: 50, height: 41, filter: \"{name}\", samples: {how} }});{EDGES}"
            );
            let name = format!("edges-{name}-{}", how.replace([':', ',', ' '], ""));
            rendered(&name, &script).picture.pixels
        };
        let bits = |pixels: &[Vec3], i: usize| pixels[i].0.map(f64::to_bits);
        let (one, all, few) = (picture("1"), picture("5"), picture("5, adaptive: true"));
        let (mut centres, mut means) = (0, 0);
        for i in 0..few.len() {
            let (centre, mean) = (bits(&one, i), bits(&all, i));
            assert!([centre, mean].contains(&bits(&few, i)), "{name}: pixel {i} is neither");
            centres += u32::from(centre != mean && bits(&few, i) == centre);
            means += u32::from(centre != mean && bits(&few, i) == mean);
        }
        assert!(centres > 20 && means > 100, "{name}: {centres} centres, {means} means");
        assert_eq!(picture("1, adaptive: true"), one, "{name}");
    }
}

#[test]
fn adaptive_loses_what_lies_between_centres() {
    // A wire a fifth of a pixel wide, a quarter from the centres: no centre sees it.
    let wire = "quad(#{ corner: [0.15, -9, 0], u: [0.2, 0, 0], v: [0, 18, 0], material: #{ ambient: 1 } });";
    let lit = |keys: &str| {
        let picture = flat(&format!("wire-{}", keys.len()), 8, keys, wire);
        picture.pixels.iter().filter(|pixel| pixel[0] > 0.0).count()
    };
    assert_eq!(lit("samples: 16, adaptive: true"), 0);
    assert_eq!(lit("samples: 16"), 8);
}
