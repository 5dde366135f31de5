//! A disc: the one body that carom knows, whether simulated or observed.
//!
//! Never put motion or contact formulas here.

use glam::DVec2;

use super::limits;

/// Number of a disc on every topic; unique in a world. `Contact.WALL` is not one.
pub type DiscId = u32;

/// A circle in the plane with its state at one instant. SI units, one fixed frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Number on the topics.
    pub id: DiscId,
    /// Centre, m.
    pub position: DVec2,
    /// Velocity of the centre, m/s.
    pub velocity: DVec2,
    /// Radius, m; above 0.
    pub radius: f64,
    /// Mass, kg; above 0, infinite = no contact changes its velocity.
    pub mass: f64,
}

impl Disc {
    /// Kinetic energy, J; 0 for an infinite mass, whose energy no contact changes.
    pub fn kinetic_energy(&self) -> f64 {
        if self.mass.is_finite() { 0.5 * self.mass * self.velocity.length_squared() } else { 0.0 }
    }

    /// The fields of `CircleState` that must be finite.
    fn lengths_and_speeds(&self) -> [(&'static str, f64); 5] {
        let Self { position, velocity, radius, .. } = *self;
        let (x, y) = (("x", position.x), ("y", position.y));
        [x, y, ("vx", velocity.x), ("vy", velocity.y), ("radius", radius)]
    }

    /// The first thing wrong with the numbers, if any: the field and what would be right.
    pub fn defect(&self) -> Option<Defect> {
        let not_finite =
            self.lengths_and_speeds().into_iter().find(|(_, value)| !value.is_finite());
        if let Some((field, value)) = not_finite {
            return Some(Defect { field, value, wanted: "a finite number" });
        }
        if self.radius <= 0.0 {
            return Some(Defect { field: "radius", value: self.radius, wanted: "above 0 m" });
        }
        if self.mass <= 0.0 || self.mass.is_nan() {
            let wanted = "above 0 kg (inf = fixed)";
            return Some(Defect { field: "mass", value: self.mass, wanted });
        }
        None
    }

    /// The first thing wrong with a disc that comes from outside: a defect, or a size beyond the
    /// limits within which every result stays finite.
    pub fn refusal(&self) -> Option<Defect> {
        let mass = if self.mass.is_finite() { self.mass } else { 1.0 };
        let too_large = |(_, value): &(_, f64)| value.abs() > limits::SIZE_MAX;
        if let Some(defect) = self.defect() {
            return Some(defect);
        }
        let mut sizes = self.lengths_and_speeds().into_iter().chain([("mass", mass)]);
        if let Some((field, value)) = sizes.find(too_large) {
            return Some(Defect { field, value, wanted: "1e60 at most" });
        }
        let positive = [("radius", self.radius), ("mass", mass)];
        let too_small = positive.into_iter().find(|(_, value)| *value < limits::SIZE_MIN);
        too_small.map(|(field, value)| Defect { field, value, wanted: "1e-60 at least" })
    }
}

/// Why a disc is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{field} = {}, must be {wanted}", limits::short(*.value))]
pub struct Defect {
    /// Name of the field in `CircleState`.
    pub field: &'static str,
    /// What it held.
    pub value: f64,
    /// What would be right.
    pub wanted: &'static str,
}
