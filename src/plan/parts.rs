//! The parts that a scene may not need: the list of them, and which of them a scene needs.
//!
//! A part is needed or not by the numbers of the scene alone; what is not needed is not built.
//! Whoever asks for it gets it all the same, where that leaves every bit as it is: so the plan can
//! be shown to be right, and what it saves can be measured. Never decide anywhere else whether a
//! scene needs a part, and never build one here.

use glam::DVec2;

use super::Method;
use crate::motion::plain::{Laws, is_extreme};
use crate::world::{Disc, Walls};

/// From so many discs on, memory is slower than looking ahead.
pub const AHEAD_FROM: usize = 30_000;

/// What an arena may do without, or is said to be always there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Part {
    /// The box that discs bounce off.
    Walls,
    /// Line segments that discs bounce off.
    Segments,
    /// The box that repeats: positions are seen from the nearest image.
    Periodic,
    /// The nearest image where the border cannot lie between.
    WrapInside,
    /// Discs of infinite mass.
    FixedDiscs,
    /// A mass for each disc.
    Masses,
    /// A radius for each disc.
    Radii,
    /// The law of inelastic pairs, and the energy that each contact takes.
    Restitution,
    /// Records of the last contacts, for the collapse model.
    ContactTime,
    /// Contacts that are remembered to more digits than coordinates hold.
    Remembered,
    /// Flights that are parabolas.
    Gravity,
    /// The mapping of time for discs that slow down.
    Drag,
    /// Where the disc of an id is.
    Commands,
    /// Looks at who a disc is, and the energy that it brings in.
    Observed,
    /// Times of impact in units of their own.
    ExtremeUnits,
    /// Offsets from a base that moves.
    Clock,
    /// Contacts at one instant that share a disc.
    Together,
    /// A grid for circles that are reported, however few.
    Grid,
    /// Four discs looked at at once.
    Lanes,
    /// Asking for memory before it is needed.
    Ahead,
    /// Positions and velocities to twice the digits.
    DoubleDouble,
    /// The account of momentum, for `error_report`.
    Account,
    /// Messages that nobody hears.
    Topics,
}

impl Part {
    /// All of them, as they are listed.
    pub const ALL: [Self; 23] = [
        Self::Walls,
        Self::Segments,
        Self::Periodic,
        Self::WrapInside,
        Self::FixedDiscs,
        Self::Masses,
        Self::Radii,
        Self::Restitution,
        Self::ContactTime,
        Self::Remembered,
        Self::Gravity,
        Self::Drag,
        Self::Commands,
        Self::Observed,
        Self::ExtremeUnits,
        Self::Clock,
        Self::Together,
        Self::Grid,
        Self::Lanes,
        Self::Ahead,
        Self::DoubleDouble,
        Self::Account,
        Self::Topics,
    ];

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Walls => "walls",
            Self::Segments => "line segments",
            Self::Periodic => "periodic box",
            Self::WrapInside => "wrap inside the box",
            Self::FixedDiscs => "fixed discs",
            Self::Masses => "unequal masses",
            Self::Radii => "unequal radii",
            Self::Restitution => "restitution below 1",
            Self::ContactTime => "contact time",
            Self::Remembered => "remembered contacts",
            Self::Gravity => "gravity",
            Self::Drag => "drag",
            Self::Commands => "commands",
            Self::Observed => "observed circles",
            Self::ExtremeUnits => "extreme units",
            Self::Clock => "long clock",
            Self::Together => "contacts at once",
            Self::Grid => "grid for circles",
            Self::Lanes => "vector units",
            Self::Ahead => "looking ahead",
            Self::DoubleDouble => "double-double states",
            Self::Account => "momentum account",
            Self::Topics => "topics unheard",
        }
    }

    /// Whether the part can be built where it is not needed, with the same bits.
    pub fn can_be_forced(self, method: Method, laws: &Laws) -> bool {
        match (self, method) {
            (Self::Grid | Self::Account, _) => method != Method::Springs,
            (Self::Walls | Self::Drag, Method::Events | Method::Plain) => true,
            (Self::WrapInside, Method::Events) => laws.periodic.is_some(),
            (Self::Periodic | Self::Masses | Self::Radii | Self::Restitution, Method::Events)
            | (Self::ContactTime | Self::Commands, Method::Events)
            | (Self::Observed | Self::Ahead, Method::Events) => true,
            (Self::ExtremeUnits, Method::Plain) => true,
            _ => false,
        }
    }

    /// Whether the method knows such a thing at all.
    pub fn is_known_to(self, method: Method) -> bool {
        use Method::{Events, Plain, Ticks};
        match self {
            Self::WrapInside | Self::Ahead => method == Events,
            Self::Remembered | Self::DoubleDouble => method == Plain,
            Self::Segments | Self::ContactTime => matches!(method, Events | Plain | Ticks),
            Self::Lanes => method != Plain,
            Self::ExtremeUnits => method != Events,
            Self::Account => method != Method::Springs,
            _ => true,
        }
    }

    /// Whether the method has it built in, needed or not.
    pub fn is_always_there(self, method: Method) -> bool {
        match self {
            Self::FixedDiscs | Self::Together | Self::Clock => true,
            Self::Masses | Self::Radii | Self::Restitution | Self::Observed => {
                method != Method::Events
            }
            Self::ContactTime => matches!(method, Method::Plain | Method::Ticks),
            Self::Commands => method != Method::Events,
            Self::DoubleDouble => method == Method::Plain,
            _ => false,
        }
    }
}

/// Some of the parts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Parts(u32);

impl Parts {
    /// None of them.
    pub const NONE: Self = Self(0);
    /// All of them.
    pub const ALL: Self = Self(u32::MAX);

    /// What a gas of discs of one size that nobody disturbs has none of: the event-driven method
    /// has code of its own for that, in which not even the questions are left.
    pub fn besides_a_gas() -> Self {
        Self::that(|part| {
            use Part::{Gravity, Observed, Radii, Segments, Walls};
            matches!(part, Walls | Segments | Gravity | Observed | Radii)
        })
    }

    /// Only this one.
    pub fn only(part: Part) -> Self {
        Self(1 << part as u8)
    }

    /// Whether a part is among them.
    pub fn has(self, part: Part) -> bool {
        self.0 & (1 << part as u8) != 0
    }

    /// Those and others.
    #[must_use]
    pub fn and(self, others: Self) -> Self {
        Self(self.0 | others.0)
    }

    /// Those that this is true of.
    pub fn that(is: impl Fn(Part) -> bool) -> Self {
        let parts = Part::ALL.into_iter().filter(|part| is(*part));
        parts.map(Self::only).fold(Self::NONE, Self::and)
    }

    /// Those that can be built though nobody needs them.
    pub fn that_can_be_forced(method: Method, laws: &Laws) -> Self {
        Self::that(|part| part.can_be_forced(method, laws))
    }

    /// Those of both.
    #[must_use]
    pub fn among(self, others: Self) -> Self {
        Self(self.0 & others.0)
    }

    /// What these discs need under these laws.
    pub fn needed(laws: &Laws, discs: &[Disc]) -> Self {
        let differ = |of: fn(&Disc) -> f64| discs.windows(2).any(|two| of(&two[0]) != of(&two[1]));
        let lossy = laws.restitution < 1.0;
        Self::that(|part| match part {
            Part::Walls => laws.walls.is_some_and(|walls| walls != Walls::FAR_AWAY),
            Part::Segments => laws.segments.is_some(),
            Part::Periodic => laws.periodic.is_some(),
            Part::FixedDiscs => discs.iter().any(|disc| disc.mass.is_infinite()),
            Part::Masses => differ(|disc| disc.mass),
            Part::Radii => differ(|disc| disc.radius),
            Part::Restitution => lossy,
            Part::ContactTime => laws.contact_time > 0.0,
            Part::Remembered => lossy && laws.gravity.is_none(),
            Part::Gravity => laws.gravity.is_some(),
            Part::Drag => laws.drag != 0.0,
            Part::Observed => discs.iter().any(brings_energy),
            Part::ExtremeUnits => laws.extreme_units || discs.iter().any(is_extreme),
            Part::Ahead => discs.len() >= AHEAD_FROM,
            _ => false,
        })
    }
}

/// Whether contacts with it bring in energy that nobody can tell from error.
pub fn brings_energy(disc: &Disc) -> bool {
    disc.mass.is_infinite() && disc.velocity != DVec2::ZERO
}
