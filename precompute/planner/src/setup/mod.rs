//! From an application's specification to a checked problem.

mod build;
mod error;
mod spec;
#[cfg(test)]
pub(crate) mod tests;

pub use crate::problem::UprightConstraint;
pub use error::ProblemError;
pub use spec::{AllowedContact, HeldCapsule, OtherCharacter, ProblemSpec, SELF_PRESS_M, Tether};
