//! Room: the nearest place at which a robot that makes way may stand.
//!
//! It is looked for in rings around where the robot is, so the same game has the same place.
//! Nothing here moves anything.

use glam::DVec2;

use crate::world::{Disc, Segments, Walls};

/// From one ring to the next, m: a gap that is narrower than rings and places are apart is missed.
const RING_M: f64 = 0.01;
/// Rings.
const RINGS: u32 = 100;
/// Places on a ring.
const PLACES: u32 = 32;
/// Gap that is left to others, m.
const GAP_M: f64 = 1e-3;

/// What a place must be free of.
#[derive(Clone, Debug)]
pub struct Room {
    /// Walls around all of it.
    pub walls: Option<Walls>,
    /// Segments.
    pub segments: Option<Segments>,
    /// All others.
    pub others: Vec<Disc>,
}

impl Room {
    /// Whether a disc is within the walls and off the segments.
    pub fn holds(&self, disc: &Disc) -> bool {
        let is_within = |walls: Walls| walls.contain(disc.position, disc.radius);
        self.walls.is_none_or(is_within)
            && !self.segments.is_some_and(|it| it.refuse(disc, self.walls.as_ref()))
    }

    /// Whether a disc could be there with a gap to all others.
    pub fn is_free(&self, disc: &Disc) -> bool {
        let is_clear = |other: &Disc| {
            disc.position.distance(other.position) >= disc.radius + other.radius + GAP_M
        };
        self.others.iter().all(is_clear) && self.holds(disc)
    }

    /// The nearest free place for a disc, up to a metre away; of those on a ring the first, against
    /// the clock from the direction away from this place, m.
    pub fn nearest(&self, disc: &Disc, away_from: DVec2) -> Option<DVec2> {
        let away = (disc.position - away_from).try_normalize().unwrap_or(DVec2::X);
        let ring = |ring: u32| {
            (0..PLACES).map(move |place| {
                let (sine, cosine) =
                    libm::sincos(std::f64::consts::TAU * f64::from(place) / f64::from(PLACES));
                let turned = DVec2::new(cosine, sine).rotate(away);
                disc.position + turned * (RING_M * f64::from(ring))
            })
        };
        let mut places = (1..=RINGS).flat_map(ring);
        places.find(|at| self.is_free(&Disc { position: *at, ..*disc }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disc(x: f64, y: f64, radius: f64) -> Disc {
        let (position, velocity) = (DVec2::new(x, y), DVec2::ZERO);
        Disc { id: 1, position, velocity, radius, mass: 1.0 }
    }

    #[test]
    fn a_robot_goes_straight_away_from_the_ball_where_it_can() {
        let (robot, ball) = (disc(1.0, 0.05, 0.09), disc(1.0, 0.0, 0.0215));
        let mut room = Room { walls: None, segments: None, others: vec![ball] };
        // 0.1125 m from the ball, and it is 0.05 m from it: the seventh ring.
        let at = room.nearest(&robot, ball.position).expect("there is room");
        assert!((at - DVec2::new(1.0, 0.12)).length() < 1e-12, "{at}");
        // Another stands there: to its side, no further than it must.
        room.others.push(disc(1.0, 0.3, 0.09));
        // Between the two there is a little.
        let at = room.nearest(&robot, ball.position).expect("there is room");
        assert!(room.is_free(&Disc { position: at, ..robot }) && at.y < 0.12, "{at}");
        let nearer = (1..=PLACES * 40).flat_map(|k| {
            let angle = DVec2::from_angle(std::f64::consts::TAU * f64::from(k) / 1_280.0);
            let reach = at.distance(robot.position) - RING_M - 1e-9;
            [0.3, 0.6, 0.8, 0.9, 1.0].map(|part| robot.position + angle * (part * reach))
        });
        for nearer in nearer {
            let is_free = room.is_free(&Disc { position: nearer, ..robot });
            assert!(!is_free, "{nearer} is nearer than {at}");
        }
        // Nobody knows where to where there is no room at all.
        let (min, max) = (DVec2::new(0.9, -0.05), DVec2::new(1.1, 0.15));
        room.walls = Some(Walls { min, max, restitution: 1.0 });
        assert_eq!(room.nearest(&robot, ball.position), None);
    }
}
