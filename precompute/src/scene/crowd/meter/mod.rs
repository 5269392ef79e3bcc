//! What is measured of a crowd, thirty times a simulated second: overlaps, progress, who is stuck, flow, lanes.

mod gate;
mod lanes;
mod overlap;
mod progress;

pub(super) use gate::GateMeter;
pub use gate::{Flow, HUMAN_FLOW_PER_M_S};
pub(super) use lanes::LaneMeter;
pub use overlap::OverlapMeter;
pub use progress::{ProgressMeter, Sight};
