//! Laws of a few measured values: the power of a curve, and the bias of a walk.
//!
//! Never a plot.

/// The power `p` of `y = c x^p`, by least squares of the logarithms, and `c`; all above 0.
pub fn power_law(points: &[(f64, f64)]) -> (f64, f64) {
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let count = logs.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|point| point.0), mean(|point| point.1));
    let covariance: f64 = logs.iter().map(|point| (point.0 - x) * (point.1 - y)).sum();
    let variance: f64 = logs.iter().map(|point| (point.0 - x).powi(2)).sum();
    let power = covariance / variance;
    (power, (y - power * x).exp())
}

/// A sum of many small errors, as one that grows and one that wanders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Walk {
    /// The bias: what every event adds, on average.
    pub bias: f64,
    /// Standard error of the bias.
    pub bias_error: f64,
    /// The wandering part of an event: after `n` it is this times the root of `n`.
    pub step: f64,
}

impl Walk {
    /// Of sums after equally many events each, the first at 0 events: differences of neighbours
    /// have the bias as mean, and the wandering part as spread.
    pub fn of(sums: &[f64], events_each: f64) -> Self {
        let steps: Vec<f64> = sums.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let count = steps.len() as f64;
        let mean = steps.iter().sum::<f64>() / count;
        let spread = steps.iter().map(|step| (step - mean).powi(2)).sum::<f64>() / (count - 1.0);
        Self {
            bias: mean / events_each,
            bias_error: (spread / count).sqrt() / events_each,
            step: (spread / events_each).sqrt(),
        }
    }

    /// Whether the bias is none that chance makes: beyond three standard errors.
    pub fn is_biased(&self) -> bool {
        self.bias.abs() > 3.0 * self.bias_error
    }
}
