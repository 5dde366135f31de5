//! Fields: what is drawn on the ground of each league, which the scene's physics does not need.
//!
//! Lines are told to teams, nobody runs into them. Each number is the league's own; a test compares
//! those that the scene has too.

/// Which league's protocol a scene speaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum League {
    /// Small size: the simulation protocol, vision and tracked frames.
    Ssl,
    /// Very small size: packets and environment as FIRASim has them.
    Vsss,
}

/// A field, centred on the origin, goals at the ends of x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Field {
    /// Whose it is.
    pub league: League,
    /// Between the goal lines, m.
    pub length_m: f64,
    /// Between the touch lines, m.
    pub width_m: f64,
    /// From the lines to the boundary, m.
    pub boundary_m: f64,
    /// Between the posts, m.
    pub goal_width_m: f64,
    /// From the goal line to the net, m.
    pub goal_depth_m: f64,
    /// Of the defence area, along x, m.
    pub penalty_depth_m: f64,
    /// Of the defence area, along y, m.
    pub penalty_width_m: f64,
    /// From the goal to the penalty mark, m.
    pub penalty_mark_m: f64,
    /// Of the centre circle, m.
    pub circle_radius_m: f64,
    /// Thickness of the lines, m.
    pub line_m: f64,
    /// Height of a robot that says no other, m.
    pub robot_height_m: f64,
}

/// SSL division A (ssl-rules, "The Playing Environment").
pub const SSL_A: Field = Field {
    league: League::Ssl,
    length_m: 12.0,
    width_m: 9.0,
    boundary_m: 0.3,
    goal_width_m: 1.8,
    goal_depth_m: 0.18,
    penalty_depth_m: 1.8,
    penalty_width_m: 3.6,
    penalty_mark_m: 8.0,
    circle_radius_m: 0.5,
    line_m: 0.01,
    robot_height_m: 0.15,
};

/// SSL division B (ssl-rules, "The Playing Environment").
pub const SSL_B: Field = Field {
    length_m: 9.0,
    width_m: 6.0,
    goal_width_m: 1.0,
    penalty_depth_m: 1.0,
    penalty_width_m: 2.0,
    penalty_mark_m: 6.0,
    ..SSL_A
};

/// VSSS with five robots a team (FIRASim, division A of its settings).
pub const VSSS_5V5: Field = Field {
    league: League::Vsss,
    length_m: 2.2,
    width_m: 1.8,
    boundary_m: 0.0,
    goal_width_m: 0.4,
    goal_depth_m: 0.15,
    penalty_depth_m: 0.15,
    penalty_width_m: 0.5,
    penalty_mark_m: 0.375,
    circle_radius_m: 0.25,
    line_m: 0.003,
    robot_height_m: 0.075,
};

/// VSSS with three robots a team (FIRASim, division B of its settings).
pub const VSSS_3V3: Field = Field {
    length_m: 1.5,
    width_m: 1.3,
    goal_depth_m: 0.1,
    penalty_width_m: 0.7,
    circle_radius_m: 0.2,
    ..VSSS_5V5
};

/// All fields, by the names of their scenes.
const FIELDS: [(&str, Field); 4] =
    [("ssl-a", SSL_A), ("ssl-b", SSL_B), ("vsss-3v3", VSSS_3V3), ("vsss-5v5", VSSS_5V5)];

/// The field of a name.
pub fn find(name: &str) -> Option<Field> {
    FIELDS.iter().find(|(field, _)| *field == name).map(|(_, field)| *field)
}

/// The names of all fields.
pub fn names() -> impl Iterator<Item = &'static str> {
    FIELDS.iter().map(|(name, _)| *name)
}
