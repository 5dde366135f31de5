//! Who may meet whom, kept over many ticks: lists of neighbours with a skin.
//!
//! Lists hold as long as every disc stays within its leash, half of the skin, of where it was when
//! they were made (Verlet, doi:10.1103/PhysRev.159.98). A disc that may leave it before the window
//! ends is a rover there: everyone is its neighbour. So lists leave nobody out, whatever is thrown
//! or carried about, and results do not depend on when they were made.

use glam::DVec2;

use super::bodies::{Bodies, Body, Seen, Sizes};
use super::cells::Cells;
use crate::world::Periodic;

/// The leash in mean ways of a window; the bounds in mean radii. Measured: a quarter as much costs
/// a third to a half more (`cargo bench --bench ticks`, robots and random pucks).
const LEASH_WAYS: f64 = 12.0;
const LEASH_RADII: (f64, f64) = (0.5, 4.0);

/// More rovers than when the lists were made before they are made again.
const ROVERS_MORE: usize = 2;

/// Windows after which lists are made again in any case: discs may have slowed down.
const AGE_MAX: u32 = 256;

/// Lists of neighbours.
#[derive(Clone, Debug)]
pub(super) struct Neighbours {
    periodic: Option<Periodic>,
    /// Windows since the lists were made; beyond its maximum before.
    age: u32,
    leash: f64,
    /// Where the discs were when the lists were made.
    listed: Vec<DVec2>,
    all: Lists,
    /// Those with a larger index only.
    later: Lists,
    rovers: Vec<u32>,
    is_rover: Vec<bool>,
    /// Rovers when the lists were made.
    rovers_usual: usize,
    cells: Cells,
}

/// A list for each disc, one after the other.
#[derive(Clone, Debug, Default)]
struct Lists {
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Lists {
    fn clear(&mut self) {
        self.starts.clear();
        self.starts.push(0);
        self.items.clear();
    }

    fn end_list(&mut self) {
        self.starts.push(self.items.len() as u32);
    }

    fn of(&self, k: usize) -> &[u32] {
        &self.items[self.starts[k] as usize..self.starts[k + 1] as usize]
    }
}

impl Neighbours {
    /// No lists yet.
    pub fn new(periodic: Option<Periodic>) -> Self {
        Self {
            periodic,
            age: u32::MAX,
            leash: 0.0,
            listed: Vec::new(),
            all: Lists::default(),
            later: Lists::default(),
            rovers: Vec::new(),
            is_rover: Vec::new(),
            rovers_usual: 0,
            cells: Cells::new(periodic),
        }
    }

    /// To be called when discs came, went or changed their size.
    pub fn discard(&mut self) {
        self.age = u32::MAX;
    }

    /// Makes the lists hold for a window of so many seconds that begins with the discs as seen.
    pub fn prepare(&mut self, bodies: &Bodies, sizes: &Sizes, window: f64) {
        self.age = self.age.saturating_add(1);
        if self.age <= AGE_MAX {
            self.find_rovers(&bodies.seen, window);
            if self.rovers.len() <= self.rovers_usual + ROVERS_MORE {
                return;
            }
        }
        self.make(bodies, sizes, window);
        self.find_rovers(&bodies.seen, window);
        self.rovers_usual = self.rovers.len();
    }

    /// Leaves lists out: everyone is a rover.
    pub fn prepare_none(&mut self, count: usize) {
        self.discard();
        self.is_rover.clear();
        self.is_rover.resize(count, true);
        self.rovers.clear();
        self.rovers.extend(0..count as u32);
    }

    /// The neighbours of a disc, and perhaps itself.
    pub fn of(&self, k: usize) -> impl Iterator<Item = usize> + '_ {
        let (everyone, listed, rovers) = if self.is_rover[k] {
            (0..self.is_rover.len(), &[][..], &[][..])
        } else {
            (0..0, self.all.of(k), &self.rovers[..])
        };
        let listed = listed.iter().map(|&j| j as usize).filter(|&j| !self.is_rover[j]);
        everyone.chain(listed).chain(rovers.iter().map(|&j| j as usize))
    }

    /// Calls `look` once for each two neighbours.
    #[inline]
    pub fn for_each_pair(&self, mut look: impl FnMut(usize, usize)) {
        let listed = if self.rovers.len() < self.is_rover.len() { self.is_rover.len() } else { 0 };
        for i in 0..listed {
            for &j in self.later.of(i) {
                let j = j as usize;
                if !(self.is_rover[i] | self.is_rover[j]) {
                    look(i, j);
                }
            }
        }
        for &i in &self.rovers {
            let i = i as usize;
            for j in 0..self.is_rover.len() {
                // Two rovers would find each other twice.
                if j > i || !self.is_rover[j] {
                    look(i.min(j), i.max(j));
                }
            }
        }
    }

    /// Lets a disc rove until the window ends, if it may leave its leash by then.
    pub fn follow(&mut self, k: usize, position: DVec2, way: f64) {
        if !self.is_rover[k] && !self.holds(k, position, way) {
            self.is_rover[k] = true;
            self.rovers.push(k as u32);
        }
    }

    /// Whether a disc at a place stays within its leash on a way of so many metres.
    #[inline]
    fn holds(&self, k: usize, position: DVec2, way: f64) -> bool {
        let mut moved = position - self.listed[k];
        if let Some(periodic) = &self.periodic {
            moved += periodic.shift(moved);
        }
        let rest = self.leash - way;
        rest >= 0.0 && moved.length_squared() <= rest * rest
    }

    fn find_rovers(&mut self, seen: &[Seen], window: f64) {
        self.rovers.clear();
        self.is_rover.clear();
        for (k, disc) in seen.iter().enumerate() {
            let roves = !self.holds(k, disc.position, disc.speed * window);
            self.is_rover.push(roves);
            if roves {
                self.rovers.push(k as u32);
            }
        }
    }

    /// Lists all pairs that could touch while both are on the leash.
    fn make(&mut self, bodies: &Bodies, sizes: &Sizes, window: f64) {
        let Bodies { seen, bodies, .. } = bodies;
        let (least, most) = LEASH_RADII;
        let way_radii = sizes.speed_mean * window / sizes.radius_mean;
        self.leash = (LEASH_WAYS * way_radii).max(least).min(most) * sizes.radius_mean;
        self.age = 0;
        self.listed.clear();
        self.listed.extend(seen.iter().map(|disc| disc.position));
        self.cells.sort(seen, sizes.radius_mean, 2.0 * self.leash);
        self.all.clear();
        self.later.clear();
        for k in 0..seen.len() {
            self.list(seen, bodies, k);
        }
    }

    fn list(&mut self, seen: &[Seen], bodies: &[Body], k: usize) {
        let (all, later) = (&mut self.all, &mut self.later);
        self.cells.for_each_near(seen, k, |j| {
            if bodies[k].can_collide_with(&bodies[j as usize]) {
                all.items.push(j);
                if j as usize > k {
                    later.items.push(j);
                }
            }
        });
        all.end_list();
        later.end_list();
    }
}
