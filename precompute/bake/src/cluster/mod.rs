//! Pose groups: frames so alike that motion may continue from any of them as from the others (Lee, Choi and Lee 2006,
//! section 3).

mod agglomerate;
mod linkage;
mod neighbours;
#[cfg(test)]
mod tests;
mod tree;

use crate::{features::Features, share::run_dealt, stages::stage_error};
use neighbours::FrameSpace;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use throng_base::Comm;
use throng_motion::clip::{ClipSet, FrameId};
use throng_motion::error::{Result, check_ranges};
use throng_motion::progress::Progress;
use tree::ClusterItem;

/// Assignment of frames to pose groups.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseGroups {
    /// Group of every frame; [`PoseGroups::NO_GROUP`] for excluded frames. Groups are numbered in order of their first
    /// frame (ClipSet::num_frames()).
    pub groups: Vec<u32>,
    /// Medoid of each group: the frame whose distances to the others have the least sum (number of groups).
    pub medoids: Vec<FrameId>,
    /// Largest distance between two frames of one group (rad, as `FeaturesConfig` explains).
    pub max_diameter: f32,
    /// Upper bound of every diameter (rad).
    pub threshold: f32,
}

impl PoseGroups {
    /// Group number of a frame without a group.
    pub const NO_GROUP: u32 = u32::MAX;

    /// Number of groups.
    pub fn num_groups(&self) -> usize {
        self.medoids.len()
    }

    /// Group of a frame; `None` for excluded frames (frame < groups.len()).
    pub fn group_of(&self, frame: FrameId) -> Option<u32> {
        Some(self.groups[frame.0 as usize]).filter(|&g| g != Self::NO_GROUP)
    }
}

/// Size of the sample with which frames of a larger group are compared to find its medoid.
const MEDOID_SAMPLE: usize = 256;

/// Sorts frames into groups such that any two frames of a group are nearer than the threshold.
///
/// Frames share a group only if their contacts agree, as well as those of the frames before and after. At the ends of a
/// run of usable frames, the frame itself stands in for the missing neighbour.
///
/// - `clips`: annotated.
/// - `features`: of the same clips.
/// - `comm`: processes that group frames together; each has the frames of some contact states.
///
/// The medoid of a group of more than 256 frames is the one nearest to an even sample of 256 of them.
///
/// # Errors
/// [`throng_motion::error::BuildError::Key`] for a threshold outside its limits.
/// [`throng_motion::error::BuildError::Stage`] for clips without contacts, or features of other clips.
///
/// Lee, Choi and Lee 2006, section 3. Differs: in place of agglomerative hierarchical k-means, near pairs are merged
/// first if those of a contact state are few enough, which is complete linkage but for the estimate of which pair is
/// nearer; k-means splits denser data.
pub fn group(
    clips: &ClipSet,
    features: &Features,
    config: &ClusterConfig,
    progress: &dyn Progress,
    comm: &dyn Comm,
) -> Result<PoseGroups> {
    let limit = check(clips, features, config)?;
    // Large classes first, so that no thread starts one when the others are done.
    let mut classes: Vec<Vec<u32>> = classes_of_contacts(clips).into_values().collect();
    classes.sort_by_key(|frames| std::cmp::Reverse(frames.len()));
    let own = classes.iter().skip(comm.rank()).step_by(comm.num_ranks());
    progress.begin("cluster", own.map(|frames| frames.len() as u64).sum(), "frames");
    let space = FrameSpace::new(features);
    let merge = |class: usize| {
        progress.check()?;
        let frames = &classes[class];
        let items = agglomerate::agglomerate(&space, frames, limit, agglomerate::max_pairs(frames.len()));
        progress.advance(frames.len() as u64);
        Ok(items)
    };
    let items: Vec<Vec<ClusterItem>> =
        run_dealt(comm, classes.len(), |own| own.into_par_iter().with_max_len(1).map(merge).collect())?;
    progress.end();
    let items = items.concat();
    let max_diameter = items.iter().fold(0.0, |largest, item| item.diameter(&space, largest));
    Ok(PoseGroups { max_diameter, threshold: limit, ..number_groups(items, features, comm)? })
}

/// The threshold in single precision, once clips and features are found to match.
fn check(clips: &ClipSet, features: &Features, config: &ClusterConfig) -> Result<f32> {
    let limit = config.check()?;
    if let Some(c) = clips.clips.iter().find(|c| c.contacts.len() != c.num_frames()) {
        let message = format!("clip {}: expected {} contacts, found {}", c.name, c.num_frames(), c.contacts.len());
        return Err(stage_error("cluster", message, "Annotate the clips first"));
    }
    if features.num_frames() != clips.num_frames() {
        let message = format!("expected features of {} frames, found {}", clips.num_frames(), features.num_frames());
        return Err(stage_error("cluster", message, "Extract the features from the same clips"));
    }
    Ok(limit)
}

fn number_groups(items: Vec<ClusterItem>, features: &Features, comm: &dyn Comm) -> Result<PoseGroups> {
    let mut items: Vec<Vec<u32>> = items.into_iter().map(|i| i.frames).collect();
    items.par_iter_mut().for_each(|frames| frames.sort_unstable());
    items.sort_unstable_by_key(|frames| frames[0]);
    let mut groups = vec![PoseGroups::NO_GROUP; features.num_frames()];
    for (g, frames) in items.iter().enumerate() {
        frames.iter().for_each(|&f| groups[f as usize] = g as u32);
    }
    let medoids =
        run_dealt(comm, items.len(), |own| Ok(own.into_par_iter().map(|g| medoid(&items[g], features)).collect()))?;
    Ok(PoseGroups { groups, medoids, ..PoseGroups::default() })
}

/// First frame with the least sum of distances.
fn medoid(frames: &[u32], features: &Features) -> FrameId {
    let sample = || frames.iter().step_by(frames.len().div_ceil(MEDOID_SAMPLE));
    let sum = |f: u32| sample().map(|&g| f64::from(features.distance(FrameId(f), FrameId(g)))).sum::<f64>();
    let sums = frames.iter().map(|&f| (sum(f), FrameId(f)));
    sums.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(FrameId(frames[0]), |(_, f)| f)
}

/// Settings of the grouping of frames.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ClusterConfig {
    /// Upper bound of the distance between any two frames of a group (rad, as `features` explains; > 0).
    pub threshold: f64,
}

impl Default for ClusterConfig {
    fn default() -> Self {
        Self { threshold: 0.3 }
    }
}

impl ClusterConfig {
    /// Threshold as single precision: any distance below it is below the one of the config.
    ///
    /// # Errors
    /// [`throng_motion::error::BuildError::Key`] for a threshold outside its limits.
    pub(crate) fn check(&self) -> Result<f32> {
        check_ranges([("threshold", self.threshold, 1e-6, 1e3)]).map_err(|e| e.within_key("cluster"))?;
        Ok(self.threshold as f32)
    }
}

/// Contact states of a frame with its neighbours: previous, this, next.
type ContactStates = [u8; 3];

/// Usable frames by contact states, ascending.
///
/// At the ends of a run of usable frames, the frame itself stands in for the missing neighbour, as for velocities.
fn classes_of_contacts(clips: &ClipSet) -> BTreeMap<ContactStates, Vec<u32>> {
    let mut classes = BTreeMap::<_, Vec<u32>>::new();
    for (clip, start) in clips.clips.iter().zip(clips.frame_starts()) {
        for run in clip.usable_ranges() {
            for f in run.clone() {
                let neighbours = [f.max(run.start + 1) - 1, f, (f + 1).min(run.end - 1)];
                classes.entry(neighbours.map(|f| clip.contacts[f].0)).or_default().push(start + f as u32);
            }
        }
    }
    classes
}
