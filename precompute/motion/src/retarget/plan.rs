//! Decisions that the clips of a set share, so that each clip can then be retargeted by itself.

use super::align::{self, Alignment};
use super::body::{Body, Source};
use super::ground::Point;
use super::names::unique_names;
use super::transfer::{Motion, transfer};
use super::{Proportions, RetargetConfig, check, check_legs, ground, group, proportions};
use crate::clip::{Clip, Exclusion, ExclusionReason};
use crate::error::{BuildError, Warnings};
use crate::import::{Glitch, Imported, Treated};
use glam::{Quat, Vec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use throng_base::maths;
use throng_core::Skeleton;

/// Total length of the first clips of a source skeleton from which its body and floor are measured (s).
const TELLING_S: f64 = 600.0;

/// Everything that retargeting a clip needs besides the clip.
pub struct Plan {
    /// The database skeleton.
    pub skeleton: Skeleton,
    /// Clips by source skeleton; groups and their clips in input order.
    pub performers: Vec<Performer>,
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
pub struct Performer {
    /// Indices of its first clips, which alone were measured: a later one changes nothing for the others.
    #[serde(skip)]
    pub telling: Vec<usize>,
    /// The floor: level until [`Plan::lay_floor`] sets it.
    pub floor: Floor,
    body: Body,
    alignment: Alignment,
    own: Skeleton,
}

impl Performer {
    /// - `telling`: indices of the clips that [`telling`] chooses.
    /// - `sources`: these clips.
    fn new(telling: Vec<usize>, sources: &[Source]) -> Self {
        let body = Body::measure(sources);
        let alignment = align::align(&body);
        let own = proportions::own(&body, &alignment);
        Self { telling, floor: Floor::default(), body, alignment, own }
    }

    /// The group measured again, upright: a foot is level where it stands.
    fn turned(&self, turn: Quat, sources: &[Source]) -> Self {
        let sources: Vec<Source> = sources.iter().map(|s| Source { turn: Some(turn), ..*s }).collect();
        Self::new(self.telling.clone(), &sources)
    }

    /// A clip on the skeleton, and the positions of its standing feet.
    fn transfer(&self, source: &Source, turn: Option<Quat>, skeleton: &Skeleton) -> (Motion, Vec<Point>) {
        let source = Source { turn, ..*source };
        let motion = transfer(source, &self.body, &self.alignment, &self.own, skeleton);
        let standing = ground::standing(&motion, skeleton, source.clip.rate_hz);
        (motion, standing)
    }

    /// Slope of the floor that clips show together.
    fn slope(&self, sources: &[Source], turn: Option<Quat>, skeleton: &Skeleton) -> Vec3 {
        let points: Vec<Vec<Point>> = sources.par_iter().map(|s| self.transfer(s, turn, skeleton).1).collect();
        ground::slope(&points.iter().map(Vec::as_slice).collect::<Vec<_>>())
    }
}

/// The clips of a source skeleton from which its body and floor are measured.
fn telling(clips: &[usize], sources: &[Source]) -> Vec<usize> {
    let mut seconds = 0.0;
    let first = |i: &&usize| {
        let enough = seconds >= TELLING_S;
        seconds += sources[**i].clip.num_frames as f64 / sources[**i].clip.rate_hz;
        !enough
    };
    clips.iter().take_while(first).copied().collect()
}

/// Passes the clips at some indices, with their motion, to a function that examines them.
pub type Lender<'a> = dyn Fn(&[usize], &mut dyn FnMut(&[Source])) -> Result<(), BuildError> + Sync + 'a;

/// A [`Lender`] of clips whose motion is in memory.
pub fn lend<'a>(sources: &'a [Source<'a>]) -> Box<Lender<'a>> {
    Box::new(|places, look| {
        look(&places.iter().map(|&i| sources[i]).collect::<Vec<_>>());
        Ok(())
    })
}

impl Plan {
    /// Measures every source skeleton and names the clips; floors are still level.
    ///
    /// - `sources`: all clips; their motion is not used.
    /// - `lender`: called for the motion of a few clips of each source skeleton.
    ///
    /// # Errors
    /// Errors of [`super::onto`] and of `lender`.
    pub fn new(
        sources: &[Source],
        lender: &Lender<'_>,
        cfg: &RetargetConfig,
        warnings: &mut Warnings,
    ) -> Result<Self, BuildError> {
        sources.iter().try_for_each(check)?;
        let groups = group(sources);
        let measured = |clips: &Vec<usize>| {
            let (telling, mut performer) = (telling(clips, sources), None);
            lender(&telling, &mut |sources| performer = Some(Performer::new(telling.clone(), sources)))?;
            Ok(performer)
        };
        let performers: Vec<Option<Performer>> = groups.par_iter().map(measured).collect::<Result<_, BuildError>>()?;
        let performers: Vec<Performer> = performers.into_iter().flatten().collect();
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
    pub fn find_floor(&self, performer: usize, lender: &Lender<'_>) -> Result<Floor, BuildError> {
        let (p, mut floor) = (&self.performers[performer], Floor::default());
        if !self.align_ground {
            return Ok(floor);
        }
        lender(&p.telling, &mut |sources| {
            floor.slope = p.slope(sources, None, &self.skeleton);
            if ground::is_steep(floor.slope) {
                let turn = ground::upright(floor.slope);
                let slope = p.turned(turn, sources).slope(sources, Some(turn), &self.skeleton);
                let slope = if ground::is_steep(slope) { Vec3::ZERO } else { slope };
                floor = Floor { turn: Some(turn), slope };
            }
        })?;
        Ok(floor)
    }

    /// Sets the floor of a source skeleton; where it was tilted, the body is measured again, upright.
    pub fn lay_floor(&mut self, performer: usize, floor: Floor, lender: &Lender<'_>) -> Result<(), BuildError> {
        let p = &mut self.performers[performer];
        if let Some(turn) = floor.turn {
            let mut turned = None;
            lender(&p.telling, &mut |sources| turned = Some(p.turned(turn, sources)))?;
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
    pub fn lay(&self, clip: usize, imported: &Imported) -> Clip {
        let mut out = self.lay_source(clip, &imported.into());
        leave_out_glitches(&mut out, imported);
        out
    }

    pub(super) fn lay_source(&self, clip: usize, source: &Source) -> Clip {
        let p = &self.performers[self.performer_of[clip]];
        let Floor { turn, mut slope } = p.floor;
        let (mut motion, mut standing) = p.transfer(source, turn, &self.skeleton);
        if self.align_ground {
            slope = ground::own_slope(&standing, slope);
            if ground::is_steep(slope) {
                let upright = ground::upright(slope);
                let turn = turn.map_or(upright, |turn| maths::compose(upright, turn).normalize());
                (motion, standing) = p.transfer(source, Some(turn), &self.skeleton);
                slope = ground::own_slope(&standing, Vec3::ZERO);
                slope = if ground::is_steep(slope) { Vec3::Z * slope.z } else { slope };
            }
            ground::level(&mut motion, ground::height(&standing, slope), slope, source.clip.rate_hz);
        }
        let Motion { root_positions, rotations } = motion;
        Clip {
            source: source.clip.path.display().to_string(),
            ..Clip::new(self.names[clip].clone(), source.clip.rate_hz, root_positions, rotations)
        }
    }
}

/// Excludes the frames of glitches that are cut.
pub(super) fn leave_out_glitches(clip: &mut Clip, imported: &Imported) {
    let n = clip.num_frames();
    clip.excluded = imported.glitches.iter().filter(|g| g.treated == Treated::Cut).map(|g| exclusion(g, n)).collect();
}

/// The frames of a glitch and those next to it: at another rate, frames in between are made of both.
fn exclusion(glitch: &Glitch, num_frames: usize) -> Exclusion {
    let range = glitch.frames.start.saturating_sub(1)..(glitch.frames.end + 1).min(num_frames);
    Exclusion { range, reason: ExclusionReason::Glitch }
}
