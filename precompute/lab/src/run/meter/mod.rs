//! What is measured: overlaps of discs and of trunks, progress, stuck agents, flow, lanes.

mod gate;
mod lanes;
mod overlap;
mod progress;
mod trunks;

pub(super) use gate::GateMeter;
pub use gate::{Flow, HUMAN_FLOW_PER_M_S};
pub(super) use lanes::LaneMeter;
pub use overlap::OverlapMeter;
pub use progress::{ProgressMeter, Sight};
pub use trunks::{TRUNK_RADIUS_M, TrunkMeter};
