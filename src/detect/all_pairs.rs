//! Every touching pair by looking at every pair: fast for few discs, and the judge of the grid.

use super::touching::touch;
use super::{Pair, Pairs, TooManyPairs};
use crate::world::Disc;

/// All pairs that touch (gap at most `margin`, m), in ascending order of indices.
///
/// # Errors
/// [`TooManyPairs`] when the discs are heaped on each other beyond the limit.
pub fn touching_pairs(discs: &[Disc], margin: f64) -> Result<Vec<Pair>, TooManyPairs> {
    let mut pairs = Pairs::default();
    for (i, a) in discs.iter().enumerate() {
        for (j, b) in discs.iter().enumerate().skip(i + 1) {
            if touch(a, b, margin) {
                pairs.add(i, j)?;
            }
        }
    }
    Ok(pairs.sorted())
}
