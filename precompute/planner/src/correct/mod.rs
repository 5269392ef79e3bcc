//! Correction of clips: a limb that collides with what is around is planned anew.

#[cfg(test)]
mod tests;

use crate::clips::with_motion;
use crate::collide::Checker;
use crate::planner::{Budget, LimbPlanner, PlanConfig, PlanError, PlanOutcome, Planners};
use crate::problem::{EXTERNAL_STEP_S, LimbState, Problem};
use crate::search::TreeLog;
use crate::setup::{ProblemError, ProblemSpec};
use schemars::JsonSchema;
use serde::Serialize;
use throng_motion::Clip;

/// How clips are corrected.
#[derive(Clone, Copy, Debug)]
pub struct CorrectConfig<'a> {
    /// How plans are made.
    pub plan: PlanConfig,
    /// Limits of the effort for each plan; its rate is the clip's.
    pub budget: Budget<'a>,
    /// Time before and after a collision in which the limb gives way (s, > 0).
    pub margin_s: f64,
    /// Largest margin: it grows by half where no path is found (s, >= margin_s).
    pub margin_most_s: f64,
    /// Stretch of the clip that is searched for collisions, and in which the limb may give way; the whole clip where `None`
    /// (s).
    pub search_window_s: Option<[f64; 2]>,
    /// Keeps the trees of every search, for inspection.
    pub trees: Option<&'a TreeLog>,
    /// Continues with the trees of the last run.
    pub planners: Option<&'a Planners>,
}

impl Default for CorrectConfig<'_> {
    fn default() -> Self {
        let (plan, budget) = (PlanConfig::default(), Budget { draws: 3000, ..Budget::default() });
        let (search_window_s, trees, planners) = (None, None, None);
        Self { plan, budget, margin_s: 0.4, margin_most_s: 2.0, search_window_s, trees, planners }
    }
}

impl CorrectConfig<'_> {
    /// Plans, and keeps trees and planner where the configuration asks for it.
    pub(crate) fn run(&self, planner: &mut LimbPlanner, problem: &Problem, rate_hz: f64) -> PlanOutcome {
        let mut budget = Budget { rate_hz, ..self.budget };
        if let Some(last) = self.planners.and_then(|p| p.take_planner(problem)) {
            (*planner, budget.warm) = (last, true);
        }
        let outcome = planner.plan(problem, &self.plan, &budget);
        self.trees.iter().for_each(|trees| trees.keep(problem, planner));
        self.planners.iter().for_each(|planners| planners.keep_planner(problem, planner));
        outcome
    }
}

/// Reason why a stretch stays as it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CorrectionError {
    /// The problem is invalid, has no free pose to plan from, or a planted foot is in the obstacle.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// No plan was found.
    #[error("from {from_s:.2} s to {to_s:.2} s: {why}")]
    Unsolved {
        /// (s)
        from_s: f64,
        /// (s)
        to_s: f64,
        /// Reason of the failure.
        why: PlanError,
    },
}

/// A stretch in which a clip collides, and the result of its correction.
#[derive(Clone, Debug, PartialEq)]
pub struct CorrectedSpan {
    /// Stretch in which the clip collides.
    pub span: CollisionStretch,
    /// Window that was planned anew (s).
    pub window_s: [f64; 2],
    /// The plan, or the reason why there is none.
    pub outcome: Result<PlanOutcome, CorrectionError>,
    /// Stretches of that window in which the rest of the body collides by itself: the limb gave way, but no plan of it helps
    /// there.
    pub driven: Vec<CollisionStretch>,
}

/// Corrects one limb of a clip: finds its collisions, widens each stretch until both ends are free, and plans it in time
/// with the rest of the motion.
///
/// The clip begins at time 0 of what is around. Frames outside of the windows and other joints stay as they are, to the bit.
///
/// - `spec`: the surroundings; its motion is the clip's, its ends are not used.
/// - returns the clip, and every stretch with its result; those that failed are unchanged. Where the rest of the body collides
///   by itself, the limb gives way all the same, and the stretch says so.
///
/// # Errors
/// [`ProblemError`] where the problem is invalid.
///
/// # Source
/// Shapiro, Kallmann and Faloutsos 2007, section 6.1.
pub fn correct_clip(
    clip: &Clip,
    spec: &ProblemSpec<'_>,
    config: &CorrectConfig<'_>,
) -> Result<(Clip, Vec<CorrectedSpan>), ProblemError> {
    let mut out = clip.clone();
    let last_s = (clip.num_frames().saturating_sub(1)) as f64 / clip.rate_hz;
    let [from_s, to_s] = config.search_window_s.unwrap_or([0.0, last_s]).map(|t| t.clamp(0.0, last_s));
    let whole = Problem::prepare(&spec.between_times([from_s, to_s]))?;
    let mut planner = LimbPlanner::new();
    let mut report = Vec::new();
    let mut free_from_s = from_s;
    for span in find_collisions(&whole) {
        if span.to_s <= free_from_s {
            // The plan before already covers this collision.
            continue;
        }
        let last = (to_s * clip.rate_hz + 1e-6) as usize;
        let checker = Checker::default();
        let mut window = CorrectionWindow { clip, problem: &whole, checker, free_from_s, last };
        let mut margin_s = config.margin_s;
        report.push(loop {
            let found = window.window_around(&span, margin_s).map_err(CorrectionError::from).and_then(|window_s| {
                let spec = ProblemSpec { admit_driven: true, ..spec.between_times(window_s) };
                let problem = Problem::new(&spec)?;
                let outcome = config.run(&mut planner, &problem, clip.rate_hz);
                let (None, Some(motion)) = (outcome.why, planner.motion()) else {
                    let why = outcome.why.unwrap_or(PlanError::Rate);
                    return Err(CorrectionError::Unsolved { from_s: window_s[0], to_s: window_s[1], why });
                };
                out = with_motion(&out, 0.0, spec.limb, &motion)?;
                Ok((window_s, outcome, problem.driven_collisions(&spec)))
            });
            match found {
                Ok((window_s, outcome, driven)) => {
                    free_from_s = window_s[1];
                    break CorrectedSpan { span: span.clone(), window_s, outcome: Ok(outcome), driven };
                }
                Err(_) if margin_s < config.margin_most_s => margin_s = (1.5 * margin_s).min(config.margin_most_s),
                Err(e) => {
                    let window_s = [span.from_s, span.to_s];
                    break CorrectedSpan { window_s, span: span.clone(), outcome: Err(e), driven: Vec::new() };
                }
            }
        });
    }
    Ok((out, report))
}

/// Finds the window in which a limb may give way.
struct CorrectionWindow<'a> {
    clip: &'a Clip,
    problem: &'a Problem,
    checker: Checker,
    /// Time from which the clip may be changed (s).
    free_from_s: f64,
    /// Last frame that may be changed.
    last: usize,
}

impl CorrectionWindow<'_> {
    /// Window from a margin before a collision to a margin behind it, widened to the next frames that are free.
    fn window_around(&mut self, span: &CollisionStretch, margin_s: f64) -> Result<[f64; 2], ProblemError> {
        let rate = self.clip.rate_hz;
        let last = self.last;
        let least = (self.free_from_s * rate - 1e-6).ceil() as usize;
        let (first_hit, last_hit) =
            ((span.from_s * rate).floor() as usize, ((span.to_s * rate).ceil() as usize).min(last));
        let (part, with) = (&span.part, &span.with);
        if let Some(frame) = (first_hit..=last_hit).find(|f| self.is_planted(*f)) {
            let there =
                format!("{part} stands on the ground where it collides with {with} at {:.2} s", frame as f64 / rate);
            return Err(format!("{there}: planted feet never move; move {with}").into());
        }
        let margin = (margin_s * rate).ceil() as usize;
        let end = |end: &str| {
            format!("{part} is in {with} up to the clip's {end}: there is no free pose to plan from; move {with}")
        };
        let wanted = first_hit.saturating_sub(margin).max(least);
        let from = self.free_frame(first_hit, wanted, least).ok_or_else(|| end("start"))?;
        let to = self.free_frame(last_hit, (last_hit + margin).min(last), last).ok_or_else(|| end("end"))?;
        Ok([from, to].map(|f| f as f64 / rate))
    }

    /// Searches outwards from a frame that collides: the wanted frame if it is free and no foot is planted before it, else one
    /// nearby, farther out if need be.
    fn free_frame(&mut self, hit: usize, wanted: usize, most: usize) -> Option<usize> {
        let outwards = |from: usize, to: usize| -> Vec<usize> {
            if to >= from { (from..=to).collect() } else { (to..=from).rev().collect() }
        };
        // Up to and including the frame at which a foot is planted: there the pose stays as it was.
        let mut reach = outwards(hit, most);
        if let Some(planted) = reach.iter().position(|f| self.is_planted(*f)) {
            reach.truncate(planted + 1);
        }
        let mut all = outwards(wanted, most).into_iter().chain(outwards(wanted, hit));
        all.find(|f| reach.contains(f) && *f != hit && self.is_free(*f))
    }

    fn is_free(&mut self, frame: usize) -> bool {
        let time_s = frame as f64 / self.clip.rate_hz;
        let pose = self.problem.external_pose_at(time_s);
        self.checker.deepest_hit(self.problem, &LimbState { pose, time_s }).is_none()
    }

    /// True where the limb is a leg whose foot is planted.
    fn is_planted(&self, frame: usize) -> bool {
        self.problem.chain.limb.is_planted(&self.clip.contacts, frame)
    }
}

/// A stretch of time in which a limb collides by the motion itself. The names of the fields are keys of JSON reports.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CollisionStretch {
    /// Begin (s).
    pub from_s: f64,
    /// End (s).
    pub to_s: f64,
    /// Part of the limb, or held capsule, that is deepest.
    pub part: String,
    /// Obstacle that it is in.
    #[serde(rename = "obstacle")]
    pub with: String,
    /// Largest depth (m).
    pub depth_m: f64,
}

/// Penetration below which rounding alone may explain it (m).
const NEGLIGIBLE_M: f64 = 1e-4;

/// Stretches in which the external motion's own poses of the limb collide, sampled 120 times a second.
pub fn find_collisions(problem: &Problem) -> Vec<CollisionStretch> {
    let mut checker = Checker::default();
    let mut spans: Vec<CollisionStretch> = Vec::new();
    let mut inside = false;
    let [from, to] = [problem.init.time_s, problem.goal.time_s];
    for step in 0..problem.external_poses.len() {
        let time_s = (from + step as f64 * EXTERNAL_STEP_S).min(to);
        let state = LimbState { pose: problem.external_pose_at(time_s), time_s };
        let hit = checker.deepest_hit(problem, &state).filter(|h| h.depth_m > NEGLIGIBLE_M);
        let goes_on = std::mem::replace(&mut inside, hit.is_some());
        let Some(hit) = hit else { continue };
        let ([part, with], depth_m) = (problem.hit_names(&hit), hit.depth_m);
        match spans.last_mut().filter(|_| goes_on) {
            Some(span) if depth_m > span.depth_m => {
                (span.to_s, span.part, span.with, span.depth_m) = (time_s, part, with, depth_m);
            }
            Some(span) => span.to_s = time_s,
            None => spans.push(CollisionStretch { from_s: time_s, to_s: time_s, part, with, depth_m }),
        }
    }
    spans
}
