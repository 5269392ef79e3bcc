//! A behaviour with another grid.

use super::super::behaviour::{BehaviourSpec, PolicyBehaviour};
use super::super::model::SegmentMotion;
use throng_core::policy::{SegmentRecord, TargetGrid};

/// A behaviour moved to another grid over the same region.
pub(super) struct RegriddedBehaviour<'a> {
    pub behaviour: &'a dyn PolicyBehaviour,
    pub grid: TargetGrid,
}

impl PolicyBehaviour for RegriddedBehaviour<'_> {
    fn spec(&self) -> BehaviourSpec<'_> {
        BehaviourSpec { grid: self.grid, ..self.behaviour.spec() }
    }

    fn sample(&self, segment: usize, motion: &SegmentMotion, record: &mut SegmentRecord) {
        self.behaviour.sample(segment, motion, record);
    }
}
