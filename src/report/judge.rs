//! The judge of many digits: retells a run from its list of contacts in 300 bits, and tells whether
//! it is the true one.
//!
//! A path is the true one if it begins right, is straight between contacts, if each contact takes
//! place where and when two surfaces touch and approach, in order, and changes the velocities as
//! the pair law says, and if no two discs overlap at any time. All of this is verified here, from
//! the numbers of the scene and who met whom alone; neither the times nor the states that a method
//! found are used. So the judge of a method shares no line with it.
//!
//! Contacts at one instant that share a disc have no such truth: scenes with them are refused.

use dashu_float::FBig;

use crate::exact::DoubleDouble;
use crate::world::{Contact, Disc, Partner, Settings, Side};

/// Digits carried, bits.
const BITS: usize = 300;

/// What is nearer to contact than this, relative to it, is decided in many digits.
const NEAR: f64 = 1e-9;

/// What the many digits themselves may be off by, relative: 2^-200.
const ROUNDING: f64 = 6.223015277861142e-61;

/// A number of many digits.
type Big = FBig;

fn big(x: f64) -> Big {
    // Only an infinite or no number fails: scenes have been checked.
    let exact = Big::try_from(x).expect("a finite number");
    exact.with_precision(BITS).value()
}

/// A number of many digits as two doubles.
fn double_double(x: &Big) -> DoubleDouble {
    let hi = x.to_f64().value();
    DoubleDouble { hi, lo: (x - big(hi)).to_f64().value() }
}

/// Where the true path ends.
#[derive(Clone, Debug)]
pub struct Truth {
    /// Places of the discs by index, x and y, m.
    pub places: Vec<[DoubleDouble; 2]>,
    /// Contacts of pairs and walls on the way.
    pub contacts: usize,
    /// The largest difference of a contact's time to the one that the method gave, s.
    pub time_error_s: f64,
}

impl Truth {
    /// Distance of a disc from its true place, m.
    pub fn distance_m(&self, index: usize, disc: &Disc) -> f64 {
        let [x, y] = &self.places[index];
        let off = |ours: f64, truth: &DoubleDouble| (ours - truth.hi) - truth.lo;
        off(disc.position.x, x).hypot(off(disc.position.y, y))
    }
}

/// A disc on its way: where it would have been at time 0 on its present flight, and its velocity.
#[derive(Clone)]
struct Body {
    place: [Big; 2],
    velocity: [Big; 2],
    radius: Big,
    mass: f64,
}

/// A straight flight.
#[derive(Clone)]
struct Flight {
    from: Big,
    place: [Big; 2],
    velocity: [Big; 2],
    /// The same in doubles.
    rough: Rough,
}

#[derive(Clone, Copy)]
struct Rough {
    from: f64,
    place: glam::DVec2,
    velocity: glam::DVec2,
}

/// Retells a run of `discs`, whose ids are their indices, up to `until` (s).
///
/// # Errors
/// Why the contacts are not those of the true path.
pub fn retell(
    settings: &Settings,
    discs: &[Disc],
    contacts: &[Contact],
    until: f64,
) -> Result<Truth, String> {
    let mut story = Story::new(settings, discs);
    for (k, contact) in contacts.iter().enumerate() {
        story.tell(contact).map_err(|what| format!("contact {k}: {what}"))?;
    }
    let end = big(until);
    if story.now > end {
        return Err(format!("the last contact is after {until} s"));
    }
    story.check_that_none_overlap(until)?;
    let place = |body: &Body| {
        let at = |k: usize| double_double(&(&body.place[k] + &body.velocity[k] * &end));
        [at(0), at(1)]
    };
    Ok(Truth {
        places: story.bodies.iter().map(place).collect(),
        contacts: contacts.len(),
        time_error_s: story.time_error_s,
    })
}

struct Story<'a> {
    settings: &'a Settings,
    bodies: Vec<Body>,
    flights: Vec<Vec<Flight>>,
    now: Big,
    time_error_s: f64,
}

impl<'a> Story<'a> {
    fn new(settings: &'a Settings, discs: &[Disc]) -> Self {
        let body = |disc: &Disc| Body {
            place: [big(disc.position.x), big(disc.position.y)],
            velocity: [big(disc.velocity.x), big(disc.velocity.y)],
            radius: big(disc.radius),
            mass: disc.mass,
        };
        let bodies: Vec<Body> = discs.iter().map(body).collect();
        let flights = bodies.iter().map(|body| vec![flight(body, &big(0.0))]).collect();
        Self { settings, bodies, flights, now: big(0.0), time_error_s: 0.0 }
    }

    fn tell(&mut self, contact: &Contact) -> Result<(), String> {
        let i = contact.a as usize;
        let time = match contact.b {
            Partner::Disc(j) => self.collide(i, j as usize)?,
            Partner::Wall(side) => self.bounce(i, side)?,
            Partner::Segment(_) => return Err("no scene of the report has segments".to_owned()),
        };
        if time < self.now {
            return Err("before the one before it".to_owned());
        }
        let error = (&time - big(contact.time)).to_f64().value().abs();
        self.time_error_s = self.time_error_s.max(error);
        let partner = match contact.b {
            Partner::Disc(j) => Some(j as usize),
            Partner::Wall(_) | Partner::Segment(_) => None,
        };
        for k in std::iter::once(i).chain(partner) {
            let flight = flight(&self.bodies[k], &time);
            self.flights[k].push(flight);
        }
        self.now = time;
        Ok(())
    }

    /// Two discs at the instant at which they touch; returns that.
    fn collide(&mut self, i: usize, j: usize) -> Result<Big, String> {
        let (a, b) = (&self.bodies[i], &self.bodies[j]);
        let Sight { d, w, reach } = Sight::of(a, b);
        let (ww, dw) = (dot(&w, &w), dot(&d, &w));
        let discriminant = &dw * &dw - &ww * (dot(&d, &d) - &reach * &reach);
        if discriminant <= big(0.0) {
            return Err(format!("discs {i} and {j} pass each other"));
        }
        let time = (-&dw - discriminant.sqrt()) / &ww;
        let d = [0, 1].map(|k| &d[k] + &w[k] * &time);
        // Along the line of centres, (1 + e) of the speed of approach, in parts inverse to mass.
        let turn = dot(&d, &w) / dot(&d, &d) * (big(1.0) + big(self.settings.restitution));
        let fractions = match (a.mass.is_infinite(), b.mass.is_infinite()) {
            (true, true) => return Err(format!("discs {i} and {j} are both fixed")),
            (true, false) => [big(0.0), big(1.0)],
            (false, true) => [big(1.0), big(0.0)],
            (false, false) => {
                let sum = big(a.mass) + big(b.mass);
                [big(b.mass) / &sum, big(a.mass) / &sum]
            }
        };
        self.kick(i, &[0, 1].map(|k| &d[k] * &turn * &fractions[0]), &time);
        self.kick(j, &[0, 1].map(|k| -&d[k] * &turn * &fractions[1]), &time);
        Ok(time)
    }

    fn bounce(&mut self, i: usize, side: Side) -> Result<Big, String> {
        let walls = self.settings.walls.ok_or("there are no walls")?;
        let body = &self.bodies[i];
        let (axis, wall, outwards) = match side {
            Side::Left => (0, walls.min.x, -1.0),
            Side::Right => (0, walls.max.x, 1.0),
            Side::Bottom => (1, walls.min.y, -1.0),
            Side::Top => (1, walls.max.y, 1.0),
        };
        if &body.velocity[axis] * big(outwards) <= big(0.0) {
            return Err(format!("disc {i} does not approach its wall"));
        }
        let at = big(wall) - &body.radius * big(outwards);
        let time = (at - &body.place[axis]) / &body.velocity[axis];
        let mut kick = [big(0.0), big(0.0)];
        kick[axis] = -&body.velocity[axis] * (big(1.0) + big(walls.restitution));
        self.kick(i, &kick, &time);
        Ok(time)
    }

    fn kick(&mut self, k: usize, change: &[Big; 2], time: &Big) {
        let body = &mut self.bodies[k];
        for axis in [0, 1] {
            body.place[axis] -= &change[axis] * time;
            body.velocity[axis] += &change[axis];
        }
    }

    /// No disc is beyond a wall, no two overlap, from the start to the end.
    fn check_that_none_overlap(&self, until: f64) -> Result<(), String> {
        let boxes: Vec<_> = self.flights.iter().map(|flights| bounds(flights, until)).collect();
        for (i, (low, high)) in boxes.iter().enumerate() {
            let radius = self.bodies[i].radius.to_f64().value() * (1.0 - NEAR);
            let inside = |walls: &crate::world::Walls| {
                [*low, *high].iter().all(|p| walls.contain(*p, radius))
            };
            if !self.settings.walls.as_ref().is_none_or(inside) {
                return Err(format!("disc {i} leaves the box"));
            }
            for (j, (other_low, other_high)) in boxes.iter().enumerate().skip(i + 1) {
                let sum = &self.bodies[i].radius + &self.bodies[j].radius;
                let reach = sum.to_f64().value() * (1.0 + NEAR);
                let apart = (*low - reach).cmpgt(*other_high) | (*other_low - reach).cmpgt(*high);
                if !apart.any() && !self.stay_apart(i, j, &sum, until) {
                    return Err(format!("discs {i} and {j} overlap"));
                }
            }
        }
        Ok(())
    }

    /// Whether two discs never overlap.
    fn stay_apart(&self, i: usize, j: usize, reach: &Big, until: f64) -> bool {
        let (ours, theirs) = (&self.flights[i], &self.flights[j]);
        let (mut k, mut l) = (0, 0);
        let s = reach.to_f64().value();
        loop {
            let end = |flights: &[Flight], k: usize| {
                flights.get(k + 1).map_or(until, |next| next.rough.from)
            };
            let (a, b) = (&ours[k], &theirs[l]);
            let (from, to) = (a.rough.from.max(b.rough.from), end(ours, k).min(end(theirs, l)));
            let (d, w) = (b.rough.place - a.rough.place, b.rough.velocity - a.rough.velocity);
            let nearest = (-d.dot(w) / w.length_squared()).clamp(from, to.max(from));
            let nearest = if nearest.is_nan() { from } else { nearest };
            let least = (d + w * nearest).length().min((d + w * from).length());
            if least < s * (1.0 - NEAR) {
                return false;
            }
            if least < s * (1.0 + NEAR) {
                let next = [ours.get(k + 1), theirs.get(l + 1)].map(|next| next.map(|f| &f.from));
                if !never_nearer(a, b, next, (reach, until)) {
                    return false;
                }
            }
            if to >= until {
                return true;
            }
            if end(ours, k) <= end(theirs, l) { k += 1 } else { l += 1 }
        }
    }
}

/// The same decided in many digits for two flights, whose ends are given.
fn never_nearer(
    a: &Flight,
    b: &Flight,
    ends: [Option<&Big>; 2],
    (reach, until): (&Big, f64),
) -> bool {
    let last = big(until);
    let from = if a.from > b.from { &a.from } else { &b.from };
    let to =
        ends.into_iter().flatten().fold(&last, |least, end| if end < least { end } else { least });
    if to <= from {
        return true;
    }
    let d = [0, 1].map(|k| &b.place[k] - &a.place[k]);
    let w = [0, 1].map(|k| &b.velocity[k] - &a.velocity[k]);
    let least = reach * reach * (big(1.0) - big(ROUNDING));
    let clear = |time: &Big| {
        let at = [0, 1].map(|k| &d[k] + &w[k] * time);
        dot(&at, &at) >= least
    };
    let ww = dot(&w, &w);
    let passes = ww > big(0.0) && {
        let nearest = -dot(&d, &w) / &ww;
        &nearest > from && &nearest < to && !clear(&nearest)
    };
    clear(from) && clear(to) && !passes
}

/// One body as another sees it at time 0 on their present flights.
struct Sight {
    d: [Big; 2],
    w: [Big; 2],
    reach: Big,
}

impl Sight {
    fn of(a: &Body, b: &Body) -> Self {
        Self {
            d: [0, 1].map(|k| &b.place[k] - &a.place[k]),
            w: [0, 1].map(|k| &b.velocity[k] - &a.velocity[k]),
            reach: &a.radius + &b.radius,
        }
    }
}

fn dot(a: &[Big; 2], b: &[Big; 2]) -> Big {
    &a[0] * &b[0] + &a[1] * &b[1]
}

fn flight(body: &Body, from: &Big) -> Flight {
    let double = |x: &[Big; 2]| glam::DVec2::new(x[0].to_f64().value(), x[1].to_f64().value());
    let rough = Rough {
        from: from.to_f64().value(),
        place: double(&body.place),
        velocity: double(&body.velocity),
    };
    Flight { from: from.clone(), place: body.place.clone(), velocity: body.velocity.clone(), rough }
}

/// The corners of the box that flights stay in.
fn bounds(flights: &[Flight], until: f64) -> (glam::DVec2, glam::DVec2) {
    let infinite = glam::DVec2::splat(f64::INFINITY);
    let mut corners = (infinite, -infinite);
    for (k, flight) in flights.iter().enumerate() {
        let to = flights.get(k + 1).map_or(until, |next| next.rough.from);
        for time in [flight.rough.from, to] {
            let place = flight.rough.place + flight.rough.velocity * time;
            corners = (corners.0.min(place), corners.1.max(place));
        }
    }
    corners
}
