//! Texels of pictures.

use reflet_pack::tints::{TexelFilter, Texture, Wrap};

/// The texel at (s, t): s to the right, t upward, the picture from 0 to 1.
pub(crate) fn look_up(
    image: &Texture,
    [s, t]: [f64; 2],
    filter: TexelFilter,
    wrap: [Wrap; 2],
) -> [f32; 3] {
    let size = [i64::from(image.width), i64::from(image.height)];
    let texel = |x: i64, y: i64| {
        image.texels[(inside(y, size[1], wrap[1]) * size[0] + inside(x, size[0], wrap[0])) as usize]
    };
    let (x, y) = (s * size[0] as f64, (1.0 - t) * size[1] as f64);
    if !(x.is_finite() && y.is_finite()) {
        return texel(0, 0);
    }
    if filter == TexelFilter::Nearest {
        return texel(x.floor() as i64, y.floor() as i64);
    }
    let (x, y) = (x - 0.5, y - 0.5);
    let (i, j) = (x.floor(), y.floor());
    let (a, b) = ((x - i) as f32, (y - j) as f32);
    let (i, j) = (i as i64, j as i64);
    // Far off all whole numbers are the last one.
    let (k, l) = (i.saturating_add(1), j.saturating_add(1));
    let corners = [texel(i, j), texel(k, j), texel(i, l), texel(k, l)];
    [0, 1, 2].map(|k| {
        let above = corners[0][k] * (1.0 - a) + corners[1][k] * a;
        let below = corners[2][k] * (1.0 - a) + corners[3][k] * a;
        above * (1.0 - b) + below * b
    })
}

/// The texel of `n` in a row that number `i` stands for.
fn inside(i: i64, n: i64, wrap: Wrap) -> i64 {
    match wrap {
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::Clamp => i.clamp(0, n - 1),
        Wrap::Mirror => {
            let there = i.rem_euclid(2 * n);
            if there < n { there } else { 2 * n - 1 - there }
        }
    }
}

/// Two colours, number by number.
pub(crate) fn product(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|k| a[k] * b[k])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beyond_its_edges_a_picture_is_clamped_repeated_or_mirrored() {
        let at = |wrap| (-4..8).map(|i| inside(i, 3, wrap)).collect::<Vec<_>>();
        assert_eq!(at(Wrap::Repeat), [2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1]);
        assert_eq!(at(Wrap::Clamp), [0, 0, 0, 0, 0, 1, 2, 2, 2, 2, 2, 2]);
        assert_eq!(at(Wrap::Mirror), [2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 0, 1]);
    }
}
