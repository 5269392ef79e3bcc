//! Climbing stairs and a ladder and sliding in a gym of known geometry.
//!
//! From intention to pose: `plan` deals rounds through the gym (`gym`), `route` walks them with the steps of the `walk`
//! rig, including stairs; `ladder` and `descend` (down a `course`) begin and end in a stand, with the body of `body`;
//! `moment` blends one motion into the next.

mod body;
mod course;
mod gym;
mod ladder;
mod moment;
mod plan;
mod route;
mod slide;

use super::frame::{self, Samples};
use super::{SynthConfig, foot::FootShape, walk::assemble::ClipSignals, walk::footsteps};
use moment::{BodyMoment, crossfade};
use plan::{GymVisitor, VisitLeg};
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use route::WalkRoute;
use throng_base::thresholds::STANDING_MPS_F64;
use throng_core::{Contacts, Skeleton};
use throng_motion::clip::{Clip, ClipSet, ClipTag, runs_where};

/// Time over which one motion is blended into the next (s).
const OVERLAP: f64 = 0.4;
/// Shortest stand that gets a tag (s).
const STAND: f64 = 0.6;

/// Makes the `playground` set: walking on the ground and on decks, stairs up and down, climbing a ladder up and down,
/// sitting down at the top of straight and curved slides, sliding, and getting up, in the coordinates of
/// `data/environments/playground.toml`, on the default skeleton, with the true contacts and supports.
///
/// - returns clips `playground_00`, `playground_01`, ... that begin and end standing, tagged `stairs`, `climb`, `sit`,
///   `descend` and `stand`.
pub fn playground(cfg: &SynthConfig) -> ClipSet {
    let skeleton = Skeleton::default();
    let mut rng = Pcg64Mcg::seed_from_u64(cfg.seed);
    let mut visitor = GymVisitor::new(cfg.variation);
    let (mut clips, mut seconds) = (Vec::new(), 0.0);
    while seconds < cfg.minutes * 60.0 {
        let wanted = (cfg.minutes * 60.0 - seconds).min(cfg.clip_seconds);
        let legs = visitor.visit(wanted, &mut rng);
        let name = format!("playground_{:02}", clips.len());
        let clip = perform_legs(name, &legs, &skeleton, cfg, &mut rng);
        seconds += clip.num_frames() as f64 / cfg.rate_hz;
        clips.push(clip);
    }
    ClipSet { skeleton, clips }
}

/// Makes a clip of the legs of a visit.
fn perform_legs(name: String, legs: &[VisitLeg], skeleton: &Skeleton, cfg: &SynthConfig, rng: &mut impl Rng) -> Clip {
    let grid = Samples::for_clip(1.0, cfg.rate_hz);
    let walks: Vec<_> = legs.iter().map(|leg| walk_leg(leg, skeleton, cfg, rng)).collect();
    let mut moments: Vec<BodyMoment> = Vec::new();
    let mut marks = Vec::new();
    for (i, leg) in legs.iter().enumerate() {
        let overlap = if i == 0 { 0 } else { grid.count_within(OVERLAP) };
        let begin = moments.len().saturating_sub(overlap) as f64 * grid.dt;
        let act = || act_moments(leg, [&walks[i - 1], &walks[i + 1]], skeleton, grid.dt, rng);
        let (next, spans) = walks[i].clone().unwrap_or_else(act);
        marks.extend(spans.into_iter().map(|(name, from, to)| (name, begin + from, begin + to)));
        crossfade(&mut moments, next, overlap);
    }
    let mut clip = frame::empty_clip(name, "playground", cfg);
    let mut support = 0.0;
    for moment in moments.iter().step_by(grid.per_frame) {
        frame::push_pose(&mut clip, &moment.body, moment.hand_contacts, skeleton);
        support = moment.support().unwrap_or(support);
        clip.support.push(support as f32);
    }
    clip.tags = standing_tags(&clip);
    frame::add_tags(&mut clip, marks);
    clip
}

/// Moments of a leg, and the spans of its tags: name, begin and end (s).
type LegMoments = (Vec<BodyMoment>, Vec<(&'static str, f64, f64)>);

/// Moments of a leg, if it is a walk.
fn walk_leg(leg: &VisitLeg, skeleton: &Skeleton, cfg: &SynthConfig, rng: &mut impl Rng) -> Option<LegMoments> {
    let VisitLeg::Walk(route) = leg else { return None };
    let shape = FootShape::from_skeleton(skeleton);
    let last = rng.random_range(0.9..1.7);
    let steps = footsteps::place_footsteps(shape, route.start, &route.walk.steps, last, gym::ground, rng);
    // Whole tenths of a second, so that the next motion begins at the same time at every rate.
    let samples = Samples::for_clip((10.0 * steps.duration).floor() / 10.0 + 1e-6, cfg.rate_hz);
    let signals = ClipSignals::new(&steps, skeleton, &samples, cfg.variation, rng, |_, _| {}, |_| {});
    Some(((0..samples.times.len()).map(|i| BodyMoment::upright(signals.pose(i))).collect(), stair_spans(route)))
}

/// Times of a walk on stairs, with their tag (s).
fn stair_spans(route: &WalkRoute) -> Vec<(&'static str, f64, f64)> {
    let mut times = Vec::with_capacity(route.walk.steps.len());
    let mut last = 0.0;
    for step in &route.walk.steps {
        let (lift, land) = footsteps::timing(step, last);
        times.push((lift, land));
        last = land;
    }
    route.stairs.iter().map(|r| ("stairs", times[r.start].0, times[r.end - 1].1)).collect()
}

/// Moments of a leg other than a walk, between two walks.
fn act_moments(
    leg: &VisitLeg,
    ends: [&Option<LegMoments>; 2],
    skeleton: &Skeleton,
    dt: f64,
    rng: &mut impl Rng,
) -> LegMoments {
    let [Some((before, _)), Some((after, _))] = ends else { return LegMoments::default() };
    let (Some(from), Some(to)) = (before.last(), after.first()) else { return LegMoments::default() };
    let moments = match leg {
        VisitLeg::Walk(_) => return LegMoments::default(),
        VisitLeg::ClimbUp => ladder::climb(&from.body, &to.body, skeleton, dt, rng),
        // Climbing down is climbing up in reverse.
        VisitLeg::ClimbDown => ladder::climb(&to.body, &from.body, skeleton, dt, rng).into_iter().rev().collect(),
        VisitLeg::Slide(course) => return slide::descend(course, [&from.body, &to.body], skeleton, dt, rng),
    };
    let end = moments.len() as f64 * dt - OVERLAP;
    (moments, vec![("climb", OVERLAP, end)])
}

/// Tags of stretches at rest on both feet.
fn standing_tags(clip: &Clip) -> Vec<ClipTag> {
    let feet = Contacts(Contacts::LEFT.0 | Contacts::RIGHT.0);
    let still = |f: usize| {
        let (a, b) = (clip.root_positions[f.saturating_sub(1)], clip.root_positions[f]);
        clip.contacts[f] == feet && f64::from(a.distance(b)) * clip.rate_hz < STANDING_MPS_F64
    };
    let least = (STAND * clip.rate_hz) as usize;
    let long = runs_where(0..clip.num_frames(), still).into_iter().filter(|r| r.len() >= least);
    long.map(|range| ClipTag { name: "stand".into(), range }).collect()
}

#[cfg(test)]
mod tests;
