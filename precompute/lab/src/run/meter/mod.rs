//! Meters of agents: progress, stuck agents, flow, lanes.

mod gate;
mod lanes;
mod progress;

pub(super) use gate::GateMeter;
pub use gate::{GateFlow, HUMAN_FLOW_PER_M_S};
pub(super) use lanes::LaneMeter;
pub use progress::{AgentSample, ProgressMeter};
