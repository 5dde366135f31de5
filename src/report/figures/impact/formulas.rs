//! The time of impact by each of the formulas that are compared: carom's own, and plain ones that
//! others use, which stand here for nothing but the comparison.

use std::hint::black_box;

use glam::DVec2;

use crate::detect::impact::{Relative, pair_impact, pair_impact_in_full, pair_impacts};

/// One formula.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Formula {
    /// `(-B - sqrt(B^2 - A C)) / A`, as in school.
    School,
    /// `C / (-B + sqrt(B^2 - A C))`: no difference at the end.
    Stable,
    /// The same with `C = (|d| - s)(|d| + s)` and the discriminant from the vector product.
    Cross,
    /// Everything in double-double.
    InFull,
    /// What carom runs: double-double only where digits would be lost.
    Carom,
    /// The same of many pairs at once, as the arena asks for them.
    CaromMany,
}

impl Formula {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::School, Self::Stable, Self::Cross, Self::InFull, Self::Carom, Self::CaromMany];

    /// Its name in legends.
    pub fn name(self) -> &'static str {
        match self {
            Self::School => "school formula",
            Self::Stable => "stable arrangement",
            Self::Cross => "vector product",
            Self::InFull => "double-double throughout",
            Self::Carom => "carom, one by one",
            Self::CaromMany => "carom, many at once",
        }
    }

    /// Whether its errors must be a few u.
    pub fn is_robust(self) -> bool {
        matches!(self, Self::InFull | Self::Carom | Self::CaromMany)
    }

    /// Times of impact of all pairs, infinite = never.
    pub fn times(self, pairs: &[Relative], times: &mut [f64]) {
        let each = |formula: fn(DVec2, DVec2, f64) -> Option<f64>, times: &mut [f64]| {
            for (&Relative { d, w, s }, time) in pairs.iter().zip(times) {
                *time = formula(d, w, s).unwrap_or(f64::INFINITY);
            }
        };
        match self {
            Self::School => each(school, times),
            Self::Stable => each(stable, times),
            Self::Cross => each(cross, times),
            Self::InFull => each(pair_impact_in_full, times),
            Self::Carom => each(pair_impact, times),
            Self::CaromMany => pair_impacts(pairs, times),
        }
    }

    /// The same for a stopwatch: one by one, so that no compiler computes many at once unasked.
    pub fn run(self, pairs: &[Relative], times: &mut [f64]) {
        match self {
            Self::School => one_by_one(pairs, school),
            Self::Stable => one_by_one(pairs, stable),
            Self::Cross => one_by_one(pairs, cross),
            Self::InFull => one_by_one(pairs, pair_impact_in_full),
            Self::Carom => one_by_one(pairs, pair_impact),
            Self::CaromMany => pair_impacts(black_box(pairs), black_box(times)),
        }
    }
}

#[inline(always)]
fn one_by_one(pairs: &[Relative], formula: impl Fn(DVec2, DVec2, f64) -> Option<f64>) {
    for &Relative { d, w, s } in pairs {
        black_box(formula(d, w, s));
    }
}

fn school(d: DVec2, w: DVec2, s: f64) -> Option<f64> {
    let b = d.dot(w);
    if b >= 0.0 {
        return None;
    }
    let c = d.length_squared() - s * s;
    if c <= 0.0 {
        return Some(0.0);
    }
    let a = w.length_squared();
    let discriminant = b * b - a * c;
    (discriminant >= 0.0).then(|| (-b - discriminant.sqrt()) / a)
}

fn stable(d: DVec2, w: DVec2, s: f64) -> Option<f64> {
    let b = d.dot(w);
    if b >= 0.0 {
        return None;
    }
    let c = d.length_squared() - s * s;
    if c <= 0.0 {
        return Some(0.0);
    }
    let discriminant = b * b - w.length_squared() * c;
    (discriminant >= 0.0).then(|| c / (discriminant.sqrt() - b))
}

fn cross(d: DVec2, w: DVec2, s: f64) -> Option<f64> {
    let b = d.dot(w);
    if b >= 0.0 {
        return None;
    }
    let distance = d.length();
    let c = (distance - s) * (distance + s);
    if c <= 0.0 {
        return Some(0.0);
    }
    let cross = d.perp_dot(w);
    let discriminant = s * s * w.length_squared() - cross * cross;
    (discriminant >= 0.0).then(|| c / (discriminant.sqrt() - b))
}
