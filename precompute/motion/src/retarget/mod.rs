//! Raw clips onto the database skeleton: rest poses aligned, proportions changed, feet on the ground.
//!
//! Clips of one source skeleton share one `Alignment`: a constant rotation per role that takes the database
//! joint's axes (the model's axes in a T-pose) to the source joint's. Multiplied onto the source's world rotations
//! it gives the database joints' rotations, whatever the source's own rest pose is.

mod align;
mod body;
mod geometry;
mod ground;
mod legs;
mod names;
mod plan;
mod proportions;
mod transfer;
mod wear;

use crate::error::{BuildError, Result, Warnings, ensure};
use crate::raw::{RawClip, RawJoint};
use crate::{clip::ClipSet, import::ImportedClip};
use body::SourceBody;
pub use body::{RetargetSource, Roles};
use glam::Vec3;
pub use legs::bend_leg;
pub use names::rename_mirror_clashes;
pub use plan::{ClipProvider, Floor, RetargetPlan, SkeletonGroup, provide_from_memory};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
pub use throng_core::skeleton::LEGS;
use throng_core::{Joint, Skeleton};
pub use wear::{BodyFit, WornPose};

/// Settings by which clips are put onto the database skeleton.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RetargetConfig {
    /// Proportions of the database skeleton.
    pub proportions: Proportions,
    /// Move each clip up or down, as a whole, so that its feet stand on the ground, and take out the slope of the
    /// floor that clips of one source skeleton share, where they show one, up to 8 degrees: above 1.7 the body is turned
    /// with it. A clip whose floor is another one, or rises or falls steadily by up to 3 cm/s, is levelled by itself. Stairs
    /// and terrain stay.
    pub align_ground: bool,
}

impl Default for RetargetConfig {
    fn default() -> Self {
        Self { proportions: Proportions::Default, align_ground: true }
    }
}

/// Proportions of the database skeleton.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Proportions {
    /// An adult of 1.75 m.
    #[default]
    Default,
    /// The first clip's own.
    Clip,
    /// Given joint by joint.
    Explicit(ExplicitProportions),
}

/// Rest offsets by joint name; joints that are not named keep the default skeleton's.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ExplicitProportions {
    /// Offset (x left, y up, z forward) of a joint from its parent in the T-pose, by snake_case joint name;
    /// the hips' is their height above the ground (m).
    pub offsets: BTreeMap<String, [f32; 3]>,
}

/// Longest offset along each axis (m).
const MAX_OFFSET: f32 = 10.0;
/// Distance below which two rest positions of a joint are one: files are rounded (m).
const SAME_OFFSET_M: f32 = 1e-4;

impl RetargetConfig {
    /// Checks the proportions.
    ///
    /// # Errors
    /// [`BuildError::Key`] for a name that is no joint, an offset that is too long, or a leg without length.
    pub fn check(&self) -> Result<()> {
        if let Proportions::Explicit(explicit) = &self.proportions { explicit.skeleton().map(|_| ()) } else { Ok(()) }
    }
}

impl ExplicitProportions {
    /// The skeleton of these offsets.
    ///
    /// # Errors
    /// [`BuildError::Config`] for a name that is no joint, or a leg without length.
    fn skeleton(&self) -> Result<Skeleton> {
        let mut out = Skeleton::default();
        for (name, offset) in &self.offsets {
            let key = || format!("retarget.proportions.explicit.offsets.{name}");
            let joint = Joint::from_name(name).ok_or_else(|| {
                let all = Joint::ALL.map(Joint::name).join(", ");
                BuildError::key(key(), format!("expected the name of a joint ({all}), found `{name}`."))
            })?;
            let why = || format!("expected up to {MAX_OFFSET} m each way, found {offset:?}");
            ensure(offset.iter().all(|v| v.abs() <= MAX_OFFSET), || BuildError::key(key(), why()))?;
            out.offsets[joint.index()] = Vec3::from_array(*offset);
        }
        let why = "expected legs longer than 0.05 m; check the offsets of the shins and feet.";
        let sound = out.leg_length() > 0.05;
        sound.then_some(out).ok_or_else(|| BuildError::key("retarget.proportions.explicit", why))
    }
}

/// Retargets every clip to one database skeleton.
///
/// Joint rotations are the source's, aligned so that the T-pose is the identity; hips positions are multiplied by the quotient
/// of the leg lengths; with `align_ground` y = 0 is where the feet stand. A spine joint, clavicle or hand that is not in the
/// source stays rigid with its parent, which keeps the joints it has in place.
///
/// # Errors
/// [`BuildError::Stage`] when a clip has no hips, thighs, shins or feet, or no legs to measure, and
/// [`BuildError::Config`] for explicit proportions that are not a body.
pub fn retarget_clips(clips: &[ImportedClip], cfg: &RetargetConfig, warnings: &mut Warnings) -> Result<ClipSet> {
    let sources: Vec<RetargetSource> = clips.iter().map(RetargetSource::from).collect();
    let mut set = retarget_sources(&sources, cfg, warnings)?;
    set.clips.iter_mut().zip(clips).for_each(|(clip, imported)| plan::leave_out_glitches(clip, imported));
    Ok(set)
}

fn retarget_sources(sources: &[RetargetSource], cfg: &RetargetConfig, warnings: &mut Warnings) -> Result<ClipSet> {
    let provider = provide_from_memory(sources);
    let mut plan = RetargetPlan::new(sources, &*provider, cfg, warnings)?;
    for p in 0..plan.performers.len() {
        plan.set_floor(p, plan.find_floor(p, &*provider)?, &*provider)?;
    }
    let clips = sources.par_iter().enumerate().map(|(i, source)| plan.retarget_source(i, source)).collect();
    Ok(ClipSet { skeleton: plan.skeleton, clips })
}

/// Clips by performer: clips of one source skeleton, with the same joints and lengths, together; in input order.
pub fn performers(clips: &[ImportedClip]) -> Vec<Vec<usize>> {
    group_by_skeleton(&clips.iter().map(RetargetSource::from).collect::<Vec<_>>())
}

/// Clips by source skeleton: same joints, rest pose and roles, whatever the ends of chains. Groups and their clips in input
/// order.
fn group_by_skeleton(sources: &[RetargetSource]) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (i, s) in sources.iter().enumerate() {
        let same = |g: &&mut Vec<usize>| {
            let first = &sources[g[0]];
            first.roles == s.roles && same_rig(first, s)
        };
        match groups.iter_mut().find(same) {
            Some(g) => g.push(i),
            None => groups.push(vec![i]),
        }
    }
    groups
}

/// True for clips of one source skeleton. The rest position of the hips, and their parent, may differ: some exporters write
/// there where a take begins.
fn same_rig(a: &RetargetSource, b: &RetargetSource) -> bool {
    fn joints(c: &RawClip) -> impl Iterator<Item = (usize, &RawJoint)> {
        c.joints.iter().enumerate().filter(|(_, j)| !j.is_end)
    }
    let hips = a.roles[Joint::Hips.index()];
    let up_from_hips: Vec<usize> = std::iter::successors(hips, |&j| a.clip.joints[j].parent).collect();
    let same = |((i, a), (_, b)): ((usize, &RawJoint), (usize, &RawJoint))| {
        let is_there = a.offset.distance(b.offset) < SAME_OFFSET_M || up_from_hips.contains(&i);
        (&a.name, a.parent) == (&b.name, b.parent) && is_there
    };
    joints(a.clip).count() == joints(b.clip).count() && joints(a.clip).zip(joints(b.clip)).all(same)
}

/// Checks the roles without which nothing can be retargeted.
fn check_roles(source: &RetargetSource) -> Result<()> {
    use Joint::*;
    let has_frames = source.clip.num_frames > 0;
    ensure(has_frames, || fault(source, "the clip has no frames".into(), "Remove the file from the input."))?;
    let needed = [Hips, LeftThigh, LeftShin, LeftFoot, RightThigh, RightShin, RightFoot];
    let missing: Vec<&str> =
        needed.into_iter().filter(|j| source.roles[j.index()].is_none()).map(Joint::name).collect();
    let what =
        format!("expected a joint for each of hips, thighs, shins and feet, found none for {}", missing.join(", "));
    ensure(missing.is_empty(), || fault(source, what, "Name the joints in a skeleton profile."))
}

fn check_legs(source: &RetargetSource, body: &SourceBody) -> Result<()> {
    let what = format!("expected legs longer than 0.05 m, found {} m", body.leg_length());
    let help = "Check the unit and which joints are named as thighs, shins and feet.";
    ensure(body.leg_length() > 0.05, || fault(source, what, help))
}

/// An error about a clip.
fn fault(source: &RetargetSource, what: String, help: &str) -> BuildError {
    let message = format!("{}: {what}", source.clip.path.display());
    BuildError::Stage { stage: "retarget", message, help: help.into() }
}

#[cfg(test)]
mod tests;
