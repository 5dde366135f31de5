//! How wrong one contact of two pucks is, by method: what `config/error_model.json` is made of.
//!
//! A disc meets another obliquely, alone; the relative velocity after it is compared with the
//! closed form. Averaged over impact parameters and over the part of a step at which the contact
//! falls. No clock is read here.

use glam::DVec2;

use crate::motion::arena::Arena;
use crate::plan::budget::{Meetings, Way};
use crate::plan::{Method, Plan};
use crate::world::{Contact, Disc, Owner, Pace, Partner, Settings};

/// Impact parameters, evenly over the contact distance, and instants within a step.
const OFFSETS: u32 = 24;
const PHASES: u32 = 12;

/// Way on which two come together, in contact distances, at least.
const WAY: f64 = 3.0;

/// Mean square of relative speed over that of approach where all impact parameters are alike.
const SPEED_OVER_APPROACH: f64 = 1.5;

/// Two discs that will meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encounter {
    /// Radii, m.
    pub radii: [f64; 2],
    /// Masses, kg.
    pub masses: [f64; 2],
    /// Relative speed, m/s.
    pub speed: f64,
    /// Restitution.
    pub restitution: f64,
    /// Where they meet, m from the origin along both axes.
    pub at: f64,
}

impl Encounter {
    /// Equal elastic discs with a contact distance of 1 m, at 1 m/s.
    pub const PLAIN: Self =
        Self { radii: [0.5; 2], masses: [1.0; 2], speed: 1.0, restitution: 1.0, at: 0.0 };

    /// How fast they meet.
    pub fn meetings(&self) -> Meetings {
        let rate = self.speed / (self.radii[0] + self.radii[1]);
        let [a, b] = self.masses;
        let coordinate = self.at.abs() / (self.radii[0] + self.radii[1]);
        Meetings { rate, weighted: rate * (a * b / (a + b)).sqrt(), coordinate, way: WAY }
    }

    /// Error of the contact, root mean square, over the relative speed.
    ///
    /// # Errors
    /// Why the method does not do it.
    pub fn error(&self, way: Way) -> Result<f64, String> {
        let mut sum = 0.0;
        for offset in 0..OFFSETS {
            for phase in 0..PHASES {
                let part = |k: u32, of: u32| (f64::from(k) + 0.5) / f64::from(of);
                let error = self.once(way, part(offset, OFFSETS), part(phase, PHASES))?;
                sum += error.length_squared();
            }
        }
        Ok((sum / f64::from(OFFSETS * PHASES)).sqrt() / self.speed)
    }

    fn once(&self, way: Way, offset: f64, phase: f64) -> Result<DVec2, String> {
        let [ra, rb] = self.radii;
        let reach = ra + rb;
        // Along no axis: each formula has its rounding.
        let along = DVec2::from_angle(0.7 + phase);
        let contact = along.rotate(DVec2::new(-(1.0 - offset * offset).sqrt(), offset));
        let settled = WAY * reach / self.speed;
        let step = if let Way::Steps(step) = way { step } else { 0.01 * settled };
        let time = ((settled / step).ceil() + phase) * step;
        let relative = along * self.speed;
        // Both move: no method may profit from one at rest.
        let drift = along.perp() * (0.3 * self.speed);
        let velocities = [drift + 0.5 * relative, drift - 0.5 * relative];
        let start = contact * reach - relative * time;
        let disc = |id: u32, position, k: usize| Disc {
            id,
            position: position + self.at,
            velocity: velocities[k],
            radius: self.radii[k],
            mass: self.masses[k],
        };
        let discs = [disc(1, start, 0), disc(2, DVec2::ZERO, 1)];
        // Far from the origin they are not where they were put.
        let apart = discs[0].position - discs[1].position;
        let contact = if self.at == 0.0 { contact } else { contact_after(apart, relative, reach) };
        let exact = relative - (1.0 + self.restitution) * relative.dot(contact) * contact;
        let settings = Settings { restitution: self.restitution, ..Settings::default() };
        let mut arena = arena(way, &settings, &discs)?;
        let until = 2.0 * time + 4.0 * contact_time(way, &self.masses);
        while arena.now() < until {
            arena.pass(until).map_err(|halt| halt.to_string())?;
        }
        let after: Vec<Disc> = arena.discs(Owner::Simulated).collect();
        Ok(after[0].velocity - after[1].velocity - exact)
    }
}

/// Where a disc is, seen from the other, when both meet, over their contact distance.
fn contact_after(apart: DVec2, relative: DVec2, reach: f64) -> DVec2 {
    let direction = relative.normalize();
    let miss = direction.perp() * direction.perp_dot(apart);
    (miss - direction * (reach * reach - miss.length_squared()).sqrt()) / reach
}

/// An arena that moves in a way.
///
/// # Errors
/// Why the method does not suit the scene.
pub fn arena(way: Way, settings: &Settings, discs: &[Disc]) -> Result<Arena, String> {
    let settings = with(way, settings);
    let mut plan = Plan::of(&settings, discs);
    plan.choose(settings.method, &settings, discs)?;
    Arena::build(&plan, plan.laws(&settings), discs)
}

/// The settings of a scene that moves in a way.
pub fn with(way: Way, settings: &Settings) -> Settings {
    let pace = match way {
        Way::Exact(_) => settings.pace,
        Way::Steps(step) => Pace { step, ..settings.pace },
        Way::Springs(stiffness) => Pace { stiffness, damping: 0.0, ..settings.pace },
    };
    Settings { method: Some(way.method()), pace, ..*settings }
}

/// How long springs touch, s.
fn contact_time(way: Way, masses: &[f64; 2]) -> f64 {
    let [a, b] = masses;
    let Way::Springs(stiffness) = way else { return 0.0 };
    std::f64::consts::PI * (a * b / (a + b) / stiffness).sqrt()
}

/// How fast the pucks of a scene meet: from contacts that took place; where there are none, from
/// speeds; where all is at rest, as if commands set them in motion at 1 m/s.
pub fn meetings(contacts: &[Contact], discs: &[Disc]) -> Meetings {
    let place = |id: u32| discs.binary_search_by_key(&id, |disc| disc.id).ok();
    let (mut rates, mut weighted, mut count) = (0.0, 0.0, 0.0);
    let (mut coordinates, mut ways) = (0.0, 0.0);
    for contact in contacts {
        let Partner::Disc(partner) = contact.b else { continue };
        let (Some(a), Some(b)) = (place(contact.a), place(partner)) else { continue };
        let (a, b) = (&discs[a], &discs[b]);
        let rate = contact.approach_speed / (a.radius + b.radius);
        rates += rate * rate;
        weighted += rate * rate / (1.0 / a.mass + 1.0 / b.mass);
        let reach = a.radius + b.radius;
        coordinates += (contact.point.abs().max_element() / reach).powi(2);
        ways += contact.point.distance_squared(a.position) / (reach * reach);
        count += 1.0;
    }
    if count > 0.0 {
        let mean = |sum: f64| (SPEED_OVER_APPROACH * sum / count).sqrt();
        let [coordinate, way] = [coordinates, ways].map(|sum| (sum / count).sqrt());
        return Meetings { rate: mean(rates), weighted: mean(weighted), coordinate, way };
    }
    let speed = discs.iter().map(|disc| disc.velocity.length()).fold(0.0, f64::max);
    let radius = discs.iter().map(|disc| disc.radius).fold(f64::INFINITY, f64::min);
    let masses = discs.iter().map(|disc| disc.mass).filter(|mass| mass.is_finite());
    let rate = if speed > 0.0 { speed } else { 1.0 } / radius;
    let largest = discs.iter().map(|disc| disc.position.abs().max_element()).fold(0.0, f64::max);
    let weighted = rate * (0.5 * masses.fold(0.0, f64::max)).sqrt();
    Meetings { rate, weighted, coordinate: 0.5 * largest / radius, way: 0.0 }
}

/// All that can be measured of methods: the coefficients of the model, without a margin.
///
/// # Errors
/// Why a method did not do it.
pub fn coefficients() -> Result<[f64; 5], String> {
    let encounter = Encounter::PLAIN;
    let exact = |method| encounter.error(Way::Exact(method));
    let (mut steps, mut springs) = (0.0f64, 0.0f64);
    for power in 2..=8 {
        let step = 0.5f64.powi(power);
        let way = encounter.meetings().rate * step;
        steps = steps.max(encounter.error(Way::Steps(step))? / way);
    }
    for power in 3..=8 {
        let stiffness = 4f64.powi(power);
        let way = encounter.meetings().weighted / stiffness.sqrt();
        springs = springs.max(encounter.error(Way::Springs(stiffness))? / way);
    }
    let [events, plain, ticks] = [Method::Events, Method::Plain, Method::Ticks];
    Ok([exact(events)?, exact(plain)?, exact(ticks)?, steps, springs])
}
