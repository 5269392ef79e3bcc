//! The search for a path: two trees in joint angles and time.

mod algorithm;
mod grid;
#[cfg(test)]
mod tests;
mod tree;

pub(crate) use algorithm::SearchRequest;
pub use algorithm::{SearchConfig, SearchOutcome, TreeSearch};
pub(crate) use grid::TimeGrid;
pub use tree::{LoggedNode, LoggedTrees, MetricWeights, TreeLog};
