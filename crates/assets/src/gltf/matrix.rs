//! Matrices of nodes, joints and instances, by columns.

use super::json::Node;

pub(super) type Matrix = [[f64; 4]; 4];

pub(super) const IDENTITY: Matrix =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// a b.
pub(super) fn times(a: &Matrix, b: &Matrix) -> Matrix {
    b.map(|column| [0, 1, 2, 3].map(|row| (0..4).map(|k| a[k][row] * column[k]).sum()))
}

/// Where a point comes to.
pub(super) fn moved(m: &Matrix, [x, y, z]: [f64; 3]) -> [f64; 3] {
    let point = [x, y, z, 1.0];
    [0, 1, 2].map(|row| (0..4).map(|k| m[k][row] * point[k]).sum())
}

/// The cofactors of the upper 3x3 part: what normals turn with.
pub(super) fn cofactors(m: &Matrix) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|c| {
        let (a, b) = (m[(c + 1) % 3], m[(c + 2) % 3]);
        [0, 1, 2].map(|r| {
            let (j, k) = ((r + 1) % 3, (r + 2) % 3);
            a[j] * b[k] - a[k] * b[j]
        })
    })
}

/// Whether it turns what is right-handed to left-handed; by its cofactors.
pub(super) fn mirrors(m: &Matrix, cofactors: &[[f64; 3]; 3]) -> bool {
    (0..3).map(|r| m[0][r] * cofactors[0][r]).sum::<f64>() < 0.0
}

/// Scaled, then turned by a quaternion (x, y, z, w), then moved.
pub(super) fn placed(translation: [f64; 3], rotation: [f64; 4], scale: [f64; 3]) -> Matrix {
    let length = rotation.iter().map(|x| x * x).sum::<f64>().sqrt();
    // Of length one, but for rounding to the file's numbers.
    let unit = length > 0.0 && length.is_finite();
    let [x, y, z, w] = if unit { rotation.map(|part| part / length) } else { [0.0, 0.0, 0.0, 1.0] };
    let [sx, sy, sz] = scale;
    let turned = |axis: [f64; 3], by: f64| [axis[0] * by, axis[1] * by, axis[2] * by, 0.0];
    let [tx, ty, tz] = translation;
    [
        turned([1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)], sx),
        turned([2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)], sy),
        turned([2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)], sz),
        [tx, ty, tz, 1.0],
    ]
}

impl Node {
    /// Its own transform.
    pub fn own(&self) -> Matrix {
        match &self.matrix {
            Some(numbers) => columns(numbers),
            None => placed(
                self.translation.unwrap_or_default(),
                self.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]),
                self.scale.unwrap_or([1.0; 3]),
            ),
        }
    }
}

/// Sixteen numbers, column by column, as a matrix.
pub(super) fn columns(numbers: &[f64; 16]) -> Matrix {
    [0, 1, 2, 3].map(|c| [0, 1, 2, 3].map(|r| numbers[4 * c + r]))
}
