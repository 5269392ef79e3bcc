//! Agents of a scene: what happened to them, how often, and what moves one of them.

mod details;
mod happened;
mod rates;

pub use details::{Details, FORCE_TERMS, bound, details, first_agent, way};
pub use happened::{EventLog, Happened, What, With};
pub use rates::{Rates, WINDOW_S};

use super::STEP_HZ;
