//! Error-free transformations: the few operations from which every robust formula is built.
//!
//! A sum or a product of two doubles is kept whole as `hi + lo`, so that cancellation costs nothing
//! (Dekker, Numer. Math. 18, 224 (1971); Ogita, Rump, Oishi, doi:10.1137/030601818).
//! Never put a physical formula here.

mod vector;

pub use vector::DoubleDoubleVec;

/// Unit roundoff of binary64, 2^-53.
pub const UNIT_ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// `a + b` as a rounded sum and its exact error (Knuth).
#[inline(always)]
pub fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    (sum, (a - (sum - b_part)) + (b - b_part))
}

/// `a * b` as a rounded product and its exact error, barring underflow.
#[inline(always)]
pub fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    (product, a.mul_add(b, -product))
}

/// `a * b + c * d` within 1.5 ulp (Kahan; Jeannerod, Louvet, Muller,
/// doi:10.1090/S0025-5718-2013-02679-8): its sign is right even where the products cancel.
#[inline(always)]
pub fn sum_of_products(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let (product, error) = two_product(c, d);
    a.mul_add(b, product) + error
}

/// `a * b + c * d` as a rounded sum and what it leaves out, to about 2^-105.
#[inline(always)]
pub fn sum_of_two_products(a: f64, b: f64, c: f64, d: f64) -> (f64, f64) {
    let (p, p_error) = two_product(a, b);
    let (q, q_error) = two_product(c, d);
    let (sum, error) = two_sum(p, q);
    (sum, error + (p_error + q_error))
}

/// An unevaluated sum `hi + lo` with `|lo|` at most half an ulp of `hi`: about 106 bits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DoubleDouble {
    /// The leading part.
    pub hi: f64,
    /// What the leading part leaves out.
    pub lo: f64,
}

impl DoubleDouble {
    /// `a + b`, exactly.
    #[inline(always)]
    pub fn sum(a: f64, b: f64) -> Self {
        let (hi, lo) = two_sum(a, b);
        Self { hi, lo }
    }

    /// `a * b`, exactly, barring underflow.
    #[inline(always)]
    pub fn product(a: f64, b: f64) -> Self {
        let (hi, lo) = two_product(a, b);
        Self { hi, lo }
    }

    /// `self + other`, relative error a few 2^-106 unless the two cancel.
    #[inline(always)]
    pub fn plus(self, other: Self) -> Self {
        let (hi, error) = two_sum(self.hi, other.hi);
        let (lo, rest) = two_sum(self.lo, other.lo);
        let high = DoubleDouble::sum(hi, error + lo);
        DoubleDouble::sum(high.hi, high.lo + rest)
    }

    /// `self * other`, relative error a few 2^-106.
    #[inline(always)]
    pub fn times(self, other: Self) -> Self {
        let (hi, error) = two_product(self.hi, other.hi);
        DoubleDouble::sum(hi, error + self.hi.mul_add(other.lo, self.lo * other.hi))
    }

    /// `self - other`, as [`Self::plus`].
    #[inline(always)]
    pub fn minus(self, other: Self) -> Self {
        self.plus(other.negated())
    }

    /// `self * x`, relative error a few 2^-106.
    #[inline(always)]
    pub fn times_double(self, x: f64) -> Self {
        let (hi, error) = two_product(self.hi, x);
        Self::sum(hi, self.lo.mul_add(x, error))
    }

    /// `self` times a power of two, exactly, barring underflow.
    #[inline(always)]
    pub fn scaled(self, power_of_two: f64) -> Self {
        Self { hi: self.hi * power_of_two, lo: self.lo * power_of_two }
    }

    /// `self * self`.
    #[inline(always)]
    pub fn squared(self) -> Self {
        let (hi, error) = two_product(self.hi, self.hi);
        Self::sum(hi, (2.0 * self.hi).mul_add(self.lo, error))
    }

    /// `self / other`, relative error a few 2^-104.
    pub fn over(self, other: Self) -> Self {
        let first = self.hi / other.hi;
        let rest = self.minus(other.times_double(first));
        let second = rest.hi / other.hi;
        let third = rest.minus(other.times_double(second)).hi / other.hi;
        Self::sum(first, second).plus(third.into())
    }

    /// `-self`, exactly.
    #[inline(always)]
    pub fn negated(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }

    /// The nearest double.
    #[inline(always)]
    pub fn value(self) -> f64 {
        self.hi + self.lo
    }
}

impl From<f64> for DoubleDouble {
    fn from(hi: f64) -> Self {
        Self { hi, lo: 0.0 }
    }
}

/// The sign of a sum of doubles, exactly: -1, 0 or 1. `terms` is used as scratch.
///
/// Distillation: error-free sweeps until the parts no longer overlap; the last one then decides.
pub fn sign_of_sum(terms: &mut [f64]) -> i32 {
    loop {
        let mut changed = false;
        for k in 1..terms.len() {
            let (sum, error) = two_sum(terms[k - 1], terms[k]);
            // By bits: a NaN must end the loop too.
            changed |=
                sum.to_bits() != terms[k].to_bits() || error.to_bits() != terms[k - 1].to_bits();
            (terms[k - 1], terms[k]) = (error, sum);
        }
        if !changed {
            let leading = terms.iter().rev().copied().find(|&term| term != 0.0).unwrap_or(0.0);
            return if leading > 0.0 { 1 } else { -i32::from(leading < 0.0) };
        }
    }
}

/// A running sum with the rounding error of every addition carried along (Neumaier 1974).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RunningSum {
    sum: f64,
    error: f64,
}

impl RunningSum {
    /// Adds one term.
    pub fn add(&mut self, term: f64) {
        let (sum, error) = two_sum(self.sum, term);
        self.sum = sum;
        self.error += error;
    }

    /// The sum times a power of two, exactly, barring underflow.
    pub fn scaled(self, power_of_two: f64) -> Self {
        Self { sum: self.sum * power_of_two, error: self.error * power_of_two }
    }

    /// The sum so far.
    pub fn value(&self) -> f64 {
        self.sum + self.error
    }
}

impl FromIterator<f64> for RunningSum {
    fn from_iter<I: IntoIterator<Item = f64>>(terms: I) -> Self {
        let mut sum = Self::default();
        terms.into_iter().for_each(|term| sum.add(term));
        sum
    }
}

/// A power of two near `magnitude`, by which dividing is exact; 1 for 0 and non-finite values.
///
/// Kept within 2^±1000 so that the quotient of two of them, and its inverse, are finite.
pub fn power_of_two_near(magnitude: f64) -> f64 {
    if magnitude == 0.0 || !magnitude.is_finite() {
        return 1.0;
    }
    let bits = magnitude.abs().to_bits();
    // A subnormal has no implied leading bit: its exponent follows from its highest set bit.
    let exponent = match (bits >> 52) as i32 {
        0 => -1011 - bits.leading_zeros() as i32,
        biased => biased - 1023,
    };
    f64::from_bits(((exponent.clamp(-1000, 1000) + 1023) as u64) << 52)
}
