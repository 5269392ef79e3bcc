//! Meters of agents: overlaps, progress, stuck agents, flow, lanes.

mod gate;
mod lanes;
mod overlap;
mod progress;

pub(super) use gate::GateMeter;
pub use gate::{GateFlow, HUMAN_FLOW_PER_M_S};
pub(super) use lanes::LaneMeter;
pub use overlap::DiscOverlapMeter;
pub use progress::{AgentSample, ProgressMeter};
