//! Collision checks of a limb: at one time, and along the whole edge from one state to another.

mod checker;
mod edge;
#[cfg(test)]
mod tests;

pub use checker::Checker;
