//! Steering of agents at events: a force field over near and far surroundings.

pub(crate) mod company;
pub(crate) mod config;
pub(crate) mod density_grid;
pub(crate) mod far_field;
pub(crate) mod field;
pub(crate) mod filter;
pub(crate) mod forces;
pub(crate) mod keep_right;
pub(crate) mod neighbours;
pub(crate) mod relationships;
pub(crate) mod retreat;
pub(crate) mod sight;
