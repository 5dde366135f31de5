//! One oblique collision of two discs alone, against its closed form.
//!
//! A disc at 2 m/s meets an equal one at rest, whose normal velocity it takes over. Averaged over
//! impact parameters and over the part of a step at which the contact falls. What remains as the
//! step goes to 0 is an error of the method, not of the step. Rapier's remains: it keeps a contact
//! that it found before the discs met, and with it a wrong line of centres, until they have moved
//! by 5 cm. Told not to, it converges as Box2D does. (Box2D after that of boxdd 0.5.0 recycles
//! contacts in the same way; boxdd 0.6.0 gave 2.2e-2, 2.4e-2 and 2.5e-2 m/s at 1/60, 1/240 and
//! 1/1000 s.)

use glam::DVec2;
use serde::Serialize;

use super::box2d::Box2d;
use super::own::Stepped;
use super::rapier::Rapier;
use super::{Mover, Setup, Stepper};
use crate::motion::events::Events;
use crate::motion::plain::Laws;
use crate::world::{Disc, Owner};

const SPEED: f64 = 2.0;

/// Impact parameters, evenly from 0 to this part of the diameter.
const OFFSETS: u32 = 20;
const OFFSET_MAX: f64 = 0.95;

/// Contacts within a step, evenly.
const PHASES: u32 = 16;

/// Time before the contact, and time after it, s: far beyond every margin.
const APPROACH: f64 = 0.1;

/// What one engine made of the collision.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Isolated {
    /// Who.
    pub mover: Mover,
    /// Length of the step, s; `None` = exact.
    pub step_s: Option<f64>,
    /// Root mean square error of the velocity with which the striker leaves, m/s.
    pub rms_error_mps: f64,
}

/// All rows: carom's exact method, then every engine at every step.
pub(super) fn rows(steps: &[f64]) -> Result<Vec<Isolated>, String> {
    let exact = rms(1.0 / 60.0, |collision| collision.exact())?;
    let mut rows = vec![Isolated { mover: Mover::Events, step_s: None, rms_error_mps: exact }];
    for mover in Mover::STEPPERS.into_iter().chain([Mover::RapierFresh]) {
        for &step in steps {
            let rms_error_mps = match mover {
                Mover::Box2d => rms(step, Collision::stepped::<Box2d>),
                Mover::Rapier => rms(step, Collision::stepped::<Rapier<true>>),
                Mover::RapierFresh => rms(step, Collision::stepped::<Rapier<false>>),
                _ => rms(step, Collision::stepped::<Stepped>),
            }?;
            rows.push(Isolated { mover, step_s: Some(step), rms_error_mps });
        }
    }
    Ok(rows)
}

fn rms(step: f64, leave: impl Fn(&Collision) -> Result<DVec2, String>) -> Result<f64, String> {
    let mut sum = 0.0;
    for offset in 0..OFFSETS {
        for phase in 0..PHASES {
            let collision = Collision {
                offset: OFFSET_MAX * (f64::from(offset) + 0.5) / f64::from(OFFSETS),
                phase: (f64::from(phase) + 0.5) / f64::from(PHASES),
                step,
            };
            sum += leave(&collision)?.distance_squared(collision.closed_form());
        }
    }
    Ok((sum / f64::from(OFFSETS * PHASES)).sqrt())
}

/// One of them.
struct Collision {
    /// Impact parameter, m.
    offset: f64,
    /// Part of a step at which the discs touch.
    phase: f64,
    /// s
    step: f64,
}

impl Collision {
    /// Where the striker is at the contact; the other lies at 0.
    fn contact(&self) -> DVec2 {
        DVec2::new(-(1.0 - self.offset * self.offset).sqrt(), self.offset)
    }

    /// Whole steps before that in which the contact falls.
    fn lead(&self) -> f64 {
        (APPROACH / self.step).ceil()
    }

    fn discs(&self) -> [Disc; 2] {
        let time = (self.lead() + self.phase) * self.step;
        let velocity = DVec2::new(SPEED, 0.0);
        let position = self.contact() - velocity * time;
        let still =
            Disc { id: 2, position: DVec2::ZERO, velocity: DVec2::ZERO, radius: 0.5, mass: 1.0 };
        [Disc { id: 1, position, velocity, ..still }, still]
    }

    /// The velocity with which the striker leaves: without its part along the normal.
    fn closed_form(&self) -> DVec2 {
        let velocity = DVec2::new(SPEED, 0.0);
        velocity - velocity.project_onto_normalized(self.contact())
    }

    fn exact(&self) -> Result<DVec2, String> {
        let mut arena = Events::new(Laws::FREE, &self.discs());
        let until = 2.0 * self.lead() * self.step;
        while arena.now() < until {
            arena.pass(until).map_err(|stall| stall.to_string())?;
        }
        let striker = arena.discs(Owner::Simulated).find(|disc| disc.id == 1);
        striker.map(|disc| disc.velocity).ok_or_else(|| "no disc".to_owned())
    }

    fn stepped<S: Stepper>(&self) -> Result<DVec2, String> {
        let discs = self.discs();
        let setup = Setup { discs: &discs, walls: None, step: self.step, count: false };
        let mut engine = S::new(&setup)?;
        for _ in 0..2 * self.lead() as u64 {
            engine.step()?;
        }
        Ok(engine.discs()[0].velocity)
    }
}
