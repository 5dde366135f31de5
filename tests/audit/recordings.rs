//! Recordings for the audit: clean ones of carom's arena, and ones spoilt on purpose by an engine
//! of the tests' own, which does one collision wrong and goes on lawfully.

use carom::audit::Frame;
use carom::motion::arena::Arena;
use carom::plan::Plan;
use carom::scene::lattice::Lattice;
use carom::world::{Disc, Owner, Settings, Walls};
use glam::DVec2;

use crate::common::Random;

/// Samples of an arena at a rate.
pub fn sampled(arena: &mut Arena, rate: f64, frames: usize) -> Vec<Frame> {
    let start = arena.now();
    let sample = |k: usize| {
        let time = start + k as f64 / rate;
        while arena.now() < time {
            arena.pass(time).expect("no stall");
        }
        let discs = arena.discs(Owner::Simulated).collect();
        Frame { time_ns: (1e9 * k as f64 / rate).round() as i64, discs }
    };
    (0..frames).map(sample).collect()
}

/// A melted gas of pucks between walls.
pub struct Gas {
    pub count: usize,
    pub area_fraction: f64,
    pub size_ratio: f64,
    pub mass_max: f64,
    pub restitution: f64,
    /// Diameters of the smaller pucks, m.
    pub diameter: f64,
    pub seed: u64,
}

impl Gas {
    pub fn new(count: usize, area_fraction: f64) -> Self {
        let (size_ratio, mass_max, restitution) = (1.0, 1.0, 1.0);
        Self { count, area_fraction, size_ratio, mass_max, restitution, diameter: 0.1, seed: 1 }
    }

    /// The arena after a few collisions of each.
    pub fn arena(&self) -> (Arena, Settings) {
        let lattice = Lattice {
            count: self.count,
            area_fraction: self.area_fraction,
            size_ratio: self.size_ratio,
            mass_max: self.mass_max,
            walled: true,
            seed: self.seed,
        };
        let (mut discs, side) = lattice.discs().expect("room");
        for disc in &mut discs {
            disc.position *= self.diameter;
            disc.radius *= self.diameter;
        }
        let (min, max) = (DVec2::ZERO, DVec2::splat(side * self.diameter));
        let walls = Walls { min, max, restitution: self.restitution };
        let settings =
            Settings { restitution: self.restitution, walls: Some(walls), ..Settings::default() };
        let plan = Plan::of(&settings, &discs);
        let mut arena = Arena::new(&plan, plan.laws(&settings), &discs);
        while arena.contacts() < 5 * self.count as u64 {
            let next = arena.now() + 0.01;
            while arena.now() < next {
                arena.pass(next).expect("no stall");
            }
        }
        (arena, settings)
    }
}

/// How a collision is spoilt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spoil {
    /// One of the two keeps a tenth of its impulse.
    Momentum,
    /// Restitution is half of the law's.
    Energy,
    /// The impulse is turned by 0.3 rad.
    Normal,
    /// No restitution, and they stay together.
    Sticking,
    /// As if the masses were exchanged.
    SwappedMasses,
    /// Velocities times -0.1.
    Scaled,
    /// They run through each other.
    Unseen,
    /// They answer only when they overlap by a part of the radius.
    Late(f64),
}

/// An engine that does what it is told with one pair, and the law with all others.
pub struct Engine {
    pub discs: Vec<Disc>,
    pub restitution: f64,
    pub walls: Option<Walls>,
    pub now: f64,
    /// Pairs that do not see each other, until they are apart.
    blind: Option<(usize, usize)>,
    /// How late a pair answers, part of the smaller radius.
    late: Option<(usize, usize, f64)>,
}

/// The collision that was spoilt.
#[derive(Clone, Copy, Debug)]
pub struct Spoilt {
    pub time: f64,
    pub pair: [u32; 2],
}

impl Engine {
    pub fn new(discs: Vec<Disc>, restitution: f64, walls: Option<Walls>) -> Self {
        Self { discs, restitution, walls, now: 0.0, blind: None, late: None }
    }

    fn impact(&self, i: usize, j: usize) -> Option<f64> {
        let (a, b) = (&self.discs[i], &self.discs[j]);
        let (d, w) = (b.position - a.position, b.velocity - a.velocity);
        let mut s = a.radius + b.radius;
        if let Some((x, y, part)) = self.late
            && (x, y) == (i, j)
        {
            s -= part * a.radius.min(b.radius);
        }
        let (dw, ww) = (d.dot(w), w.dot(w));
        let root = dw * dw - ww * (d.dot(d) - s * s);
        (dw < 0.0 && root >= 0.0).then(|| ((-dw - root.sqrt()) / ww).max(0.0))
    }

    fn next(&self) -> Option<(f64, usize, Option<usize>, DVec2)> {
        let mut next: Option<(f64, usize, Option<usize>, DVec2)> = None;
        let mut offer = |time: f64, i, j, n| {
            if next.is_none_or(|(first, ..)| time < first) {
                next = Some((time, i, j, n));
            }
        };
        for i in 0..self.discs.len() {
            for j in i + 1..self.discs.len() {
                if self.blind != Some((i, j))
                    && let Some(time) = self.impact(i, j)
                {
                    offer(time, i, Some(j), DVec2::ZERO);
                }
            }
            let Some(walls) = self.walls else { continue };
            let Disc { position, velocity, radius, .. } = self.discs[i];
            for (n, left) in [
                (DVec2::X, walls.max.x - radius - position.x),
                (DVec2::NEG_X, position.x - radius - walls.min.x),
                (DVec2::Y, walls.max.y - radius - position.y),
                (DVec2::NEG_Y, position.y - radius - walls.min.y),
            ] {
                let speed = velocity.dot(n);
                if speed > 0.0 {
                    offer((left / speed).max(0.0), i, None, n);
                }
            }
        }
        next
    }

    fn drift(&mut self, time: f64) {
        self.discs.iter_mut().for_each(|disc| disc.position += disc.velocity * time);
        self.now += time;
        if let Some((i, j)) = self.blind {
            let (a, b) = (&self.discs[i], &self.discs[j]);
            let d = b.position - a.position;
            if d.length() > a.radius + b.radius && d.dot(b.velocity - a.velocity) > 0.0 {
                self.blind = None;
            }
        }
    }

    fn normal(&self, i: usize, j: usize) -> DVec2 {
        (self.discs[j].position - self.discs[i].position).normalize()
    }

    /// Restitution `e` along `n`, with these masses.
    fn exchange(&mut self, (i, j): (usize, usize), n: DVec2, e: f64, (ma, mb): (f64, f64)) {
        let w = self.discs[j].velocity - self.discs[i].velocity;
        let jump = (1.0 + e) * w.dot(n) / (ma + mb);
        self.discs[i].velocity += mb * jump * n;
        self.discs[j].velocity -= ma * jump * n;
    }

    fn lawful(&mut self, i: usize, j: usize) {
        let masses = (self.discs[i].mass, self.discs[j].mass);
        self.exchange((i, j), self.normal(i, j), self.restitution, masses);
    }

    fn spoil(&mut self, (i, j): (usize, usize), how: Spoil) {
        let (n, e) = (self.normal(i, j), self.restitution);
        let masses = (self.discs[i].mass, self.discs[j].mass);
        match how {
            Spoil::Momentum => {
                let before = self.discs[j].velocity;
                self.lawful(i, j);
                self.discs[j].velocity = before + 0.1 * (self.discs[j].velocity - before);
            }
            Spoil::Energy => self.exchange((i, j), n, 0.5 * e, masses),
            Spoil::Normal => {
                self.exchange((i, j), DVec2::from_angle(0.3).rotate(n), e, masses);
            }
            Spoil::Sticking => {
                self.exchange((i, j), n, 0.0, masses);
                self.blind = Some((i, j));
            }
            Spoil::SwappedMasses => self.exchange((i, j), n, e, (masses.1, masses.0)),
            Spoil::Scaled => {
                self.discs[i].velocity *= -0.1;
                self.discs[j].velocity *= -0.1;
            }
            Spoil::Unseen => self.blind = Some((i, j)),
            Spoil::Late(part) => self.late = Some((i, j, part)),
        }
    }

    /// Samples, and the collision that was spoilt: the first for which `which` is true.
    pub fn record(
        &mut self,
        rate: f64,
        frames: usize,
        how: Option<Spoil>,
        which: impl Fn(&[Disc], usize, usize, f64) -> bool,
    ) -> (Vec<Frame>, Option<Spoilt>) {
        let mut spoilt = None;
        let mut all = Vec::new();
        for k in 0..frames {
            let until = k as f64 / rate;
            while let Some((time, i, j, n)) = self.next()
                && self.now + time <= until
            {
                self.drift(time);
                let Some(j) = j else {
                    let v = self.discs[i].velocity;
                    let e = self.walls.map_or(1.0, |walls| walls.restitution);
                    self.discs[i].velocity = v - (1.0 + e) * v.dot(n) * n;
                    continue;
                };
                match how {
                    Some(how) if spoilt.is_none() && which(&self.discs, i, j, self.now) => {
                        let pair = [self.discs[i].id, self.discs[j].id];
                        spoilt = Some(Spoilt { time: self.now, pair });
                        self.spoil((i, j), how);
                    }
                    _ => {
                        self.lawful(i, j);
                        self.late = None;
                    }
                }
            }
            self.drift(until - self.now);
            let time_ns = (1e9 * until).round() as i64;
            all.push(Frame { time_ns, discs: self.discs.clone() });
        }
        (all, spoilt)
    }
}

/// Adds Gaussian noise to all that is recorded.
pub fn with_noise(frames: &mut [Frame], position: f64, velocity: f64, random: &mut Random) {
    let mut gauss = || {
        let radius = (-2.0 * random.uniform(0.0, 1.0).max(1e-300).ln()).sqrt();
        radius * DVec2::from_angle(random.uniform(0.0, std::f64::consts::TAU))
    };
    for disc in frames.iter_mut().flat_map(|frame| &mut frame.discs) {
        disc.position += position * gauss();
        disc.velocity += velocity * gauss();
    }
}

/// Rounds all that is recorded to 4 bytes.
pub fn in_single(frames: &mut [Frame]) {
    let single = |v: DVec2| v.as_vec2().as_dvec2();
    for disc in frames.iter_mut().flat_map(|frame| &mut frame.discs) {
        disc.position = single(disc.position);
        disc.velocity = single(disc.velocity);
    }
}
