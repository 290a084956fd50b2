//! The real roots of polynomials, by their derivatives: between two neighbouring extrema there is
//! one root where the signs differ, and none (or a double one) where they do not.

/// The real roots in increasing order, simple ones. `c[i]` belongs to `t^i`; the last is not 0.
pub fn real_roots(c: &[f64]) -> Vec<f64> {
    let degree = c.len() - 1;
    if degree == 0 {
        return Vec::new();
    }
    if degree == 1 {
        return vec![-c[0] / c[1]];
    }
    let slope: Vec<f64> = (1..=degree).map(|i| c[i] * i as f64).collect();
    // Cauchy's bound on the roots.
    let bound = 1.0 + c[..degree].iter().fold(0.0f64, |m, x| m.max((x / c[degree]).abs()));
    let mut stops = vec![-bound];
    stops.extend(real_roots(&slope).into_iter().filter(|t| t.abs() < bound));
    stops.push(bound);
    let mut roots = Vec::new();
    for ends in stops.windows(2) {
        if value(c, ends[0]) == 0.0 {
            roots.push(ends[0]);
        } else if (value(c, ends[0]) < 0.0) != (value(c, ends[1]) < 0.0) {
            roots.push(between(c, &slope, ends[0], ends[1]));
        }
    }
    roots
}

pub fn value(c: &[f64], t: f64) -> f64 {
    c.iter().rev().fold(0.0, |sum, x| sum * t + x)
}

/// The root between two values of different signs: Newton's steps, and halves where they leave it.
fn between(c: &[f64], slope: &[f64], mut low: f64, mut high: f64) -> f64 {
    let low_is_negative = value(c, low) < 0.0;
    let mut t = 0.5 * (low + high);
    for _ in 0..200 {
        let f = value(c, t);
        if (f < 0.0) == low_is_negative {
            low = t;
        } else {
            high = t;
        }
        let newton = t - f / value(slope, t);
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if next == t || high - low <= f64::EPSILON * t.abs() {
            return next;
        }
        t = next;
    }
    t
}
