//! Promises of simulations, one module each.

mod pedestrians;
mod snapshot;
