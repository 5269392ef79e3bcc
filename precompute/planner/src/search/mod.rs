//! The search for a path: two trees in joint angles and time.

mod algorithm;
mod grid;
mod grown;
#[cfg(test)]
mod tests;
mod tree;

pub(crate) use algorithm::Quest;
pub use algorithm::{Found, Search, SearchConfig};
pub(crate) use grid::TimeGrid;
pub use grown::{Grown, GrownNode, Trees};
pub use tree::Weights;
