//! Made motion: what behaviours need and clips lack, made from what is there.
//!
//! A gait and a stance give starts, stops, turns, arcs and steps: the feet get places of their own along a new course,
//! and the body above them goes from one to the other. Both ends of each are frames of clips, so that the motion graph
//! joins them without error.

mod courses;
mod feet;
mod gait;
mod needs;
mod stance;
mod stepping;

use crate::graph::MotionGraphConfig;
use crate::share::{clip_owners, sort_by_owner};
use courses::MadeMove;
use gait::{GaitCycle, gait_distance};
pub use needs::Lacks;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stance::RestStance;
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use stepping::CourseWalker;
use throng_base::Comm;
use throng_core::Skeleton;
use throng_core::format::MADE_TAG;
use throng_motion::clip::{Clip, ClipSet, ClipTag};
use throng_motion::error::Result;
use throng_motion::mirror;

/// Most gaits that get starts and stops.
const MAX_GAITS: usize = 10;
/// Difference from which two gaits need starts and stops of their own (rad a joint).
const OTHER_GAIT: f32 = 0.12;

/// Speed of the gait that is preferred (m/s).
const USUAL_MPS: f32 = 1.1;
/// Weight of the likeness of a stance to the gait, and unrest from which no clip stands at ease.
const LIKENESS: f32 = 1.0;
const MOST_UNREST: f32 = 1.0;

/// Made motion of a build.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MadeReport {
    /// Clips, mirrored copies not counted.
    pub clips: usize,
    /// Starts.
    pub starts: usize,
    /// Stops.
    pub stops: usize,
    /// Turns on the spot.
    pub turns: usize,
    /// Arcs of walks.
    pub arcs: usize,
    /// Steps aside and back.
    pub steps: usize,
    /// Stands, where no clip stands at ease.
    pub stands: usize,
    /// Made frames (s).
    pub seconds: f64,
    /// Clips whose gait was used.
    pub gaits: Vec<String>,
    /// Clip whose stance was used; empty where it was made.
    pub stance: String,
}

impl MadeReport {
    /// Sentence such as `12 clips made: 4 starts, 4 stops, 4 turns`; empty if none are made.
    pub fn summary(&self) -> String {
        let all = [
            (self.starts, "start"),
            (self.stops, "stop"),
            (self.turns, "turn"),
            (self.arcs, "arc"),
            (self.steps, "step"),
            (self.stands, "stand"),
        ];
        let plural = |n: usize| if n == 1 { "" } else { "s" };
        let parts: Vec<String> =
            all.iter().filter(|(n, _)| *n > 0).map(|&(n, what)| format!("{n} {what}{}", plural(n))).collect();
        if parts.is_empty() {
            return String::new();
        }
        format!("{} clip{} made: {}", self.clips, plural(self.clips), parts.join(", "))
    }
}

/// Made clips.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MadeMotion {
    /// The clips, each with its mirrored copy after it if there are such copies.
    pub clips: Vec<Clip>,
    /// Their numbers.
    pub report: MadeReport,
}

/// Makes the motion that behaviours need and clips lack.
///
/// - `comm`: processes that hold the other poses.
///
/// # Errors
/// Faults of the exchange between processes.
pub fn make_missing(
    clips: &ClipSet,
    lacks: Lacks,
    cfg: &MotionGraphConfig,
    mirrored: bool,
    comm: &dyn Comm,
) -> Result<MadeMotion> {
    let found = sort_by_owner(comm, &clip_owners(clips, comm.num_ranks()), |c| {
        let clip = &clips.clips[c];
        match clip.mirrored {
            true => (Vec::new(), None),
            false => (GaitCycle::find(clip, &clips.skeleton), RestStance::find(clip, &clips.skeleton, cfg)),
        }
    })?;
    let (gaits, stances): (Vec<_>, Vec<_>) = found.into_iter().unzip();
    let mut made = MadeMotion::default();
    let gaits = choose_gaits(gaits.into_iter().flatten().collect(), mirrored);
    let Some(first) = gaits.first() else { return Ok(made) };
    let cost = |s: &RestStance| s.unrest + LIKENESS * s.distance_from(first);
    let stance = stances.into_iter().flatten().min_by(|a, b| cost(a).total_cmp(&cost(b)));
    let stance = stance.filter(|s| s.unrest < MOST_UNREST).or_else(|| RestStance::of_gait(first, &clips.skeleton));
    let Some(stance) = stance else { return Ok(made) };
    let mut maker = MotionMaker { skeleton: &clips.skeleton, mirrored, made: &mut made };
    maker.make_all(&gaits, &stance, lacks);
    made.report.stance = if stance.made { String::new() } else { stance.clip.name.clone() };
    made.report.gaits = gaits.iter().map(|g| g.clip.name.clone()).collect();
    made.report.gaits.dedup();
    Ok(made)
}

/// Gaits that are worth a start and a stop, the most usual one first, and each unlike those before it.
fn choose_gaits(mut all: Vec<GaitCycle>, mirrored: bool) -> Vec<GaitCycle> {
    // Mirrored copies start with the other foot.
    let of_foot = |foot: usize| all.iter().filter(|g| g.foot == foot).count();
    let foot = usize::from(of_foot(1) > of_foot(0));
    all.retain(|g| !mirrored || g.foot == foot);
    let cost = |g: &GaitCycle| {
        let alike = |o: &GaitCycle| if o.foot == g.foot { gait_distance(o, g).min(0.5) } else { 0.0 };
        let usual = all.iter().map(alike).sum::<f32>() / all.len() as f32;
        usual + 0.5 * g.unsteadiness + 0.1 * (g.speed_mps() - USUAL_MPS).abs()
    };
    let costs: Vec<f32> = all.iter().map(cost).collect();
    let mut order: Vec<usize> = (0..all.len()).collect();
    order.sort_by(|&a, &b| costs[a].total_cmp(&costs[b]));
    let mut out: Vec<GaitCycle> = Vec::new();
    for k in order {
        let unlike = |other: &GaitCycle| other.foot != all[k].foot || gait_distance(other, &all[k]) > OTHER_GAIT;
        if out.len() < MAX_GAITS && out.iter().all(unlike) {
            out.push(all[k].clone());
        }
    }
    out
}

/// Makes clips of gaits and a stance, and counts them.
struct MotionMaker<'a> {
    skeleton: &'a Skeleton,
    mirrored: bool,
    made: &'a mut MadeMotion,
}

impl MotionMaker<'_> {
    fn make_all(&mut self, gaits: &[GaitCycle], stance: &RestStance, lacks: Lacks) {
        if stance.made {
            self.push(Clip { name: "made/stand".into(), ..stance.clip.clone() }, 0..stance.clip.num_frames());
            self.made.report.stands += 1;
        }
        let mut feet = [false; 2];
        for (k, gait) in gaits.iter().enumerate() {
            let side = if gait.foot == 0 { 1.0 } else { -1.0 };
            // The first gait of each foot does all; others start and stop.
            let is_first = !std::mem::replace(&mut feet[gait.foot], true);
            let mut moves = Vec::new();
            if lacks.joins || lacks.starts && is_first {
                moves.extend([MadeMove::Start(0.0), MadeMove::Stop]);
            }
            if lacks.starts && is_first {
                moves.extend([FRAC_PI_4, FRAC_PI_2].map(|a| MadeMove::Start(side * a)));
            }
            if (lacks.starts || lacks.turns) && is_first {
                moves.extend([(FRAC_PI_4, 2), (FRAC_PI_2, 3), (PI, 5)].map(|(a, n)| MadeMove::Turn(side * a, n)));
                let steps = [[0.35, 0.0], [0.3, 0.3], [0.0, 0.4], [0.0, -0.4]];
                moves.extend(steps.map(|[aside, ahead]| MadeMove::Step(side * aside, ahead, 2)));
            }
            if lacks.arcs && (is_first || k < 4) {
                moves.extend([0.4, 0.8].iter().flat_map(|&a| [MadeMove::Arc(a), MadeMove::Arc(-a)]));
            }
            for what in moves {
                self.make(what, gait, stance, k);
            }
        }
    }

    /// Makes one clip.
    fn make(&mut self, what: MadeMove, gait: &GaitCycle, stance: &RestStance, number: usize) {
        let Some(course) = what.course(gait, stance) else { return };
        let walker = CourseWalker { gait, stance, skeleton: self.skeleton, course: &course };
        let Some(clip) = walker.walk() else { return };
        let stand = (courses::STAND_S * gait.clip.rate_hz as f32) as usize;
        let from = if course.stands[0] { stand } else { course.captured[0] };
        let rest = course.weight.iter().rposition(|w| *w > 0.0).unwrap_or(0) + 1;
        let to = if course.stands[1] { rest } else { course.captured[1] }.min(clip.num_frames());
        let report = &mut self.made.report;
        *match what {
            MadeMove::Start(_) => &mut report.starts,
            MadeMove::Stop => &mut report.stops,
            MadeMove::Turn(..) => &mut report.turns,
            MadeMove::Arc(_) => &mut report.arcs,
            MadeMove::Step(..) => &mut report.steps,
        } += 1;
        self.push(Clip { name: format!("made/{}-{number}", what.name()), ..clip }, from..to.max(from));
    }

    fn push(&mut self, clip: Clip, made: std::ops::Range<usize>) {
        let report = &mut self.made.report;
        report.clips += 1;
        report.seconds += made.len() as f64 / clip.rate_hz;
        let clip = Clip { tags: vec![ClipTag { name: MADE_TAG.into(), range: made }], ..clip };
        let copy = self.mirrored.then(|| mirror::mirror_clip(&clip));
        self.made.clips.push(clip);
        self.made.clips.extend(copy);
    }
}

/// From 0 to 1, with velocity 0 at both ends.
fn smooth(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests;
