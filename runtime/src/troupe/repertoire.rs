//! What a step reads of a bundle, checked once.

use crate::contacts::Contacts;
use crate::format::FrameRow;
use crate::graph::MotionGraph;
use crate::planar::Planar;
use crate::policy::PolicyTable;
use crate::skeleton::Skeleton;
use crate::tables::Tables;

use super::foot_lock::Leg;

/// Views on everything in a bundle that characters need to move. Make it once and keep it as long as the tables.
#[derive(Clone, Debug)]
pub struct Repertoire<'t> {
    pub(crate) frames: &'t [FrameRow],
    pub(crate) contacts: &'t [Contacts],
    pub(crate) graph: MotionGraph<'t>,
    pub(crate) policies: Vec<PolicyTable<'t>>,
    pub(crate) skeleton: Skeleton,
    pub(crate) legs: [Leg; 2],
    pub(crate) rate_hz: f32,
}

impl<'t> Repertoire<'t> {
    /// Takes the views of an open bundle.
    pub fn new(tables: &'t Tables) -> Self {
        Self {
            frames: tables.frames(),
            contacts: tables.contacts(),
            graph: tables.graph(),
            policies: (0..tables.num_policies()).map(|i| tables.policy(i)).collect(),
            skeleton: tables.skeleton().clone(),
            legs: Leg::both(tables.skeleton()),
            rate_hz: tables.meta().rate_hz as f32,
        }
    }

    /// Number of policies; a [`super::Goal`] names one of them.
    pub fn num_policies(&self) -> usize {
        self.policies.len()
    }

    /// A policy, by number.
    pub fn policy(&self, index: usize) -> Option<&PolicyTable<'t>> {
        self.policies.get(index)
    }

    /// The motion graph.
    pub fn graph(&self) -> &MotionGraph<'t> {
        &self.graph
    }

    /// The skeleton of all characters.
    pub fn skeleton(&self) -> &Skeleton {
        &self.skeleton
    }

    /// Planar root of a frame within its clip.
    pub(crate) fn planar(&self, frame: u32) -> Planar {
        let [x, z, heading] = self.frames[frame as usize].planar;
        Planar::new(x, z, heading)
    }
}
