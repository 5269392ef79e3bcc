//! What a step reads of a bundle, checked once.

use crate::contacts::Contacts;
use crate::format::{ClipRecord, FrameRow};
use crate::graph::MotionGraph;
use crate::hits::HitRecord;
use crate::planar::Planar;
use crate::policy::PolicyTable;
use crate::skeleton::Skeleton;
use crate::tables::Tables;

use super::anatomy::Anatomy;

/// Views on everything in a bundle that characters need to move. Make it once and keep it as long as the tables.
#[derive(Clone, Debug)]
pub struct Repertoire<'t> {
    pub(crate) frames: &'t [FrameRow],
    pub(crate) contacts: &'t [Contacts],
    pub(crate) clips: &'t [ClipRecord],
    pub(crate) hits: &'t [HitRecord],
    /// First hit of each segment, and the one after its last. [Size: number of segments]
    segment_hits: Vec<[u32; 2]>,
    pub(crate) graph: MotionGraph<'t>,
    pub(crate) policies: Vec<PolicyTable<'t>>,
    pub(crate) skeleton: Skeleton,
    pub(crate) anatomy: Anatomy,
    pub(crate) rate_hz: f32,
}

impl<'t> Repertoire<'t> {
    /// Takes the views of an open bundle.
    pub fn new(tables: &'t Tables) -> Self {
        Self {
            frames: tables.frames(),
            contacts: tables.contacts(),
            clips: tables.clips(),
            hits: tables.hits(),
            segment_hits: segment_hits(&tables.graph(), tables.hits()),
            graph: tables.graph(),
            policies: (0..tables.num_policies()).map(|i| tables.policy(i)).collect(),
            skeleton: tables.skeleton().clone(),
            anatomy: Anatomy::new(tables.skeleton()),
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

    /// Effective hits, ascending by frame; a [`super::Blow`] names one of them.
    pub fn hits(&self) -> &'t [HitRecord] {
        self.hits
    }

    /// Numbers of the hits that a segment passes: those on its start belong to the segment before.
    /// [Limit: segment < number of segments]
    pub fn hits_of(&self, segment: u32) -> std::ops::Range<u32> {
        let [first, end] = self.segment_hits[segment as usize];
        first..end
    }

    /// The skeleton of all characters.
    pub fn skeleton(&self) -> &Skeleton {
        &self.skeleton
    }

    /// Number of the clip that a frame belongs to. [Limit: frame < number of frames]
    pub(crate) fn clip_of(&self, frame: u32) -> usize {
        self.clips.partition_point(|c| c.first_frame <= frame) - 1
    }

    /// Planar root of a frame within its clip.
    pub(crate) fn planar(&self, frame: u32) -> Planar {
        let [x, z, heading] = self.frames[frame as usize].planar;
        Planar::new(x, z, heading)
    }
}

/// The hits in `(start, start + num_frames]` of every segment.
fn segment_hits(graph: &MotionGraph<'_>, hits: &[HitRecord]) -> Vec<[u32; 2]> {
    let up_to = |frame: u32| hits.partition_point(|h| h.frame <= frame) as u32;
    graph.segments.iter().map(|s| [up_to(s.start), up_to(s.start + s.num_frames)]).collect()
}
