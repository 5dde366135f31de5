//! The scene format: YAML, each key with its unit and range, every error with its place.
//!
//! Unknown keys, numbers out of range, repeated names or ids and overlapping starts are refused.

use std::collections::HashSet;

use glam::DVec2;
use serde::Deserialize;
use serde_saphyr::{Location, Spanned, options};

use super::batch::{Batch, Placed, Range};
use super::boundary::{SegmentsFile, WallsFile};
use super::league::{BallFile, DriveFile, FieldFile, RobotsFile};
use super::{NodeSettings, Puck, Scene, SceneError};
use crate::detect;
use crate::detect::touching::overlap;
use crate::messages::Contact;
use crate::plan::budget::{self, Wish};
use crate::plan::parts::Parts;
use crate::plan::{BroadPhase, Method};
use crate::world::{Disc, Drive, Pace, Periodic, Segments, Settings, Walls, limits};

/// Grey: the colour of pucks that name none.
pub(super) const DEFAULT_COLOUR: [u8; 4] = [128, 128, 128, 255];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneFile {
    name: Option<String>,
    restitution: Option<Spanned<f64>>,
    contact_time_s: Option<Spanned<f64>>,
    method: Option<Spanned<String>>,
    step_s: Option<Spanned<f64>>,
    tick_s: Option<Spanned<f64>>,
    stiffness: Option<Spanned<f64>>,
    damping: Option<Spanned<f64>>,
    pub(super) walls: Option<Spanned<WallsFile>>,
    pub(super) segments: Option<Spanned<SegmentsFile>>,
    pub(super) gravity: Option<Spanned<[f64; 2]>>,
    pub(super) drag: Option<Spanned<f64>>,
    pub(super) periodic: Option<Spanned<WallsFile>>,
    field: Option<Spanned<FieldFile>>,
    ball: Option<Spanned<BallFile>>,
    #[serde(default)]
    robots: Vec<Spanned<RobotsFile>>,
    #[serde(default)]
    pucks: Vec<Spanned<PuckFile>>,
    #[serde(default)]
    batches: Vec<Spanned<BatchFile>>,
    #[serde(default)]
    node: NodeFile,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PuckFile {
    name: Spanned<String>,
    id: Option<u32>,
    position: [f64; 2],
    #[serde(default)]
    velocity: [f64; 2],
    radius: f64,
    mass: Option<f64>,
    colour: Option<Spanned<String>>,
    driven: Option<bool>,
    drive: Option<Spanned<DriveFile>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BatchFile {
    name: Spanned<String>,
    count: Spanned<usize>,
    #[serde(default)]
    seed: u64,
    radius: Spanned<Amount>,
    mass: Option<Spanned<Amount>>,
    speed: Option<Spanned<f64>>,
    region: Option<Spanned<WallsFile>>,
    colour: Option<Spanned<String>>,
    driven: Option<bool>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Amount {
    One(f64),
    Range([f64; 2]),
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct NodeFile {
    publish_rate_hz: Option<Spanned<f64>>,
    stale_after_s: Option<Spanned<f64>>,
    contact_margin_m: Option<Spanned<f64>>,
    command_timeout_s: Option<Spanned<f64>>,
    frame_id: Option<String>,
    circle_topics: Option<Spanned<Vec<String>>>,
    error: Option<Spanned<f64>>,
    budget: Option<Spanned<RunTime>>,
}

/// Seconds, or a time with its unit.
#[derive(Deserialize)]
#[serde(untagged)]
enum RunTime {
    Seconds(f64),
    Text(String),
}

/// Reads a scene from YAML; `file` is its name in errors.
///
/// # Errors
/// [`SceneError`] with line and column.
pub fn parse(text: &str, file: &str) -> Result<Scene, SceneError> {
    // What a scene with the most pucks has; the library stops at 250 000.
    let options = options! { budget: serde_saphyr::budget! {
        max_nodes: NODES_PER_PUCK * limits::PUCKS_PER_SCENE,
        max_events: 2 * NODES_PER_PUCK * limits::PUCKS_PER_SCENE,
    } };
    let scene: SceneFile =
        serde_saphyr::from_str_with_options(text, options).map_err(|e| unreadable(&e, file))?;
    let scene = Reader::new(file).read(&scene)?;
    Ok(Scene { text: text.into(), ..scene })
}

/// Keys and values of a puck that names all that it may.
const NODES_PER_PUCK: usize = 50;

/// A puck without a place, such as a program adds to an arena.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TemplateFile {
    name: Option<Spanned<String>>,
    #[serde(default)]
    velocity: [f64; 2],
    radius: f64,
    mass: Option<f64>,
    colour: Option<Spanned<String>>,
    driven: Option<bool>,
    drive: Option<Spanned<DriveFile>>,
}

/// Reads a puck without a place from YAML: the keys of a scene's puck, of which `radius` is
/// required. Its id is 0 and it stands at the origin; its name is empty if it has none.
///
/// # Errors
/// [`SceneError`] with line and column; `file` is what the text is called in it.
pub fn parse_puck(text: &str, file: &str) -> Result<Puck, SceneError> {
    let template: TemplateFile = serde_saphyr::from_str(text).map_err(|e| unreadable(&e, file))?;
    let mut reader = Reader::new(file);
    let name = template.name.as_ref().map(|name| reader.name(name)).transpose()?;
    let disc = Disc {
        id: 0,
        position: DVec2::ZERO,
        velocity: DVec2::from_array(template.velocity),
        radius: template.radius,
        mass: template.mass.unwrap_or(1.0),
    };
    if let Some(defect) = disc.refusal() {
        return Err(reader.error(None, defect.to_string()));
    }
    let colour = reader.colour(&template.colour)?;
    let (driven, drive) = reader.drive(template.driven.unwrap_or(true), &template.drive)?;
    let name = name.unwrap_or_default();
    Ok(Puck { name, disc, colour, driven, drive, ..Puck::default() })
}

/// The library's words in one line, with the place in front.
fn unreadable(error: &serde_saphyr::Error, file: &str) -> SceneError {
    let place = error.location().map(|place| (place.line(), place.column()));
    // The library shows the lines around it and repeats the place.
    let message = error.without_snippet().to_string().replace('\n', " ");
    let message = match message.rsplit_once(" at line ") {
        Some((what, _)) => what.to_owned(),
        None => message,
    };
    SceneError { file: file.to_owned(), place, message }
}

/// Where pucks may stand.
#[derive(Clone, Copy)]
pub(super) struct Bounds {
    pub walls: Option<Walls>,
    /// Whether these are the border of a periodic box.
    pub periodic: bool,
    pub segments: Option<Segments>,
}

/// Checks a scene and builds it.
pub(super) struct Reader<'a> {
    file: &'a str,
    names: HashSet<String>,
    ids: HashSet<u32>,
    /// Where to look for a free id.
    next_id: u32,
    pub(super) pucks: Vec<Puck>,
}

pub(super) type Checked<T> = Result<T, SceneError>;

impl<'a> Reader<'a> {
    fn new(file: &'a str) -> Self {
        let (names, ids, pucks) = (HashSet::new(), HashSet::new(), Vec::new());
        Self { file, names, ids, next_id: limits::FIRST_PUCK_ID, pucks }
    }

    fn read(mut self, scene: &SceneFile) -> Checked<Scene> {
        let restitution = self.fraction("restitution", &scene.restitution, 1.0)?;
        let walls = match &scene.walls {
            Some(walls) => Some(self.walls("walls", walls, restitution)?),
            None => None,
        };
        let contact_time = match &scene.contact_time_s {
            Some(_) => Some(self.at_least_0("contact_time_s", &scene.contact_time_s, 0.0)?),
            None => None,
        };
        self.ids.extend(scene.pucks.iter().filter_map(|puck| puck.value.id));
        let periodic = self.periodic(scene)?;
        // Pucks begin inside the periodic box, clear of its border: so none overlap across it.
        let room = periodic.map(|Periodic { min, max }| Walls { min, max, restitution: 1.0 });
        let segments = self.segments(scene, restitution)?;
        let bounds = Bounds {
            walls: walls.or(room),
            periodic: room.is_some(),
            segments: segments.as_ref().map(|(all, _)| *all),
        };
        self.read_ball(&scene.ball, bounds)?;
        self.read_robots(&scene.robots, bounds)?;
        self.read_pucks(&scene.pucks, bounds)?;
        self.read_batches(&scene.batches, bounds)?;
        let node = &scene.node;
        let stale_default = limits::STALE_AFTER_S;
        let settings = Settings {
            restitution,
            walls,
            segments: bounds.segments,
            gravity: self.gravity(&scene.gravity)?,
            drag: self.drag(scene)?,
            periodic,
            contact_time,
            method: self.method(&scene.method)?,
            pace: self.pace(scene)?,
            contact_margin: self.at_least_0("contact_margin_m", &node.contact_margin_m, 0.0)?,
            stale_after: self.above_0("stale_after_s", &node.stale_after_s, stale_default)?,
            command_timeout: self.at_least_0("command_timeout_s", &node.command_timeout_s, 0.0)?,
            keep: Parts::NONE,
        };
        self.fits(periodic, scene)?;
        let field = self.field(&scene.field)?;
        let segment_names = segments.map_or_else(Vec::new, |(_, names)| names);
        let node = self.node(node)?;
        self.pucks.sort_by_key(|puck| puck.disc.id);
        let name = scene.name.clone().unwrap_or_else(|| self.file.to_owned());
        let (pucks, text) = (std::mem::take(&mut self.pucks), "".into());
        let mut read = Scene { name, settings, pucks, node, text, field, segment_names };
        let place = scene.method.as_ref().map(|method| method.referenced);
        read.choose(None, None).map_err(|message| self.error(place, message))?;
        Ok(read)
    }

    /// The method; `None` = the plan chooses.
    fn method(&self, method: &Option<Spanned<String>>) -> Checked<Option<Method>> {
        let Some(method) = method else { return Ok(None) };
        let error = |message| self.error(Some(method.referenced), format!("method: {message}"));
        Method::named(&method.value).map_err(error)
    }

    fn pace(&self, scene: &SceneFile) -> Checked<Pace> {
        let Pace { step, tick, stiffness, damping } = Pace::default();
        Ok(Pace {
            step: self.above_0("step_s", &scene.step_s, step)?,
            tick: self.above_0("tick_s", &scene.tick_s, tick)?,
            stiffness: self.above_0("stiffness", &scene.stiffness, stiffness)?,
            damping: self.at_least_0("damping", &scene.damping, damping)?,
        })
    }

    fn node(&self, node: &NodeFile) -> Checked<NodeSettings> {
        let (default, (least, most)) = (limits::PUBLISH_RATE_HZ, limits::PUBLISH_RATES_HZ);
        let (right, wanted) = (|rate| (least..=most).contains(&rate), format!("{least} to {most}"));
        let publish_rate_hz =
            self.number("publish_rate_hz", &node.publish_rate_hz, default, right, &wanted)?;
        let circle_topics = match &node.circle_topics {
            Some(topics) => topics.value.clone(),
            None => vec!["circle_states".to_owned()],
        };
        if let Some(topic) = circle_topics.iter().find(|topic| !is_topic(topic)) {
            let place = node.circle_topics.as_ref().map(|topics| topics.referenced);
            let message = format!("circle_topics: `{topic}` is not a topic name");
            return Err(self.error(place, message));
        }
        let mut seen = HashSet::new();
        for topic in &circle_topics {
            if !seen.insert(topic.trim_start_matches('/')) {
                let place = node.circle_topics.as_ref().map(|topics| topics.referenced);
                let message = format!("circle_topics: `{topic}` stands there twice");
                return Err(self.error(place, message));
            }
        }
        let frame_id = node.frame_id.clone().unwrap_or_else(|| "map".to_owned());
        let wish = self.wish(node)?;
        Ok(NodeSettings { publish_rate_hz, frame_id, circle_topics, wish })
    }

    /// Bounds of error and run time.
    fn wish(&self, node: &NodeFile) -> Checked<Wish> {
        let error = match &node.error {
            Some(_) => Some(self.above_0("error", &node.error, 0.0)?),
            None => None,
        };
        let Some(file) = &node.budget else { return Ok(Wish { error, budget: None }) };
        let budget = match &file.value {
            RunTime::Seconds(seconds) => budget::parse_budget(&seconds.to_string()),
            RunTime::Text(text) => budget::parse_budget(text),
        };
        let wrong = |wanted| self.error(Some(file.referenced), format!("budget: {wanted}"));
        Ok(Wish { error, budget: Some(budget.map_err(wrong)?) })
    }

    fn read_pucks(&mut self, pucks: &[Spanned<PuckFile>], bounds: Bounds) -> Checked<()> {
        let mut used: HashSet<u32> = self.pucks.iter().map(|puck| puck.disc.id).collect();
        let mut places: Vec<Location> = vec![Location::UNKNOWN; self.pucks.len()];
        if let Some(puck) = pucks.get(limits::PUCKS_PER_SCENE) {
            let message = format!("at most {} pucks", limits::PUCKS_PER_SCENE);
            return Err(self.error(Some(puck.referenced), message));
        }
        for puck in pucks {
            places.push(puck.referenced);
            let (place, puck) = (Some(puck.referenced), &puck.value);
            let name = self.name(&puck.name)?;
            let id = self.id(puck.id);
            if !used.insert(id) {
                return Err(self.error(place, format!("puck `{name}`: id {id} is taken")));
            }
            if id == Contact::WALL {
                return Err(self.error(place, format!("puck `{name}`: id {id} stands for a wall")));
            }
            let disc = Disc {
                id,
                position: DVec2::from_array(puck.position),
                velocity: DVec2::from_array(puck.velocity),
                radius: puck.radius,
                mass: puck.mass.unwrap_or(1.0),
            };
            self.may_stand(&name, &disc, bounds, place)?;
            let colour = self.colour(&puck.colour)?;
            let (driven, drive) = self.drive(puck.driven.unwrap_or(true), &puck.drive)?;
            self.pucks.push(Puck { name, disc, colour, driven, drive, ..Puck::default() });
        }
        self.no_overlaps(&places)
    }

    /// Refuses a puck that is out of range or out of bounds.
    pub(super) fn may_stand(
        &self,
        name: &str,
        disc: &Disc,
        bounds: Bounds,
        place: Option<Location>,
    ) -> Checked<()> {
        let Bounds { walls, periodic, segments } = bounds;
        if let Some(defect) = disc.refusal() {
            return Err(self.error(place, format!("puck `{name}`: {defect}")));
        }
        if walls.is_some_and(|walls| !walls.contain(disc.position, disc.radius)) {
            let bounds =
                if periodic { "begin inside the periodic box" } else { "lie inside the walls" };
            let message = format!("puck `{name}` must {bounds}");
            return Err(self.error(place, message));
        }
        if segments.is_some_and(|segments| segments.refuse(disc, walls.as_ref())) {
            let message = format!("puck `{name}` must lie within the field, off all segments");
            return Err(self.error(place, message));
        }
        Ok(())
    }

    /// `places`: of the pucks in the file.
    fn no_overlaps(&self, places: &[Location]) -> Checked<()> {
        let discs: Vec<Disc> = self.pucks.iter().map(|puck| puck.disc).collect();
        let pairs = detect::touching_pairs(&discs, 0.0, BroadPhase::Grid)
            .map_err(|error| self.error(None, error.to_string()))?;
        let first = pairs.into_iter().find(|&(i, j)| overlap(&discs[i], &discs[j]));
        let Some((i, j)) = first else { return Ok(()) };
        let (a, b) = (&self.pucks[i].name, &self.pucks[j].name);
        let message = format!("puck `{b}` overlaps puck `{a}`: part them, or let them just touch");
        let place = Some(places[j]).filter(|place| *place != Location::UNKNOWN);
        Err(self.error(place, message))
    }

    fn read_batches(
        &mut self,
        batches: &[Spanned<BatchFile>],
        Bounds { walls, segments, .. }: Bounds,
    ) -> Checked<()> {
        for batch in batches {
            let (place, file) = (Some(batch.referenced), &batch.value);
            let base = self.name(&file.name)?;
            if !is_token(&format!("{base}_0")) {
                let message = format!("batch `{base}`: a name before _0 must not end with _");
                return Err(self.error(Some(file.name.referenced), message));
            }
            let batch = self.batch(file, walls, place)?;
            let colour = self.colour(&file.colour)?;
            let ids: Vec<u32> = (0..batch.count).map(|_| self.id(None)).collect();
            let discs: Vec<Disc> = self.pucks.iter().map(|puck| puck.disc).collect();
            let mut placed = Placed::new(&discs, batch.radius.max).within(segments, walls);
            let placed = placed.add_batch(&batch, &ids);
            let discs = placed.map_err(|count| {
                let message = format!(
                    "batch `{base}`: only {count} of {} pucks found a place; fewer or smaller \
                     ones, or more room",
                    batch.count
                );
                self.error(place, message)
            })?;
            for (k, disc) in discs.into_iter().enumerate() {
                let name = format!("{base}_{k}");
                if !self.names.insert(name.clone()) {
                    return Err(self.error(place, format!("the name `{name}` is taken")));
                }
                let (driven, drive) = (file.driven.unwrap_or(false), Drive::default());
                self.pucks.push(Puck { name, disc, colour, driven, drive, ..Puck::default() });
            }
        }
        Ok(())
    }

    fn batch(
        &self,
        file: &BatchFile,
        walls: Option<Walls>,
        place: Option<Location>,
    ) -> Checked<Batch> {
        let region = match (&file.region, walls) {
            (Some(region), _) => self.walls("region", region, 1.0)?,
            (None, Some(walls)) => walls,
            (None, None) => {
                return Err(self.error(place, "a batch without walls needs a `region`".to_owned()));
            }
        };
        if let Some(walls) =
            walls.filter(|walls| !walls.contain(region.min, 0.0) || !walls.contain(region.max, 0.0))
        {
            let [[x, y], [right, top]] = [walls.min, walls.max].map(|corner| corner.to_array());
            let within = format!("x {x} to {right}, y {y} to {top} m");
            let message = format!("the region must lie inside the walls, {within}");
            return Err(self.error(place, message));
        }
        let count = file.count.value;
        if count > limits::PUCKS_PER_SCENE.saturating_sub(self.pucks.len()) {
            let message = format!("count: at most {} pucks", limits::PUCKS_PER_SCENE);
            return Err(self.error(Some(file.count.referenced), message));
        }
        let one = Spanned::new(Amount::One(1.0), Location::UNKNOWN, Location::UNKNOWN);
        Ok(Batch {
            count,
            seed: file.seed,
            radius: self.range("radius", &file.radius)?,
            mass: self.range("mass", file.mass.as_ref().unwrap_or(&one))?,
            speed: self.number(
                "speed",
                &file.speed,
                0.0,
                |speed| (0.0..=limits::SIZE_MAX).contains(&speed),
                "from 0 to 1e60 m/s",
            )?,
            region,
        })
    }

    /// A name that is new and a token of topic names.
    pub(super) fn name(&mut self, name: &Spanned<String>) -> Checked<String> {
        let place = Some(name.referenced);
        if !is_token(&name.value) {
            return Err(self.error(place, no_token(&name.value)));
        }
        if !self.names.insert(name.value.clone()) {
            return Err(self.error(place, format!("the name `{}` is taken", name.value)));
        }
        Ok(name.value.clone())
    }

    /// The id wished for, or the next free one.
    pub(super) fn id(&mut self, wished: Option<u32>) -> u32 {
        if let Some(id) = wished {
            return id;
        }
        while !self.ids.insert(self.next_id) {
            self.next_id += 1;
        }
        self.next_id
    }

    pub(super) fn colour(&self, colour: &Option<Spanned<String>>) -> Checked<[u8; 4]> {
        let Some(colour) = colour else { return Ok(DEFAULT_COLOUR) };
        let parsed = csscolorparser::parse(&colour.value).map_err(|_| {
            let message = format!("colour `{}`: a CSS colour such as \"#d62728\"", colour.value);
            self.error(Some(colour.referenced), message)
        })?;
        Ok(parsed.to_rgba8())
    }

    fn range(&self, key: &str, amount: &Spanned<Amount>) -> Checked<Range> {
        let (min, max) = match amount.value {
            Amount::One(value) => (value, value),
            Amount::Range([min, max]) => (min, max),
        };
        if limits::SIZE_MIN <= min && min <= max && max <= limits::SIZE_MAX {
            return Ok(Range { min, max });
        }
        let message = format!(
            "{key}: a number from {:e} to {:e}, or [smallest, largest]",
            limits::SIZE_MIN,
            limits::SIZE_MAX
        );
        Err(self.error(Some(amount.referenced), message))
    }

    pub(super) fn fraction(
        &self,
        key: &str,
        value: &Option<Spanned<f64>>,
        default: f64,
    ) -> Checked<f64> {
        self.number(key, value, default, |x| (0.0..=1.0).contains(&x), "from 0 to 1")
    }

    pub(super) fn at_least_0(
        &self,
        key: &str,
        value: &Option<Spanned<f64>>,
        default: f64,
    ) -> Checked<f64> {
        self.number(key, value, default, |x| x >= 0.0 && x.is_finite(), "0 or more")
    }

    pub(super) fn above_0(
        &self,
        key: &str,
        value: &Option<Spanned<f64>>,
        default: f64,
    ) -> Checked<f64> {
        self.number(key, value, default, |x| x > 0.0 && x.is_finite(), "above 0")
    }

    pub(super) fn number(
        &self,
        key: &str,
        value: &Option<Spanned<f64>>,
        default: f64,
        right: impl Fn(f64) -> bool,
        wanted: &str,
    ) -> Checked<f64> {
        match value {
            None => Ok(default),
            Some(number) if right(number.value) => Ok(number.value),
            Some(number) => {
                let message = format!("{key} = {}, must be {wanted}", number.value);
                Err(self.error(Some(number.referenced), message))
            }
        }
    }

    pub(super) fn error(&self, place: Option<Location>, message: String) -> SceneError {
        let place = place.map(|place| (place.line(), place.column()));
        SceneError { file: self.file.to_owned(), place, message }
    }
}

/// Whether a word may stand between the slashes of a topic name.
pub fn is_token(word: &str) -> bool {
    let letters = word.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    let begins_well = word.starts_with(|c: char| c.is_ascii_alphabetic());
    letters && begins_well && !word.contains("__") && word.len() <= limits::NAME_LETTERS
}

/// Why a name is none, in one line whatever it is.
pub fn no_token(name: &str) -> String {
    let (shown, most) = (60, limits::NAME_LETTERS);
    let dots = if name.chars().nth(shown).is_some() { "..." } else { "" };
    let length = if name.len() > most { format!(", at most {most}") } else { String::new() };
    let name: String = name.chars().take(shown).flat_map(char::escape_debug).collect();
    format!("name `{name}{dots}`: letters, digits and single _, not beginning with a digit{length}")
}

/// Whether a text is a relative or absolute topic name.
fn is_topic(name: &str) -> bool {
    name.strip_prefix('/').unwrap_or(name).split('/').all(is_token)
}
