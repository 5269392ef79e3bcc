//! Whether a linkage is free: at one time, and on the whole way from one state to another.

mod checker;
mod edge;
mod kept;
#[cfg(test)]
mod tests;

pub use checker::Checker;
pub use edge::EdgeCheck;
