//! Nearest images: in a periodic box two discs meet across its border, wherever they are recorded.
//!
//! A later sample is taken at the image nearest to the earlier one, and of two discs the second at
//! the image nearest to the first. That is the right one as long as nobody flies far between two
//! samples: where that is not sure, nothing is judged.

use glam::DVec2;

use super::Frame;
use super::flight::Flight;
use super::law::Law;
use crate::detect::{self, Pair, TooManyPairs};
use crate::plan::BroadPhase;
use crate::world::{Disc, Periodic};

/// Ways of the fastest disc by which a pair may be apart and still meet, with room for discs that
/// are faster between two contacts.
const WAYS: f64 = 3.0;

impl Law {
    /// What brings a place to its image nearest to another, m.
    pub(super) fn shift(&self, from: DVec2, to: DVec2) -> DVec2 {
        self.periodic.map_or(DVec2::ZERO, |periodic| periodic.shift(to - from))
    }

    /// What brings the second of two discs to its image nearest to the first, m.
    pub(super) fn shift_of(&self, a: &Flight, b: &Flight) -> DVec2 {
        self.shift(a.before.position, b.before.position)
    }

    /// From the first disc to the second at the earlier sample, m.
    pub(super) fn apart(&self, a: &Flight, b: &Flight) -> DVec2 {
        b.before.position - a.before.position + self.shift_of(a, b)
    }

    /// The same at the later sample, m.
    pub(super) fn apart_after(&self, a: &Flight, b: &Flight) -> DVec2 {
        let (from, to) = (a.after.position, b.after.position);
        to - from + self.shift(from, to)
    }

    /// Whether two discs that meet in this time, at this largest speed, do so at nearest images.
    pub(super) fn shows_nearest(&self, frame: &Frame, fastest: f64, length: f64) -> bool {
        let Some(periodic) = self.periodic else { return true };
        let mut largest = [0.0_f64; 2];
        for disc in &frame.discs {
            let [first, second] = largest;
            largest = [first.max(disc.radius), second.max(first.min(disc.radius))];
        }
        let apart = largest[0] + largest[1] + WAYS * fastest * length;
        2.0 * apart < periodic.size().min_element()
    }
}

/// Touching pairs in a periodic box, by circles at the border that are there a second time.
pub(super) fn touching_pairs(
    discs: &[Disc],
    periodic: &Periodic,
    broad_phase: BroadPhase,
) -> Result<Vec<Pair>, TooManyPairs> {
    let inside = |disc: &Disc| Disc { position: periodic.inside(disc.position), ..*disc };
    let mut all: Vec<Disc> = discs.iter().map(inside).collect();
    let mut whose: Vec<usize> = (0..all.len()).collect();
    let largest = discs.iter().map(|disc| disc.radius).fold(0.0, f64::max);
    // Those at the left border again at the right one; then all at the lower one at the upper one.
    for axis in [DVec2::X, DVec2::Y] {
        for k in 0..all.len() {
            let disc = all[k];
            if (disc.position - periodic.min).dot(axis) <= disc.radius + largest {
                let position = disc.position + periodic.size() * axis;
                all.push(Disc { position, ..disc });
                whose.push(whose[k]);
            }
        }
    }
    let pairs = detect::touching_pairs(&all, 0.0, broad_phase)?;
    let own = pairs.into_iter().map(|(i, j)| (whose[i].min(whose[j]), whose[i].max(whose[j])));
    let mut pairs: Vec<Pair> = own.filter(|(i, j)| i != j).collect();
    pairs.sort_unstable();
    pairs.dedup();
    Ok(pairs)
}
