//! A behaviour with another grid.

use super::super::behaviour::{Behaviour, Spec};
use super::super::model::SegmentMotion;
use throng_core::policy::{SegmentRecord, TargetGrid};

/// A behaviour moved to another grid over the same region.
pub(super) struct OnGrid<'a> {
    pub behaviour: &'a dyn Behaviour,
    pub grid: TargetGrid,
}

impl Behaviour for OnGrid<'_> {
    fn spec(&self) -> Spec<'_> {
        Spec { grid: self.grid, ..self.behaviour.spec() }
    }

    fn sample(&self, segment: usize, motion: &SegmentMotion, record: &mut SegmentRecord) {
        self.behaviour.sample(segment, motion, record);
    }
}
