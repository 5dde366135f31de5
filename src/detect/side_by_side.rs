//! Times of impact of many pairs at once, one pair in each lane of the processor's wide registers.
//!
//! The formulas are those of [`super::impact`], and so are the bits. But no pair has a branch of
//! its own: what one does not need is computed all the same and left, which costs less than to ask.
//! The loops are plain, and short enough for the compiler to make one instruction of several turns;
//! never put a branch into them that a selection between two values could not replace.

use glam::DVec2;

use super::impact::{
    Relative, exact_clearance, exact_discriminant, pair_impact_here, plain_clearance,
    plain_discriminant,
};
use crate::exact::sum_of_products;

/// Two registers of four lanes, which hide each other's latency. Measured: four pairs are slower by
/// a sixth, and from sixteen on the columns do not stay in registers.
const BLOCK: usize = 8;

/// [`super::impact::pair_impacts`], to be compiled for each kind of processor with wide registers.
#[inline(always)]
pub(super) fn pair_impacts_here(pairs: &[Relative], times: &mut [f64]) {
    let (blocks, rest) = pairs.as_chunks();
    let (block_times, rest_times) = times.as_chunks_mut();
    for (block, times) in blocks.iter().zip(block_times) {
        *times = block_impacts(&Columns::of(block));
    }
    for (pair, time) in rest.iter().zip(rest_times) {
        *time = pair_impact_here(pair.d, pair.w, pair.s).unwrap_or(f64::INFINITY);
    }
}

/// The pairs of a block, one quantity after the other.
struct Columns {
    d: [[f64; BLOCK]; 2],
    w: [[f64; BLOCK]; 2],
    s: [f64; BLOCK],
}

impl Columns {
    #[inline(always)]
    fn of(pairs: &[Relative; BLOCK]) -> Self {
        let zeros = [0.0; BLOCK];
        let mut columns = Self { d: [zeros; 2], w: [zeros; 2], s: zeros };
        for (k, pair) in pairs.iter().enumerate() {
            [columns.d[0][k], columns.d[1][k]] = pair.d.to_array();
            [columns.w[0][k], columns.w[1][k]] = pair.w.to_array();
            columns.s[k] = pair.s;
        }
        columns
    }

    #[inline(always)]
    fn pair(&self, k: usize) -> (DVec2, DVec2, f64) {
        let [d, w] = [&self.d, &self.w].map(|[x, y]| DVec2::new(x[k], y[k]));
        (d, w, self.s[k])
    }
}

#[inline(always)]
fn block_impacts(pairs: &Columns) -> [f64; BLOCK] {
    let (mut b, mut c, mut decided) = ([0.0; BLOCK], [0.0; BLOCK], true);
    for k in 0..BLOCK {
        let (d, w, s) = pairs.pair(k);
        b[k] = sum_of_products(d.x, w.x, d.y, w.y);
        let ((plain, good), exact) = (plain_clearance(d, s), exact_clearance(d, s));
        c[k] = if good { plain } else { exact };
        decided &= (b[k] >= 0.0) | (c[k] <= 0.0);
    }
    let mut times = if decided { [0.0; BLOCK] } else { roots(pairs, &b, &c) };
    for k in 0..BLOCK {
        times[k] = if c[k] <= 0.0 { 0.0 } else { times[k] };
        times[k] = if b[k] >= 0.0 { f64::INFINITY } else { times[k] };
    }
    times
}

/// `c / (-b + sqrt(discriminant))`, infinite where the paths pass each other.
#[inline(always)]
fn roots(pairs: &Columns, b: &[f64; BLOCK], c: &[f64; BLOCK]) -> [f64; BLOCK] {
    let mut times = [0.0; BLOCK];
    for k in 0..BLOCK {
        let (d, w, s) = pairs.pair(k);
        let ((plain, good), exact) = (plain_discriminant(d, w, s), exact_discriminant(d, w, s));
        let discriminant = if good { plain } else { exact };
        let time = c[k] / (discriminant.sqrt() - b[k]);
        times[k] = if discriminant >= 0.0 { time } else { f64::INFINITY };
    }
    times
}
