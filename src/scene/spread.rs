//! Discs of very different sizes, placed at random without overlap, the largest first.
//!
//! As many square metres are covered by radii from r to 2r as by those from 2r to 4r: numbers fall
//! with the square of the radius. Masses are proportional to areas.
//!
//! Never dense: what is placed at random without moving jams.

use glam::DVec2;

use super::batch::points;
use super::lattice::{Lattice, settle};
use crate::world::Disc;

/// Random places tried for one disc before giving up.
const TRIES_PER_DISC: usize = 100_000;

/// No disc.
const NONE: u32 = u32::MAX;

/// As many discs as the lattice has, over the same area fraction, with radii from 0.5 m to the size
/// ratio times that; and the side of the square, m. `None` if they find no place.
pub fn discs(lattice: &Lattice) -> Option<(Vec<Disc>, f64)> {
    let mut discs = lattice.drawn();
    let last = (lattice.count - 1) as f64;
    let narrow = 1.0 - lattice.size_ratio.powi(-2);
    for (k, disc) in discs.iter_mut().enumerate() {
        disc.radius = 0.5 / (1.0 - narrow * (last - k as f64) / last).sqrt();
        disc.mass = (2.0 * disc.radius).powi(2);
        // At the same temperature.
        disc.velocity /= 2.0 * disc.radius;
    }
    let covered: f64 = discs.iter().map(|disc| disc.radius.powi(2)).sum();
    let side = (std::f64::consts::PI * covered / lattice.area_fraction).sqrt();
    let mut placed = Placed::new(side);
    let mut points = points(lattice.seed ^ 0x5eed);
    for disc in &mut discs {
        let room = side - 2.0 * disc.radius;
        let mut tries = points
            .by_ref()
            .take(TRIES_PER_DISC)
            .map(|point| if lattice.walled { disc.radius + room * point } else { side * point });
        disc.position = tries.find(|&place| room > 0.0 && placed.is_free(place, disc.radius))?;
        placed.add(disc.position, disc.radius);
    }
    line_up(&mut discs, side / last.sqrt());
    settle(&mut discs);
    Some((discs, side))
}

/// Numbers neighbours alike, in rows of this height, m, as on a lattice: they meet most often.
fn line_up(discs: &mut [Disc], height: f64) {
    let row = |disc: &Disc| (disc.position.y / height).floor();
    discs.sort_by(|a, b| row(a).total_cmp(&row(b)).then(a.position.x.total_cmp(&b.position.x)));
    (0..).zip(discs).for_each(|(id, disc)| disc.id = id);
}

/// Discs that have their place in a square that repeats, by octaves of their radii.
struct Placed {
    side: f64,
    octaves: Vec<Octave>,
    discs: Vec<(DVec2, f64, u32)>,
}

/// Cells as wide as the largest diameter, each with the disc that came last.
struct Octave {
    radius: f64,
    lines: i64,
    last: Vec<u32>,
}

impl Placed {
    fn new(side: f64) -> Self {
        Self { side, octaves: Vec::new(), discs: Vec::new() }
    }

    /// Adds a disc that is no larger than those before.
    fn add(&mut self, position: DVec2, radius: f64) {
        if self.octaves.last().is_none_or(|octave| 2.0 * radius <= octave.radius) {
            let lines = ((self.side / (2.0 * radius)) as i64).clamp(1, 4096);
            let last = vec![NONE; (lines * lines) as usize];
            self.octaves.push(Octave { radius, lines, last });
        }
        let number = self.discs.len() as u32;
        if let Some(octave) = self.octaves.last_mut() {
            let cell = (position * (octave.lines as f64 / self.side)).floor();
            let index = octave.index(cell.x as i64, cell.y as i64);
            let last = &mut octave.last[index];
            self.discs.push((position, radius, *last));
            *last = number;
        }
    }

    fn is_free(&self, position: DVec2, radius: f64) -> bool {
        self.octaves.iter().all(|octave| {
            let cell = (position * (octave.lines as f64 / self.side)).floor();
            let around = if octave.lines < 3 { 0..octave.lines } else { -1..2 };
            let mut cells = around.clone().flat_map(|dy| around.clone().map(move |dx| (dx, dy)));
            cells.all(|(dx, dy)| {
                let index = octave.index(cell.x as i64 + dx, cell.y as i64 + dy);
                self.is_free_among(octave.last[index], position, radius)
            })
        })
    }

    /// Whether there is room beside a disc and those before it in its cell.
    fn is_free_among(&self, mut number: u32, position: DVec2, radius: f64) -> bool {
        while number != NONE {
            let (other, other_radius, before) = self.discs[number as usize];
            let d = position - other;
            let d = d - self.side * (d / self.side).round();
            if d.length() <= (radius + other_radius) * (1.0 + 1e-9) {
                return false;
            }
            number = before;
        }
        true
    }
}

impl Octave {
    /// Of a cell, which may lie beyond the border.
    fn index(&self, column: i64, row: i64) -> usize {
        let (column, row) = (column.rem_euclid(self.lines), row.rem_euclid(self.lines));
        (row * self.lines + column) as usize
    }
}
