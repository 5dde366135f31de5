//! Who is near whom, kept over many steps: lists with a skin, in two tiers.
//!
//! ```text
//! all discs -- cells --> outer list -- distance --> inner list -- distance --> near at this step
//!            every ~60 steps        every ~12 steps           every step
//! ```
//!
//! A list holds all pairs whose gap was at most its skin when it was made; it leaves nobody out
//! until two discs may have come closer by what the skin is wider than what is asked for (Verlet,
//! doi:10.1103/PhysRev.159.98). How much that is follows from the two largest speeds, which costs
//! nothing; when it is used up the outer list looks at how far discs really went. What is found
//! does not depend on when lists were made, but for the order. Judged by all pairs.
//!
//! Never decide here who touches: only who is near.

pub mod cells;

pub mod lanes;

use glam::DVec2;

use crate::detect::TooManyPairs;
use crate::world::Periodic;
use cells::Cells;
use lanes::{Look, Pairs};

/// Steps that lists shall last. Measured (`cargo bench --bench steps`): half as many or twice as
/// many cost up to a tenth more, a single list two fifths.
const INNER_STEPS: f64 = 12.0;
const OUTER_STEPS: f64 = 64.0;

/// Skin of an outer list in mean radii, at least and at most.
const OUTER_RADII: (f64, f64) = (0.05, 4.0);

/// Lists of near pairs.
#[derive(Clone, Debug)]
pub struct Near {
    periodic: Option<Periodic>,
    cells: Cells,
    outer: Pairs,
    inner: Pairs,
    /// Gaps up to which the lists hold, m; less than nothing = there is no list.
    outer_skin: f64,
    inner_skin: f64,
    /// By how much two discs may have come closer since a list was made, m.
    outer_spent: f64,
    inner_spent: f64,
    /// Where the discs were when the outer list was made.
    listed: Vec<DVec2>,
    /// Radii, m; `equal` where all are.
    radii: Vec<f64>,
    equal: Option<f64>,
    radius_mean: f64,
}

impl Near {
    /// No lists yet.
    pub fn new(periodic: Option<Periodic>) -> Self {
        Self {
            periodic,
            cells: Cells::new(periodic),
            outer: Pairs::default(),
            inner: Pairs::default(),
            outer_skin: f64::NEG_INFINITY,
            inner_skin: f64::NEG_INFINITY,
            outer_spent: 0.0,
            inner_spent: 0.0,
            listed: Vec::new(),
            radii: Vec::new(),
            equal: None,
            radius_mean: 0.0,
        }
    }

    /// To be called when discs came, went, changed their size or were put elsewhere.
    pub fn discard(&mut self) {
        self.outer_skin = f64::NEG_INFINITY;
        self.inner_skin = f64::NEG_INFINITY;
        self.radii.clear();
    }

    /// Finds all pairs with a gap up to `margin` (m), and perhaps some more.
    ///
    /// `closer` (m): by how much two discs can have come closer since the last call; infinite = not
    /// known. `counts` leaves pairs out for as long as a list lasts.
    ///
    /// # Errors
    /// [`TooManyPairs`] when discs lie heaped on each other.
    pub fn within(
        &mut self,
        places: &[DVec2],
        radii: &[f64],
        (margin, closer): (f64, f64),
        counts: Option<impl Fn(usize, usize) -> bool>,
        found: &mut Pairs,
    ) -> Result<(), TooManyPairs> {
        if self.radii.len() != radii.len() || self.outer_skin < 0.0 {
            self.note_radii(radii);
        }
        self.outer_spent += closer;
        self.inner_spent += closer;
        if self.inner_skin - self.inner_spent < margin {
            self.renew_inner(places, (margin, closer), counts)?;
        }
        let list = if self.inner_skin == self.outer_skin { &self.outer } else { &self.inner };
        list.select(&self.look(places, margin), found);
        Ok(())
    }

    fn note_radii(&mut self, radii: &[f64]) {
        self.discard();
        self.radii.extend_from_slice(radii);
        let first = radii.first().copied();
        self.equal = first.filter(|first| radii.iter().all(|radius| radius == first));
        self.radius_mean = radii.iter().sum::<f64>() / radii.len().max(1) as f64;
    }

    fn look<'a>(&'a self, places: &'a [DVec2], margin: f64) -> Look<'a> {
        let radii = if self.equal.is_some() { &[][..] } else { &self.radii[..] };
        let reach = self.equal.map_or(0.0, |radius| 2.0 * radius);
        let wrap = self.periodic.map(|periodic| periodic.size());
        Look { places, radii, reach, margin, wrap }
    }

    /// Skins for the present speeds: of the outer and of the inner list.
    fn skins(&self, margin: f64, closer: f64) -> (f64, f64) {
        let (least, most) = OUTER_RADII;
        let unit = self.radius_mean;
        let wanted = margin + (OUTER_STEPS * closer).max(least * unit);
        // Where discs fly far in a step a list would last for a few of them, and hold most pairs.
        if margin + 4.0 * closer >= most * unit || !closer.is_finite() {
            return (margin, margin);
        }
        let outer = wanted.min(most * unit);
        let inner = margin + (INNER_STEPS * closer).max(0.25 * least * unit);
        (outer, if inner < 0.7 * outer { inner } else { outer })
    }

    fn renew_inner(
        &mut self,
        places: &[DVec2],
        (margin, closer): (f64, f64),
        counts: Option<impl Fn(usize, usize) -> bool>,
    ) -> Result<(), TooManyPairs> {
        let (outer_skin, mut inner_skin) = self.skins(margin, closer);
        if self.outer_skin >= 0.0 && self.outer_skin - self.outer_spent < inner_skin {
            self.outer_spent = self.way(places);
        }
        // A list that holds for a few steps more is used up first.
        let left = self.outer_skin - self.outer_spent;
        if left >= inner_skin || left - margin >= 2.0 * closer && closer > 0.0 {
            inner_skin = inner_skin.min(left);
        } else {
            self.renew_outer(places, outer_skin, counts)?;
            inner_skin = inner_skin.min(outer_skin);
        }
        self.inner_skin = inner_skin;
        self.inner_spent = 0.0;
        if self.inner_skin == self.outer_skin {
            return Ok(());
        }
        let mut inner = std::mem::take(&mut self.inner);
        self.outer.select(&self.look(places, inner_skin), &mut inner);
        self.inner = inner;
        Ok(())
    }

    /// By how much two discs have come closer since the outer list was made at most, m: the sum of
    /// the two longest ways.
    fn way(&self, places: &[DVec2]) -> f64 {
        let (mut longest, mut second, mut still) = (0.0f64, 0.0f64, true);
        for (place, listed) in places.iter().zip(&self.listed) {
            let mut moved = *place - *listed;
            if let Some(periodic) = &self.periodic {
                moved += periodic.shift(moved);
            }
            let way = moved.length_squared();
            still &= moved == DVec2::ZERO;
            if way > second {
                (longest, second) = if way > longest { (way, longest) } else { (longest, way) };
            }
        }
        let way = (longest.sqrt() + second.sqrt()) * (1.0 + 1e-9);
        // Squares may have lost digits, or be no numbers.
        if still || (way > 1e-130 && way.is_finite()) { way } else { f64::INFINITY }
    }

    fn renew_outer(
        &mut self,
        places: &[DVec2],
        skin: f64,
        counts: Option<impl Fn(usize, usize) -> bool>,
    ) -> Result<(), TooManyPairs> {
        self.outer_skin = f64::NEG_INFINITY;
        self.cells.list(places, &self.radii, skin, &mut self.outer)?;
        if let Some(counts) = counts {
            self.outer.retain(counts);
        }
        self.outer_skin = skin;
        self.outer_spent = 0.0;
        self.listed.clear();
        self.listed.extend_from_slice(places);
        Ok(())
    }
}
