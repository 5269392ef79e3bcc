//! From what an application says to a checked problem.

mod build;
mod error;
mod spec;
#[cfg(test)]
pub(crate) mod tests;

pub use error::ProblemError;
pub use spec::{Allowed, Held, Level, Other, ProblemSpec, Tether};
