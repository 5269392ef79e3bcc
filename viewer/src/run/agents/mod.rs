//! Agents of a scene: their events, event rates, and details of one of them.

mod details;
mod event_log;
mod rates;
mod trace;

pub use details::{AgentDetails, FORCE_TERMS, agent_bound, agent_details};
pub use event_log::{AgentEvent, AgentEventKind, EventFilter, EventLog, OtherParty};
pub use rates::{EventRates, WINDOW_S};
pub use throng_precompute::run::{agent_path, first_agent};
pub use trace::{AgentTrace, SpreadLog, StateEntry};
