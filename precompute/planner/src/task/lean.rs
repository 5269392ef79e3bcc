//! Bending of the trunk where an arm cannot reach otherwise; hips move with it, so that the weight stays over the feet.

use super::{StepFailure, TaskStage, TaskStep, TrunkLean, object_target};
use crate::ik::{LimbIk, Swivel};
use crate::linkage::{Chain, Limb, LimbPose};
use crate::rotation::{Rigid, angle_between, rotation_about};
use crate::{balance::centre_of_mass, driven::place_joints, limits::BodyLimits, refuse, smooth::smoothstep};
use glam::{DQuat, DVec3};
use throng_core::{Contacts, Joint, NUM_JOINTS, Skeleton};

/// Joints that bend, from the hips up.
pub(super) const SPINE: [Joint; 3] = [Joint::Spine, Joint::Chest, Joint::UpperChest];
/// Joints that turn back, so that arms hang and faces stay up, with the share of the bend that each keeps.
const BACK: [(Joint, f64); 3] = [(Joint::Neck, 0.5), (Joint::LeftUpperArm, 0.0), (Joint::RightUpperArm, 0.0)];
/// Joints that move with the hips, beside them.
pub(super) const LEGS: [Joint; 6] =
    [Joint::LeftThigh, Joint::LeftShin, Joint::LeftFoot, Joint::RightThigh, Joint::RightShin, Joint::RightFoot];
/// Largest bend (rad), and largest distance by which bending helps (m).
const MOST_RAD: f64 = 1.4;
/// Share of the bend that the hips take, where they move.
const HIPS: f64 = 0.4;
pub(super) const MOST_M: f64 = 0.5;
/// Step of the bends that are tried (rad).
const STEP_RAD: f64 = 0.02;
/// Distance by which the shoulder comes nearer than needed, one try after the other (m).
pub(super) const SPARE_M: [f64; 3] = [0.04, 0.1, 0.18];
/// Largest motion of the hips, largest lowering by bent knees, and its step (m).
const HIPS_M: f64 = 0.16;
const LOWER_M: f64 = 0.1;
const LOWER_STEP_M: f64 = 0.01;

/// Position of the hips, and rotations of all joints.
pub(super) type RootPose = (DVec3, [DQuat; NUM_JOINTS]);

/// A bend of the trunk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bend {
    /// Axis in the frame of the hips (unit).
    axis: DVec3,
    /// Angle of the upper chest (rad).
    angle: f64,
    /// Share of the angle that the hips take.
    hips: f64,
    /// Lowering by bent knees (m).
    lower_m: f64,
}

/// A character that bends.
#[derive(Clone, Copy)]
pub(super) struct BendingTrunk<'a> {
    pub skeleton: &'a Skeleton,
    pub limits: &'a BodyLimits,
    /// True keeps the weight where it was: both feet are planted.
    pub balances: bool,
}

impl BendingTrunk<'_> {
    /// The least bend that brings a shoulder within a distance of a target.
    pub fn least_bend(&self, pose: &RootPose, shoulder: Joint, target: DVec3, far_m: f64) -> Option<Bend> {
        let places = place_joints(self.skeleton, pose.0, &pose.1);
        let (pivot, from) = (places[Joint::Spine.index()].position, places[shoulder.index()].position);
        let across = (from - pivot).cross(target - from).try_normalize()?;
        let axis = pose.1[0].inverse() * across;
        let limit = |j: Joint| self.limits.joints[j.index()];
        let mut angle = STEP_RAD;
        while angle <= MOST_RAD {
            let mut bend = Bend { axis, angle, hips: if self.balances { HIPS } else { 0.0 }, lower_m: 0.0 };
            let bent = bent_rotations(&pose.1, &bend, 1.0);
            let is_within = SPINE.into_iter().all(|j| {
                let [a, b] = [pose.1[j.index()], bent[j.index()]];
                limit(j).is_none_or(|l| l.excess(b) <= l.excess(a).max(0.0) + 1e-6)
            });
            if !is_within {
                return None;
            }
            while bend.lower_m <= LOWER_M {
                if let Some((root, turns)) = self.bent_pose(pose, &bend, 1.0) {
                    let at = place_joints(self.skeleton, root, &turns)[shoulder.index()].position;
                    if at.distance(target) <= far_m {
                        return Some(bend);
                    }
                    break;
                }
                bend.lower_m += LOWER_STEP_M;
            }
            angle += STEP_RAD;
        }
        None
    }

    /// A pose with a share of a bend; `None` where legs do not reach the ground then.
    pub fn bent_pose(&self, pose: &RootPose, bend: &Bend, share: f64) -> Option<RootPose> {
        let turns = bent_rotations(&pose.1, bend, share);
        if !self.balances {
            return Some((pose.0, turns));
        }
        let before = place_joints(self.skeleton, pose.0, &pose.1);
        let weight = centre_of_mass(&before);
        let mut out = (pose.0 - DVec3::Y * bend.lower_m * share, turns);
        for _ in 0..4 {
            out = self.place_feet(out, &before)?;
            let off = (weight - centre_of_mass(&place_joints(self.skeleton, out.0, &out.1))).with_y(0.0);
            out.0 += off;
        }
        if (out.0 - pose.0).with_y(0.0).length() > HIPS_M { None } else { self.place_feet(out, &before) }
    }

    /// Moves the legs so that feet stay where they were.
    fn place_feet(&self, (root, mut turns): RootPose, before: &[Rigid; NUM_JOINTS]) -> Option<RootPose> {
        for limb in [Limb::LeftLeg, Limb::RightLeg] {
            let joints = limb.joints();
            let limits = self.limits.limb_limits(limb)?;
            let present = LimbPose(joints.map(|j| turns[j.index()]));
            let admitted = std::array::from_fn(|i| limits[i].widened_to_admit(present.0[i]));
            let ik = LimbIk::new(&Chain::new(limb, self.skeleton), &admitted);
            let base = Rigid { position: root, rotation: turns[0] };
            let pose = ik.solve(&base, &before[joints[2].index()], &present, Swivel::Present, |_| None::<()>).ok()?;
            (0..3).for_each(|i| turns[joints[i].index()] = pose.0[i]);
        }
        Some((root, turns))
    }
}

/// Rotations with a share of a bend.
fn bent_rotations(turns: &[DQuat; NUM_JOINTS], bend: &Bend, share: f64) -> [DQuat; NUM_JOINTS] {
    let mut world = [turns[0]; NUM_JOINTS];
    for joint in &Joint::ALL[1..] {
        let parent = joint.parent().map_or(0, Joint::index);
        world[joint.index()] = world[parent] * turns[joint.index()];
    }
    let axis = turns[0] * bend.axis;
    let turn = |part: f64| rotation_about(axis, bend.angle * share * part);
    let mut out = *turns;
    let mut to = world;
    to[0] = (turn(bend.hips) * world[0]).normalize();
    out[0] = to[0];
    for joint in &Joint::ALL[1..] {
        let (i, parent) = (joint.index(), joint.parent().map_or(0, Joint::index));
        let up = SPINE.iter().position(|j| j == joint).map(|k| (k + 1) as f64 / SPINE.len() as f64);
        let part = up.map(|up| bend.hips + (1.0 - bend.hips) * up);
        let part = part.or(BACK.iter().find(|b| b.0 == *joint).map(|b| b.1));
        match part {
            Some(part) => {
                to[i] = turn(part) * world[i];
                out[i] = (to[parent].inverse() * to[i]).normalize();
            }
            None => to[i] = to[parent] * turns[i],
        }
    }
    out
}

/// Bends a character towards the target of a step, from when the limb leaves the clip until it is back.
///
/// - `by_m`: distance of the target out of reach (m).
pub(super) fn lean_to_target(stage: &mut TaskStage<'_>, step: &TaskStep, by_m: f64) -> Result<(), StepFailure> {
    let (who, limb, [from_s, at_s, to_s]) = (step.character, step.limb, step.times_s);
    let held_s = at_s + step.hold_s;
    let leans = stage.leans.iter().any(|l| l.character == who && l.window_s[0] < to_s && l.window_s[1] > from_s);
    let is_during = |[begin, end]: [f64; 2]| begin < to_s - 1e-6 && end > from_s + 1e-6;
    let is_busy = leans || stage.planned_limbs.iter().any(|p| p.character == who && is_during(p.window_s));
    refuse(is_busy, format_args!("nobody leans while another task of the same body is done"))?;
    let actor = &stage.actors[who];
    let rate_hz = actor.clip.rate_hz;
    let frame_of = |t: f64| (t * rate_hz).round() as usize;
    let frames = frame_of(from_s)..=frame_of(to_s).min(actor.clip.num_frames() - 1);
    let both = |f: usize| {
        let c = actor.clip.contacts.get(f).copied().unwrap_or_default();
        c.any(Contacts::LEFT) && c.any(Contacts::RIGHT)
    };
    let balances = stage.task.balance && frames.clone().all(both);
    let trunk = BendingTrunk { skeleton: &actor.skeleton, limits: &actor.limits, balances };
    let pose = |f: usize| -> RootPose {
        let row = f * NUM_JOINTS;
        let turn = |j: usize| actor.clip.rotations[row + j].as_dquat().normalize();
        (actor.clip.root_positions[f].as_dvec3(), std::array::from_fn(turn))
    };
    let at = object_target(stage, step, at_s).position;
    let there = pose(frame_of(at_s));
    let shoulder = limb.joints()[0];
    let far_m = place_joints(&actor.skeleton, there.0, &there.1)[shoulder.index()].position.distance(at) - by_m;
    let bend = trunk.least_bend(&there, shoulder, at, far_m);
    let bend = bend.ok_or_else(|| StepFailure::new("out of reach, as far as the trunk bends"))?;
    let share = |t: f64| ease((t - from_s) / (at_s - from_s)) * ease((to_s - t) / (to_s - held_s));
    let mut clip = actor.clip.clone();
    for f in frames.clone() {
        let (old, share) = (pose(f), share(f as f64 / rate_hz));
        if share == 0.0 {
            continue;
        }
        let bent = trunk.bent_pose(&old, &bend, share);
        let (root, turns) = bent.ok_or_else(|| StepFailure::new("who leans there does not stand"))?;
        if trunk.balances {
            clip.root_positions[f] = root.as_vec3();
        }
        for (j, (_, b)) in old.1.iter().zip(&turns).enumerate().filter(|(_, (a, b))| angle_between(**a, **b) > 1e-9) {
            let (i, new) = (f * NUM_JOINTS + j, b.as_quat().normalize());
            clip.rotations[i] = if new.dot(clip.rotations[i]) < 0.0 { -new } else { new };
        }
    }
    for f in frames.clone().skip(1) {
        for j in SPINE {
            let turn = |f: usize| clip.rotations[f * NUM_JOINTS + j.index()].as_dquat().normalize();
            let speed = angle_between(turn(f - 1), turn(f)) * rate_hz;
            let is_fast = actor.limits.joints[j.index()].is_some_and(|l| speed > l.speed);
            refuse(is_fast, format_args!("{} has no time to lean so far; give more time", j.name()))?;
        }
    }
    stage.actors[who].replace_clip(clip);
    stage.leans.push(TrunkLean { character: who, window_s: [from_s, to_s], moves_hips: balances });
    Ok(())
}

/// Joints that a lean changes.
pub(super) fn leaned_joints(leaned: &TrunkLean) -> impl Iterator<Item = Joint> {
    let legs = if leaned.moves_hips { &LEGS[..] } else { &[] };
    SPINE.into_iter().chain(BACK.map(|b| b.0)).chain(legs.iter().copied())
}

/// From 0 to 1, without a jump in speed or acceleration.
pub(super) fn ease(x: f64) -> f64 {
    smoothstep(x.clamp(0.0, 1.0))
}
