//! A vector of the plane in double-double: what positions and velocities are where no digit may be
//! lost.
//!
//! Never put a physical formula here.

use glam::DVec2;

use super::{DoubleDouble, two_sum};

/// A vector whose components have about 106 bits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DoubleDoubleVec {
    /// Along x.
    pub x: DoubleDouble,
    /// Along y.
    pub y: DoubleDouble,
}

impl DoubleDoubleVec {
    /// Of high parts and what they leave out.
    #[inline(always)]
    pub fn of(hi: DVec2, lo: DVec2) -> Self {
        let part = |hi, lo| DoubleDouble { hi, lo };
        Self { x: part(hi.x, lo.x), y: part(hi.y, lo.y) }
    }

    /// `self + other`.
    #[inline(always)]
    pub fn plus(self, other: Self) -> Self {
        Self { x: self.x.plus(other.x), y: self.y.plus(other.y) }
    }

    /// `self - other`.
    #[inline(always)]
    pub fn minus(self, other: Self) -> Self {
        Self { x: self.x.minus(other.x), y: self.y.minus(other.y) }
    }

    /// `self + shift` for a shift of plain doubles.
    #[inline(always)]
    pub fn plus_double(self, shift: DVec2) -> Self {
        let plus = |x: DoubleDouble, shift| {
            let (hi, error) = two_sum(x.hi, shift);
            DoubleDouble::sum(hi, error + x.lo)
        };
        Self { x: plus(self.x, shift.x), y: plus(self.y, shift.y) }
    }

    /// `self * factor`.
    #[inline(always)]
    pub fn times(self, factor: DoubleDouble) -> Self {
        Self { x: self.x.times(factor), y: self.y.times(factor) }
    }

    /// `self * factor` for a plain double.
    #[inline(always)]
    pub fn times_double(self, factor: f64) -> Self {
        Self { x: self.x.times_double(factor), y: self.y.times_double(factor) }
    }

    /// `self` times a power of two, exactly, barring underflow.
    #[inline(always)]
    pub fn scaled(self, power_of_two: f64) -> Self {
        Self { x: self.x.scaled(power_of_two), y: self.y.scaled(power_of_two) }
    }

    /// The square of the length.
    #[inline(always)]
    pub fn length_squared(self) -> DoubleDouble {
        self.x.squared().plus(self.y.squared())
    }

    /// The scalar product; its error is small beside the products, not beside a sum that cancels.
    #[inline(always)]
    pub fn dot(self, other: Self) -> DoubleDouble {
        self.x.times(other.x).plus(self.y.times(other.y))
    }

    /// The component of the vector product across the plane.
    #[inline(always)]
    pub fn cross(self, other: Self) -> DoubleDouble {
        self.x.times(other.y).minus(self.y.times(other.x))
    }

    /// The nearest vector of doubles.
    #[inline(always)]
    pub fn hi(self) -> DVec2 {
        DVec2::new(self.x.hi, self.y.hi)
    }

    /// What [`Self::hi`] leaves out.
    #[inline(always)]
    pub fn lo(self) -> DVec2 {
        DVec2::new(self.x.lo, self.y.lo)
    }
}

impl From<DVec2> for DoubleDoubleVec {
    fn from(vector: DVec2) -> Self {
        Self { x: vector.x.into(), y: vector.y.into() }
    }
}
