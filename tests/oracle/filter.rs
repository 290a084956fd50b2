//! Where a filter puts a pixel's positions: its weights summed up numerically, and the sum inverted
//! by bisection. Nothing of it is known in closed form here.

/// How much a place counts that lies so far from the pixel's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PixelFilter {
    Box,
    Tent,
    Gaussian,
}

/// Intervals of Simpson's rule from the centre to a place. The fourth derivative of the gaussian is
/// at most 48, so its error is below `48 / (180 * 512^4)`, 4e-12.
const STEPS: usize = 512;

impl PixelFilter {
    pub const ALL: [PixelFilter; 3] = [PixelFilter::Box, PixelFilter::Tent, PixelFilter::Gaussian];

    /// As scripts call it.
    pub fn name(self) -> &'static str {
        ["box", "tent", "gaussian"][self as usize]
    }

    /// How far it reaches from the centre, in pixels.
    fn reach(self) -> f64 {
        if self == PixelFilter::Box { 0.5 } else { 1.0 }
    }

    /// The weight at a distance within reach.
    fn weight(self, x: f64) -> f64 {
        match self {
            PixelFilter::Box => 1.0,
            PixelFilter::Tent => 1.0 - x.abs(),
            // exp(-x^2 / (2 sigma^2)) with sigma 1/2.
            PixelFilter::Gaussian => (-2.0 * x * x).exp(),
        }
    }

    /// The weight between the centre and a distance.
    fn sum_to(self, x: f64) -> f64 {
        let h = x / STEPS as f64;
        let inner = (1..STEPS).map(|i| {
            let factor = if i % 2 == 1 { 4.0 } else { 2.0 };
            factor * self.weight(i as f64 * h)
        });
        (self.weight(0.0) + inner.sum::<f64>() + self.weight(x)) * h / 3.0
    }

    /// The share of the weight to the left of a place, counted in pixels from the centre.
    pub fn share(self, x: f64) -> f64 {
        let x = x.clamp(-self.reach(), self.reach());
        let half = self.sum_to(x.abs()) / self.sum_to(self.reach()) / 2.0;
        if x < 0.0 { 0.5 - half } else { 0.5 + half }
    }

    /// The place, from the pixel's left edge, to the left of which the share `u` of the weight lies.
    pub fn place(self, u: f64) -> f64 {
        let (mut low, mut high) = (-self.reach(), self.reach());
        while high - low > 1e-12 {
            let middle = (low + high) / 2.0;
            if self.share(middle) < u {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 + (low + high) / 2.0
    }
}
