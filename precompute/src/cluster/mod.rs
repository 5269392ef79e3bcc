//! Pose groups: frames so alike that motion may go on from either as if it were the other (004 section 3).

mod config;

pub use config::ClusterConfig;

use crate::clip::FrameId;
use serde::{Deserialize, Serialize};

/// Which frame belongs to which group.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseGroups {
    /// Group of every frame; [`PoseGroups::NO_GROUP`] for excluded frames. [Size: ClipSet::num_frames()]
    pub groups: Vec<u32>,
    /// The frame of each group that is nearest to all its others. [Size: number of groups]
    pub medoids: Vec<FrameId>,
    /// Largest distance between two frames of one group. [Unit: rad, as `FeaturesConfig` explains]
    pub max_diameter: f32,
    /// Every diameter stays below this. [Unit: rad]
    pub threshold: f32,
}

impl PoseGroups {
    /// Stands where a frame has no group.
    pub const NO_GROUP: u32 = u32::MAX;

    /// Number of groups.
    pub fn num_groups(&self) -> usize {
        self.medoids.len()
    }

    /// Group of a frame, none for excluded frames. [Limit: frame < groups.len()]
    pub fn of(&self, frame: FrameId) -> Option<u32> {
        Some(self.groups[frame.0 as usize]).filter(|&g| g != Self::NO_GROUP)
    }
}
