//! Baselines that Throng is compared with, and the experiments of the papers that it builds on.

pub mod matching;
pub mod measure;
pub mod natural;
pub mod paper;
pub mod plain_problem;
pub mod plot;
pub mod quality;
pub mod reaches;
pub mod search;
pub mod steering;
#[cfg(test)]
mod testing;
