//! Agents of a scene: their events, event rates, and details of one of them.

mod details;
mod happened;
mod rates;
mod spread;
mod trace;

pub use details::{Details, FORCE_TERMS, bound, details, first_agent, way};
pub use happened::{EventFilter, EventLog, Happened, What, With};
pub use rates::{Rates, WINDOW_S};
pub use spread::SpreadLog;
pub use trace::{Entry, Trace};

use super::STEP_HZ;
