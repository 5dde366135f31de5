//! Faults: what is wrong with a datagram, as the protocol's error: a code and a line for people.
//!
//! Codes are a closed list, which teams' software may rely on. A datagram may be wrong in thousands
//! of places: only so many are kept as an answer holds.

use super::proto::simulation::SimulatorError;
use super::{RobotName, limits};
use crate::receive::Cause;

/// What kind of fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Code {
    /// The datagram is not the message of its port, or something required is missing.
    Unreadable,
    /// A number is not finite.
    NotFinite,
    /// A number is finite, but nothing that is served.
    OutOfRange,
    /// There is no such robot, team or ball.
    Unknown,
    /// Something that carom does not simulate: it is left out, the rest is done.
    Unsupported,
    /// A chip kick: the ball stays on the ground and has the horizontal part of it.
    Chip,
    /// The arena does not take it there; nothing is changed.
    NotDone,
}

impl Code {
    /// Its name in `SimulatorError.code`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unreadable => "CAROM_UNREADABLE",
            Self::NotFinite => "CAROM_NOT_FINITE",
            Self::OutOfRange => "CAROM_OUT_OF_RANGE",
            Self::Unknown => "CAROM_UNKNOWN",
            Self::Unsupported => "CAROM_UNSUPPORTED",
            Self::Chip => "CAROM_CHIP_STAYS_ON_GROUND",
            Self::NotDone => "CAROM_NOT_DONE",
        }
    }

    /// As what it is counted; nothing if what was asked is done, but for what carom has not.
    pub fn cause(self) -> Option<Cause> {
        match self {
            Self::Unreadable => Some(Cause::Undecodable),
            Self::NotFinite => Some(Cause::NotFinite),
            Self::OutOfRange | Self::NotDone => Some(Cause::OutOfRange),
            Self::Unknown => Some(Cause::UnknownRobot),
            Self::Unsupported | Self::Chip => None,
        }
    }
}

/// Something wrong with a datagram.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct Fault {
    /// Its kind.
    pub code: Code,
    /// What, where, what would be right.
    pub message: String,
}

impl Fault {
    /// Of a kind.
    pub fn new(code: Code, message: impl Into<String>) -> Self {
        Self { code, message: message.into() }
    }
}

/// All that is wrong with a datagram, as far as an answer holds it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Faults {
    kept: Vec<Fault>,
    more: usize,
}

impl Faults {
    /// One more.
    pub fn add(&mut self, code: Code, message: impl Into<String>) {
        self.push(Fault::new(code, message));
    }

    /// One more.
    pub fn push(&mut self, fault: Fault) {
        if self.kept.len() < limits::FAULTS_TOLD {
            self.kept.push(fault);
        } else {
            self.more += 1;
        }
    }

    /// Says so if there are more parts of a kind than are read.
    pub fn limit(&mut self, what: &str, parts: usize) {
        let most = limits::COMMANDS_PER_DATAGRAM;
        if parts > most {
            self.add(Code::OutOfRange, format!("{parts} {what}: only {most} are read"));
        }
    }

    /// What came of reading a part, if that is sound.
    pub fn sift<T>(&mut self, part: Result<T, Fault>) -> Option<T> {
        part.map_err(|fault| self.push(fault)).ok()
    }

    /// Those that are kept.
    pub fn iter(&self) -> impl Iterator<Item = &Fault> {
        self.kept.iter()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }

    /// As the protocol has them.
    pub fn errors(&self) -> Vec<SimulatorError> {
        let error = |code: Code, message: String| SimulatorError {
            code: Some(code.name().to_owned()),
            message: Some(message),
        };
        let mut errors: Vec<SimulatorError> =
            self.kept.iter().map(|fault| error(fault.code, fault.message.clone())).collect();
        if self.more > 0 {
            errors.push(error(Code::OutOfRange, format!("and {} errors more", self.more)));
        }
        errors
    }
}

/// A number that is required, finite and at most `most` either way.
///
/// # Errors
/// [`Fault`] with the name of the field.
pub fn number(what: &str, value: Option<f32>, most: f64) -> Result<f64, Fault> {
    let missing = || Fault::new(Code::Unreadable, format!("{what} is missing"));
    bounded(what, f64::from(value.ok_or_else(missing)?), most)
}

/// A number that may be missing.
///
/// # Errors
/// As of [`number`].
pub fn optional(what: &str, value: Option<f32>, most: f64) -> Result<Option<f64>, Fault> {
    value.map(|value| bounded(what, f64::from(value), most)).transpose()
}

/// A number that may be missing and is above 0.
///
/// # Errors
/// As of [`number`].
pub fn positive(what: &str, value: Option<f32>, most: f64) -> Result<Option<f64>, Fault> {
    let value = optional(what, value, most)?;
    match value {
        Some(value) if value <= 0.0 => {
            Err(Fault::new(Code::OutOfRange, format!("{what} is {value}: must be above 0")))
        }
        value => Ok(value),
    }
}

/// A number that is finite and at most `most` either way.
///
/// # Errors
/// As of [`number`].
pub fn bounded(what: &str, value: f64, most: f64) -> Result<f64, Fault> {
    if !value.is_finite() {
        Err(Fault::new(Code::NotFinite, format!("{what} is {value}: must be finite")))
    } else if value.abs() > most {
        Err(Fault::new(Code::OutOfRange, format!("{what} is {value}: at most {most}")))
    } else {
        Ok(value)
    }
}

/// The name of a robot that a team may have.
///
/// # Errors
/// [`Fault`] with the numbers that there are.
pub fn numbered(name: RobotName) -> Result<RobotName, Fault> {
    let most = limits::ROBOTS_PER_TEAM - 1;
    let unknown = || Fault::new(Code::Unknown, format!("robot {name}: must be 0 to {most}"));
    (name.number <= most).then_some(name).ok_or_else(unknown)
}
