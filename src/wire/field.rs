//! Fields: what is drawn on the ground of each league, which the scene's physics does not need.
//!
//! The scene has the sizes; here is what its league adds to them. Lines are told to teams, nobody
//! runs into them.

use crate::scene::league::Field as Marks;

/// Which league's protocol is spoken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum League {
    /// Small size: the simulation protocol, vision and tracked frames.
    Ssl,
    /// Very small size: packets and environment as FIRASim has them.
    Vsss,
}

impl League {
    /// By the name of a scene, or its own: `ssl`, `vsss`, and whatever begins so.
    pub fn of(name: &str) -> Option<Self> {
        match name.split('-').next() {
            Some("ssl") => Some(Self::Ssl),
            Some("vsss") => Some(Self::Vsss),
            _ => None,
        }
    }
}

/// A field with what its league adds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Field {
    /// Whose it is.
    pub league: League,
    /// What is measured on it.
    pub marks: Marks,
    /// From the goal to the penalty mark, m.
    pub penalty_mark_m: f64,
    /// Thickness of the lines, m.
    pub line_m: f64,
    /// Height of a robot that says no other, m.
    pub robot_height_m: f64,
}

impl Field {
    /// Of a league.
    pub fn new(league: League, marks: Marks) -> Self {
        match league {
            // Penalty mark 8 m on 12 m, 6 m on 9 m; lines; robots fit below (ssl-rules, "The
            // Playing Environment", "Robots").
            League::Ssl => Self {
                league,
                marks,
                penalty_mark_m: marks.length * 2.0 / 3.0,
                line_m: 0.01,
                robot_height_m: 0.15,
            },
            // FIRASim, its settings.
            League::Vsss => {
                Self { league, marks, penalty_mark_m: 0.375, line_m: 0.003, robot_height_m: 0.075 }
            }
        }
    }
}

/// Division B of the Small Size League, for tests.
#[cfg(test)]
pub fn division_b() -> Field {
    let marks = Marks {
        length: 9.0,
        width: 6.0,
        goal_width: 1.0,
        goal_depth: 0.18,
        margin: 0.3,
        penalty_depth: 1.0,
        penalty_width: 2.0,
        centre_radius: 0.5,
    };
    Field::new(League::Ssl, marks)
}
