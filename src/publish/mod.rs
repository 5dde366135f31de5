//! Publish: what one step says outward becomes messages. Nothing here computes physics.
//! [`error_report`] says how a second of it went.

pub mod error_report;

pub mod markers;

pub mod odometry;

use glam::DVec2;

use crate::messages::{
    CircleState, CircleStates, CircleVelocities, CircleVelocity, Contact, Contacts, Crash, Crashes,
    Header,
};
use crate::referee::{self, Fault};
use crate::world::{self, Disc, DiscId, Partner};

/// `corrected_velocities`
pub fn corrected_velocities(header: Header, velocities: &[(DiscId, DVec2)]) -> CircleVelocities {
    let message = |&(id, v): &(DiscId, DVec2)| CircleVelocity { id, vx: v.x, vy: v.y };
    CircleVelocities {
        header,
        part: 0,
        parts: 0,
        velocities: velocities.iter().map(message).collect(),
    }
}

/// `contacts`
pub fn contacts(header: Header, contacts: &[world::Contact]) -> Contacts {
    Contacts { header, part: 0, parts: 0, contacts: contacts.iter().map(contact).collect() }
}

fn contact(contact: &world::Contact) -> Contact {
    Contact {
        a: contact.a,
        b: match contact.b {
            Partner::Disc(id) => id,
            Partner::Wall(_) | Partner::Segment(_) => Contact::WALL,
        },
        point_x: contact.point.x,
        point_y: contact.point.y,
        normal_x: contact.normal.x,
        normal_y: contact.normal.y,
        gap: contact.gap,
        approach_speed: contact.approach_speed,
        impulse: contact.impulse,
        energy_loss: contact.energy_loss,
        time: contact.time,
    }
}

/// `crashes`
pub fn crashes(header: Header, crashes: &[referee::Crash]) -> Crashes {
    let message = |crash: &referee::Crash| Crash {
        a: crash.robots[0],
        b: crash.robots[1],
        speed_a: crash.speeds[0],
        speed_b: crash.speeds[1],
        approach_speed: crash.approach_speed,
        fault_a: crash.fault != Fault::Second,
        fault_b: crash.fault != Fault::First,
        point_x: crash.place.x,
        point_y: crash.place.y,
        time: crash.time,
    };
    Crashes { header, part: 0, parts: 0, crashes: crashes.iter().map(message).collect() }
}

/// `arena_states`, by id
pub fn arena_states(header: Header, discs: impl Iterator<Item = Disc>) -> CircleStates {
    let message = |disc: Disc| CircleState {
        id: disc.id,
        x: disc.position.x,
        y: disc.position.y,
        vx: disc.velocity.x,
        vy: disc.velocity.y,
        radius: disc.radius,
        mass: disc.mass,
    };
    let mut circles: Vec<CircleState> = discs.map(message).collect();
    // Mostly in order, which costs one look: the last takes the place of one that went.
    circles.sort_unstable_by_key(|circle| circle.id);
    CircleStates { header, part: 0, parts: 0, circles }
}
