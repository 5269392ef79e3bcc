//! Standing places from which a limb reaches its target.

use super::gait::{WalkRecording, heading_of};
use super::route::RouteObstacles;
use crate::driven::{DrivenMotion, place_joints};
use crate::rotation::{Rigid, rotation_about, wrap_angle};
use crate::task::lean::{BendingTrunk, RootPose, SPARE_M};
use crate::task::preview::{object_target, reachable_poses, surroundings_at_target};
use crate::task::stage::{TaskStage, ThingPlacement};
use crate::{ik::IkError, linkage::Limb, problem::Problem, task::step::TaskStep};
use glam::{DQuat, DVec2, DVec3};
use std::f64::consts::TAU;
use throng_base::thresholds::BODY_RADIUS_M;
use throng_core::{Joint, NUM_JOINTS};
use throng_geometry::SolidShape;

/// Best distance from the target, step of distances, and number of steps to either side (m).
const BEST_M: f64 = 0.5;
const STEP_M: f64 = 0.05;
const NUM_RINGS: i32 = 8;
/// Number of directions around the target.
const NUM_SIDES: u32 = 20;
/// Turns past the target, so that the shoulder is nearer to it (rad).
const ASIDE: [f64; 3] = [0.35, 0.0, 0.8];
/// Costs: of a turn at the place (m/rad), of a distance off the best one (1), of a turn past the target (m/rad).
const TURN_M: f64 = 0.4;
const RING_M: f64 = 1.5;
const ASIDE_M: f64 = 0.3;
/// Least distance of a standing body, and of its arms, from everything (m).
const CLEAR_M: f64 = 0.04;
const ARM_M: f64 = 0.01;
/// Distance by which a character that brings something stands nearer than needed (m).
const BRING_M: f64 = 0.05;
/// Least distance of the body while a limb is planned, and tolerated depth at other times (m).
const WALK_M: f64 = 0.004;
const PRESS_M: f64 = 0.02;
/// Guess of the time for turns at the beginning and at the end, and for coming to a stand (s).
const AROUND_S: f64 = 2.0;

/// A standing place.
#[derive(Clone, Copy, Debug)]
pub(super) struct StandingPlace {
    /// Position, x and z (m).
    pub position: DVec2,
    /// Heading (rad).
    pub heading: f64,
    /// Approximate time at which the target is reached from there (s).
    pub at_s: f64,
    cost: f64,
}

/// Search for standing places of a step.
pub(super) struct StandSearch<'a> {
    stage: TaskStage<'a>,
    step: &'a TaskStep,
    /// Position and heading of the character now.
    from: (DVec2, f64),
    now_s: f64,
    /// Pose in which it stands.
    pose: (DVec3, [DQuat; NUM_JOINTS]),
    nearest: Option<IkError<String>>,
    /// True where the trunk may bend.
    pub leans: bool,
    /// Obstacle on the path to a place that would otherwise do.
    met: Option<String>,
}

impl<'a> StandSearch<'a> {
    /// - `stage`: with the clip so far of the walking character.
    pub fn new(stage: TaskStage<'a>, step: &'a TaskStep, gait: &WalkRecording) -> Self {
        let (from, now_s, pose) = (gait.place(), gait.time_s(), gait.pose());
        Self { stage, step, from, now_s, pose, nearest: None, leans: false, met: None }
    }

    /// Place of the object, or the place to which it is brought.
    pub fn target(&self, time_s: f64) -> Rigid {
        object_target(&self.stage, self.step, time_s)
    }

    /// Candidate places, the best first: where the character stands already, then around the target.
    pub fn candidate_places(&self, speed_mps: f64) -> Vec<StandingPlace> {
        let (from, heading) = self.from;
        let soon_s = self.now_s + 1.0;
        let mut all = vec![StandingPlace { position: from, heading, at_s: soon_s, cost: f64::NEG_INFINITY }];
        let flat = |p: DVec3| DVec2::new(p.x, p.z);
        // Transform of the target by the time the character is there.
        let distance = flat(self.target(soon_s).position).distance(from);
        let at_s = self.now_s + distance / speed_mps + AROUND_S;
        let target = flat(self.target(at_s).position);
        // A right arm is nearer to what is to the right: the character faces to the left of it.
        let side = if self.step.limb.joints()[0].name().starts_with("left") { -1.0 } else { 1.0 };
        for ring in -NUM_RINGS..=NUM_RINGS {
            let radius = BEST_M + STEP_M * f64::from(ring);
            if radius < 0.1 {
                continue;
            }
            for k in 0..NUM_SIDES {
                let angle = TAU * f64::from(k) / f64::from(NUM_SIDES);
                let at = target + radius * DVec2::new(angle.sin(), angle.cos());
                let travel = heading_of(at - from);
                for aside in ASIDE {
                    let heading = wrap_angle(heading_of(target - at) + side * aside);
                    let price = from.distance(at)
                        + TURN_M * wrap_angle(heading - travel).abs()
                        + RING_M * (radius - BEST_M).abs()
                        + ASIDE_M * (aside - ASIDE[0]).abs();
                    all.push(StandingPlace { position: at, heading, at_s, cost: price });
                }
            }
        }
        all.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        all
    }

    /// Position of the hips and rotations of a character that stands there.
    pub fn pose_at(&self, stand: &StandingPlace) -> (DVec3, [DQuat; NUM_JOINTS]) {
        let (root, mut turns) = self.pose;
        let (from, heading) = self.from;
        let turn = rotation_about(DVec3::Y, stand.heading - heading);
        let ground = |p: DVec2| DVec3::new(p.x, 0.0, p.y);
        turns[0] = (turn * turns[0]).normalize();
        (ground(stand.position) + turn * (root - ground(from)), turns)
    }

    /// True where a body that stands there collides with nothing.
    pub fn is_free(&self, stand: &StandingPlace) -> bool {
        let actor = &self.stage.actors[self.step.character];
        let (root, turns) = self.pose_at(stand);
        let places = place_joints(&actor.skeleton, root, &turns);
        let solids = self.solids_at(stand.at_s);
        actor.shape.capsules.iter().all(|c| {
            let core = c.core.map(|p| places[c.joint.index()].transform_point(p));
            let is_limb = Limb::ALL.iter().any(|l| l.is_arm() && l.moves_joint(c.joint));
            let room = if is_limb { ARM_M } else { CLEAR_M };
            solids.iter().all(|(_, shape, at)| !shape.is_nearer(&core.map(|p| at.local_point(p)), c.radius + room))
        })
    }

    /// Obstacles on the ground until the character is there.
    pub fn route_obstacles(&self, stand: &StandingPlace) -> RouteObstacles {
        let both = [self.now_s, stand.at_s].map(|t| self.solids_at(t).into_iter().map(|(_, shape, at)| (shape, at)));
        let mut ground = RouteObstacles { things: both.into_iter().flatten().collect(), discs: Vec::new() };
        let others = self.stage.actors.iter().enumerate().filter(|(i, _)| *i != self.step.character);
        for (_, other) in others {
            let steps = ((stand.at_s - self.now_s) / 0.5).ceil() as usize;
            for k in 0..=steps {
                let at = other.joint_place(Joint::Hips, self.now_s + 0.5 * k as f64).position;
                ground.discs.push((DVec2::new(at.x, at.z), f64::from(BODY_RADIUS_M)));
            }
        }
        ground
    }

    /// True where the walking body collided with nothing on the way, frame by frame, but for limbs that have steps of their
    /// own, and arms while nothing is planned.
    ///
    /// - `window_s`: window in which the limb is planned.
    pub fn is_walk_free(&mut self, walked: &WalkRecording, window_s: [f64; 2]) -> bool {
        let actor = &self.stage.actors[self.step.character];
        let steps = self.stage.task.steps.iter().filter(|s| s.character == self.step.character);
        let limbs: Vec<Limb> = steps.map(|s| s.limb).collect();
        let is_arm = |j: Joint| Limb::ALL.iter().any(|l| l.is_arm() && l.moves_joint(j));
        for (time_s, (root, turns)) in walked.frames_after(self.now_s) {
            let places = place_joints(&actor.skeleton, root, &turns);
            let is_planned = (window_s[0]..=window_s[1]).contains(&time_s);
            let room = if is_planned { WALK_M } else { -PRESS_M };
            // Arms that swing into something on the way are corrected by steps of their own.
            let counts = |j: Joint| !limbs.iter().any(|l| l.moves_joint(j)) && (is_planned || !is_arm(j));
            for c in actor.shape.capsules.iter().filter(|c| counts(c.joint)) {
                let core = c.core.map(|p| places[c.joint.index()].transform_point(p));
                let meets = |(_, shape, at): &&(String, SolidShape, Rigid)| {
                    shape.is_nearer(&core.map(|p| at.local_point(p)), c.radius + room)
                };
                if let Some((with, ..)) = self.solids_at(time_s).iter().find(meets) {
                    let limb = Limb::ALL.iter().find(|l| l.is_arm() && l.moves_joint(c.joint));
                    let out =
                        limb.map(|l| format!(" (a task `correct` of {} mends that)", l.name())).unwrap_or_default();
                    self.met = Some(format!("{} meets {with} on the way{out}", c.joint.name()));
                    return false;
                }
            }
        }
        true
    }

    /// Shapes of everything but the object that is taken or brought, and things that hands carry.
    fn solids_at(&self, time_s: f64) -> Vec<(String, SolidShape, Rigid)> {
        let is_carried = |i: usize| matches!(self.stage.placement_at(i, time_s), ThingPlacement::OnJoint { .. });
        let things = self.stage.task.things.iter().enumerate();
        let there = things.filter(|(i, t)| !(is_carried(*i) || t.is_object && Some(*i) == self.step.object));
        let placed = there.flat_map(|(i, thing)| {
            let at = self.stage.thing_place(i, time_s);
            thing.shapes.iter().map(move |s| (thing.name.clone(), s.clone(), at))
        });
        placed.collect()
    }

    /// True where the limb reaches its target from a pose, within limits and free: hips and rotations. An object to be brought has to be reachable from a
    /// little farther away, too, as its place in the hand is not known yet.
    pub fn is_reached_at(&mut self, (root, turns): (DVec3, [DQuat; NUM_JOINTS]), at_s: f64) -> bool {
        let away = (root - self.target(at_s).position).with_y(0.0).normalize_or_zero();
        let is_near = !self.step.action.needs_held_object() || self.is_reached_by((root + BRING_M * away, turns), at_s);
        is_near && self.is_reached_by((root, turns), at_s)
    }

    fn is_reached_by(&mut self, (root, turns): (DVec3, [DQuat; NUM_JOINTS]), at_s: f64) -> bool {
        let who = self.step.character;
        let actor = &mut self.stage.actors[who];
        actor.motion = DrivenMotion::from_pose(&actor.skeleton, root, turns);
        let around = surroundings_at_target(&self.stage, self.step, at_s);
        let others = self.stage.other_capsules(who, |_| true);
        let spec = self.stage.limb_spec(who, self.step.limb, &around, &others);
        let Ok(problem) = Problem::prepare(&spec) else { return false };
        let (poses, nearest) = reachable_poses(&self.stage, self.step, &problem, at_s);
        let by_m = if let Some(IkError::OutOfReach { by_m }) = &nearest { Some(*by_m) } else { None };
        let is_reached = poses.iter().any(Option::is_some);
        if let (true, Some(by_m), false) = (self.leans, by_m, is_reached) {
            return self.is_reached_leaning((root, turns), at_s, by_m);
        }
        if let Some(why) = nearest {
            IkError::keep_nearest(&mut self.nearest, why);
        }
        is_reached
    }

    /// True where the target is reached from a pose with a bend of the trunk.
    fn is_reached_leaning(&mut self, pose: RootPose, at_s: f64, by_m: f64) -> bool {
        let (actor, at) = (&self.stage.actors[self.step.character], self.target(at_s).position);
        let trunk =
            BendingTrunk { skeleton: &actor.skeleton, limits: &actor.limits, balances: self.stage.task.balance };
        let shoulder = self.step.limb.joints()[0];
        let far_m = place_joints(&actor.skeleton, pose.0, &pose.1)[shoulder.index()].position.distance(at) - by_m;
        let bend = trunk.least_bend(&pose, shoulder, at, far_m - SPARE_M[0]);
        let bent = bend.and_then(|bend| trunk.bent_pose(&pose, &bend, 1.0));
        self.leans = false;
        let is_reached = bent.is_some_and(|bent| self.is_reached_by(bent, at_s));
        self.leans = true;
        is_reached
    }

    /// Reason why there is no place.
    pub fn failure_reason(&self) -> String {
        let nearest = self.nearest.as_ref().map_or("everywhere something is in the way".into(), ToString::to_string);
        match &self.met {
            Some(met) => {
                format!("no way leads to a place to stand from which it is reached: {met}; give more room, or move it")
            }
            None => format!(
                "there is no place to stand from which it is reached, or no way there: at best {nearest}; give more room, more \
                 grips or another limb"
            ),
        }
    }
}
