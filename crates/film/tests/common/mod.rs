//! Pictures to encode: noise, flat ones, gradients, and a small render.
#![allow(dead_code, reason = "each test file uses some")]

use reflet_film::{Layout, Picture, Sample, SampleKind, SamplesMut, Transfer, TransferTable};

/// A picture of linear intensities given per pixel.
pub fn picture(
    width: u32,
    height: u32,
    tile: u32,
    kind: SampleKind,
    transfer: Transfer,
    colour: impl Fn(u32, u32) -> [f32; 3],
) -> Picture {
    let layout = Layout::try_new(width, height, tile).unwrap();
    let mut picture = Picture::try_new(layout, kind).unwrap();
    let table = TransferTable::new(transfer, kind);
    let side = tile as usize;
    for mut part in picture.tiles_mut() {
        let rect = layout.tile_rect(part.index);
        // Padding that an encoder read would show.
        let mut pixels = vec![[0.7, 0.1, 0.9, 0.3]; side * side];
        for y in 0..rect.height {
            for x in 0..rect.width {
                let rgb = colour(rect.x + x, rect.y + y);
                pixels[y as usize * side + x as usize][..3].copy_from_slice(&rgb);
            }
        }
        table.encode_tile(&pixels, &mut part.samples);
    }
    picture
}

/// A picture of 8-bit samples given as they are.
pub fn bytes(width: u32, height: u32, tile: u32, colour: impl Fn(u32, u32) -> [u8; 3]) -> Picture {
    let layout = Layout::try_new(width, height, tile).unwrap();
    let mut picture = Picture::try_new(layout, SampleKind::U8).unwrap();
    for part in picture.tiles_mut() {
        let rect = layout.tile_rect(part.index);
        let SamplesMut::U8(samples) = part.samples else {
            panic!("8 bits were asked for");
        };
        samples.fill(0xa5);
        for y in 0..rect.height {
            for x in 0..rect.width {
                let at = ((y * tile + x) * 3) as usize;
                samples[at..at + 3].copy_from_slice(&colour(rect.x + x, rect.y + y));
            }
        }
    }
    picture
}

/// All rows, R, G, B triples.
pub fn rows<T: Sample + Default>(picture: &Picture) -> Vec<T> {
    let width = picture.layout().width() as usize * 3;
    let mut all = vec![T::default(); width * picture.layout().height() as usize];
    for (y, row) in all.chunks_exact_mut(width).enumerate() {
        picture.row(y as u32, row);
    }
    all
}

/// Bytes without a pattern, the same in every run.
pub fn noise(x: u32, y: u32, seed: u32) -> u32 {
    let mut h = x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca6b) ^ seed;
    h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
    h ^ (h >> 15)
}

type V = [f32; 3];

fn dot(a: V, b: V) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn along(a: V, t: f32, d: V) -> V {
    [a[0] + t * d[0], a[1] + t * d[1], a[2] + t * d[2]]
}

fn unit(a: V) -> V {
    let l = dot(a, a).sqrt();
    a.map(|x| x / l)
}

/// Ten mirroring balls on a checkered floor under two lights, at frame `phase` of their change.
pub fn balls(width: u32, height: u32, kind: SampleKind, phase: f32) -> Picture {
    let centre = |i: usize| -> (V, f32) {
        let a = (40.0 * i as f32).to_radians();
        match i {
            9 => ([0.0, 1.2, 0.0], 1.2),
            _ => ([3.0 * a.cos(), 0.8, 3.0 * a.sin()], 0.8),
        }
    };
    let hit = |p: V, d: V| -> Option<(f32, usize)> {
        let mut best = (d[1] < 0.0).then(|| (-p[1] / d[1], 10));
        for i in 0..10 {
            let (c, r) = centre(i);
            let l = along(c, -1.0, p);
            let b = dot(l, d);
            let q = b * b - dot(l, l) + r * r;
            if q > 0.0 {
                let t = b - q.sqrt();
                if t > 1e-3 && best.is_none_or(|(near, _)| t < near) {
                    best = Some((t, i));
                }
            }
        }
        best
    };
    let lights: [(V, f32); 2] = [([6.0, 9.0, -6.0], 8.4), ([-7.0, 6.0, -4.0], 6.0)];
    picture(width, height, 16, kind, Transfer::Srgb, |x, y| {
        let k = 50.0_f32.to_radians() / 2.0;
        let (u, v) = (x as f32 + 0.5, y as f32 + 0.5);
        let (w, h) = (width as f32, height as f32);
        let forward = unit([0.0, -1.7, 9.0]);
        let up = [0.0, forward[2], -forward[1]];
        let right = (2.0 * u / w - 1.0) * k.tan();
        let rise = (1.0 - 2.0 * v / h) * k.tan() * h / w;
        let mut d = unit(along(along(forward, rise, up), -right, [-1.0, 0.0, 0.0]));
        let mut p = [0.0, 2.5, -9.0];
        let (mut colour, mut weight) = ([0.0; 3], [1.0_f32; 3]);
        for _ in 0..6 {
            let Some((t, i)) = hit(p, d) else { break };
            p = along(p, t, d);
            let n = match i {
                10 => [0.0, 1.0, 0.0],
                _ => unit(along(p, -1.0, centre(i).0)),
            };
            let even = (p[0].floor() + p[2].floor()) as i32 % 2 == 0;
            let wave = |c: usize| i as f32 + [0.0, 2.0, 4.0][c];
            let diffuse: V = match (i, even) {
                (10, true) => [0.9; 3],
                (10, false) => [0.2, 0.2, 0.25],
                _ => std::array::from_fn(|c| 0.5 * (0.5 + 0.4 * wave(c).cos())),
            };
            for (at, power) in lights {
                let l = along(at, -1.0, p);
                let r = dot(l, l).sqrt();
                let l = l.map(|x| x / r);
                let cos = dot(n, l);
                let lit = cos > 0.0 && hit(along(p, 1e-3, n), l).is_none_or(|(t, _)| t > r);
                for c in 0..3 {
                    colour[c] += weight[c] * diffuse[c] * if lit { power * cos / r } else { 0.0 };
                }
            }
            if i == 10 {
                break;
            }
            for (c, weight) in weight.iter_mut().enumerate() {
                *weight *= 0.5 + 0.4 * (std::f32::consts::TAU * phase + wave(c)).sin();
            }
            d = unit(along(d, -2.0 * dot(d, n), n));
        }
        colour
    })
}
