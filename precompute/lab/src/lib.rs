//! Measures, compares and pictures what Throng bakes and runs.

pub mod inspect;
pub mod matching;
pub mod measure;
pub mod picture;
pub mod run;
pub mod slip;
pub mod trial;
