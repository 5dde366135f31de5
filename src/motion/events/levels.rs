//! Levels of cells, for discs of very different sizes: each lives in the finest that fits it.
//!
//! Every pair is seen by one of the two before it can meet. Among discs of one level that is so as
//! with one level only. Of a small and a large disc the one that looked last saw the other:
//!
//! - A large disc is written into all finer cells whose discs it can meet while it stays within a
//!   small square around where it was then: at contact such a cell holds a point in the ring from
//!   its radius to both radii, stay and margin included. When it leaves the square or its cell it
//!   is written anew; then and when it changes its velocity, it looks into those cells.
//! - A small disc looks whenever it changes its velocity or its cell at who is written into that.
//!   So what is not seen by the small one looks later itself.
//!
//! What lies deep in a large disc is in no ring: until a look at all of it finds nothing there,
//! it is written into all of it. In exact motion nothing comes in but through the ring, and is met
//! there.
//!
//! Where a periodic box has no room for five cells of a level, that one and all beyond have one
//! cell, which nobody leaves: between two looks, discs then move far less than half the box.
//!
//! Never used where one level does: there nothing but one branch is added.

use glam::DVec2;

use super::cells::{Block, Border, Cells, EMPTY, Needs, ROOM_MAX, widths};
use super::lanes::{Meeting, NOBODY, Unit};
use super::{Due, Events, TIE};
use crate::world::Disc;

/// Discs of a cell from which on one level is not enough.
const CROWDED: f64 = 4.0;

/// Most discs wanted in one of the finest cells.
const FINEST: f64 = 1.2501;

/// Width of cells over that of the next finer level, at most where sizes are in between.
const FACTOR: f64 = 2.5;

/// Least width of a coarser cell, and its margin, in diameters.
const COARSER: (f64, f64) = (1.25, 0.1);

/// How far a large disc goes from where it was written into finer cells, in widths of the finest.
const STAY: f64 = 0.5;

/// Discs that a cell has room for.
const ROOM: usize = 8;

/// What lies beyond the finest cells.
#[derive(Clone, Debug, Default)]
pub struct Levels {
    coarser: Vec<Cells>,
    /// The largest radius of each level, m; the finest first.
    radii: Vec<f64>,
    /// The level of each disc.
    of: Vec<u8>,
    /// By disc: whether nothing lies deep in it.
    hollow: Vec<bool>,
    /// By level: the coarser discs that may be met in each cell.
    rims: Vec<Cells>,
    /// By disc: where it is written into rims.
    rings: Vec<Option<Box<Ring>>>,
    /// How far a large disc goes along each axis from where it was written down, m.
    stay: f64,
    /// Whether the last level is one cell of a periodic box.
    boundless: bool,
    /// To be looked at: kept for its memory.
    blocks: Vec<(usize, Block)>,
}

/// Where a large disc was when it was written into finer cells, and into which.
#[derive(Clone, Debug)]
struct Ring {
    centre: DVec2,
    blocks: Vec<(usize, Block)>,
}

/// Cells for discs as they lie.
pub struct Grids {
    /// The finest.
    pub cells: Cells,
    /// All others.
    pub levels: Levels,
    /// The largest diameter, m.
    pub diameter: f64,
    /// What the finest cells are made for.
    pub needs: Needs,
}

/// The cells that discs need: of one level, if those hold few discs.
pub fn grids(needs: &Needs, discs: &[Disc]) -> Grids {
    let (width, _) = widths(needs);
    // Around discs in the free plane there is as much room again.
    let share = if needs.border == Border::Open { 4.0 } else { 1.0 };
    if share * needs.density * width * width > CROWDED
        && let Some(grids) = on_levels(needs, discs, share)
    {
        return grids;
    }
    one_level(needs)
}

/// The cells of one level that fits all discs.
pub fn one_level(needs: &Needs) -> Grids {
    Grids {
        cells: Cells::new(needs),
        levels: Levels::default(),
        diameter: needs.diameter,
        needs: *needs,
    }
}

/// Several levels; `None` if there would be one, or a periodic box is too small.
fn on_levels(needs: &Needs, discs: &[Disc], share: f64) -> Option<Grids> {
    let mut radii: Vec<f64> = discs.iter().map(|disc| disc.radius).collect();
    radii.sort_unstable_by(f64::total_cmp);
    let (finest, count) = finest(needs, &radii, share);
    let (width, margin) = widths(&finest);
    let cells = Cells::of_width(&finest, width, margin, ROOM);
    let mut levels = Levels { stay: STAY * cells.width(), ..Levels::default() };
    levels.radii.push(radii[count - 1]);
    levels.add_coarser(&cells, needs, &radii, count);
    if levels.is_single() || !levels.are_wide(&cells, needs, &radii) {
        return None;
    }
    levels.of = discs.iter().map(|disc| levels.fitting(disc.radius)).collect();
    levels.hollow = vec![false; discs.len()];
    levels.rings = vec![None; discs.len()];
    let celled = levels.coarser.len();
    levels.rims = (0..celled).map(|level| levels.grid(&cells, level).clone()).collect();
    Some(Grids { cells, levels, diameter: needs.diameter, needs: finest })
}

/// The finest level: as many of the smallest discs as do not crowd cells that fit the largest of
/// them, and how many these are.
fn finest(needs: &Needs, radii: &[f64], share: f64) -> (Needs, usize) {
    let area = needs.area / share;
    let mut beyond = vec![0.0; radii.len() + 1];
    for k in (0..radii.len()).rev() {
        beyond[k] = beyond[k + 1] + std::f64::consts::PI * radii[k] * radii[k];
    }
    let of = |k: usize| {
        let density = (k + 1) as f64 / (area - beyond[k + 1]).max(0.25 * area);
        let (is_equal, is_finest) = (radii[0] == radii[k], k + 1 < radii.len());
        Needs { diameter: 2.0 * radii[k], density, is_equal, is_finest, ..*needs }
    };
    let fits = |k: usize| of(k).density * widths(&of(k)).0.powi(2) <= FINEST;
    let (mut low, mut high) = (0, radii.len());
    while high - low > 1 {
        let middle = usize::midpoint(low, high);
        if fits(middle) { low = middle } else { high = middle }
    }
    (of(low), radii.partition_point(|&radius| radius <= radii[low]))
}

impl Grids {
    /// Whether no disc of a periodic box can meet two images of another.
    pub fn are_wide(&self) -> bool {
        !self.levels.is_single() || self.cells.lines_min() >= 5
    }
}

impl Levels {
    /// Whether there is no coarser one.
    #[inline(always)]
    pub fn is_single(&self) -> bool {
        self.coarser.is_empty()
    }

    /// How many coarser ones there are.
    pub fn coarser(&self) -> usize {
        self.coarser.len()
    }

    /// The level of a disc.
    pub fn level(&self, disc: usize) -> usize {
        self.of.get(disc).map_or(0, |&level| usize::from(level))
    }

    /// The cells of a level; beyond the last, the rims of the first and so on.
    pub fn grid<'a>(&'a self, finest: &'a Cells, level: usize) -> &'a Cells {
        let Some(above) = level.checked_sub(1) else { return finest };
        let beyond = above.checked_sub(self.coarser.len());
        beyond.map_or_else(|| &self.coarser[above], |level| &self.rims[level])
    }

    /// The cells of a level, to be changed.
    pub fn grid_mut<'a>(&'a mut self, finest: &'a mut Cells, level: usize) -> &'a mut Cells {
        if level == 0 { finest } else { &mut self.coarser[level - 1] }
    }

    /// The finest level for discs of a radius.
    fn fitting(&self, radius: f64) -> u8 {
        self.radii.partition_point(|&largest| largest < radius) as u8
    }

    /// Levels for all but the `at` smallest discs.
    fn add_coarser(&mut self, finest: &Cells, needs: &Needs, radii: &[f64], mut at: usize) {
        let mut width = finest.width();
        while at < radii.len() {
            let mut limit = FACTOR * width;
            while 2.0 * COARSER.0 * radii[at] > limit {
                limit *= FACTOR;
            }
            at = radii.partition_point(|radius| 2.0 * COARSER.0 * radius <= limit).max(at + 1);
            let diameter = 2.0 * radii[at - 1];
            let least = (COARSER.0 * diameter).max(2.0 * width) * (1.0 + 1e-9);
            let mut cells = Cells::of_width(needs, least, COARSER.1 * diameter, ROOM);
            if matches!(needs.border, Border::Periodic(_)) && !is_wide(&cells, needs, radii, at) {
                let all = Needs { border: Border::Closed, ..*needs };
                cells = Cells::of_width(&all, f64::INFINITY, 0.0, ROOM_MAX);
                (at, self.boundless) = (radii.len(), true);
            }
            width = cells.width();
            self.radii.push(radii[at - 1]);
            self.coarser.push(cells);
        }
    }

    /// Whether the levels do for a periodic box.
    fn are_wide(&self, finest: &Cells, needs: &Needs, radii: &[f64]) -> bool {
        if !self.boundless {
            return !matches!(needs.border, Border::Periodic(_)) || finest.lines_min() >= 5;
        }
        let half = 0.5 * (needs.max - needs.min).min_element();
        let [.., second, first] = radii else { return false };
        let celled = self.radii.len() - 1;
        let clear = |level: usize| {
            let cells = self.grid(finest, level);
            first + self.radii[level] + 3.0 * cells.width() + self.stay < half
        };
        finest.lines_min() >= 5 && first + second + 2.0 * self.stay < half && (0..celled).all(clear)
    }

    /// The largest radius of a level, m; nothing where there is only one.
    pub fn radius(&self, level: usize) -> Option<f64> {
        self.radii.get(level).copied()
    }

    /// One more disc.
    pub fn push(&mut self, radius: f64) {
        if !self.is_single() {
            self.of.push(self.fitting(radius));
            self.hollow.push(false);
            self.rings.push(None);
        }
    }

    /// One disc less; the last takes its place.
    pub fn swap_remove(&mut self, disc: usize) {
        if !self.is_single() {
            self.of.swap_remove(disc);
            self.hollow.swap_remove(disc);
            self.rings.swap_remove(disc);
        }
    }

    /// Calls a disc otherwise in the rims.
    pub fn rename(&mut self, disc: usize, to: usize) {
        let ring = self.rings.get(disc).and_then(Option::as_ref);
        for (level, block) in ring.into_iter().flat_map(|ring| &ring.blocks) {
            self.rims[*level].remove_from(block, disc as u32);
            self.rims[*level].add_to(block, to as u32);
        }
    }

    /// Takes all discs out.
    pub fn clear(&mut self) {
        self.coarser.iter_mut().chain(&mut self.rims).for_each(Cells::clear);
        self.hollow.fill(false);
        self.rings.fill(None);
    }

    /// Takes a large disc out of the rims.
    pub fn erase(&mut self, disc: usize) {
        if self.is_single() {
            return;
        }
        for (level, block) in self.rings[disc].take().into_iter().flat_map(|ring| ring.blocks) {
            self.rims[level].remove_from(&block, disc as u32);
        }
    }

    /// Writes a large disc of a level into the rims.
    fn write(&mut self, finest: &Cells, disc: usize, centre: DVec2, radius: f64) {
        self.erase(disc);
        let mut blocks = Vec::new();
        // The corners of the square are farther than its sides.
        let stay = 1.5 * self.stay;
        for finer in 0..self.level(disc) {
            let inner = if self.hollow[disc] { (radius - stay).max(0.0) } else { 0.0 };
            let outer = radius + self.radii[finer] + stay;
            let cells = self.grid(finest, finer);
            cells.for_each_in_ring(centre, (inner, outer), &mut |block| {
                blocks.push((finer, block));
            });
        }
        for (level, block) in &blocks {
            self.rims[*level].add_to(block, disc as u32);
        }
        self.rings[disc] = Some(Box::new(Ring { centre, blocks }));
    }
}

/// Whether cells are narrow enough for a periodic box, in which the largest discs may be too large
/// for any.
fn is_wide(cells: &Cells, needs: &Needs, radii: &[f64], discs: usize) -> bool {
    let side = (needs.max - needs.min).min_element();
    let largest = radii[radii.len() - 1];
    let clear = largest + radii[discs - 1] + 4.0 * cells.width() < 0.5 * side;
    cells.lines_min() >= 5 && (clear || 5.0 * 2.0 * COARSER.0 * largest < side)
}

impl Events {
    /// The largest radius that the cells of a disc have room for, m.
    pub(super) fn radius_max(&self, k: usize) -> f64 {
        let radii = &self.levels.radii;
        radii.get(self.levels.level(k)).copied().unwrap_or(0.5 * self.diameter)
    }

    /// Predicts a disc among those of all levels.
    #[inline(never)]
    pub(super) fn predict_on_levels<U: Unit>(&mut self, k: usize) {
        let (level, place) = (self.levels.level(k), self.dues[k].place);
        if level > 0 && self.levels.rings[k].is_none() {
            self.write(k);
        }
        let mut blocks = std::mem::take(&mut self.levels.blocks);
        self.list_blocks(k, &mut blocks);
        let is_searched = level > 0 && !self.levels.hollow[k];
        let (mut found, mut filled) = (NOBODY, false);
        self.gather::<U>(&blocks, |arena| {
            let meeting = arena.earliest_gathered::<U>(k);
            found = earlier(found, meeting, arena.same_instant);
            filled |= is_searched && arena.is_filled(k);
        });
        if is_searched && !filled {
            self.levels.hollow[k] = true;
            self.write(k);
        }
        self.levels.blocks = blocks;
        self.take_on_level(k, self.due_for(k, found, place));
    }

    /// Writes down what a disc is due for, if no wall comes before that.
    fn take_on_level(&mut self, k: usize, mut due: Due) {
        let level = self.levels.level(k);
        let cells = self.levels.grid(&self.cells, level);
        let outermost = cells.is_outermost(due.place);
        self.consider_wall(k, &mut due, outermost);
        due.exit = self.exit(self.exits_between(k, cells.edges(due.place)));
        if let Some(ring) = &self.levels.rings[k] {
            let (low, high) = (ring.centre - self.levels.stay, ring.centre + self.levels.stay);
            due.exit = due.exit.min(self.exit(self.exits_between(k, (low, high))));
        }
        self.dues[k] = due;
        if self.fence.is_some() {
            self.consider_segments(k, level);
        }
    }

    /// All cells in which a disc may meet somebody.
    fn list_blocks(&self, k: usize, blocks: &mut Vec<(usize, Block)>) {
        let level = self.levels.level(k);
        blocks.clear();
        let cells = self.levels.grid(&self.cells, level);
        blocks.push((level, cells.around(self.dues[k].place)));
        self.list_coarser(k, blocks);
        if let Some(ring) = &self.levels.rings[k] {
            blocks.extend_from_slice(&ring.blocks);
        }
    }

    fn list_coarser(&self, k: usize, blocks: &mut Vec<(usize, Block)>) {
        let level = self.levels.level(k);
        if let Some(rims) = self.levels.rims.get(level) {
            blocks.push((level + 1 + self.levels.coarser.len(), rims.only(self.dues[k].place)));
        }
    }

    /// Writes a large disc into finer cells where it is now.
    fn write(&mut self, k: usize) {
        let (centre, radius) = (self.flights[k].at(self.now), self.radii.get(k));
        self.levels.write(&self.cells, k, centre, radius);
    }

    /// Gathers who is in the blocks, and calls when all are or there is no room for more.
    #[inline(always)]
    fn gather<U: Unit>(&mut self, blocks: &[(usize, Block)], mut act: impl FnMut(&mut Self)) {
        self.near[0].clear();
        for &(level, block) in blocks {
            if !self.near[0].has_room(block.count()) {
                act(self);
                self.near[0].clear();
            }
            let cells = self.levels.grid(&self.cells, level);
            U::gather(cells.numbers(), &block, &mut self.near[0]);
            if cells.is_spilled() {
                let beyond: Vec<u32> = cells.beyond(&block).collect();
                for disc in beyond {
                    if !self.near[0].has_room(1) {
                        act(self);
                        self.near[0].clear();
                    }
                    self.near[0].push(disc);
                }
            }
        }
        act(self);
    }

    /// Whether one of the gathered discs of finer levels lies deep in this one.
    fn is_filled(&self, k: usize) -> bool {
        let level = self.levels.level(k);
        let finer = |other: &&u32| self.levels.level(**other as usize) < level;
        self.near[0].discs().iter().filter(finer).any(|&other| self.is_deep_in(other as usize, k))
    }

    /// Whether a disc has its centre within a larger one.
    fn is_deep_in(&self, k: usize, larger: usize) -> bool {
        self.offset(larger, k).length() < self.radii.get(larger)
    }

    /// A disc was put where it did not come by flying: it may lie deep in others, and they in it.
    pub(super) fn note_jump(&mut self, k: usize) {
        if self.levels.is_single() {
            return;
        }
        self.levels.erase(k);
        self.levels.hollow[k] = false;
        let level = self.levels.level(k);
        // Cells are wider than the discs that live in them, so it lies next to their centres.
        for larger in level + 1..self.levels() {
            let cells = self.levels.grid(&self.cells, larger);
            let block = cells.around(cells.place(self.position(k)));
            let held = block.rows().flat_map(|row| &cells.numbers()[row]).copied();
            let held: Vec<u32> = held.chain(cells.beyond(&block)).collect();
            for larger in held.into_iter().filter(|held| *held != EMPTY).map(|held| held as usize) {
                if self.levels.hollow[larger] && self.is_deep_in(k, larger) {
                    self.levels.hollow[larger] = false;
                    self.write(larger);
                }
            }
        }
    }

    /// The discs around another on all levels.
    pub(super) fn discs_on_levels_near<U: Unit>(&mut self, k: usize) -> Vec<usize> {
        let (mut blocks, mut discs) = (Vec::new(), Vec::new());
        self.list_blocks(k, &mut blocks);
        self.gather::<U>(&blocks, |arena| {
            discs.extend(arena.near[0].discs().iter().map(|&other| other as usize));
        });
        discs
    }

    /// A disc leaves its cell, or has come as far as its stay.
    #[inline(never)]
    pub(super) fn change_cell_on_level<U: Unit>(&mut self, k: usize, due: Due) {
        let level = self.levels.level(k);
        let cells = self.levels.grid_mut(&mut self.cells, level);
        let edges = cells.edges(due.place);
        let (x, y) = self.exits_between(k, edges);
        if level > 0 {
            self.levels.erase(k);
        }
        if level > 0 && x.min(y) > due.exit {
            self.come_into_box(k, level);
            return U::renew(self, k, f64::NAN);
        }
        let along_x = x <= y;
        let flight = &mut self.flights[k];
        let up = if along_x { flight.vx > 0.0 } else { flight.vy > 0.0 };
        let cells = self.levels.grid_mut(&mut self.cells, level);
        let Some((place, shift)) = cells.neighbour(due.place, along_x, up) else {
            return self.renew_all_cells();
        };
        (flight.x, flight.y) = (flight.x + shift.x, flight.y + shift.y);
        self.noted.turn(&[k]);
        cells.remove(due.place, k as u32);
        cells.add(place, k as u32);
        self.dues[k].place = place;
        if level > 0 || self.is_stale(&due) {
            return U::renew(self, k, f64::NAN);
        }
        let ahead = self.cells.ahead(place, along_x, up);
        self.predict_ahead_on_levels::<U>(k, Due { place, ..due }, ahead);
        self.calendar.insert(self.dues[k].time(), k);
    }

    /// Discs that leave no cell come back into a periodic box here.
    fn come_into_box(&mut self, k: usize, level: usize) {
        if self.levels.boundless && level == self.levels.coarser.len() {
            self.bring_inside(k);
        }
    }

    /// What is known of the own level still holds, but for cells that came near; the coarser ones
    /// are all looked at.
    fn predict_ahead_on_levels<U: Unit>(&mut self, k: usize, mut due: Due, ahead: Block) {
        let mut blocks = std::mem::take(&mut self.levels.blocks);
        blocks.clear();
        blocks.push((0, ahead));
        self.list_coarser(k, &mut blocks);
        let mut found = NOBODY;
        self.gather::<U>(&blocks, |arena| {
            let meeting = arena.earliest_gathered::<U>(k);
            found = earlier(found, meeting, arena.same_instant);
        });
        self.levels.blocks = blocks;
        // Who was known already is seen again at the same time but for rounding.
        let is_known = found.with as usize == due.met();
        if is_known && found.time + self.same_instant >= due.contact {
            due.partner |= if found.tie { TIE } else { 0 };
        } else {
            due = self.sooner(k, due, found);
        }
        self.take_on_level(k, due);
    }
}

/// The earlier of two meetings.
fn earlier(a: Meeting, b: Meeting, instant: f64) -> Meeting {
    let (first, second) = if b.time < a.time { (b, a) } else { (a, b) };
    let is_tied = second.time < f64::INFINITY && second.time <= first.time + instant;
    Meeting { tie: first.tie || is_tied, ..first }
}
