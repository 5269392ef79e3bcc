//! Events: their schedule and their processing.

#[cfg(feature = "baselines")]
pub(crate) mod baselines;
pub(crate) mod decide;
pub(crate) mod engine;
pub(crate) mod event;
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
