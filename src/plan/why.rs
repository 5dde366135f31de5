//! The plan in words: each part, kept or left out, and why, with the numbers of the scene.
//!
//! Only words are made here; what is decided is decided in [`Plan::of`].

use std::ops::RangeInclusive;

use serde::Serialize;

use super::parts::{Part, Parts};
use super::{ALL_PAIRS_UP_TO, Method, Plan};
use crate::motion::events::Lanes;
use crate::world::{Disc, Settings};

/// What became of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It is needed, and built.
    Kept,
    /// It is not needed, but was asked for.
    Forced,
    /// It is not built.
    LeftOut,
    /// The method has it, needed or not.
    AlwaysThere,
}

impl Verdict {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Kept => "kept",
            Self::Forced => "asked for",
            Self::LeftOut => "left out",
            Self::AlwaysThere => "always there",
        }
    }
}

/// A part, and what was decided about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The part.
    pub part: Part,
    /// What became of it.
    pub verdict: Verdict,
    /// Why, in a few words.
    pub why: String,
}

/// A scene whose plan is to be told.
#[derive(Clone, Copy, Debug)]
pub struct Told<'a> {
    /// Its plan.
    pub plan: &'a Plan,
    /// Its settings.
    pub settings: &'a Settings,
    /// Its pucks.
    pub pucks: &'a [Disc],
}

impl Told<'_> {
    /// Why the pucks move by this method.
    pub fn why_method(&self) -> String {
        let (method, count) = (self.plan.method, self.pucks.len());
        if self.settings.method == Some(method) {
            return "asked for".to_owned();
        }
        match method {
            Method::Events => format!("{count} pucks, all pairs pay up to {ALL_PAIRS_UP_TO}"),
            _ if count <= ALL_PAIRS_UP_TO => {
                format!("{}, all pairs pay up to {ALL_PAIRS_UP_TO}", pucks(count))
            }
            _ => "extreme units or a small periodic box: events has none of them".into(),
        }
    }

    /// Every part.
    pub fn rows(&self) -> Vec<Row> {
        Part::ALL.into_iter().map(|part| self.row(part)).collect()
    }

    fn row(&self, part: Part) -> Row {
        let verdict = self.verdict(part);
        let why = match verdict {
            _ if self.pucks.is_empty() => self.without_pucks(part),
            Verdict::Kept => self.needed(part),
            Verdict::AlwaysThere => self.always(part),
            Verdict::Forced | Verdict::LeftOut => self.not_needed(part),
        };
        Row { part, verdict, why }
    }

    fn verdict(&self, part: Part) -> Verdict {
        let Plan { needed, built, method, .. } = *self.plan;
        let resolver = matches!(part, Part::Restitution | Part::Observed | Part::Together);
        if self.pucks.is_empty() && part != Part::Grid {
            return if resolver { Verdict::AlwaysThere } else { Verdict::LeftOut };
        }
        match part {
            _ if !part.is_known_to(method) => Verdict::LeftOut,
            Part::Lanes if has_lanes() => Verdict::Kept,
            _ if needed.has(part) => Verdict::Kept,
            _ if part.is_always_there(method) => Verdict::AlwaysThere,
            _ if built.has(part) => Verdict::Forced,
            _ => Verdict::LeftOut,
        }
    }

    /// Whether what it saves can be measured: forced, the part changes no bit of the arena.
    pub fn is_measured(&self, part: Part) -> bool {
        let laws = self.plan.laws(self.settings);
        let can_be = Parts::that_can_be_forced(self.plan.method, &laws).has(part);
        let in_contacts = !matches!(part, Part::Grid | Part::Commands);
        !self.pucks.is_empty() && can_be && in_contacts && !self.plan.needed.has(part)
    }

    fn without_pucks(&self, part: Part) -> String {
        let of_circles = match part {
            Part::Restitution => "one law for all: answers take it as it is",
            Part::Observed => "all that there is: circles that are reported",
            Part::Together => "whether contacts share a circle is known from each message",
            Part::Grid => return self.not_needed(part),
            Part::Topics => return self.not_needed(part),
            _ => "no pucks, nothing moves",
        };
        of_circles.to_owned()
    }

    fn needed(&self, part: Part) -> String {
        let Settings { restitution, drag, .. } = *self.settings;
        let fixed = self.pucks.iter().filter(|puck| puck.mass.is_infinite()).count();
        match part {
            Part::Walls => self.plan.laws(self.settings).walls.map_or(String::new(), |walls| {
                let size = walls.max - walls.min;
                format!("a box of {} m by {} m", short(size.x), short(size.y))
            }),
            Part::Segments => self.settings.segments.map_or(String::new(), |segments| {
                format!("{} of them, met at faces and ends", segments.all().len())
            }),
            Part::Periodic => self.settings.periodic.map_or(String::new(), |periodic| {
                let size = periodic.size();
                format!("it repeats every {} m and {} m", short(size.x), short(size.y))
            }),
            Part::FixedDiscs => format!("{} of infinite mass", pucks(fixed)),
            Part::Masses => format!("masses from {} kg", self.range(|puck| puck.mass)),
            Part::Radii => format!("radii from {} m", self.range(|puck| puck.radius)),
            Part::Restitution => format!("pairs keep {restitution} of their speed"),
            Part::ContactTime => {
                format!("contacts lose energy: {} s", short(self.plan.contact_time))
            }
            Part::Remembered => format!("at restitution {restitution} a few discs may collapse"),
            Part::Gravity => "flights are parabolas".to_owned(),
            Part::Drag => format!("speeds fall with {} 1/s", short(drag)),
            Part::Observed => "a puck of infinite mass moves: it brings in energy".to_owned(),
            Part::ExtremeUnits => "sizes beyond 1e-70 to 1e70: squares of squares leave".to_owned(),
            Part::Ahead => format!("{} pucks do not fit the caches", self.pucks.len()),
            Part::Lanes => "this processor has them: four discs at once".to_owned(),
            _ => String::new(),
        }
    }

    fn not_needed(&self, part: Part) -> String {
        let (count, method) = (self.pucks.len(), self.plan.method);
        let a_box = part == Part::Segments;
        if !self.pucks.is_empty() && !part.is_known_to(method) && !a_box {
            return format!("the method {method} does not have it");
        }
        match part {
            Part::Walls => "no walls".to_owned(),
            Part::Segments if self.settings.segments.is_some() => {
                "the four are a box, which is enough".to_owned()
            }
            Part::Segments => "none".to_owned(),
            Part::Periodic => "nothing repeats".to_owned(),
            Part::WrapInside if self.settings.periodic.is_none() => "nothing repeats".to_owned(),
            Part::WrapInside => "only the outermost cells look across the border".to_owned(),
            Part::Masses => self.all_equal("masses", "kg", |puck| puck.mass),
            Part::Radii => self.all_equal("radii", "m", |puck| puck.radius),
            Part::Restitution => "pairs are elastic".to_owned(),
            Part::ContactTime => "no contact loses energy, so nothing collapses".to_owned(),
            Part::Remembered => "pairs are elastic: no collapse".to_owned(),
            Part::Gravity => "none; with it other formulas, so other last digits".to_owned(),
            Part::Drag => "none: time needs no mapping".to_owned(),
            Part::Commands => "an index of ids comes with the first; memory only".to_owned(),
            Part::Observed => "nobody has reported a circle yet".to_owned(),
            Part::ExtremeUnits => {
                "all of radii, coordinates, speeds within 1e-70 to 1e70".to_owned()
            }
            Part::Grid => format!("messages of up to {ALL_PAIRS_UP_TO} circles: all pairs"),
            Part::Lanes => "this processor has none that are known here".to_owned(),
            Part::Ahead => format!("{} fit the caches", pucks(count)),
            Part::Account => "kept once somebody listens to error_report".to_owned(),
            Part::Topics => "a message that nobody subscribes to is not built".to_owned(),
            _ => String::new(),
        }
    }

    fn always(&self, part: Part) -> String {
        let method = self.plan.method;
        let is_events = method == Method::Events;
        let why = match part {
            Part::FixedDiscs => "none here; one comparison where two masses share",
            Part::Clock if is_events => "one pass over the discs in an epoch of 8 contacts each",
            Part::Clock if method == Method::Plain => "times are offsets from a base that moves",
            Part::Clock => "time is so many whole steps or ticks, and a rest",
            Part::Together if is_events => "no scene excludes it: a look at the next three events",
            Part::Together => "no scene excludes it: a look at the other events",
            Part::DoubleDouble => "what the method is for: it judges the others",
            Part::ContactTime => "every disc counts its quick contacts",
            Part::Masses | Part::Radii => "every disc carries its own",
            Part::Restitution => "one law for all restitutions",
            Part::Commands => "a search among the discs",
            Part::Observed => "every disc carries its owner",
            _ => "",
        };
        why.to_owned()
    }

    fn span(&self, of: impl Fn(&Disc) -> f64) -> RangeInclusive<f64> {
        let least = self.pucks.iter().map(&of).fold(f64::INFINITY, f64::min);
        least..=self.pucks.iter().map(&of).fold(f64::NEG_INFINITY, f64::max)
    }

    fn range(&self, of: impl Fn(&Disc) -> f64) -> String {
        let span = self.span(of);
        format!("{} to {}", short(*span.start()), short(*span.end()))
    }

    fn all_equal(&self, what: &str, unit: &str, of: impl Fn(&Disc) -> f64) -> String {
        let value = short(*self.span(of).start());
        match self.pucks.len() {
            1 => format!("a single puck: {value} {unit}"),
            count => format!("all {count} {what} are {value} {unit}"),
        }
    }
}

fn has_lanes() -> bool {
    Lanes::best() != Lanes::portable()
}

fn pucks(count: usize) -> String {
    if count == 1 { "1 puck".to_owned() } else { format!("{count} pucks") }
}

/// A number to four digits.
fn short(x: f64) -> String {
    let text = format!("{x:.3e}");
    match text.parse::<f64>() {
        Ok(value) if value == 0.0 || (1e-3..1e6).contains(&value.abs()) => value.to_string(),
        _ if x.is_infinite() => "infinity".to_owned(),
        _ => text,
    }
}
