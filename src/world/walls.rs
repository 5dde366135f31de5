//! The box around an arena: four straight, fixed walls.
//!
//! Never decide here when a wall is hit: that is detection.

use glam::DVec2;

use super::disc::Disc;

/// One of the four walls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Side {
    /// The wall at the smallest x.
    Left,
    /// The wall at the largest x.
    Right,
    /// The wall at the smallest y.
    Bottom,
    /// The wall at the largest y.
    Top,
}

impl Side {
    /// Unit normal, pointing out of the box: from a disc to the wall.
    pub fn normal(self) -> DVec2 {
        match self {
            Side::Left => DVec2::NEG_X,
            Side::Right => DVec2::X,
            Side::Bottom => DVec2::NEG_Y,
            Side::Top => DVec2::Y,
        }
    }
}

/// An axis-parallel box whose walls discs bounce off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Walls {
    /// Lower left corner, m.
    pub min: DVec2,
    /// Upper right corner, m.
    pub max: DVec2,
    /// Restitution of a wall contact, 0 to 1.
    pub restitution: f64,
}

impl Walls {
    /// Walls that nothing reaches: for who shall look at walls where there are none.
    pub const FAR_AWAY: Self =
        Self { min: DVec2::splat(-1e200), max: DVec2::splat(1e200), restitution: 1.0 };

    /// Distance of a disc's surface from a wall, m; negative = beyond it.
    pub fn gap(&self, side: Side, disc: &Disc) -> f64 {
        let DVec2 { x, y } = disc.position;
        match side {
            Side::Left => x - disc.radius - self.min.x,
            Side::Right => self.max.x - disc.radius - x,
            Side::Bottom => y - disc.radius - self.min.y,
            Side::Top => self.max.y - disc.radius - y,
        }
    }

    /// The place of a disc brought exactly onto a wall.
    pub fn onto(&self, side: Side, disc: &Disc) -> DVec2 {
        let DVec2 { x, y } = disc.position;
        match side {
            Side::Left => DVec2::new(self.min.x + disc.radius, y),
            Side::Right => DVec2::new(self.max.x - disc.radius, y),
            Side::Bottom => DVec2::new(x, self.min.y + disc.radius),
            Side::Top => DVec2::new(x, self.max.y - disc.radius),
        }
    }

    /// The place of a disc brought inside, if it is not there; of one as wide as the box, in its
    /// middle.
    pub fn inside(&self, disc: &Disc) -> DVec2 {
        let (low, high) = (self.min + disc.radius, self.max - disc.radius);
        disc.position.max(low).min(high.max(low))
    }

    /// Whether a disc lies inside, touching allowed.
    pub fn contain(&self, position: DVec2, radius: f64) -> bool {
        position.cmpge(self.min + radius).all() && position.cmple(self.max - radius).all()
    }
}
