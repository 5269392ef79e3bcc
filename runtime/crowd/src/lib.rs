//! Crowds of agents without bodies: discs on the ground or balls in the air that never overlap.
//!
//! Each agent acts at its own events (Kim, Kim and Shin 2003a, 2003b). Between two of them it keeps its
//! acceleration, so that its position at any time is known. At an event it asks a force field what it should do, and
//! takes a plan that cannot end in an overlap. See [`Crowd`].
//!
//! - `space`: vectors in two and three dimensions, plans, cells, obstacles.
//! - `routes`: orders, routes, and paths round obstacles.
//! - `steering`: the force field, which gives the desired motion of an agent, whether or not it is safe.
//! - `safety`: the rule by which no two agents ever overlap, and the pairs that are checked.
//! - `senses`: meetings of agents, and the zones and cells that they enter.
//! - `scenery`: data that does not change with time.
//! - `events`: the queue of events, and their processing. The crowd itself is here.
//! - `navigation`: paths of bodies that something else moves.

mod agent;
mod config;
mod crowd;
mod error;
mod events;
mod navigation;
mod routes;
mod safety;
mod scenery;
mod senses;
mod shared;
mod space;
mod steering;
#[cfg(test)]
mod tests;

pub use agent::Agent;
pub use config::{CrowdConfig, CrowdSetup, Scheme};
pub use crowd::Crowd;
pub use error::CrowdError;
pub use events::event::{CrowdEvent, CrowdEventKind, EventCounts};
pub use navigation::{NavigatedBody, Navigation, NavigationAim, NavigationState};
pub use routes::order::{AgentOrder, AgentStatus, RouteBegin};
pub use routes::route::{AtEnd, Route};
pub use routes::streets::{NoPath, Streets};
pub use senses::{Sense, Senses, Zone};
pub use shared::SharedCrowd;
pub use space::Space;
pub use space::obstacle::{Interest, Obstacle};
pub use steering::config::SteeringConfig;
pub use steering::field::{ForceField, Forces};
pub use steering::relationships::{InterestLocation, PersonalInterest};
pub use throng_base::Id;

/// No agent, no cell, no route.
const NONE: u32 = u32::MAX;
