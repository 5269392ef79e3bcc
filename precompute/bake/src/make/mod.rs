//! Made motion: what behaviours need and clips lack, made from what is there.
//!
//! A gait and a stance give starts, stops, turns, arcs and steps: the feet get places of their own along a new course,
//! and the body above them goes from one to the other. Both ends of each are frames of clips, so that the motion graph
//! joins them without error. Caches notice a change here; bundles that scenes have made before stay until they are deleted.

mod courses;
mod feet;
mod gait;
mod needs;
mod stance;
mod stand;
mod stepping;

use crate::graph::{MotionGraphConfig, TakenMotion};
use crate::share::{clip_owners, sort_by_owner};
use courses::MadeMove;
use gait::{GaitCycle, gait_distance};
use needs::NUM_GAITS;
pub use needs::{LEAST_START_M, Lacks};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stance::RestStance;
pub use stand::make_stands;
use std::collections::BTreeMap;
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use stepping::CourseWalker;
use throng_base::{Comm, thresholds::USUAL_GAIT_MPS};
use throng_core::Skeleton;
use throng_core::format::{Gait, MADE_TAG, MotionClass};
use throng_motion::annotate::classes::{NameHints, classify, named_manner};
use throng_motion::{Clip, ClipSet, ClipTag, Result, mirror};

/// Most gaits of a manner that get starts and stops: of all motion, and of that to which nothing leads.
const MAX_GAITS: [usize; 2] = [14, 6];
/// Most gaits of each kind that get arcs, and turns round while going.
const MAX_TURNED: usize = 2;
/// Largest turn within a cycle of a gait that gets arcs and turns round, the first of its kind and foot excepted (rad).
const LARGEST_TURN: f32 = 0.15;
/// Difference from which two gaits need starts and stops of their own (rad a joint).
const OTHER_GAIT: f32 = 0.12;

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
    /// Arcs of gaits.
    pub arcs: usize,
    /// Turns round while going.
    pub pivots: usize,
    /// Steps aside and back.
    pub steps: usize,
    /// Stands, where no clip stands at ease, or none for long.
    pub stands: usize,
    /// Made frames (s).
    pub seconds: f64,
    /// Starts that the clips have, mirrored copies not counted, or stops if these are fewer.
    pub captured_starts: usize,
    /// Clips whose gait was used.
    pub gaits: Vec<String>,
    /// Clips whose stances were used.
    pub stances: Vec<String>,
}

impl MadeReport {
    /// Sentence such as `12 clips made: 4 starts, 4 stops, 4 turns`; empty if none are made.
    pub fn summary(&self) -> String {
        let counts = [self.starts, self.stops, self.turns, self.arcs, self.pivots, self.steps, self.stands];
        let all = counts.into_iter().zip(["start", "stop", "turn", "arc", "pivot", "step", "stand"]);
        let plural = |n: usize| if n == 1 { "" } else { "s" };
        let parts: Vec<String> =
            all.filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}{}", plural(n))).collect();
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

impl MadeMotion {
    /// Adds the motion that is made after stands.
    pub fn append(&mut self, mut other: Self) {
        self.clips.append(&mut other.clips);
        let stands = std::mem::replace(&mut self.report, other.report);
        self.report.clips += stands.clips;
        self.report.stands += stands.stands;
        self.report.seconds += stands.seconds;
    }
}

/// Makes the motion that behaviours need and clips lack.
///
/// - `lacks`: what each manner lacks.
/// - `comm`: processes that hold the other poses.
///
/// # Errors
/// Faults of the exchange between processes.
pub fn make_missing(
    clips: &ClipSet,
    lacks: &BTreeMap<String, Lacks>,
    cfg: &MotionGraphConfig,
    mirrored: bool,
    comm: &dyn Comm,
) -> Result<MadeMotion> {
    let found = sort_by_owner(comm, &clip_owners(clips, comm.num_ranks()), |c| {
        let clip = &clips.clips[c];
        match clip.mirrored {
            true => (Vec::new(), Vec::new()),
            false => (GaitCycle::find(clip, &clips.skeleton), RestStance::find(clip, &clips.skeleton, cfg)),
        }
    })?;
    let (gaits, stances): (Vec<_>, Vec<_>) = found.into_iter().unzip();
    let mut made = MadeMotion::default();
    let (all, stances): (Vec<GaitCycle>, Vec<RestStance>) =
        (gaits.into_iter().flatten().collect(), stances.into_iter().flatten().collect());
    for (manner, lacks) in lacks {
        let own = all.iter().filter(|g| named_manner(&g.class.manner) == manner).cloned().collect();
        let chosen = choose_gaits(own, mirrored, lacks, &cfg.take);
        make_of_gaits(&chosen, &stances, lacks, &clips.skeleton, mirrored, &mut made);
    }
    let report = &mut made.report;
    report.stances.sort_unstable();
    report.stances.dedup();
    report.gaits.dedup();
    report.captured_starts = needs::count_starts(clips);
    Ok(made)
}

/// Makes what the gaits that people keep to give.
///
/// - `captured`: stances of all motion.
fn make_of_gaits(
    gaits: &[GaitCycle],
    captured: &[RestStance],
    lacks: &Lacks,
    skeleton: &Skeleton,
    mirrored: bool,
    made: &mut MadeMotion,
) {
    let mut manners: Vec<&str> = gaits.iter().map(|g| &*g.class.manner).collect();
    manners.sort_unstable();
    manners.dedup();
    let of_manner = |manner: &&str| {
        let gaits: Vec<&GaitCycle> = gaits.iter().filter(|g| g.class.manner == **manner).collect();
        RestStance::choose(captured, &gaits, skeleton)
    };
    let of_manners: Vec<Vec<RestStance>> = manners.iter().map(of_manner).collect();
    let first = made.report.gaits.len();
    let mut maker = MotionMaker::new(skeleton, mirrored, made);
    of_manners.iter().for_each(|stances| maker.make_stands("stand", stances));
    let mut seen = Vec::new();
    for (k, gait) in gaits.iter().enumerate() {
        let of = manners.binary_search(&&*gait.class.manner).unwrap_or(0);
        let key = (gait.foot, of);
        let is_first = !seen.contains(&key);
        seen.push(key);
        maker.make_all(gait, first + k, &of_manners[of], is_first, lacks);
    }
    let report = &mut made.report;
    report.stances.extend(of_manners.iter().flatten().filter(|s| !s.made).map(|s| s.clip.name.clone()));
    report.gaits.extend(gaits.iter().map(|g| g.clip.name.clone()));
}

/// Gaits that are worth a start and a stop, the most usual one first, one of each manner before others, and each unlike
/// those before it; of motion that a graph takes, if there is any.
fn choose_gaits(mut all: Vec<GaitCycle>, mirrored: bool, lacks: &Lacks, take: &[TakenMotion]) -> Vec<GaitCycle> {
    let is_taken = |g: &GaitCycle| take.contains(&TakenMotion::of_class(&g.class));
    if all.iter().any(is_taken) {
        all.retain(is_taken);
    }
    all.retain(|g| !g.goes_aside() || lacks.is_apart(g));
    // Mirrored copies start with the other foot.
    let of_foot = |foot: usize| all.iter().filter(|g| g.foot == foot).count();
    let foot = usize::from(of_foot(1) > of_foot(0));
    all.retain(|g| !mirrored || g.foot == foot);
    let cost = |g: &GaitCycle| {
        let alike = |o: &GaitCycle| if o.foot == g.foot { gait_distance(o, g).min(0.5) } else { 0.0 };
        let usual = all.iter().map(alike).sum::<f32>() / all.len() as f32;
        usual + 0.5 * g.unsteadiness + 0.1 * (g.speed_mps() - USUAL_GAIT_MPS).abs()
    };
    let costs: Vec<f32> = all.iter().map(cost).collect();
    let mut order: Vec<usize> = (0..all.len()).collect();
    order.sort_by(|&a, &b| (all[a].goes_aside().cmp(&all[b].goes_aside())).then(costs[a].total_cmp(&costs[b])));
    let kind = |k: usize| (all[k].foot, all[k].class.gait, &all[k].class.manner);
    let is_first = |i: usize| !order[..i].iter().any(|&k| kind(k) == kind(order[i]));
    let (firsts, others): (Vec<usize>, Vec<usize>) = (0..order.len()).partition(|&i| is_first(i));
    let mut out: Vec<GaitCycle> = Vec::new();
    for k in firsts.into_iter().chain(others).map(|i| order[i]) {
        let unlike = |o: &GaitCycle| {
            o.foot != all[k].foot || o.class.manner != all[k].class.manner || gait_distance(o, &all[k]) > OTHER_GAIT
        };
        let is_apart = lacks.is_apart(&all[k]);
        let has_room = out.iter().filter(|o| lacks.is_apart(o) == is_apart).count() < MAX_GAITS[usize::from(is_apart)];
        if has_room && (is_apart || out.iter().all(unlike)) {
            out.push(all[k].clone());
        }
    }
    out
}

/// Most that hips of made motion sink below those of its gait and stance (m).
const MOST_SUNK_M: f32 = 0.08;
/// Angle up to which a joint is as it was captured (rad).
const SAME_RAD: f32 = 0.005;

/// Makes clips of gaits and a stance, and counts them.
struct MotionMaker<'a> {
    skeleton: &'a Skeleton,
    mirrored: bool,
    made: &'a mut MadeMotion,
    /// True for feet with which a gait has set off.
    feet: [bool; 2],
    /// Number of gaits of each kind and foot that have got arcs, and turns round while going.
    turned: [[usize; 2]; NUM_GAITS],
}

impl<'a> MotionMaker<'a> {
    fn new(skeleton: &'a Skeleton, mirrored: bool, made: &'a mut MadeMotion) -> Self {
        Self { skeleton, mirrored, made, feet: [false; 2], turned: [[0; 2]; NUM_GAITS] }
    }

    /// Makes stands of stances that nobody has captured, or for a short time only.
    fn make_stands(&mut self, what: &str, stances: &[RestStance]) {
        for s in stances.iter().filter(|s| s.made) {
            let name = format!("made/{what}-{}", self.made.report.stands);
            self.push(Clip { name, ..s.clip.clone() }, 0..s.clip.num_frames(), &s.class);
            self.made.report.stands += 1;
        }
    }

    /// Makes what a gait gives.
    ///
    /// - `number`: its number; the first one of each foot does most.
    /// - `is_first`: true for the first gait of its foot and manner.
    fn make_all(&mut self, gait: &GaitCycle, number: usize, stances: &[RestStance], is_first: bool, lacks: &Lacks) {
        let Some(stance) = stances.first() else { return };
        let side = if gait.foot == 0 { 1.0 } else { -1.0 };
        let usual = !std::mem::replace(&mut self.feet[gait.foot], true);
        let mut moves = Vec::new();
        if lacks.starts && usual {
            moves.extend([FRAC_PI_4, FRAC_PI_2].map(|a| MadeMove::Start(side * a)));
        }
        if (lacks.starts || lacks.turns) && usual {
            moves.extend([(FRAC_PI_4, 2), (FRAC_PI_2, 2), (PI, 3)].map(|(a, n)| MadeMove::Turn(side * a, n)));
        }
        if (lacks.starts || lacks.steps) && usual {
            let steps = [[0.35, 0.0], [0.3, 0.3], [0.0, 0.4], [0.0, 0.7], [0.0, -0.4]];
            moves.extend(steps.map(|[aside, ahead]| MadeMove::Step(side * aside, ahead, 2)));
        }
        let kind = gait.class.gait as usize;
        let turned = &mut self.turned[kind][gait.foot];
        let turns = *turned < MAX_TURNED && !gait.goes_aside() && (*turned == 0 || gait.turn().abs() < LARGEST_TURN);
        *turned += usize::from(turns);
        if turns && lacks.pivots {
            moves.extend([FRAC_PI_2, PI].map(|a| MadeMove::Pivot(side * a)));
        }
        if turns && lacks.arcs[kind] {
            moves.extend(MadeMove::arcs(gait, lacks.sideways_mps2));
        }
        moves.into_iter().for_each(|what| self.make(what, gait, stance, number.to_string()));
        if lacks.joins || lacks.starts && usual || lacks.is_apart(gait) {
            let all: Vec<usize> = if is_first { (0..stances.len()).collect() } else { vec![number % stances.len()] };
            for s in all {
                let number = if s == 0 || !is_first { number.to_string() } else { format!("{number}.{s}") };
                self.make(MadeMove::Start(0.0), gait, &stances[s], number.clone());
                self.make(MadeMove::Stop, gait, &stances[s], number);
            }
        }
    }

    /// Makes one clip.
    fn make(&mut self, what: MadeMove, gait: &GaitCycle, stance: &RestStance, number: String) {
        let gait = &what.quicken(gait);
        let Some(course) = what.course(gait, stance) else { return };
        let walker = CourseWalker { gait, stance, skeleton: self.skeleton, course: &course };
        let Some(clip) = walker.walk() else { return };
        // Feet that a turn of this gait puts too far apart pull the hips down.
        let lowest = |clip: &Clip| clip.root_positions.iter().map(|p| p.y).fold(f32::MAX, f32::min);
        if lowest(&clip) < lowest(&gait.clip).min(lowest(&stance.clip)) - MOST_SUNK_M {
            return;
        }
        // What is neither the gait's pose nor the stance's is made.
        let is_captured = |f: &usize| {
            let wanted = &clip.frame_rotations(*f)[1..];
            [(&gait.clip, course.gait_at[*f]), (&stance.clip, course.stance_at[*f])].iter().any(|(of, g)| {
                of.frame_rotations(*g)[1..].iter().zip(wanted).all(|(a, b)| a.angle_between(*b) < SAME_RAD)
            })
        };
        let made = (0..clip.num_frames()).filter(|f| !is_captured(f));
        let (from, to) = made.fold((clip.num_frames(), 0), |(from, to), f| (from.min(f), to.max(f + 1)));
        let report = &mut self.made.report;
        *match what {
            MadeMove::Start(_) => &mut report.starts,
            MadeMove::Stop => &mut report.stops,
            MadeMove::Turn(..) => &mut report.turns,
            MadeMove::Arc(..) => &mut report.arcs,
            MadeMove::Pivot(_) => &mut report.pivots,
            MadeMove::Step(..) => &mut report.steps,
        } += 1;
        self.push(Clip { name: format!("made/{}-{number}", what.name()), ..clip }, from.min(to)..to, &gait.class);
    }

    /// Adds a clip, and its mirrored copy.
    ///
    /// - `made`: its made frames.
    /// - `class`: class of the motion that it is made of.
    fn push(&mut self, clip: Clip, made: std::ops::Range<usize>, class: &MotionClass) {
        let report = &mut self.made.report;
        report.clips += 1;
        report.seconds += made.len() as f64 / clip.rate_hz;
        let [walk, run, idle] = [Gait::Walk, Gait::Run, Gait::Stand].map(|g| class.gait == g);
        let hints = NameHints { walk, run, idle, manner: Some(class.manner.clone()), ..NameHints::default() };
        let classes = classify(&clip, self.skeleton, &hints);
        let clip = Clip { tags: vec![ClipTag { name: MADE_TAG.into(), range: made }], classes, ..clip };
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

/// From 0 to 1, with velocity and acceleration 0 at both ends.
fn smoother(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * t * (10.0 + t * (6.0 * t - 15.0))
}

#[cfg(test)]
mod tests;
