//! What an audit has found: collisions, violations, totals. Data, and how it adds up.
//!
//! Of a long recording there may be millions of each, so only sums, the worst and the first are
//! kept. Nothing here judges.

use glam::DVec2;
use serde::Serialize;

use super::law::{Law, Source};
use super::noise::Noise;
use crate::referee::{Fault, fault, is_crash};
use crate::world::DiscId;

/// Violations that are kept, the first of all; every one is counted.
pub const KEPT: usize = 10_000;

/// The worst that are told.
pub const WORST: usize = 10;

/// Collisions of which the values are kept for plots: every so many when there are more.
const PLOTTED: usize = 4_000;

/// What may be wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Both velocities were multiplied by one number.
    ScaledVelocities,
    /// The masses of the two were exchanged.
    SwappedMasses,
    /// The velocities of two discs changed though they never came within reach, or though they
    /// parted already.
    Phantom,
    /// The sum of the momenta changed.
    Momentum,
    /// The impulse is not along the line of centres, so what is tangential changed.
    Normal,
    /// The discs stay together where they should bounce.
    Sticking,
    /// The restitution is not that of the law: energy is lost or gained.
    Energy,
    /// The velocities changed before the discs touched.
    Early,
    /// The velocities changed when the discs overlapped already.
    Late,
    /// The discs ran through each other between two samples, and nothing changed.
    Tunnelling,
    /// The discs ran into each other, and nothing changed.
    Missed,
    /// The discs overlap at samples without having run into each other.
    Overlap,
    /// No lawful collisions lead from one sample to the next, and which of several is wrong cannot
    /// be told.
    Cluster,
}

impl Kind {
    /// All, the most telling name first.
    pub const ALL: [Self; 13] = [
        Self::ScaledVelocities,
        Self::SwappedMasses,
        Self::Phantom,
        Self::Momentum,
        Self::Normal,
        Self::Sticking,
        Self::Energy,
        Self::Early,
        Self::Late,
        Self::Tunnelling,
        Self::Missed,
        Self::Overlap,
        Self::Cluster,
    ];

    /// Whether it only says that the instant was wrong.
    pub fn is_of_instant(self) -> bool {
        matches!(self, Self::Early | Self::Late)
    }

    /// Whether it says that momentum was not kept.
    pub fn is_of_momentum(self) -> bool {
        matches!(self, Self::Momentum | Self::ScaledVelocities | Self::SwappedMasses)
    }

    /// In one word.
    pub fn name(self) -> &'static str {
        match self {
            Self::ScaledVelocities => "scaled_velocities",
            Self::SwappedMasses => "swapped_masses",
            Self::Phantom => "phantom",
            Self::Momentum => "momentum",
            Self::Normal => "normal",
            Self::Sticking => "sticking",
            Self::Energy => "energy",
            Self::Early => "early",
            Self::Late => "late",
            Self::Tunnelling => "tunnelling",
            Self::Missed => "missed",
            Self::Overlap => "overlap",
            Self::Cluster => "cluster",
        }
    }

    /// In a sentence.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::ScaledVelocities => "both velocities were multiplied by one number",
            Self::SwappedMasses => "momentum would be right with the masses exchanged",
            Self::Phantom => "velocities changed out of reach, or while parting",
            Self::Momentum => "the sum of the momenta changed",
            Self::Normal => "the impulse is not along the line of centres",
            Self::Sticking => "the discs stay together where they should bounce",
            Self::Energy => "the restitution is not that of the law",
            Self::Early => "velocities changed before the discs touched",
            Self::Late => "velocities changed when the discs overlapped",
            Self::Tunnelling => "discs ran through each other between two samples",
            Self::Missed => "discs ran into each other, and nothing changed",
            Self::Overlap => "discs overlap at samples without having run into each other",
            Self::Cluster => "no lawful collisions lead from one sample to the next",
        }
    }
}

/// A set of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Kinds(u16);

impl Kinds {
    /// A set of one.
    pub fn only(kind: Kind) -> Self {
        Self(1 << kind as u16)
    }

    /// Adds one.
    pub fn add(&mut self, kind: Kind) {
        self.0 |= 1 << kind as u16;
    }

    /// Whether it is in it.
    pub fn has(self, kind: Kind) -> bool {
        self.0 & (1 << kind as u16) != 0
    }

    /// Whether nothing is wrong.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The most telling first.
    pub fn iter(self) -> impl Iterator<Item = Kind> {
        Kind::ALL.into_iter().filter(move |kind| self.has(*kind))
    }

    /// The most telling.
    pub fn first(self) -> Option<Kind> {
        self.iter().next()
    }
}

/// Whom a disc met.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Met {
    /// Another disc.
    Disc(DiscId),
    /// A wall.
    Wall,
}

/// How well a collision could be seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Sight {
    /// Alone between two samples: all its numbers are measured.
    Alone,
    /// One of several: the law foretells them all, and the samples agree.
    Foretold,
    /// One of several, of which the law explains all others.
    Singled,
}

/// One collision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Collision {
    /// When, s of the recording's clock.
    pub time: f64,
    /// One of the two.
    pub a: DiscId,
    /// The other.
    pub b: Met,
    /// Place of contact, m.
    pub place: DVec2,
    /// Unit normal from a to b.
    pub normal: DVec2,
    /// Velocities of both before, m/s; of a wall 0.
    pub before: [DVec2; 2],
    /// Speed of approach along the normal, m/s.
    pub approach: f64,
    /// Distance of the surfaces when the velocities changed, m.
    pub gap: f64,
    /// Momentum gained by both, over the momentum exchanged.
    pub momentum: f64,
    /// Kinetic energy gained, J.
    pub energy: f64,
    /// The same by the law, J; NaN if the restitution is unknown.
    pub energy_law: f64,
    /// Implied restitution and its deviation.
    pub restitution: (f64, f64),
    /// From the line of centres to the impulse, rad, and its deviation.
    pub angle: (f64, f64),
    /// What is wrong with the later velocities, over the relative speed before.
    pub wrong: f64,
    /// Radius of the smaller of the two, m.
    pub smaller_radius: f64,
    /// Time between the samples around it, s.
    pub window: f64,
    /// How well it was seen.
    pub sight: Sight,
    /// What is wrong.
    pub kinds: Kinds,
}

/// Something that must not be.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Violation {
    /// The name that fits best.
    pub kind: Kind,
    /// What else is wrong with it.
    pub also: Vec<Kind>,
    /// When, s of the recording's clock.
    pub time_s: f64,
    /// The discs in it.
    pub discs: Vec<DiscId>,
    /// Whether a wall is in it.
    pub wall: bool,
    /// Where, m.
    pub place_m: [f64; 2],
    /// Speed of approach, m/s.
    pub approach_speed_mps: f64,
    /// How wrong, without a unit: wrong part of the velocities, or distance or depth over the
    /// smaller radius where the discs were not at each other; the larger of both. Always a number:
    /// what is beyond all is the largest.
    pub severity: f64,
    /// With numbers.
    pub detail: String,
}

/// A disc that changed its velocity alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Impulse {
    /// When, s of the recording's clock.
    pub time_s: f64,
    /// Which.
    pub disc: DiscId,
    /// Where, m.
    pub place_m: [f64; 2],
    /// Change of its velocity, m/s.
    pub change_mps: [f64; 2],
}

/// A collision faster than a limit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Crash {
    /// When, s of the recording's clock.
    pub time_s: f64,
    /// Which two.
    pub discs: [DiscId; 2],
    /// Where, m.
    pub place_m: [f64; 2],
    /// Speed of approach along the line of centres, m/s.
    pub approach_speed_mps: f64,
    /// Speeds of both before, m/s.
    pub speeds_mps: [f64; 2],
    /// Who is at fault.
    pub fault: Fault,
}

/// A hole or a leap in the recording.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "what")]
pub enum Break {
    /// Samples are missing.
    Gap {
        /// After which sample, s.
        time_s: f64,
        /// About how many.
        missing: u64,
    },
    /// Time went back.
    Reset {
        /// To which time, s.
        time_s: f64,
    },
    /// A disc is where no motion leads.
    Teleport {
        /// Found at which sample, s.
        time_s: f64,
        /// Which.
        disc: DiscId,
    },
}

/// Energy by what changed it, J.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Ledger {
    /// Kinetic energy at the first sample.
    pub first_j: f64,
    /// Kinetic energy at the last sample.
    pub last_j: f64,
    /// Gained in collisions of two discs alone.
    pub pairs_j: f64,
    /// What these would have gained by the law; NaN if the restitution is unknown.
    pub pairs_law_j: f64,
    /// Gained in groups of collisions that cannot be told apart.
    pub clusters_j: f64,
    /// What the law foretells for these.
    pub clusters_law_j: f64,
    /// Gained at walls.
    pub walls_j: f64,
    /// Gained by impulses without a partner.
    pub unexplained_j: f64,
}

/// How many of what.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Sets of samples with one stamp.
    pub frames: u64,
    /// Recorded states of discs.
    pub samples: u64,
    /// States that were no numbers, had no size, or an id that was there already: left out.
    pub unsound: u64,
    /// States of discs that were not there a sample before, or were larger or heavier then.
    pub unpaired: u64,
    /// States of discs that were silent at a stamp and were carried there along their flight.
    pub carried: u64,
    /// Sets of samples with the stamp of the one before, which were not judged.
    pub repeated: u64,
    /// Most discs at once.
    pub discs: u64,
    /// Collisions of pairs that were judged alone.
    pub alone: u64,
    /// Collisions of pairs among several, of which the law foretells all.
    pub foretold: u64,
    /// Collisions of pairs singled out of several.
    pub singled: u64,
    /// Groups of discs with several collisions between two samples that could not be judged.
    pub ambiguous: u64,
    /// Collisions with walls.
    pub walls: u64,
    /// Collisions too weak or too grazing to say anything about restitution.
    pub vague: u64,
    /// Changes of a velocity without a partner.
    pub unexplained: u64,
    /// Changes at segments, robots that kick, commanded pucks or observed circles, alone or in
    /// groups, that were not judged.
    pub beside: u64,
    /// Displacements too small for a teleport that no velocity explains.
    pub displaced: u64,
    /// Sets of samples whose discs lie heaped on each other, which were not judged.
    pub heaped: u64,
    /// Sets of samples before which discs of a periodic box may have flown so far that nobody knows
    /// at which images they met, which were not judged.
    pub far: u64,
    /// Holes in the recording.
    pub gaps: u64,
    /// Times at which time went back.
    pub resets: u64,
    /// Discs that were somewhere else at once.
    pub teleports: u64,
}

impl Counts {
    /// How often collisions may have happened that were not judged.
    pub fn not_judged(&self) -> u64 {
        let Self { ambiguous, beside, unpaired, repeated, heaped, far, .. } = self;
        ambiguous + beside + unpaired + repeated + heaped + far
    }
}

/// Collisions for plots, thinned evenly.
#[derive(Clone, Debug, Default)]
pub struct Thinned {
    kept: Vec<Collision>,
    every: u64,
    seen: u64,
}

impl Thinned {
    fn add(&mut self, collision: &Collision) {
        self.every = self.every.max(1);
        if self.seen.is_multiple_of(self.every) {
            self.kept.push(*collision);
            if self.kept.len() >= 2 * PLOTTED {
                let mut place = 0;
                self.kept.retain(|_| {
                    place += 1;
                    place % 2 == 1
                });
                self.every *= 2;
            }
        }
        self.seen += 1;
    }

    /// Those that were kept.
    pub fn collisions(&self) -> &[Collision] {
        &self.kept
    }

    /// One of how many was kept.
    pub fn every(&self) -> u64 {
        self.every.max(1)
    }
}

/// All that an audit found.
#[derive(Clone, Debug)]
pub struct Findings {
    /// What it was held against.
    pub law: Law,
    /// What the recording cannot tell.
    pub noise: Noise,
    /// How many of what.
    pub counts: Counts,
    /// Energy by what changed it.
    pub ledger: Ledger,
    /// Violations by kind.
    pub by_kind: Vec<(Kind, u64)>,
    /// The first of them.
    pub violations: Vec<Violation>,
    /// The worst, the worst first.
    pub worst: Vec<Violation>,
    /// The first impulses without a partner.
    pub impulses: Vec<Impulse>,
    /// The first holes and leaps.
    pub breaks: Vec<Break>,
    /// Collisions of pairs for plots.
    pub plotted: Thinned,
    /// Overlaps of pairs that samples show.
    pub overlaps: u64,
    /// The deepest of them, in smaller radii.
    pub deepest_overlap: f64,
    /// Part of what may be wrong and is no violation.
    pub tolerance: f64,
    /// Speed of approach above which a collision is a crash, if anybody asked, m/s.
    pub crash_speed: Option<f64>,
    /// How many there were.
    pub crashes_in_all: u64,
    /// The first crashes.
    pub crashes: Vec<Crash>,
    /// What whoever read the recording has to say about it.
    pub said: Vec<String>,
    /// First and last stamp, s.
    pub times: (f64, f64),
    /// Usual time between samples, s.
    pub usual_step: f64,
}

/// Impulses and breaks that are kept.
const LISTED: usize = 1_000;

impl Findings {
    pub(super) fn new(law: Law, noise: Noise) -> Self {
        Self {
            law,
            noise,
            counts: Counts::default(),
            ledger: Ledger::default(),
            by_kind: Kind::ALL.map(|kind| (kind, 0)).to_vec(),
            violations: Vec::new(),
            worst: Vec::new(),
            impulses: Vec::new(),
            breaks: Vec::new(),
            plotted: Thinned::default(),
            overlaps: 0,
            deepest_overlap: 0.0,
            tolerance: 0.0,
            crash_speed: None,
            crashes_in_all: 0,
            crashes: Vec::new(),
            said: Vec::new(),
            times: (f64::NAN, f64::NAN),
            usual_step: 0.0,
        }
    }

    /// Violations of all kinds.
    pub fn violations_in_all(&self) -> u64 {
        self.by_kind.iter().map(|(_, count)| count).sum()
    }

    /// Violations of this kind.
    pub fn of_kind(&self, kind: Kind) -> u64 {
        self.by_kind.iter().find(|(each, _)| *each == kind).map_or(0, |(_, count)| *count)
    }

    pub(super) fn add_collision(&mut self, collision: &Collision) {
        let counter = match (collision.b, collision.sight) {
            (Met::Wall, _) => &mut self.counts.walls,
            (_, Sight::Alone) => &mut self.counts.alone,
            (_, Sight::Foretold) => &mut self.counts.foretold,
            (_, Sight::Singled) => &mut self.counts.singled,
        };
        *counter += 1;
        if let Met::Disc(b) = collision.b {
            self.plotted.add(collision);
            self.add_crash(collision, b);
        }
        if let Some(kind) = collision.kinds.first() {
            self.add_violation(violation(collision, kind, &self.law));
        }
    }

    fn add_crash(&mut self, collision: &Collision, b: DiscId) {
        if !self.crash_speed.is_some_and(|limit| is_crash(collision.approach, limit)) {
            return;
        }
        let speeds_mps = collision.before.map(DVec2::length);
        self.crashes_in_all += 1;
        if self.crashes.len() < LISTED {
            self.crashes.push(Crash {
                time_s: collision.time,
                discs: [collision.a, b],
                place_m: collision.place.to_array(),
                approach_speed_mps: collision.approach,
                fault: fault(speeds_mps),
                speeds_mps,
            });
        }
    }

    pub(super) fn add_violation(&mut self, mut violation: Violation) {
        if !violation.severity.is_finite() {
            violation.severity = f64::MAX;
        }
        let counter = self.by_kind.iter_mut().find(|(kind, _)| *kind == violation.kind);
        counter.into_iter().for_each(|(_, count)| *count += 1);
        let place = self.worst.partition_point(|other| other.severity >= violation.severity);
        if place < WORST {
            self.worst.insert(place, violation.clone());
            self.worst.truncate(WORST);
        }
        if self.violations.len() < KEPT {
            self.violations.push(violation);
        }
    }

    pub(super) fn add_impulse(&mut self, impulse: Impulse) {
        self.counts.unexplained += 1;
        if self.impulses.len() < LISTED {
            self.impulses.push(impulse);
        }
    }

    pub(super) fn add_break(&mut self, broken: Break) {
        let counter = match broken {
            Break::Gap { .. } => &mut self.counts.gaps,
            Break::Reset { .. } => &mut self.counts.resets,
            Break::Teleport { .. } => &mut self.counts.teleports,
        };
        *counter += 1;
        if self.breaks.len() < LISTED {
            self.breaks.push(broken);
        }
    }
}

/// A collision as a violation.
fn violation(collision: &Collision, kind: Kind, law: &Law) -> Violation {
    let Collision { a, b, time, place, approach, kinds, .. } = *collision;
    let mut discs = vec![a];
    if let Met::Disc(b) = b {
        discs.push(b);
    }
    Violation {
        kind,
        also: kinds.iter().filter(|other| *other != kind).collect(),
        time_s: time,
        discs,
        wall: b == Met::Wall,
        place_m: place.to_array(),
        approach_speed_mps: approach,
        severity: severity(collision),
        detail: detail(collision, kind, law),
    }
}

fn severity(collision: &Collision) -> f64 {
    let Collision { gap, wrong, smaller_radius, kinds, .. } = *collision;
    if kinds.has(Kind::Phantom) || kinds.iter().any(Kind::is_of_instant) {
        wrong.max(gap.abs() / smaller_radius)
    } else {
        wrong
    }
}

fn detail(collision: &Collision, kind: Kind, law: &Law) -> String {
    let Collision { gap, momentum, restitution, angle, energy, .. } = collision;
    match kind {
        Kind::Momentum | Kind::SwappedMasses | Kind::ScaledVelocities => {
            format!("momentum off by {:.3} of what was exchanged; energy {energy:+.3e} J", momentum)
        }
        Kind::Normal => {
            format!("impulse {:.3} rad ({:.1e}) from the line of centres", angle.0, angle.1)
        }
        Kind::Energy | Kind::Sticking => {
            let law = match (law.restitution, law.restitution_source) {
                (Some(law), Source::Estimated) => format!("{law:.4} in most collisions"),
                (Some(law), _) => format!("{law} by the law"),
                (None, _) => "at most 1 by the law".to_owned(),
            };
            format!("restitution {:.4} ({:.1e}), {law}", restitution.0, restitution.1)
        }
        Kind::Early | Kind::Phantom => format!("surfaces {gap:.3e} m apart when it happened"),
        Kind::Late => format!("surfaces {:.3e} m deep when it happened", -gap),
        _ => String::new(),
    }
}
