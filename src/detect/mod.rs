//! Detection: which discs touch now, and when the next ones will. It only looks.
//!
//! [`touching`] is the exact predicate for one pair. [`all_pairs`] and [`grid`] list the touching
//! pairs of many discs: the first is plain and the judge of the second. [`impact`] is the time of
//! impact, of one pair or of many side by side, [`precise`] the same from states in double-double,
//! [`falling`] under gravity, [`segment`] of a disc and a line segment. Nothing here changes a
//! velocity or a position.

pub mod touching;

pub mod all_pairs;

pub mod grid;

pub mod impact;

pub mod precise;

pub mod fused;

mod side_by_side;

pub mod falling;

pub mod segment;

use crate::plan::BroadPhase;
use crate::world::{Disc, limits};

/// Two indices into the discs that were looked at, the smaller first.
pub type Pair = (usize, usize);

/// All pairs that touch (gap at most `margin`, m), in ascending order of indices, by the broad
/// phase that the plan chose: the result is the same.
///
/// # Errors
/// [`TooManyPairs`] when the discs are heaped on each other beyond the limit.
pub fn touching_pairs(
    discs: &[Disc],
    margin: f64,
    broad_phase: BroadPhase,
) -> Result<Vec<Pair>, TooManyPairs> {
    match broad_phase {
        BroadPhase::AllPairs => all_pairs::touching_pairs(discs, margin),
        BroadPhase::Grid => grid::touching_pairs(discs, margin),
    }
}

/// More touching pairs than [`limits::TOUCHING_PAIRS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("more than {} pairs touch: circles lie heaped on each other", limits::TOUCHING_PAIRS)]
pub struct TooManyPairs;

/// Collects pairs up to the limit.
#[derive(Default)]
struct Pairs(Vec<Pair>);

impl Pairs {
    fn add(&mut self, i: usize, j: usize) -> Result<(), TooManyPairs> {
        if self.0.len() == limits::TOUCHING_PAIRS {
            return Err(TooManyPairs);
        }
        self.0.push((i.min(j), i.max(j)));
        Ok(())
    }

    fn sorted(mut self) -> Vec<Pair> {
        self.0.sort_unstable();
        self.0
    }
}
