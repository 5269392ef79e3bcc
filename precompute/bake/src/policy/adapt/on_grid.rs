//! A behaviour with another grid.

use super::super::behaviour::Behaviour;
use super::super::model::SegmentMotion;
use glam::Vec2;
use throng_core::policy::{RegionRecord, Reward, SegmentRecord, TargetGrid};

/// The same behaviour on another grid over the same places.
pub(super) struct OnGrid<'a> {
    pub behaviour: &'a dyn Behaviour,
    pub grid: TargetGrid,
}

impl Behaviour for OnGrid<'_> {
    fn name(&self) -> &str {
        self.behaviour.name()
    }

    fn grid(&self) -> TargetGrid {
        self.grid
    }

    fn reward(&self) -> Reward {
        self.behaviour.reward()
    }

    fn discount(&self) -> f64 {
        self.behaviour.discount()
    }

    fn sample(&self, segment: usize, motion: &SegmentMotion, record: &mut SegmentRecord) {
        self.behaviour.sample(segment, motion, record);
    }

    fn region(&self) -> RegionRecord {
        self.behaviour.region()
    }

    fn centre(&self) -> Vec2 {
        self.behaviour.centre()
    }
}
