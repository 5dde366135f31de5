//! Discs on a triangular lattice that fits a square: a start at any density up to the closest.
//!
//! Never used for statistics before the lattice has melted.

use glam::DVec2;

use super::batch::{Batch, Range, scattered};
use crate::world::{Disc, Walls};

/// What shall lie on the lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// How many discs.
    pub count: usize,
    /// Share of the area that they cover.
    pub area_fraction: f64,
    /// Radii of every second disc over those of the others, 1 or more; the smaller radius is 0.5 m.
    pub size_ratio: f64,
    /// Masses are uniform from 1 kg to this.
    pub mass_max: f64,
    /// Whether walls stand around it; else it repeats.
    pub walled: bool,
    /// Seed of velocities and masses.
    pub seed: u64,
}

impl Lattice {
    /// The discs, and the side of the square with its lower left corner at 0, m. Without total
    /// momentum, with a kinetic energy of 1 J a disc. `None` if they cannot lie so close.
    pub fn discs(&self) -> Option<(Vec<Disc>, f64)> {
        let radius = |k: usize| if k.is_multiple_of(2) { 0.5 } else { 0.5 * self.size_ratio };
        let covered: f64 = (0..self.count).map(|k| radius(k).powi(2)).sum();
        let side = (std::f64::consts::PI * covered / self.area_fraction).sqrt();
        let columns = (self.count as f64 * 0.75f64.sqrt()).sqrt().round().max(2.0);
        let rows = 2.0 * (0.5 * self.count as f64 / columns).ceil();
        let largest = 2.0 * radius(1).max(radius(0));
        // Between walls the outermost touch them; in a periodic box no disc may meet itself.
        let (across, up, corner) = if self.walled {
            let room = side - largest;
            (room / (columns - 0.5), room / (rows - 1.0), 0.5 * largest)
        } else {
            (side / columns, side / rows, 0.25 * side / columns)
        };
        let close = across <= largest || (0.25 * across * across + up * up).sqrt() <= largest;
        if close || (columns < 3.0 && !self.walled) {
            return None;
        }
        let sites = (columns * rows) as usize;
        let mut discs = self.drawn();
        for (k, disc) in discs.iter_mut().enumerate() {
            // Empty places are spread evenly.
            let site = k * sites / self.count;
            let (column, row) = ((site % columns as usize) as f64, site / columns as usize);
            let x = across * (column + 0.5 * (row % 2) as f64);
            disc.position = corner + DVec2::new(x, up * row as f64);
            if self.walled {
                // No rounding may put it into the wall.
                disc.position = disc.position.min(DVec2::splat(side - 0.5 * largest));
            }
            disc.radius = radius(k);
        }
        settle(&mut discs);
        Some((discs, side))
    }

    /// Discs with random velocities and masses, wherever.
    fn drawn(&self) -> Vec<Disc> {
        let (min, max) = (DVec2::splat(-1.0), DVec2::splat(1.0));
        scattered(&Batch {
            count: self.count,
            seed: self.seed,
            radius: Range { min: 0.5, max: 0.5 },
            mass: Range { min: 1.0, max: self.mass_max },
            speed: 1.0,
            region: Walls { min, max, restitution: 1.0 },
        })
    }
}

/// Takes the total momentum away and scales the energy.
fn settle(discs: &mut [Disc]) {
    let mass: f64 = discs.iter().map(|disc| disc.mass).sum();
    let drift = discs.iter().map(|disc| disc.mass * disc.velocity).sum::<DVec2>() / mass;
    discs.iter_mut().for_each(|disc| disc.velocity -= drift);
    let energy: f64 = discs.iter().map(Disc::kinetic_energy).sum();
    let scale = (discs.len() as f64 / energy).sqrt();
    if scale.is_finite() {
        discs.iter_mut().for_each(|disc| disc.velocity *= scale);
    }
}
