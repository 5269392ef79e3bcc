//! Decisions that the clips of a set share, so that each clip can then be retargeted by itself.

use super::align::{self, Alignment};
use super::body::{RetargetSource, SourceBody};
use super::transfer::{RetargetedMotion, transfer_motion};
use super::{Proportions, RetargetConfig, check_legs, check_roles, ground, group_by_skeleton, proportions};
use super::{ground::FootPoint, names::unique_names};
use crate::clip::{Clip, Exclusion, ExclusionReason};
use crate::error::{Result, Warnings};
use crate::import::{GlitchTreatment, ImportedClip};
use glam::{Quat, Vec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use throng_base::maths;
use throng_core::Skeleton;

/// Total length of the first clips of a source skeleton from which its body and floor are measured (s).
const MEASURED_S: f64 = 600.0;

/// Everything that retargeting a clip needs besides the clip.
pub struct RetargetPlan {
    /// The database skeleton.
    pub skeleton: Skeleton,
    /// Clips by source skeleton; groups and their clips in input order.
    pub performers: Vec<SkeletonGroup>,
    /// Name of every clip, unique.
    pub names: Vec<String>,
    /// Group of every clip.
    performer_of: Vec<usize>,
    align_ground: bool,
}

/// The floor that clips of one source skeleton share.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Floor {
    /// Rotation that turns motion upright, where the floor was tilted.
    turn: Option<Quat>,
    /// Rise of the floor along x and z then (per metre), and over time (0).
    slope: Vec3,
}

/// Clips of one source skeleton, with the data that they share.
#[derive(Serialize)]
pub struct SkeletonGroup {
    /// Indices of its first clips, which alone were measured: a later one changes nothing for the others.
    #[serde(skip)]
    pub measured_clips: Vec<usize>,
    /// The floor: level until [`RetargetPlan::set_floor`] sets it.
    pub floor: Floor,
    pub(super) body: SourceBody,
    pub(super) alignment: Alignment,
    /// The database topology with its own proportions.
    pub(super) own: Skeleton,
}

impl SkeletonGroup {
    /// - `select_measured_clips`: indices of the clips that [`select_measured_clips`] chooses.
    /// - `sources`: these clips.
    fn new(measured_clips: Vec<usize>, sources: &[RetargetSource]) -> Self {
        let body = SourceBody::measure(sources);
        let alignment = align::align(&body);
        let own = proportions::source_skeleton(&body, &alignment);
        Self { measured_clips, floor: Floor::default(), body, alignment, own }
    }

    /// The skeleton of one clip.
    pub(super) fn measure_one(source: RetargetSource) -> Result<Self> {
        check_roles(&source)?;
        let group = Self::new(Vec::new(), &[source]);
        check_legs(&source, &group.body).map(|()| group)
    }

    /// The group measured again, upright: a foot is level where it stands.
    fn turned(&self, turn: Quat, sources: &[RetargetSource]) -> Self {
        let sources: Vec<RetargetSource> = sources.iter().map(|s| RetargetSource { turn: Some(turn), ..*s }).collect();
        Self::new(self.measured_clips.clone(), &sources)
    }

    /// A clip on the skeleton, and the positions of its standing feet.
    fn transfer(&self, from: &RetargetSource, by: Option<Quat>, body: &Skeleton) -> (RetargetedMotion, Vec<FootPoint>) {
        let from = RetargetSource { turn: by, ..*from };
        let motion = transfer_motion(from, self, body);
        let standing = ground::standing_points(&motion, body, from.clip.rate_hz);
        (motion, standing)
    }

    /// Slope of the floor that clips show together.
    fn slope(&self, sources: &[RetargetSource], turn: Option<Quat>, skeleton: &Skeleton) -> Vec3 {
        let points: Vec<Vec<FootPoint>> = sources.par_iter().map(|s| self.transfer(s, turn, skeleton).1).collect();
        ground::shared_slope(&points.iter().map(Vec::as_slice).collect::<Vec<_>>())
    }
}

/// The clips of a source skeleton from which its body and floor are measured.
fn select_measured_clips(clips: &[usize], sources: &[RetargetSource]) -> Vec<usize> {
    let mut seconds = 0.0;
    let first = |i: &&usize| {
        let enough = seconds >= MEASURED_S;
        seconds += sources[**i].clip.num_frames as f64 / sources[**i].clip.rate_hz;
        !enough
    };
    clips.iter().take_while(first).copied().collect()
}

/// Passes the clips at some indices, with their motion, to a function that examines them.
pub type ClipProvider<'a> = dyn Fn(&[usize], &mut dyn FnMut(&[RetargetSource])) -> Result<()> + Sync + 'a;

/// A [`ClipProvider`] of clips whose motion is in memory.
pub fn provide_from_memory<'a>(sources: &'a [RetargetSource<'a>]) -> Box<ClipProvider<'a>> {
    Box::new(|places, look| {
        look(&places.iter().map(|&i| sources[i]).collect::<Vec<_>>());
        Ok(())
    })
}

impl RetargetPlan {
    /// Measures every source skeleton and names the clips; floors are still level.
    ///
    /// - `sources`: all clips; their motion is not used.
    /// - `lender`: called for the motion of a few clips of each source skeleton.
    ///
    /// # Errors
    /// Errors of [`super::retarget_clips`] and of `lender`.
    pub fn new(
        sources: &[RetargetSource],
        provider: &ClipProvider<'_>,
        cfg: &RetargetConfig,
        warnings: &mut Warnings,
    ) -> Result<Self> {
        sources.iter().try_for_each(check_roles)?;
        let groups = group_by_skeleton(sources);
        let measured = |clips: &Vec<usize>| {
            let (measured_clips, mut performer) = (select_measured_clips(clips, sources), None);
            provider(&measured_clips, &mut |sources| {
                performer = Some(SkeletonGroup::new(measured_clips.clone(), sources))
            })?;
            Ok(performer)
        };
        let performers: Vec<Option<SkeletonGroup>> = groups.par_iter().map(measured).collect::<Result<_>>()?;
        let performers: Vec<SkeletonGroup> = performers.into_iter().flatten().collect();
        for (clips, performer) in groups.iter().zip(&performers) {
            check_legs(&sources[clips[0]], &performer.body)?;
        }
        let mut performer_of = vec![0; sources.len()];
        for (p, clips) in groups.iter().enumerate() {
            clips.iter().for_each(|&i| performer_of[i] = p);
        }
        let skeleton = match (&cfg.proportions, performers.first()) {
            (Proportions::Clip, Some(first)) => first.own.clone(),
            (Proportions::Explicit(p), _) => p.skeleton()?,
            _ => Skeleton::default(),
        };
        let names = unique_names(sources, warnings);
        for (source, name) in sources.iter().zip(&names).filter(|(s, _)| s.clip.num_frames < 2) {
            let path = source.clip.path.display();
            warnings.push(format!("{path}: `{name}` has a single frame and shows no motion."));
        }
        Ok(Self { skeleton, performers, names, performer_of, align_ground: cfg.align_ground })
    }

    /// The floor that the first clips of a source skeleton show.
    pub fn find_floor(&self, performer: usize, provider: &ClipProvider<'_>) -> Result<Floor> {
        let (p, mut floor) = (&self.performers[performer], Floor::default());
        if !self.align_ground {
            return Ok(floor);
        }
        provider(&p.measured_clips, &mut |sources| {
            floor.slope = p.slope(sources, None, &self.skeleton);
            if ground::is_steep(floor.slope) {
                let turn = ground::upright_turn(floor.slope);
                let slope = p.turned(turn, sources).slope(sources, Some(turn), &self.skeleton);
                let slope = if ground::is_steep(slope) { Vec3::ZERO } else { slope };
                floor = Floor { turn: Some(turn), slope };
            }
        })?;
        Ok(floor)
    }

    /// Sets the floor of a source skeleton; where it was tilted, the body is measured again, upright.
    pub fn set_floor(&mut self, performer: usize, floor: Floor, provider: &ClipProvider<'_>) -> Result<()> {
        let p = &mut self.performers[performer];
        if let Some(turn) = floor.turn {
            let mut turned = None;
            provider(&p.measured_clips, &mut |sources| turned = Some(p.turned(turn, sources)))?;
            turned.into_iter().for_each(|turned| *p = turned);
        }
        p.floor = floor;
        Ok(())
    }

    /// Everything that retargeting a clip depends on besides the clip and its name, for its key: skeletons, body and floor.
    pub fn basis(&self, clip: usize) -> impl Serialize {
        (&self.skeleton, &self.performers[self.performer_of[clip]], self.align_ground)
    }

    /// Retargets a clip to the skeleton; frames cut as glitches are left out.
    ///
    /// - `clip`: its index among the sources of the plan.
    pub fn retarget_clip(&self, clip: usize, imported: &ImportedClip) -> Clip {
        let mut out = self.retarget_source(clip, &imported.into());
        leave_out_glitches(&mut out, imported);
        out
    }

    pub(super) fn retarget_source(&self, clip: usize, source: &RetargetSource) -> Clip {
        let p = &self.performers[self.performer_of[clip]];
        let Floor { turn, mut slope } = p.floor;
        let (mut motion, mut standing) = p.transfer(source, turn, &self.skeleton);
        if self.align_ground {
            slope = ground::own_slope(&standing, slope);
            if ground::is_steep(slope) {
                let upright = ground::upright_turn(slope);
                let turn = turn.map_or(upright, |turn| maths::compose(upright, turn).normalize());
                (motion, standing) = p.transfer(source, Some(turn), &self.skeleton);
                slope = ground::own_slope(&standing, Vec3::ZERO);
                slope = if ground::is_steep(slope) { Vec3::Z * slope.z } else { slope };
            }
            ground::level_motion(&mut motion, ground::floor_height(&standing, slope), slope, source.clip.rate_hz);
        }
        let RetargetedMotion { root_positions, rotations } = motion;
        Clip {
            source: source.clip.path.display().to_string(),
            ..Clip::new(self.names[clip].clone(), source.clip.rate_hz, root_positions, rotations)
        }
    }
}

/// Excludes the frames of glitches that are cut.
pub(super) fn leave_out_glitches(clip: &mut Clip, imported: &ImportedClip) {
    let n = clip.num_frames();
    let cut = imported.glitches.iter().filter(|g| g.treated == GlitchTreatment::Cut).map(|g| &g.frames);
    // The frames next to it, too: at another rate, frames in between are made of both.
    let ranges = cut.map(|frames| frames.start.saturating_sub(1)..(frames.end + 1).min(n));
    clip.excluded = ranges.map(|range| Exclusion { range, reason: ExclusionReason::Glitch }).collect();
}
