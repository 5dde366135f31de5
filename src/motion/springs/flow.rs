//! Many contacts over a step: each one that is alone runs in closed form; where several share a
//! disc, time is cut until they are alone, or so fine that the implicit rule is accurate.
//!
//! What fixes the cut is the contacts and not the caller's step: a blow that lasts a microsecond
//! costs a few cuts around it, not a microsecond step for all. After each part the new velocities
//! are looked at backwards: discs that have met on the way, and were not thought to, are taken
//! together and the part is done again.
//!
//! Never move a disc here but through [`super::pair`], [`super::cluster`] and free flight.

use glam::DVec2;

use super::Laws;
use super::cluster::{self, Implicit};
use super::links::{self, Link, Other, stiffest_mode};
use super::pair::{Work, fly};
use crate::detect::{self, Pair, TooManyPairs};
use crate::plan::BroadPhase;
use crate::world::Disc;

/// Parts of a step where contacts share a disc, in units of 1 / omega of their stiffest mode.
const FINE: f64 = 0.05;

/// The same beyond which swinging is not resolved any more.
const COARSE: f64 = 1.0;

/// What stays the same over all parts of a step.
#[derive(Clone, Copy, Debug)]
pub struct Flow<'a> {
    /// The laws.
    pub laws: &'a Laws,
    /// How neighbours are found.
    pub broad_phase: BroadPhase,
    /// Parts are not made shorter than this, s.
    pub shortest: f64,
}

impl Flow<'_> {
    /// Moves the discs by `h` (s); returns what the contacts did, with times from `offset`.
    pub fn advance(
        &self,
        discs: &mut [Disc],
        h: f64,
        offset: f64,
    ) -> Result<Vec<Work>, TooManyPairs> {
        let start = discs.to_vec();
        let links = links::within(discs, self.laws.walls.as_ref(), h, self.broad_phase)?;
        let met = |discs: &[Disc]| self.met(discs, h);
        self.advance_from(&start, discs, links, (h, offset), met)
    }

    /// The same where no others come near within the step than these pairs, as long as speeds stay
    /// up to a limit (m/s); `None` if they do not.
    pub fn advance_among(
        &self,
        start: &[Disc],
        discs: &mut [Disc],
        near: &[Pair],
        speed_max: f64,
        h: f64,
    ) -> Result<Option<Vec<Work>>, TooManyPairs> {
        let walls = self.laws.walls.as_ref();
        let links = links::among(discs, near, walls, h, 1.0);
        let met = |discs: &[Disc]| {
            let mut met = links::among(discs, near, None, h, -1.0);
            met.extend(links::among(discs, near, walls, 0.0, 1.0));
            Ok(met)
        };
        let works = self.advance_from(start, discs, links, (h, 0.0), met)?;
        Ok((links::fastest(discs) <= speed_max).then_some(works))
    }

    /// Moves `discs`, which are as at the `start`, with these links and whom they turn out to meet.
    fn advance_from(
        &self,
        start: &[Disc],
        discs: &mut [Disc],
        mut links: Vec<Link>,
        (h, offset): (f64, f64),
        met: impl Fn(&[Disc]) -> Result<Vec<Link>, TooManyPairs>,
    ) -> Result<Vec<Work>, TooManyPairs> {
        loop {
            let mut groups = Groups::of(&links);
            let mut works = Vec::new();
            for (disc, before) in discs.iter_mut().zip(start) {
                disc.position = before.position + before.velocity * h;
            }
            for (members, links) in groups.listed(&links) {
                members.iter().for_each(|&k| discs[k] = start[k]);
                self.advance_group(discs, &members, &links, (h, offset), &mut works)?;
            }
            let known = links.len();
            for link in met(discs)? {
                let together = match link.b {
                    Other::Disc(b) => groups.are_together(link.a, b),
                    Other::Wall(_) => links[..known].contains(&link),
                };
                if !together {
                    links.push(link);
                }
            }
            if links.len() == known {
                return Ok(works);
            }
            discs.copy_from_slice(start);
        }
    }

    /// The contacts that exist at the end, and those from which straight flight may have led there.
    fn met(&self, discs: &[Disc], h: f64) -> Result<Vec<Link>, TooManyPairs> {
        let near =
            detect::touching_pairs(discs, 2.0 * links::fastest(discs) * h, self.broad_phase)?;
        let mut met = links::among(discs, &near, None, h, -1.0);
        met.extend(links::among(discs, &near, self.laws.walls.as_ref(), 0.0, 1.0));
        Ok(met)
    }

    fn advance_group(
        &self,
        discs: &mut [Disc],
        members: &[usize],
        links: &[Link],
        (h, offset): (f64, f64),
        works: &mut Vec<Work>,
    ) -> Result<(), TooManyPairs> {
        match links {
            [] => unreachable!("a group hangs together by links"),
            [link] => {
                let work = fly(discs, *link, self.laws, h);
                works.extend(work.map(|work| Work { begins: offset + work.begins, ..work }));
            }
            _ => {
                let mut group: Vec<Disc> = members.iter().map(|&k| discs[k]).collect();
                let place = |k: usize| members.partition_point(|&member| member < k);
                let local: Vec<Link> = links.iter().map(|link| link.renamed(place)).collect();
                let done = self.advance_cluster(&mut group, &local, h, offset)?;
                let back = |work: Work| Work { link: work.link.renamed(|k| members[k]), ..work };
                works.extend(done.into_iter().map(back));
                members.iter().zip(group).for_each(|(&k, disc)| discs[k] = disc);
            }
        }
        Ok(())
    }

    /// Several contacts in one group: finer, or together.
    fn advance_cluster(
        &self,
        discs: &mut [Disc],
        links: &[Link],
        h: f64,
        offset: f64,
    ) -> Result<Vec<Work>, TooManyPairs> {
        let omega = stiffest_mode(discs, links, self.laws.stiffness).sqrt();
        if h * omega <= FINE || h <= self.shortest {
            // What can not be resolved is damped: it must not grow.
            let resolved = h * omega <= COARSE;
            let rule = if resolved { Implicit::Midpoint } else { Implicit::BackwardEuler };
            return Ok(together(discs, links, self.laws, (h, offset), rule));
        }
        let half = 0.5 * h;
        let mut works = self.advance(discs, half, offset)?;
        works.extend(self.advance(discs, h - half, offset + half)?);
        Ok(works)
    }
}

/// All contacts of the links at once, by an implicit rule.
pub fn together(
    discs: &mut [Disc],
    links: &[Link],
    laws: &Laws,
    (h, offset): (f64, f64),
    rule: Implicit,
) -> Vec<Work> {
    let work = |&link: &Link| {
        let normal = link.normal(discs);
        Work {
            link,
            begins: offset,
            approach_speed: link.velocity(discs).dot(normal),
            normal,
            centre: discs[link.a].position,
            impulse: 0.0,
            loss: link.stored(discs, laws),
            deepest: link.overlap(discs, laws),
        }
    };
    let mut works: Vec<Work> = links.iter().map(work).collect();
    let before: Vec<DVec2> = links.iter().map(|link| link.velocity(discs)).collect();
    let impulses = cluster::step(discs, links, laws, h, rule);
    for ((work, before), (impulse, normal)) in works.iter_mut().zip(before).zip(impulses) {
        let mean_velocity = 0.5 * (before + work.link.velocity(discs));
        work.impulse = impulse;
        // What the motion gave, less what the spring took.
        work.loss += impulse * mean_velocity.dot(normal);
        work.loss -= work.link.stored(discs, laws);
        work.deepest = work.deepest.max(work.link.overlap(discs, laws));
    }
    works.retain(|work| work.impulse != 0.0);
    works
}

impl Link {
    fn renamed(&self, name: impl Fn(usize) -> usize) -> Self {
        let b = match self.b {
            Other::Disc(b) => Other::Disc(name(b)),
            wall => wall,
        };
        Self { a: name(self.a), b }
    }
}

/// Discs that hang together by links (union-find over those that have one).
struct Groups {
    /// In ascending order.
    members: Vec<usize>,
    /// By places in `members`.
    roots: Vec<usize>,
}

impl Groups {
    fn of(links: &[Link]) -> Self {
        let mut members: Vec<usize> = Vec::with_capacity(2 * links.len());
        for link in links {
            members.push(link.a);
            if let Other::Disc(b) = link.b {
                members.push(b);
            }
        }
        members.sort_unstable();
        members.dedup();
        let mut groups = Self { roots: (0..members.len()).collect(), members };
        for link in links {
            if let Other::Disc(b) = link.b {
                let (a, b) = (groups.place(link.a), groups.place(b));
                let (a, b) = (groups.root(a), groups.root(b));
                groups.roots[a.max(b)] = a.min(b);
            }
        }
        groups
    }

    /// Where a disc with a link is in `members`; where it would be, if it has none.
    fn place(&self, disc: usize) -> usize {
        self.members.partition_point(|member| *member < disc)
    }

    fn root(&mut self, mut k: usize) -> usize {
        while self.roots[k] != k {
            self.roots[k] = self.roots[self.roots[k]];
            k = self.roots[k];
        }
        k
    }

    fn are_together(&mut self, a: usize, b: usize) -> bool {
        let [i, j] = [a, b].map(|disc| self.place(disc));
        let known = self.members.get(i) == Some(&a) && self.members.get(j) == Some(&b);
        known && self.root(i) == self.root(j)
    }

    /// Each group's discs and links, in the order of their first discs.
    fn listed(&mut self, links: &[Link]) -> Vec<(Vec<usize>, Vec<Link>)> {
        const NONE: usize = usize::MAX;
        let mut listed: Vec<(Vec<usize>, Vec<Link>)> = Vec::new();
        let mut number = vec![NONE; self.members.len()];
        for k in 0..self.members.len() {
            let root = self.root(k);
            if number[root] == NONE {
                number[root] = listed.len();
                listed.push((Vec::new(), Vec::new()));
            }
            listed[number[root]].0.push(self.members[k]);
        }
        for link in links {
            let place = self.place(link.a);
            listed[number[self.root(place)]].1.push(*link);
        }
        listed
    }
}
