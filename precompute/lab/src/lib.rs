//! Measures, compares and pictures what Throng bakes and runs.
//!
//! [`run`] runs scenes; its figures are declared in `run/figures.rs`, filled in `run/watch.rs` and printed by the program.
//! [`trial`] sends people of a bundle to targets, [`quality`] measures their motion, [`slip`] their feet, [`drills`] how soon
//! they obey, and [`verdict`] says whether a build is good.

pub mod abilities;
pub mod drills;
pub mod frames;
mod histogram;
pub mod inspect;
pub mod live;
pub mod made;
pub mod measure;
pub mod overlap;
pub mod perform;
pub mod picture;
pub mod plans;
pub mod quality;
pub mod run;
pub mod slip;
pub mod touch;
pub mod trial;
pub mod verdict;
