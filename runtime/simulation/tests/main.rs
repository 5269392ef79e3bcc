//! Promises of simulations, one module each.

mod gestures;
mod orders;
mod pedestrians;
pub(crate) mod snapshot;
