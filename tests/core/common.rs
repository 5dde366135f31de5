//! Random numbers and discs that several tests share, always from a seed.

use carom::motion::plain::Plain;
use carom::plan::Plan;
use carom::world::{Contact, Disc, Owner, Settings, Walls};
use glam::DVec2;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

/// A seeded source of test numbers.
pub struct Random(Pcg64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(Pcg64::seed_from_u64(seed))
    }

    pub fn uniform(&mut self, min: f64, max: f64) -> f64 {
        min + (max - min) * (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in the exponent, of either sign.
    pub fn wide(&mut self, decades: f64) -> f64 {
        let size = 10f64.powf(self.uniform(-decades, decades));
        if self.0.next_u64() & 1 == 0 { size } else { -size }
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.0.next_u64() % n as u64) as usize
    }

    pub fn vector(&mut self, size: f64) -> DVec2 {
        DVec2::new(self.uniform(-size, size), self.uniform(-size, size))
    }

    pub fn direction(&mut self) -> DVec2 {
        DVec2::from_angle(self.uniform(0.0, std::f64::consts::TAU))
    }

    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for k in (1..items.len()).rev() {
            items.swap(k, self.below(k + 1));
        }
    }
}

pub fn disc(id: u32, position: [f64; 2], velocity: [f64; 2], radius: f64, mass: f64) -> Disc {
    Disc {
        id,
        position: DVec2::from_array(position),
        velocity: DVec2::from_array(velocity),
        radius,
        mass,
    }
}

/// Two discs that touch to rounding and approach.
pub fn approaching_pair(random: &mut Random) -> (Disc, Disc) {
    let normal = random.direction();
    let (ra, rb) = (random.uniform(0.1, 2.0), random.uniform(0.1, 2.0));
    let a = random.vector(5.0);
    let mut pair = (
        Disc {
            id: 1,
            position: a,
            velocity: random.vector(3.0),
            radius: ra,
            mass: random.uniform(0.1, 10.0),
        },
        Disc {
            id: 2,
            position: a + normal * (ra + rb),
            velocity: random.vector(3.0),
            radius: rb,
            mass: random.uniform(0.1, 10.0),
        },
    );
    if (pair.1.velocity - pair.0.velocity).dot(normal) > 0.0 {
        std::mem::swap(&mut pair.0.velocity, &mut pair.1.velocity);
    }
    pair
}

/// A seeded gas without overlaps in a box, with the radii and masses asked for.
pub fn gas(seed: u64, count: usize, side: f64, radius: (f64, f64), mass: (f64, f64)) -> Vec<Disc> {
    let mut random = Random::new(seed);
    let mut discs: Vec<Disc> = Vec::new();
    while discs.len() < count {
        let r = random.uniform(radius.0, radius.1);
        let position = DVec2::new(random.uniform(r, side - r), random.uniform(r, side - r));
        let free = discs.iter().all(|d| d.position.distance(position) > d.radius + r + 1e-9);
        if free {
            discs.push(Disc {
                id: discs.len() as u32,
                position,
                velocity: random.vector(1.0),
                radius: r,
                mass: random.uniform(mass.0, mass.1),
            });
        }
    }
    discs
}

pub fn box_settings(side: f64, restitution: f64) -> Settings {
    let walls = Walls { min: DVec2::ZERO, max: DVec2::splat(side), restitution };
    Settings { restitution, walls: Some(walls), ..Settings::default() }
}

/// An arena with what the plan decides for it.
pub fn arena(settings: &Settings, discs: &[Disc]) -> Plain {
    let plan = Plan::of(settings, discs);
    Plain::new(plan.laws(settings), discs, plan.epoch)
}

/// Runs to the end, however many turns that takes.
pub fn run(arena: &mut Plain, until: f64) -> Vec<Contact> {
    let mut contacts = Vec::new();
    while arena.now() < until {
        arena.advance(until, &mut contacts).expect("no stall");
    }
    contacts
}

pub fn states(arena: &Plain) -> Vec<Disc> {
    arena.discs(Owner::Simulated).collect()
}

pub fn momentum(discs: &[Disc]) -> DVec2 {
    discs.iter().filter(|d| d.mass.is_finite()).map(|d| d.mass * d.velocity).sum()
}

pub fn energy(discs: &[Disc]) -> f64 {
    discs.iter().map(Disc::kinetic_energy).sum()
}
