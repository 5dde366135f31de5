//! Random pucks from a seed, placed one after the other where nothing overlaps.
//!
//! The only place that draws random numbers of a scene. They come from a generator with a fixed
//! definition (PCG XSL RR 128/64) and only basic arithmetic, so a seed gives the same bits on every
//! machine.

use std::collections::HashMap;

use glam::DVec2;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

use crate::detect::touching::overlap;
use crate::world::{Disc, Segments, Walls};

/// Random places tried for one puck before giving up. Placing at random jams at an area fraction
/// of 0.547.
const TRIES_PER_PUCK: usize = 200_000;

/// A number, or a range from which one is drawn uniformly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The smallest.
    pub min: f64,
    /// The largest.
    pub max: f64,
}

/// What a batch of pucks shall be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Batch {
    /// How many.
    pub count: usize,
    /// Seed of its random numbers.
    pub seed: u64,
    /// Radius, m.
    pub radius: Range,
    /// Mass, kg.
    pub mass: Range,
    /// Largest speed, m/s: velocities are uniform over the disc of this radius.
    pub speed: f64,
    /// Where; pucks lie wholly inside.
    pub region: Walls,
}

/// The discs so far, in cells as wide as the largest.
pub struct Placed {
    discs: Vec<Disc>,
    cells: HashMap<(i64, i64), Vec<usize>>,
    width: f64,
    field: Option<(Segments, Option<Walls>)>,
}

impl Placed {
    /// Begins with discs that are already there; later ones have radii up to `radius_max`.
    pub fn new(discs: &[Disc], radius_max: f64) -> Self {
        let radius = discs.iter().map(|disc| disc.radius).fold(radius_max, f64::max);
        let mut placed =
            Self { discs: Vec::new(), cells: HashMap::new(), width: 2.0 * radius, field: None };
        discs.iter().for_each(|disc| placed.add(*disc));
        placed
    }

    /// Later ones stand where these segments let them, which have such walls around them.
    pub fn within(self, segments: Option<Segments>, walls: Option<Walls>) -> Self {
        Self { field: segments.map(|segments| (segments, walls)), ..self }
    }

    /// Adds the pucks of a batch with these ids; `Err` holds how many found a place.
    pub fn add_batch(&mut self, batch: &Batch, ids: &[u32]) -> Result<Vec<Disc>, usize> {
        let mut random = Pcg64::seed_from_u64(batch.seed);
        let first = self.discs.len();
        for &id in ids {
            let mut tries = (0..TRIES_PER_PUCK).map(|_| draw(batch, id, &mut random));
            let fits = |disc: &Disc| {
                batch.region.contain(disc.position, disc.radius)
                    && !self.overlaps(disc)
                    && self.field.iter().all(|(field, walls)| !field.refuse(disc, walls.as_ref()))
            };
            let Some(disc) = tries.find(fits) else { return Err(self.discs.len() - first) };
            self.add(disc);
        }
        Ok(self.discs[first..].to_vec())
    }

    fn add(&mut self, disc: Disc) {
        self.cells.entry(self.cell(disc.position)).or_default().push(self.discs.len());
        self.discs.push(disc);
    }

    fn cell(&self, position: DVec2) -> (i64, i64) {
        let index = (position / self.width).floor();
        (index.x as i64, index.y as i64)
    }

    fn overlaps(&self, disc: &Disc) -> bool {
        let (x, y) = self.cell(disc.position);
        let around = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy)));
        around
            .filter_map(|(dx, dy)| self.cells.get(&(x.saturating_add(dx), y.saturating_add(dy))))
            .flatten()
            .any(|&k| overlap(&self.discs[k], disc))
    }
}

/// The pucks of a batch wherever they fall, overlapping or not.
pub fn scattered(batch: &Batch) -> Vec<Disc> {
    let mut random = Pcg64::seed_from_u64(batch.seed);
    (0..batch.count as u32).map(|id| draw(batch, id, &mut random)).collect()
}

/// Points that are uniform in the unit square, without end.
pub fn points(seed: u64) -> impl Iterator<Item = DVec2> {
    let mut random = Pcg64::seed_from_u64(seed);
    std::iter::repeat_with(move || {
        let x = uniform(&mut random, 0.0, 1.0);
        DVec2::new(x, uniform(&mut random, 0.0, 1.0))
    })
}

/// One puck at a random place, which may overlap another.
fn draw(batch: &Batch, id: u32, random: &mut Pcg64) -> Disc {
    let radius = uniform(random, batch.radius.min, batch.radius.max);
    let mass = uniform(random, batch.mass.min, batch.mass.max);
    let (min, max) = (batch.region.min + radius, batch.region.max - radius);
    let position = DVec2::new(uniform(random, min.x, max.x), uniform(random, min.y, max.y));
    let velocity = batch.speed * in_unit_disc(random);
    Disc { id, position, velocity, radius, mass }
}

/// A number in [min, max).
fn uniform(random: &mut Pcg64, min: f64, max: f64) -> f64 {
    // The 53 high bits, as a multiple of 2^-53.
    let unit = (random.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64);
    min + (max - min) * unit
}

/// A point in the unit disc, by rejection: no function whose last bit depends on the machine.
fn in_unit_disc(random: &mut Pcg64) -> DVec2 {
    loop {
        let point = DVec2::new(uniform(random, -1.0, 1.0), uniform(random, -1.0, 1.0));
        if point.length_squared() <= 1.0 {
            return point;
        }
    }
}
