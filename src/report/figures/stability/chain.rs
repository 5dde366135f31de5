//! Three discs in a box whose path is known to 120 digits, and how fast nearby paths part.
//!
//! ```text
//!  +----------------------------+
//!  |   A ->    B|C              |   B and C are a gap apart, B has the mass that is varied
//!  +----------------------------+
//! ```
//!
//! A hits B off its centre, B hits C across the gap, and so on between the walls, up to a given
//! number of contacts. The same discs with each coordinate changed a little show the growth `G` of
//! a perturbation. Written from the laws alone; it looks at all pairs for every event.

use glam::DVec2;

use crate::report::digits::{Big, BigVec, dot, minus, nearest, plus_times, with_bits};
use crate::world::{Disc, Walls};

/// Digits carried.
const BITS: usize = 400;

/// The change of a coordinate that shows the growth: 2^-130.
const NUDGE: f64 = 7.346839692639297e-40;

/// Radius of all discs, m.
pub const RADIUS_M: f64 = 0.5;

/// The box.
pub const WALLS: Walls =
    Walls { min: DVec2::new(-4.0, -3.0), max: DVec2::new(4.0, 3.0), restitution: 1.0 };

fn big(x: f64) -> Big {
    with_bits(x, BITS)
}

/// A before B and C, of masses 1, `mass` and 1 kg, with a gap (m) between B and C.
pub fn discs(mass: f64, gap: f64) -> [Disc; 3] {
    let disc = |id, x, y, velocity, mass| Disc {
        id,
        position: DVec2::new(x, y),
        velocity,
        radius: RADIUS_M,
        mass,
    };
    [
        disc(0, -2.0, 0.3, DVec2::new(1.0, 0.125), 1.0),
        disc(1, 0.0, 0.0, DVec2::ZERO, mass),
        disc(2, 2.0 * RADIUS_M + gap, 0.0, DVec2::ZERO, 1.0),
    ]
}

/// Where the discs truly are.
pub struct Truth {
    /// At what time, s.
    pub time: f64,
    /// After how many contacts.
    pub contacts: usize,
    /// Their places, m.
    places: Vec<BigVec>,
    /// Growth of a perturbation until then: largest change of a place, in radii, for a change of
    /// one coordinate by a part of the radius, or of the speed of A.
    pub growth: f64,
}

impl Truth {
    /// In the middle between two contacts, the first of which has this number; `None` where they
    /// follow each other too closely for a double to lie between.
    pub fn after(discs: &[Disc], contacts: usize) -> Option<Self> {
        let mut path = Path::new(discs);
        for _ in 0..contacts {
            path.pass(None)?;
        }
        let (wait, _) = path.next()?;
        let time = nearest(&(&path.now + wait / big(2.0)));
        path.drift_to(&big(time));
        let places = path.places();
        let growth = (0..4 * discs.len())
            .map(|coordinate| growth(discs, coordinate, time, &places))
            .try_fold(0.0, |largest: f64, growth| growth.map(|growth| largest.max(growth)))?;
        Some(Self { time, contacts, places, growth })
    }

    /// Largest distance of a disc from its true place, in radii.
    pub fn error(&self, discs: &[Disc]) -> f64 {
        let of = |(disc, place): (&Disc, &BigVec)| {
            let [x, y] = minus(&[big(disc.position.x), big(disc.position.y)], place);
            nearest(&x).hypot(nearest(&y)) / RADIUS_M
        };
        discs.iter().zip(&self.places).map(of).fold(0.0, f64::max)
    }
}

/// Growth of a change of one of the coordinates x, y, vx, vy of one of the discs.
fn growth(discs: &[Disc], coordinate: usize, time: f64, places: &[BigVec]) -> Option<f64> {
    let mut path = Path::new(discs);
    let body = &mut path.bodies[coordinate / 4];
    let (vector, size) = match coordinate % 4 {
        0 | 1 => (&mut body.place, RADIUS_M),
        _ => (&mut body.velocity, 1.0),
    };
    vector[coordinate % 2] += big(NUDGE) * big(size);
    let end = big(time);
    while path.pass(Some(&end)).is_some() {}
    path.drift_to(&end);
    let moved = |(now, then): (&BigVec, &BigVec)| {
        let [x, y] = minus(now, then);
        nearest(&(x / big(NUDGE))).hypot(nearest(&(y / big(NUDGE)))) / RADIUS_M
    };
    Some(path.places().iter().zip(places).map(moved).fold(0.0, f64::max))
}

struct Body {
    place: BigVec,
    velocity: BigVec,
    mass: Big,
}

/// What happens next.
enum Event {
    Pair(usize, usize),
    /// A disc and an axis.
    Wall(usize, usize),
}

struct Path {
    bodies: Vec<Body>,
    now: Big,
    reach: Big,
    /// Bounds of the centres.
    low: BigVec,
    high: BigVec,
}

impl Path {
    fn new(discs: &[Disc]) -> Self {
        let vector = |v: DVec2| [big(v.x), big(v.y)];
        let body = |disc: &Disc| Body {
            place: vector(disc.position),
            velocity: vector(disc.velocity),
            mass: big(disc.mass),
        };
        Self {
            bodies: discs.iter().map(body).collect(),
            now: big(0.0),
            reach: big(2.0 * RADIUS_M),
            low: vector(WALLS.min + RADIUS_M),
            high: vector(WALLS.max - RADIUS_M),
        }
    }

    fn places(&self) -> Vec<BigVec> {
        self.bodies.iter().map(|body| body.place.clone()).collect()
    }

    /// Time until the next event, and which it is.
    fn next(&self) -> Option<(Big, Event)> {
        let mut first: Option<(Big, Event)> = None;
        let mut offer = |time: Big, event: Event| {
            if first.as_ref().is_none_or(|(earlier, _)| time < *earlier) {
                first = Some((time, event));
            }
        };
        for i in 0..self.bodies.len() {
            for axis in 0..2 {
                if let Some(time) = self.wall(i, axis) {
                    offer(time, Event::Wall(i, axis));
                }
            }
            for j in i + 1..self.bodies.len() {
                if let Some(time) = self.pair(i, j) {
                    offer(time, Event::Pair(i, j));
                }
            }
        }
        first
    }

    fn wall(&self, i: usize, axis: usize) -> Option<Big> {
        let (x, v) = (&self.bodies[i].place[axis], &self.bodies[i].velocity[axis]);
        let ahead = if *v > Big::ZERO { &self.high[axis] - x } else { &self.low[axis] - x };
        (*v != Big::ZERO).then(|| ahead / v)
    }

    fn pair(&self, i: usize, j: usize) -> Option<Big> {
        let (d, w) = self.seen(i, j);
        let b = dot(&d, &w);
        if b >= Big::ZERO {
            return None;
        }
        let c = dot(&d, &d) - &self.reach * &self.reach;
        let discriminant = &b * &b - dot(&w, &w) * &c;
        (discriminant > Big::ZERO).then(|| c / (discriminant.sqrt() - b))
    }

    /// Place and velocity of one seen from another.
    fn seen(&self, i: usize, j: usize) -> (BigVec, BigVec) {
        let (a, b) = (&self.bodies[i], &self.bodies[j]);
        (minus(&b.place, &a.place), minus(&b.velocity, &a.velocity))
    }

    fn drift_to(&mut self, time: &Big) {
        let by = time - &self.now;
        for body in &mut self.bodies {
            body.place = plus_times(&body.place, &by, &body.velocity);
        }
        self.now = time.clone();
    }

    /// Lets the next event happen if it is before the end; `None` if it is not.
    fn pass(&mut self, end: Option<&Big>) -> Option<()> {
        let (wait, event) = self.next()?;
        let time = &self.now + wait;
        if end.is_some_and(|end| time > *end) {
            return None;
        }
        self.drift_to(&time);
        match event {
            Event::Wall(i, axis) => {
                let v = &mut self.bodies[i].velocity[axis];
                *v = -v.clone();
            }
            Event::Pair(i, j) => self.collide(i, j),
        }
        Some(())
    }

    fn collide(&mut self, i: usize, j: usize) {
        let (d, w) = self.seen(i, j);
        let (a, b) = (&self.bodies[i], &self.bodies[j]);
        let share = big(2.0) * dot(&d, &w) / (dot(&d, &d) * (&a.mass + &b.mass));
        let velocity_a = plus_times(&a.velocity, &(&share * &b.mass), &d);
        let velocity_b = plus_times(&b.velocity, &-(share * &a.mass), &d);
        (self.bodies[i].velocity, self.bodies[j].velocity) = (velocity_a, velocity_b);
    }
}
