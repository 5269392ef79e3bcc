//! Promises of simulations, one module each.

mod gestures;
mod pedestrians;
mod snapshot;
