//! Measures, compares and pictures what Throng bakes and runs.

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
