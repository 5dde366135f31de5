//! One linear spring-dashpot contact by itself, in closed form: right at any stiffness and step.
//!
//! The overlap obeys `x'' + 2 beta x' + omega0^2 x = 0` with `omega0^2 = k / mu`,
//! `beta = gamma / (2 mu)` and the reduced mass `mu` (not a mass). Below `beta = omega0` it swings
//! with `omega^2 = omega0^2 - beta^2`, above it decays with the rates `r1 < r2`. Each form is used
//! where it loses no digits; `r1 = omega0^2 / r2` is never a difference.
//!
//! Never look at discs here: this is the one-dimensional law.

/// When a contact ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// When the overlap is 0; before that the dashpot may pull the discs together.
    OverlapGone,
    /// When the force would become attractive: springs push, they never pull (Schwager, Poschel,
    /// doi:10.1007/s10035-007-0065-z).
    NoAttraction,
}

/// The contact of two bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillator {
    /// `omega0^2`, 1/s^2.
    omega0_squared: f64,
    /// 1/s.
    beta: f64,
}

/// The motion between `beta` and `omega0`.
enum Regime {
    /// `omega`, 1/s.
    Swings(f64),
    /// Near the aperiodic limit: `Omega = sqrt(beta^2 - omega0^2)`, 1/s, far below `beta`.
    Limit(f64),
    /// The rates `r1 < r2`, 1/s.
    Decays(f64, f64),
}

/// What passes through zero: the overlap, its rate, the force.
#[derive(Clone, Copy)]
enum Zero {
    Overlap = 0,
    Rate = 1,
    Force = 2,
}

impl Oscillator {
    /// Of a spring (N/m), a dashpot (N s/m) and `1 / mu` (1/kg).
    pub fn new(stiffness: f64, damping: f64, inverse_mass: f64) -> Self {
        Self { omega0_squared: stiffness * inverse_mass, beta: 0.5 * damping * inverse_mass }
    }

    /// The undamped frequency, 1/s.
    pub fn omega0(&self) -> f64 {
        self.omega0_squared.sqrt()
    }

    /// The decay rate, 1/s.
    pub fn beta(&self) -> f64 {
        self.beta
    }

    /// Overlap and its rate a time `t` (s) later.
    pub fn after(&self, x: f64, v: f64, t: f64) -> (f64, f64) {
        // At the end of everything: a decay has no place left to go.
        if self.beta * t > 1e6 && !matches!(self.regime(), Regime::Decays(..)) {
            return (0.0, 0.0);
        }
        match self.regime() {
            Regime::Swings(omega) => {
                let (sine, cosine) = (omega * t).sin_cos();
                let decay = (-self.beta * t).exp();
                self.mix(x, v, decay * cosine, decay * sine / omega)
            }
            Regime::Limit(rate) => {
                let slow = (-(self.beta - rate) * t).exp();
                let fast = (-(self.beta + rate) * t).exp();
                let part = if rate == 0.0 { t } else { -(-2.0 * rate * t).exp_m1() / (2.0 * rate) };
                self.mix(x, v, 0.5 * (slow + fast), slow * part)
            }
            Regime::Decays(r1, r2) => {
                let slow = (v + r2 * x) / (r2 - r1) * (-r1 * t).exp();
                let fast = (v + r1 * x) / (r2 - r1) * (-r2 * t).exp();
                (slow - fast, r2 * fast - r1 * slow)
            }
        }
    }

    /// The first time (s) at which a contact with this overlap and rate ends; infinite = never.
    pub fn end(&self, x: f64, v: f64, ending: Ending) -> f64 {
        match ending {
            Ending::OverlapGone => self.first_zero(x, v, Zero::Overlap),
            Ending::NoAttraction => self.first_zero(x, v, Zero::Force),
        }
    }

    /// When the overlap is largest, s.
    pub fn deepest(&self, x: f64, v: f64) -> f64 {
        if v <= 0.0 { 0.0 } else { self.first_zero(x, v, Zero::Rate) }
    }

    /// Force over reduced mass, 1/s^2 m; positive = the bodies are pushed apart.
    pub fn push(&self, x: f64, v: f64) -> f64 {
        self.omega0_squared * x + 2.0 * self.beta * v
    }

    fn regime(&self) -> Regime {
        let omega0 = self.omega0();
        let squared = (omega0 - self.beta) * (omega0 + self.beta);
        if squared > 0.0 {
            return Regime::Swings(squared.sqrt());
        }
        let rate = (-squared).sqrt();
        if rate <= 0.5 * self.beta {
            return Regime::Limit(rate);
        }
        let r2 = self.beta + rate;
        Regime::Decays(self.omega0_squared / r2, r2)
    }

    /// The state from the two damped basis functions, `C(0) = 1` and `S'(0) = 1`.
    fn mix(&self, x: f64, v: f64, c: f64, s: f64) -> (f64, f64) {
        let a = v + self.beta * x;
        (x * c + a * s, v * c - (self.beta * v + self.omega0_squared * x) * s)
    }

    /// Overlap, its rate and the force all obey the same equation: the first zero of one of them
    /// that is positive now, or is 0 and grows.
    fn first_zero(&self, x: f64, v: f64, what: Zero) -> f64 {
        let acceleration = -self.push(x, v);
        let (f, slope) = match what {
            Zero::Overlap => (x, v),
            Zero::Rate => (v, acceleration),
            Zero::Force => {
                (-acceleration, self.omega0_squared * v + 2.0 * self.beta * acceleration)
            }
        };
        let time = match self.regime() {
            Regime::Swings(omega) => (omega * f).atan2(-(slope + self.beta * f)) / omega,
            Regime::Limit(rate) => {
                let fall = -(slope + (self.beta + rate) * f);
                if fall <= 0.0 {
                    f64::INFINITY
                } else if rate == 0.0 {
                    f / fall
                } else {
                    (2.0 * rate * f / fall).ln_1p() / (2.0 * rate)
                }
            }
            // Both modes of overlap, rate and force differ by powers of their rates: no difference
            // of nearly equal numbers is taken.
            Regime::Decays(r1, r2) => {
                let ratio = (v + r1 * x) / (v + r2 * x) * (r2 / r1).powi(what as i32);
                if ratio > 1.0 { ratio.ln() / (r2 - r1) } else { f64::INFINITY }
            }
        };
        if time >= 0.0 { time } else { f64::INFINITY }
    }
}
