//! Numbers with a unit and no derivation: the bounds that keep a bad input from doing harm.
//!
//! An error about one of them names it, and the setting to raise where there is one.

/// Most circles accepted in one message.
pub const CIRCLES_PER_MESSAGE: usize = 200_000;

/// Most observed circles held at once, over all publishers.
pub const OBSERVED_CIRCLES: usize = 200_000;

/// Most pucks in a scene: more have no room in an array that others read at any useful rate.
pub const PUCKS_PER_SCENE: usize = 200_000;

/// Largest coordinate, speed, radius and finite mass accepted, in SI units; squares and products
/// of a few of them stay in the range of doubles.
pub const SIZE_MAX: f64 = 1e60;

/// Smallest radius and mass accepted, in SI units.
pub const SIZE_MIN: f64 = 1e-60;

/// Radii of the largest puck than which a periodic box must be wider: at four of them a pair
/// touches in two images at once, and shortly above nobody can look ahead.
pub const RADII_IN_PERIODIC_BOX: f64 = 4.001;

/// Largest radius of an observed circle in a periodic arena, in sides of its box: five of the cells
/// that hold it fit.
pub const RADIUS_IN_PERIODIC_BOX: f64 = 0.07;

/// Smallest and largest rate of arena states, 1/s.
pub const PUBLISH_RATES_HZ: (f64, f64) = (1e-3, 1e5);

/// Most line segments around an arena: they are carried along with its laws.
pub const SEGMENTS: usize = 64;

/// Most letters of a name of a puck or of a part of a topic: with what stands around them in the
/// names of topics they must come to less than 256.
pub const NAME_LETTERS: usize = 180;

/// Largest scene file read, bytes.
pub const SCENE_FILE_BYTES: u64 = 16 << 20;

/// Most events in one advance of an arena: the loop gets its turn again after so many.
pub const EVENTS_PER_ADVANCE: usize = 2_000;

/// Most steps of fixed length in one advance of an arena, for the same reason.
pub const STEPS_PER_ADVANCE: usize = 2_000;

/// Most parts into which a step is cut where springs share discs.
pub const PARTS_PER_STEP: usize = 1 << 12;

/// Most parts of a contact of two discs that turn about each other within a step.
pub const TURNS_PER_STEP: usize = 1_000;

/// Most sweeps over the equations of springs that share discs: a few do where they are resolved.
pub const SPRING_SWEEPS: usize = 256;

/// Most guesses at the root of one contact's equation.
pub const ROOT_STEPS: usize = 200;

/// Events at one instant before an arena is called stalled; one more for each of so many discs.
pub const EVENTS_PER_INSTANT: usize = 2_000;

/// Further events at one instant for every disc: a lattice may meet, or collapse, all at once.
pub const EVENTS_PER_INSTANT_AND_DISC: usize = 300;

/// Contacts in a row, each within the contact time of the one before, after which a disc counts as
/// caught in a collapse: far more than a finite chain of blows between a few discs has.
pub const QUICK_CONTACTS: u32 = 128;

/// The same for a disc that meets none but one or two partners: three discs on a line near the
/// critical restitution need so many until they are within 1e-12 s of the end.
pub const QUICK_CONTACTS_IF_FREE: u32 = 160;

/// Contacts in a row with the same one or two partners after which a disc counts as free of others.
pub const CONTACTS_IF_FREE: u32 = 12;

/// A disc that leaves a wall on which gravity presses it with at most this speed, below restitution
/// 1, rests there, m/s: it would bounce endlessly often in a finite time.
pub const REST_SPEED_MPS: f64 = 1e-6;

/// Time between contacts of a falling disc and one that carries it where nothing loses energy, s:
/// gravity presses them together by 5e-10 m in this time on earth.
pub const PRESSED_CONTACT_S: f64 = 1e-5;

/// Most rounds over contacts that share discs: below restitution 1 they would never end.
pub const CONTACT_ROUNDS: usize = 1_000;

/// Most contacts reflected together; the cost grows with the cube. Larger groups go pair by pair.
pub const GROUP_CONTACTS: usize = 24;

/// Most pair checks over all rounds for one message, which bounds the time of an answer.
pub const CONTACT_CHECKS: usize = 50_000_000;

/// Overlap that two pucks of a running arena may have by rounding, in the sum of their radii.
pub const OVERLAP_OF_ROUNDING: f64 = 1e-9;

/// Time after which an observed circle leaves the world if nobody reports it, s.
pub const STALE_AFTER_S: f64 = 0.5;

/// Rate of `arena_states`, 1/s of simulated time.
pub const PUBLISH_RATE_HZ: f64 = 60.0;

/// First id of robots that report themselves by `odom`: below those of pucks.
pub const FIRST_ROBOT_ID: u32 = 900_000;

/// First id of robots and balls of tracked frames: below those of pucks.
pub const FIRST_PLAYER_ID: u32 = 950_000;

/// First id of pucks that a scene does not number: far above what publishers tend to use.
pub const FIRST_PUCK_ID: u32 = 1_000_000;

/// Most touching pairs looked at for one message: beyond it, circles lie heaped on each other.
pub const TOUCHING_PAIRS: usize = 4_000_000;

/// Most near pairs for each disc in the lists of a method that steps: more lie heaped.
pub const NEAR_PAIRS_PER_DISC: usize = 64;

/// Length of a step of the methods steps and springs that a scene does not name, s.
pub const STEP_S: f64 = 1.0 / 240.0;

/// Length of a tick of the method ticks that a scene does not name, s.
pub const TICK_S: f64 = 1.0 / 60.0;

/// Spring constant of contacts that a scene does not name, N/m.
pub const STIFFNESS_NPM: f64 = 1e5;

/// A number as an error tells it: with an exponent where its digits would fill the line.
pub fn short(number: f64) -> String {
    let digits = number.to_string();
    if digits.len() > DIGITS_TOLD { format!("{number:e}") } else { digits }
}

/// Most characters of a number that has no exponent: those of any with a moderate one.
const DIGITS_TOLD: usize = 24;
