//! Random numbers of the figures, from a seed and the generator of the scenes.

use crate::scene::batch::points;

/// Random numbers that are the same for ever.
pub struct Random(Box<dyn Iterator<Item = f64>>);

impl Random {
    /// From a seed.
    pub fn new(seed: u64) -> Self {
        Self(Box::new(points(seed).flat_map(|point| [point.x, point.y])))
    }

    /// Uniform from `min` up to `max`.
    pub fn uniform(&mut self, min: f64, max: f64) -> f64 {
        // The numbers do not end.
        min + (max - min) * self.0.next().unwrap_or(0.5)
    }

    /// A power of ten whose exponent is uniform.
    pub fn decades(&mut self, min: f64, max: f64) -> f64 {
        10f64.powf(self.uniform(min, max))
    }

    /// 1 or -1.
    pub fn sign(&mut self) -> f64 {
        self.uniform(-1.0, 1.0).signum()
    }
}
