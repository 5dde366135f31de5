//! Resolution: what a contact does to velocities, and never to positions, but for [`overlap`],
//! which does only that. It never looks for contacts.
//!
//! [`pair`] is the law for two discs, in the form that loses no digits, [`precise`] the same in
//! double-double; [`vector_method`] is the same law as the seven textbook steps, kept as its judge.
//! [`listed`] applies it to a list of pairs, in its order.
//! [`wall`] is the law for a wall, [`segment`] for a line segment.
//! [`touching`] resolves many contacts that exist at the same
//! instant, those that share discs by [`simultaneous`].
//! [`overlap`] parts discs that a step of fixed length let overlap.

pub mod pair;

pub mod precise;

pub mod listed;

pub mod vector_method;

pub mod wall;

pub mod segment;

pub mod touching;

pub mod simultaneous;

pub mod overlap;
