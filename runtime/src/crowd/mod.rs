//! Crowds whose members act when something is about to happen to them (000 and 001, section 2).
//!
//! Between its own events a member keeps its acceleration, so that its position at any time is known; at an event it
//! asks a force field what to do and takes a plan that cannot end in an overlap. See [`Crowd`].
//!
//! In reading order: `plan` is what a member does until its next event, `safety` why nobody overlaps anybody, `bound`
//! when two can meet, `cells` and `queue` who is near and who is next, `near`, `reach` and `others` who of those matters
//! at an event, eight at a time (`eights`), `sight`, `flow`, `outlook`, `beside`, `retreat` and `steer` the force field,
//! `decide` an event, `engine` all of them in their order, `ahead` what the next ones need of memory, `joining` who comes
//! and goes, `window` on several threads, `watchdog` that time passes.

mod ahead;
mod beside;
mod bound;
mod cells;
mod config;
mod contacts;
mod crossing;
mod decide;
mod eights;
mod engine;
mod error;
mod event;
mod field;
mod filter;
mod fixed;
mod flow;
#[cfg(test)]
mod jam_tests;
mod joining;
mod member;
mod near;
mod obstacle;
mod occupancy;
mod occupied;
mod others;
mod outlook;
mod plan;
mod query;
mod queue;
mod reach;
mod retreat;
mod route;
mod safety;
#[cfg(test)]
mod scheme_tests;
mod sight;
mod snapshot;
mod solid;
mod space;
mod spline;
mod steer;
#[cfg(test)]
mod tests;
mod tracing;
mod watchdog;
#[cfg(feature = "rayon")]
mod window;
mod world;

pub use config::{CrowdConfig, Scheme, Setup};
pub use engine::Crowd;
pub use error::CrowdError;
pub use event::{Counts, Event, EventKind};
pub use field::{Field, Forces};
pub use member::{Id, Member};
pub use obstacle::{Interest, Obstacle};
pub use route::{AtEnd, Route};
pub use space::Space;

/// No member, no place.
const NONE: u32 = u32::MAX;
