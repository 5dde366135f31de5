//! What the node declares: each setting once, and what a new value does.

use glam::DVec2;
use ros2_client::ParameterValue;

use super::{Parameter, Parameters};
use crate::motion::entry;
use crate::node::arguments::Override;
use crate::scene::{Puck, Scene};
use crate::world::{Disc, Walls, limits};

/// Longest time in seconds that means something: thirty years.
const SECONDS_MAX: f64 = 1e9;
/// Shortest time after which a circle may be stale, s.
const SECONDS_MIN: f64 = 1e-6;

/// Radius and mass of a robot that names none: as large as those of the small leagues.
const ROBOT_RADIUS_M: f64 = 0.09;
const ROBOT_MASS_KG: f64 = 2.0;

/// A setting that changes while the node runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// Simulated seconds in a second of wall time; 0 = as fast as possible.
    Rate(f64),
    /// Rate of `arena_states` and `/clock`, 1/s of simulated time.
    PublishRate(f64),
    /// After which observed circles leave, s.
    StaleAfter(f64),
    /// Observed circles with a gap up to this count as in contact, m.
    ContactMargin(f64),
    /// After which a command is over, s; 0 = never.
    CommandTimeout(f64),
    /// Whether time is that of `/clock`.
    UseSimTime(bool),
    /// Where the walls are: lower left and upper right corner, m.
    Walls(DVec2, DVec2),
}

impl Change {
    /// What a new value of a settable parameter does.
    pub fn of(name: &str, value: &ParameterValue) -> Option<Self> {
        Some(match (name, value) {
            ("rate", ParameterValue::Double(rate)) => Self::Rate(*rate),
            ("publish_rate_hz", ParameterValue::Double(rate)) => Self::PublishRate(*rate),
            ("stale_after_s", ParameterValue::Double(time)) => Self::StaleAfter(*time),
            ("contact_margin_m", ParameterValue::Double(margin)) => Self::ContactMargin(*margin),
            ("command_timeout_s", ParameterValue::Double(time)) => Self::CommandTimeout(*time),
            ("use_sim_time", ParameterValue::Boolean(use_it)) => Self::UseSimTime(*use_it),
            ("walls", ParameterValue::DoubleArray(sides)) => {
                let &[left, right, bottom, top] = sides.as_slice() else { return None };
                Self::Walls(DVec2::new(left, bottom), DVec2::new(right, top))
            }
            _ => return None,
        })
    }
}

/// All parameters, with the values that a scene and the command line gave them.
pub fn declare(scene: &Scene, name: &str, rate: f64, seconds: Option<f64>) -> Vec<Parameter> {
    let mut all = of_the_run(scene, name, rate, seconds);
    all.extend(of_the_node(scene));
    all
}

/// What runs, and how.
fn of_the_run(scene: &Scene, name: &str, rate: f64, seconds: Option<f64>) -> Vec<Parameter> {
    let (settings, node) = (&scene.settings, &scene.node);
    let text = |text: &str| ParameterValue::String(text.to_owned());
    let number = ParameterValue::Double;
    let method = settings.method.map_or("auto", |method| method.name());
    vec![
        Parameter::new("scene", text(name), "A scene file, or the name of a shipped scene."),
        Parameter::new("method", text(method), "How pucks move.")
            .only("auto, events, plain, ticks, steps or springs, as the scene allows"),
        Parameter::new("step_s", number(settings.pace.step), "Step of steps and springs, s."),
        Parameter::new("for_s", number(seconds.unwrap_or(0.0)), "End after so much time, s.")
            .within(0.0, f64::MAX)
            .only("0 = never; simulated time, wall time without pucks"),
        Parameter::new(
            "error",
            number(node.wish.error.unwrap_or(0.0)),
            "Largest error of a contact.",
        )
        .only("0 = none asked for; it chooses the method"),
        Parameter::new("budget", number(node.wish.budget.unwrap_or(0.0)), "Run time of a tick, s.")
            .only("0 = none asked for; it chooses the method"),
        Parameter::new(
            "keep_all",
            ParameterValue::Boolean(settings.keep != crate::plan::parts::Parts::NONE),
            "Build every part though nothing needs it: the same bits, more slowly.",
        ),
        Parameter::new("rate", number(rate), "Simulated seconds in a second of wall time.")
            .settable()
            .within(0.0, f64::MAX)
            .only("0 = as fast as possible"),
        Parameter::new("walls", sides(settings.walls), "The box around the pucks, m.")
            .settable()
            .only("x_min, x_max, y_min, y_max; pucks outside are brought inside; empty = no walls"),
    ]
}

/// The walls as the parameter has them.
pub fn sides(walls: Option<Walls>) -> ParameterValue {
    let sides = |Walls { min, max, .. }| vec![min.x, max.x, min.y, max.y];
    ParameterValue::DoubleArray(walls.map_or(Vec::new(), sides))
}

/// Where the node records.
pub fn of_the_bag(folder: String) -> Parameter {
    let folder = ParameterValue::String(folder);
    let what = "A folder into which the node records what it says and hears.";
    Parameter::new("record", folder, what).only("empty = nothing is recorded")
}

/// What the node says, hears and forgets.
fn of_the_node(scene: &Scene) -> Vec<Parameter> {
    let (settings, node) = (&scene.settings, &scene.node);
    let number = ParameterValue::Double;
    let (least_rate, most_rate) = limits::PUBLISH_RATES_HZ;
    vec![
        Parameter::new(
            "publish_rate_hz",
            number(node.publish_rate_hz),
            "Rate of arena_states and /clock, 1/s of simulated time; never changes the motion.",
        )
        .settable()
        .within(least_rate, most_rate),
        Parameter::new(
            "stale_after_s",
            number(settings.stale_after),
            "Observed circles not heard of for so long leave, s.",
        )
        .settable()
        .within(SECONDS_MIN, SECONDS_MAX),
        Parameter::new(
            "contact_margin_m",
            number(settings.contact_margin),
            "Observed circles with a gap up to this count as in contact, m.",
        )
        .settable()
        .within(0.0, limits::SIZE_MAX),
        Parameter::new(
            "command_timeout_s",
            number(settings.command_timeout),
            "A puck that nobody has commanded for so long stops, s of simulated time.",
        )
        .settable()
        .within(0.0, SECONDS_MAX)
        .only("0 = never"),
        Parameter::new(
            "frame_id",
            ParameterValue::String(node.frame_id.clone()),
            "Frame of the arena's messages.",
        ),
        Parameter::new(
            "circle_topics",
            ParameterValue::StringArray(node.circle_topics.clone()),
            "Topics on which circles are reported.",
        ),
        Parameter::new(
            "robots",
            ParameterValue::StringArray(Vec::new()),
            "Robots that tell their own odom; each has parameters NAME.radius and NAME.mass.",
        ),
        Parameter::new(
            "use_sim_time",
            ParameterValue::Boolean(false),
            "Take the time from /clock, for a scene without pucks; one with pucks publishes it.",
        )
        .settable()
        .only("false where there are pucks"),
    ]
}

/// The parameters of the robots that `robots` names.
pub fn of_robots(values: &[Override]) -> Vec<Parameter> {
    let last = values.iter().rfind(|value| value.name == "robots");
    let Some(ParameterValue::StringArray(names)) = last.map(|last| &last.value) else {
        return Vec::new();
    };
    let parameters = |name: &String| {
        let number = |of: &str, value, description| {
            let number = ParameterValue::Double(value);
            Parameter::new(format!("{name}.{of}"), number, description)
                .within(limits::SIZE_MIN, limits::SIZE_MAX)
        };
        let radius = number("radius", ROBOT_RADIUS_M, "Radius of the robot, m.");
        [radius, number("mass", ROBOT_MASS_KG, "Mass of the robot, kg.")]
    };
    names.iter().flat_map(parameters).collect()
}

/// Why a new value would be wrong though its type and range are right, for a scene and for the
/// walls and the pucks that are there now.
pub fn veto(
    scene: &Scene,
    (walls, pucks): (Option<Walls>, &[Puck]),
    name: &str,
    value: &ParameterValue,
) -> Result<(), String> {
    let asks_for_time = (name, value) == ("use_sim_time", &ParameterValue::Boolean(true));
    if asks_for_time && !scene.pucks.is_empty() {
        return Err("use_sim_time: this node has pucks, so it publishes /clock itself".to_owned());
    }
    if name != "walls" || *value == sides(walls) {
        return Ok(());
    }
    let Some(Change::Walls(min, max)) = Change::of(name, value) else {
        return Err("walls: four numbers, x_min, x_max, y_min, y_max, m".to_owned());
    };
    let widest = pucks.iter().map(|puck| puck.disc.radius).fold(0.0, f64::max);
    entry::moved(walls, (min, max), widest).map(drop).map_err(|error| format!("walls: {error}"))
}

/// Writes the values back into the scene that is about to run.
///
/// # Errors
/// Which value is wrong, and why.
pub fn apply(parameters: &Parameters, scene: &mut Scene) -> Result<(), String> {
    for (name, value) in parameters.all() {
        veto(scene, (scene.settings.walls, &scene.pucks), &name, &value)?;
        match (name.as_str(), value) {
            ("frame_id", ParameterValue::String(frame)) => scene.node.frame_id = frame,
            ("circle_topics", ParameterValue::StringArray(topics)) => {
                scene.node.circle_topics = topics;
            }
            (name, value) => match Change::of(name, &value) {
                Some(Change::PublishRate(rate)) => scene.node.publish_rate_hz = rate,
                Some(Change::StaleAfter(time)) => scene.settings.stale_after = time,
                Some(Change::ContactMargin(margin)) => scene.settings.contact_margin = margin,
                Some(Change::CommandTimeout(time)) => scene.settings.command_timeout = time,
                Some(Change::Walls(min, max)) => put_walls(scene, min, max)?,
                _ => {}
            },
        }
    }
    Ok(())
}

/// Moves the walls of a scene that has not begun: nobody is brought inside.
fn put_walls(scene: &mut Scene, min: DVec2, max: DVec2) -> Result<(), String> {
    let Some(walls) = scene.settings.walls.as_mut() else { return Ok(()) };
    (walls.min, walls.max) = (min, max);
    let outside = |disc: &Disc| !walls.contain(disc.position, disc.radius);
    match scene.pucks.iter().find(|puck| outside(&puck.disc)) {
        Some(puck) => Err(format!("walls: puck `{}` must lie inside", puck.name)),
        None => Ok(()),
    }
}
