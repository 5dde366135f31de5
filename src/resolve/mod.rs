//! Resolution: what a contact does to velocities. It never looks for contacts.
//!
//! [`pair`] is the law for two discs, in the form that loses no digits; [`vector_method`] is the
//! same law as the seven textbook steps, kept as its judge. [`wall`] is the law for a wall.
//! [`touching`] resolves many contacts that exist at the same instant, those that share discs by
//! [`simultaneous`].

pub mod pair;

pub mod vector_method;

pub mod wall;

pub mod touching;

pub mod simultaneous;
