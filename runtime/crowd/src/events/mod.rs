//! Events: their schedule and their processing.

pub(crate) mod decide;
pub(crate) mod engine;
pub(crate) mod event;
#[cfg(feature = "fixed-steps")]
#[path = "../../../../research/fixed-steps/engine.rs"]
pub(crate) mod fixed;
pub(crate) mod occupancy;
pub(crate) mod parallel;
pub(crate) mod prefetch;
mod query;
pub(crate) mod queue;
mod safety;
pub(crate) mod schemes;
mod sensing;
pub(crate) mod shared;
mod snapshot;
mod spawn;
pub(crate) mod watchdog;
