//! What a contact was: the record that detection and resolution leave behind.

use glam::DVec2;

use super::disc::DiscId;
use super::walls::Side;

/// The other side of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Partner {
    /// Another disc.
    Disc(DiscId),
    /// A wall of the box.
    Wall(Side),
    /// A line segment, by its place among all.
    Segment(u32),
}

/// One resolved contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The first disc; the smaller id of a pair.
    pub a: DiscId,
    /// What it touched.
    pub b: Partner,
    /// Where, m: on the line of centres, midway between the two surfaces.
    pub point: DVec2,
    /// Unit normal from `a` to `b`.
    pub normal: DVec2,
    /// Distance of the surfaces, m; negative = overlap.
    pub gap: f64,
    /// Speed of approach along the normal before the contact, m/s; above 0.
    pub approach_speed: f64,
    /// Size of the impulse exchanged along the normal, N s.
    pub impulse: f64,
    /// Kinetic energy lost to restitution, J.
    pub energy_loss: f64,
    /// When, s.
    pub time: f64,
}

impl Contact {
    /// The ids of the one or two discs in it.
    pub fn discs(&self) -> impl Iterator<Item = DiscId> + use<> {
        let partner = match self.b {
            Partner::Disc(id) => Some(id),
            Partner::Wall(_) | Partner::Segment(_) => None,
        };
        std::iter::once(self.a).chain(partner)
    }
}
