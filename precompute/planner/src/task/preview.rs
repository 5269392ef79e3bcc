//! Facts about a task before any search: targets within reach, least times, collisions of clips.

use super::stage::{ActorClip, LimbSurroundings, TaskStage};
use super::{ClipMismatch, HandTarget, ObjectGrip, Task, TaskAction, TaskStep, lean, open_edges};
use crate::correct::{CollisionStretch, find_collisions};
use crate::setup::{AllowedContact, ProblemError};
use crate::{collide::Checker, ik::IkError, linkage::LimbPose, problem::Problem, rotation::Rigid};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Serialize, Serializer};
use throng_core::Joint;
use throng_geometry::SolidShape;

/// Facts about one step before any search. The names of the fields are keys of JSON reports.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct StepPreview {
    /// Its name, or its action.
    pub name: String,
    /// Faults that no search can mend, and the way out.
    pub faults: Vec<String>,
    /// Time at which the target is reached; none of corrections (s).
    pub at_s: Option<f64>,
    /// Least time that joints need there and back at their speed limits, for the hand that is there soonest (s).
    pub least_s: Option<[f64; 2]>,
    /// Time that is given (s).
    pub given_s: Option<[f64; 2]>,
    /// Number of hands within reach, within limits and free, and number that grips and turns allow.
    pub reached: Option<[usize; 2]>,
    /// Stretches in which the limb of a correction collides by the clip itself; in JSON their number.
    #[serde(serialize_with = "number")]
    #[schemars(with = "usize")]
    pub collisions: Vec<CollisionStretch>,
}

fn number<S: Serializer>(collisions: &[CollisionStretch], out: S) -> Result<S::Ok, S::Error> {
    collisions.len().serialize(out)
}

/// Facts about a mesh.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct MeshPreview {
    /// Name of the thing that it belongs to.
    #[serde(rename = "object")]
    pub thing: String,
    /// Number of triangles.
    pub triangles: usize,
    /// Number of edges of one triangle only: where there are any, the mesh has no inside.
    pub open_edges: usize,
}

impl Task {
    /// Examines everything that can be known before any search, each step by itself: clips are as given, and changes by earlier
    /// steps do not count.
    ///
    /// # Errors
    /// [`ClipMismatch`].
    pub fn preview_steps(&self, clips: &[ActorClip]) -> Result<Vec<StepPreview>, ClipMismatch> {
        self.check_clips(clips)?;
        let stage = TaskStage::new(self, clips);
        Ok(self.steps.iter().map(|step| preview_step(&stage, step)).collect())
    }

    /// Facts about all meshes.
    pub fn preview_meshes(&self) -> Vec<MeshPreview> {
        let all = self.things.iter().flat_map(|t| t.shapes.iter().map(move |shape| (t.name.clone(), shape)));
        let one = |(thing, shape): (String, &SolidShape)| {
            let SolidShape::Mesh(mesh) = shape else { return None };
            let (triangles, open_edges) = (mesh.corners().len(), open_edges(mesh.corners()));
            Some(MeshPreview { thing, triangles, open_edges })
        };
        all.filter_map(one).collect()
    }
}

fn preview_step(stage: &TaskStage<'_>, step: &TaskStep) -> StepPreview {
    let at_s = (step.action != TaskAction::Correct).then_some(step.times_s[1]);
    let mut out = StepPreview { name: step.name.clone(), at_s, ..StepPreview::default() };
    let end_s = stage.actors[step.character].end_s();
    let [from_s, _, to_s] = step.times_s;
    let done = if step.action == TaskAction::Correct {
        preview_correction(stage, step, &mut out)
    } else if !(from_s >= 0.0 && to_s <= end_s + 1e-6) {
        let why = format!("expected a window within the clip's 0 to {end_s:.2} s, found {from_s:.2} to {to_s:.2} s");
        out.faults.push(why);
        return out;
    } else {
        preview_visit(stage, step, &mut out)
    };
    out.faults.extend(done.err().map(|e| e.to_string()));
    if let Some(second) = &step.second {
        let own = TaskStep { limb: second.limb, grips: second.grips.clone(), second: None, ..step.clone() };
        let limb = second.limb.words();
        out.faults.extend(preview_step(stage, &own).faults.into_iter().map(|why| format!("{limb}: {why}")));
    }
    out
}

fn preview_correction(stage: &TaskStage<'_>, step: &TaskStep, out: &mut StepPreview) -> Result<(), ProblemError> {
    let actor = &stage.actors[step.character];
    let window_s = [step.times_s[0].max(0.0), step.times_s[2].min(actor.end_s())];
    let around = stage.surroundings_of_limb(step.character, step.limb, window_s);
    let others = stage.other_bodies(step.character);
    let spec = stage.limb_spec(step.character, step.limb, &around, &others).between_times(window_s);
    let problem = Problem::prepare(&spec)?;
    out.collisions = find_collisions(&problem);
    for s in problem.driven_collisions(&spec) {
        let CollisionStretch { from_s, to_s, part, with, depth_m } = s;
        if out.collisions.iter().any(|c| c.from_s < to_s && c.to_s > from_s) {
            out.faults.push(format!(
                "{part} itself is {depth_m:.3} m too near {with} from {from_s:.2} s to {to_s:.2} s, as {} is: no motion of the \
                 limb helps it",
                step.limb.name()
            ));
        }
    }
    for CollisionStretch { from_s, to_s, part, with, .. } in &out.collisions {
        let [from, to] = [from_s, to_s].map(|t| (t * actor.clip.rate_hz).round() as usize);
        if let Some(frame) = (from..=to).find(|f| step.limb.is_planted(&actor.clip.contacts, *f)) {
            let t = frame as f64 / actor.clip.rate_hz;
            let why = format!("{part} stands on the ground at {t:.2} s, in {with}: planted feet never move");
            out.faults.push(why);
        }
    }
    Ok(())
}

fn preview_visit(stage: &TaskStage<'_>, step: &TaskStep, out: &mut StepPreview) -> Result<(), ProblemError> {
    let (who, [from_s, at_s, to_s]) = (step.character, step.times_s);
    let around = surroundings_at_target(stage, step, at_s);
    let problem = stage.limb_problem(who, step.limb, &around, [from_s, to_s])?;
    let (all, nearest) = reachable_poses(stage, step, &problem, at_s);
    let hands = all.len();
    let poses: Vec<LimbPose> = all.into_iter().flatten().collect();
    out.reached = Some([poses.len(), hands]);
    out.given_s = Some([at_s - from_s, to_s - at_s - step.hold_s]);
    let ends = [problem.init.pose, problem.goal.pose];
    let needs = poses.iter().map(|p| ends.map(|end| problem.least_time(&end, p)));
    let leans = stage.task.lean && step.limb.is_arm();
    let soonest = needs.min_by(|a, b| (a[0].0 + a[1].0).total_cmp(&(b[0].0 + b[1].0)));
    match (soonest, nearest) {
        (Some(least), _) => {
            out.least_s = Some(least.map(|l| l.0));
            for ((least_s, joint), given_s) in least.into_iter().zip(out.given_s.unwrap_or_default()) {
                if least_s > given_s {
                    let joint = joint.name();
                    out.faults.push(format!(
                        "{joint} needs at least {least_s:.3} s at its speed limit, but has {given_s:.3} s; give more time"
                    ));
                }
            }
        }
        // Up to this distance, a bend of the trunk may help.
        (None, Some(IkError::OutOfReach { by_m })) if leans && by_m <= lean::MOST_M => {}
        (None, Some(why)) => out.faults.push(format!("not reached at {at_s:.2} s: {why}")),
        (None, None) => {}
    }
    // Part and obstacle of collisions of the clip's poses at both ends.
    let mut checker = Checker::default();
    let hits = [&problem.init, &problem.goal].map(|state| checker.deepest_hit(&problem, state));
    let mut deep: Vec<[String; 2]> = hits.iter().flatten().map(|hit| problem.hit_names(hit)).collect();
    deep.dedup();
    for [part, with] in deep {
        out.faults.push(format!(
            "{part} is in {with} where the window begins or ends; begin earlier, end later, or correct first"
        ));
    }
    Ok(())
}

/// Place of a step's object, or the place to which it is brought.
pub(super) fn object_target(stage: &TaskStage<'_>, step: &TaskStep, time_s: f64) -> Rigid {
    match (&step.to, step.object) {
        (Some(to), _) => stage.resolve_place(to, time_s)[0],
        (None, Some(object)) => stage.thing_place(object, time_s),
        (None, None) => Rigid::IDENTITY,
    }
}

/// Grips of a step; for an object that is brought, the one with which it was taken, without its turn, which is not known
/// before.
pub(super) fn grips_of(task: &Task, step: &TaskStep) -> Vec<ObjectGrip> {
    if !step.action.needs_held_object() {
        return step.grips.clone();
    }
    let taken = task.steps.iter().filter(|s| s.object == step.object && s.limb == step.limb);
    let at = taken.flat_map(|s| &s.grips).next().map_or(DVec3::ZERO, |g| match g {
        ObjectGrip::Any(at) => *at,
        ObjectGrip::Turned(wrist) => wrist.position,
    });
    vec![ObjectGrip::Any(at)]
}

/// Surroundings of a limb at its target: the hand may touch the object that it takes, and an object that is brought is in the
/// hand.
pub(super) fn surroundings_at_target(stage: &TaskStage<'_>, step: &TaskStep, at_s: f64) -> LimbSurroundings {
    let mut around = stage.surroundings_of_limb(step.character, step.limb, [at_s, at_s]);
    if let Some(name) = step.object.map(|o| stage.task.things[o].name.clone()) {
        around.allowed.retain(|a| a.other != name && a.part.as_ref() != Some(&name));
        if step.action.needs_held_object() {
            around.solids.retain(|s| s.name != name);
            around.held.retain(|h| h.name != name);
        } else {
            around.allowed.extend(allowed_touches(step, &name));
        }
    }
    around.allowed.extend(step.contacts.iter().flat_map(|c| allowed_touches(step, c)));
    around
}

/// Allowances for hand and fingers, or foot and toes, to touch something.
fn allowed_touches<'a>(step: &'a TaskStep, with: &'a str) -> impl Iterator<Item = AllowedContact> + 'a {
    let limb = step.limb;
    let ends = Joint::ALL.into_iter().filter(move |j| limb.moves_joint(*j) && !limb.joints()[..2].contains(j));
    ends.map(|j| AllowedContact { part: Some(j.name().into()), other: with.into(), window_s: None })
}

/// The pose that reaches each of some hands, `None` where there is none; and the nearest failure.
type HandPoses = (Vec<Option<LimbPose>>, Option<IkError<String>>);

/// Poses of the hands that a step's grips allow.
pub(super) fn reachable_poses(stage: &TaskStage<'_>, step: &TaskStep, problem: &Problem, at_s: f64) -> HandPoses {
    let target = object_target(stage, step, at_s);
    let grips = grips_of(stage.task, step);
    solve_hands(problem, &stage.actors[step.character].hand_targets(step.limb, &grips, &target, at_s), at_s)
}

/// Poses of some hands.
pub(super) fn solve_hands(problem: &Problem, hands: &[HandTarget], at_s: f64) -> HandPoses {
    let (mut checker, present) = (Checker::default(), problem.external_pose_at(at_s));
    let mut nearest = None;
    let poses = hands.iter().map(|goal| {
        let found = problem.solve_reach(&mut checker, &goal.hand, at_s, &present);
        found.map_err(|why| IkError::keep_nearest(&mut nearest, why)).ok()
    });
    (poses.collect(), nearest)
}
