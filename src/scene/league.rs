//! What a robot soccer scene has besides pucks: how robots drive and kick, the ball, teams of
//! robots, and the field as its league measures it.
//!
//! Never move anything here, and never decide how a robot or a ball moves.

use glam::DVec2;
use serde::{Deserialize, Serialize};
use serde_saphyr::Spanned;

use super::Puck;
use super::file::{Bounds, Checked, Reader};
use crate::world::{Ball, Disc, Drive, Kicker, Model};

/// Name of the ball of a scene.
pub const BALL: &str = "ball";

/// Which team a robot plays for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Team {
    /// The blue one.
    Blue,
    /// The yellow one.
    Yellow,
}

/// A robot's place in its team.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Member {
    /// Its team.
    pub team: Team,
    /// Its number there, from 0.
    pub number: u32,
}

/// A field as its league measures it, m; its middle is the origin, the goals are at the ends of x.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Field {
    /// From goal line to goal line.
    pub length: f64,
    /// From touch line to touch line.
    pub width: f64,
    /// Of a goal, between its posts.
    pub goal_width: f64,
    /// Of a goal, behind the goal line.
    pub goal_depth: f64,
    /// From the lines to the walls.
    pub margin: f64,
    /// Of the penalty area, from the goal line.
    pub penalty_depth: f64,
    /// Of the penalty area, along the goal line.
    pub penalty_width: f64,
    /// Radius of the circle in the middle.
    pub centre_radius: f64,
}

pub(super) type FieldFile = Field;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DriveFile {
    model: Option<DriveModel>,
    speed_max: Option<Spanned<f64>>,
    acceleration_max: Option<Spanned<f64>>,
    braking_max: Option<Spanned<f64>>,
    turn_max: Option<Spanned<f64>>,
    turn_acceleration_max: Option<Spanned<f64>>,
    turn_braking_max: Option<Spanned<f64>>,
    heading: Option<Spanned<f64>>,
    kicker: Option<KickerFile>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum DriveModel {
    Holonomic,
    Differential,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct KickerFile {
    speed_max: Spanned<f64>,
    half_angle: Spanned<f64>,
    reach: Spanned<f64>,
    grip: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BallFile {
    position: [f64; 2],
    #[serde(default)]
    velocity: [f64; 2],
    radius: f64,
    mass: f64,
    sliding: Option<Spanned<f64>>,
    rolling: Option<Spanned<f64>>,
    drag: Option<Spanned<f64>>,
    switch_ratio: Option<Spanned<f64>>,
    colour: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RobotsFile {
    name: Spanned<String>,
    team: Team,
    radius: f64,
    mass: f64,
    colour: Option<Spanned<String>>,
    drive: Option<Spanned<DriveFile>>,
    places: Vec<Spanned<[f64; 3]>>,
}

impl Reader<'_> {
    /// The ball, if there is one.
    pub(super) fn read_ball(
        &mut self,
        file: &Option<Spanned<BallFile>>,
        bounds: Bounds,
    ) -> Checked<()> {
        let Some(Spanned { value: file, referenced, .. }) = file else { return Ok(()) };
        let usual = Ball::default();
        let ratio = |x: f64| x > 0.0 && x <= 1.0;
        let wanted = "above 0, 1 at most";
        let ball = Ball {
            sliding: self.above_0("sliding", &file.sliding, usual.sliding)?,
            rolling: self.at_least_0("rolling", &file.rolling, usual.rolling)?,
            drag: self.at_least_0("drag", &file.drag, usual.drag)?,
            switch_ratio: self.number(
                "switch_ratio",
                &file.switch_ratio,
                usual.switch_ratio,
                ratio,
                wanted,
            )?,
        };
        let name = self.name(&Spanned::new(BALL.to_owned(), *referenced, *referenced))?;
        let disc = Disc {
            id: self.id(None),
            position: DVec2::from_array(file.position),
            velocity: DVec2::from_array(file.velocity),
            radius: file.radius,
            mass: file.mass,
        };
        self.may_stand(&name, &disc, bounds, Some(*referenced))?;
        let colour = self.colour(&file.colour)?;
        self.pucks.push(Puck { name, disc, colour, ball: Some(ball), ..Puck::default() });
        Ok(())
    }

    /// Robots, team by team.
    pub(super) fn read_robots(
        &mut self,
        groups: &[Spanned<RobotsFile>],
        bounds: Bounds,
    ) -> Checked<()> {
        for Spanned { value: group, .. } in groups {
            let colour = self.colour(&group.colour)?;
            let (driven, drive) = self.drive(true, &group.drive)?;
            for (number, place) in (0u32..).zip(&group.places) {
                let base = &group.name;
                let name = format!("{}_{number}", base.value);
                let name = self.name(&Spanned::new(name, base.referenced, base.defined))?;
                let [x, y, heading] = place.value;
                if heading.is_nan() || heading.abs() > std::f64::consts::TAU {
                    let message = format!("robot `{name}`: [x, y, heading], a turn at most in rad");
                    return Err(self.error(Some(place.referenced), message));
                }
                let disc = Disc {
                    id: self.id(None),
                    position: DVec2::new(x, y),
                    velocity: DVec2::ZERO,
                    radius: group.radius,
                    mass: group.mass,
                };
                self.may_stand(&name, &disc, bounds, Some(place.referenced))?;
                let (drive, member) =
                    (Drive { heading, ..drive }, Some(Member { team: group.team, number }));
                self.pucks.push(Puck {
                    name,
                    disc,
                    colour,
                    driven,
                    drive,
                    member,
                    ..Puck::default()
                });
            }
        }
        Ok(())
    }

    /// The field, whose numbers are lengths.
    pub(super) fn field(&self, file: &Option<Spanned<FieldFile>>) -> Checked<Option<Field>> {
        let Some(Spanned { value: field, referenced, .. }) = file else { return Ok(None) };
        let Field { length, width, goal_width, goal_depth, margin, .. } = *field;
        let Field { penalty_depth, penalty_width, centre_radius, .. } = *field;
        let above_0 = [length, width].into_iter().all(|x| x > 0.0 && x.is_finite());
        let more = [goal_width, goal_depth, margin, penalty_depth, penalty_width, centre_radius];
        if above_0 && more.into_iter().all(|x| x >= 0.0 && x.is_finite()) {
            return Ok(Some(*field));
        }
        let message = "field: lengths in m, of the field itself above 0".to_owned();
        Err(self.error(Some(*referenced), message))
    }

    fn kicker(&self, file: &KickerFile) -> Checked<Kicker> {
        let above_0 = |key: &str, value: &Spanned<f64>| {
            self.above_0(
                key,
                &Some(Spanned::new(value.value, value.referenced, value.defined)),
                0.0,
            )
        };
        Ok(Kicker {
            speed_max: above_0("speed_max", &file.speed_max)?,
            half_angle: above_0("half_angle", &file.half_angle)?,
            reach: above_0("reach", &file.reach)?,
            grip: self.at_least_0("grip", &file.grip, 0.0)?,
        })
    }

    /// How a puck is driven, if it is.
    pub(super) fn drive(
        &self,
        driven: bool,
        file: &Option<Spanned<DriveFile>>,
    ) -> Checked<(bool, Drive)> {
        let Some(Spanned { value: file, referenced, .. }) = file else {
            return Ok((driven, Drive::default()));
        };
        if !driven {
            let message = "drive: only with driven: true".to_owned();
            return Err(self.error(Some(*referenced), message));
        }
        let model = match file.model {
            Some(DriveModel::Holonomic) => Model::Holonomic,
            Some(DriveModel::Differential) => Model::Differential,
            None => {
                let message = "drive: needs a model, holonomic or differential".to_owned();
                return Err(self.error(Some(*referenced), message));
            }
        };
        let limit = |key: &str, value: &Option<Spanned<f64>>| {
            self.number(key, value, f64::INFINITY, |x| x > 0.0, "above 0")
        };
        let given = |key: &str, value: &Option<Spanned<f64>>| match value {
            Some(_) => limit(key, value).map(Some),
            None => Ok(None),
        };
        let turn = |x: f64| x.abs() <= std::f64::consts::TAU;
        let drive = Drive {
            model,
            speed_max: limit("speed_max", &file.speed_max)?,
            acceleration_max: limit("acceleration_max", &file.acceleration_max)?,
            turn_max: limit("turn_max", &file.turn_max)?,
            turn_acceleration_max: limit("turn_acceleration_max", &file.turn_acceleration_max)?,
            heading: self.number("heading", &file.heading, 0.0, turn, "a turn at most, in rad")?,
            braking_max: given("braking_max", &file.braking_max)?,
            turn_braking_max: given("turn_braking_max", &file.turn_braking_max)?,
            kicker: file.kicker.as_ref().map(|kicker| self.kicker(kicker)).transpose()?,
        };
        Ok((driven, drive))
    }
}
