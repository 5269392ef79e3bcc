//! Crowds whose members act when something is about to happen to them (000 and 001, section 2).
//!
//! Between its own events a member keeps its acceleration, so that its position at any time is known; at an event it
//! asks a force field what to do and takes a plan that cannot end in an overlap. See [`Crowd`].

mod config;
mod engine;
mod error;
mod event;
mod field;
mod member;
mod obstacle;
mod route;
mod space;

pub use config::{CrowdConfig, Scheme, Setup};
pub use engine::Crowd;
pub use error::CrowdError;
pub use event::{Counts, Event, EventKind};
pub use field::{Field, Forces};
pub use member::{Id, Member};
pub use obstacle::Obstacle;
pub use route::{AtEnd, Route};
pub use space::Space;
