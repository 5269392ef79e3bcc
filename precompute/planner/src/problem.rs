//! Planning problems: a limb from one pose to another, in time with everything that moves.

use crate::linkage::{Chain, LIMB_JOINTS, LimbPose};
use crate::track::{MotionTrack, RigidPath};
use crate::{limits::JointLimits, rotation::Rigid};
use glam::DVec3;
use throng_core::Joint;
use throng_geometry::{Segment, SolidShape};

/// A point of the search space c^P x [t_init, t_goal].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimbState {
    /// Pose of the planned joints.
    pub pose: LimbPose,
    /// Time (s).
    pub time_s: f64,
}

/// Something in the world that limbs may not touch.
#[derive(Clone, Debug)]
pub struct MovingSolid {
    /// Name in messages and allowances.
    pub name: String,
    /// Shape in its own frame.
    pub shape: SolidShape,
    /// Place over time.
    pub path: RigidPath,
}

/// A checked problem, prepared for many queries: everything that moves is a function of time with a bound on its speed.
///
/// # Source
/// Shapiro, Kallmann and Faloutsos 2007, section 3: configuration (m^M(t), c^P), world w(t).
#[derive(Clone, Debug)]
pub struct Problem {
    /// Unique number of a prepared problem, so that cached collision samples belong to one problem.
    pub(crate) number: u64,
    /// The joints that are planned.
    pub chain: Chain,
    /// Their limits.
    pub limits: [JointLimits; LIMB_JOINTS],
    /// The joint that carries the chain.
    pub(crate) base: MotionTrack<Rigid>,
    /// Capsules that move with the chain.
    pub parts: Vec<LimbPart>,
    /// Solids in the way.
    pub solids: Vec<PlacedSolid>,
    /// Capsules of bodies in the way.
    pub bodies: Vec<BodyPart>,
    pub(crate) tether: Option<TetherTrack>,
    pub(crate) upright: Option<UprightConstraint>,
    /// Pairs that may not come near each other; those with the same target are adjacent.
    pub pairs: Vec<CollisionPair>,
    /// Poses of the limb in the external motion, every [`EXTERNAL_STEP_S`] from `init` on.
    pub(crate) external_poses: Vec<LimbPose>,
    /// Start of the plan.
    pub init: LimbState,
    /// Goal of the plan.
    pub goal: LimbState,
}

/// Time step of the external motion's poses (s).
pub(crate) const EXTERNAL_STEP_S: f64 = 1.0 / 120.0;

/// A capsule that moves with the limb.
#[derive(Clone, Debug)]
pub struct LimbPart {
    /// Its name, for messages.
    pub name: String,
    /// Index of the joint of the chain.
    pub link: usize,
    /// Core in the joint's frame (m).
    pub core: Segment,
    /// Half of the core's length (m).
    pub half_length: f64,
    /// Of the capsule (m).
    pub radius: f64,
    /// Longest distance from each joint of the chain to the farther end of the core (m).
    pub reach: [f64; LIMB_JOINTS],
    /// Longest distance from the base to the farther end of the core (m).
    pub base_reach: f64,
}

/// A solid, and the ball around it.
#[derive(Clone, Debug)]
pub struct PlacedSolid {
    /// The solid.
    pub solid: MovingSolid,
    /// Middle of the ball (m).
    pub middle: DVec3,
    /// Radius of the ball (m).
    pub radius: f64,
    /// Distance from its origin to its farthest point (m).
    pub reach: f64,
}

/// A capsule of a body that an external motion drives.
#[derive(Clone, Debug)]
pub struct BodyPart {
    /// Name of the other character; `None` for the own body.
    pub character: Option<String>,
    /// The joint that carries it.
    pub joint: Joint,
    /// Its core over time (m).
    pub track: MotionTrack<Segment>,
    /// Half of its greatest length (m).
    pub half_length: f64,
    /// Of the capsule (m).
    pub radius: f64,
}

/// Things that a part of the limb may collide with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum CollisionTarget {
    /// A solid, by its number.
    Solid(usize),
    /// A capsule of a body, by its number.
    Body(usize),
    /// Reach of the other hand; the part is a point of it.
    Tether,
    /// The vertical; the part is a direction, a metre long, so that metres are radians.
    Upright,
}

/// Constraint that keeps a held object upright: a direction of the hand or foot stays near the vertical.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UprightConstraint {
    /// Direction in the frame of the limb's last joint (unit).
    pub up: DVec3,
    /// Largest angle from the vertical (rad, > 0, < pi).
    pub within_rad: f64,
}

/// Joint from which the other hand is reached, over time.
#[derive(Clone, Debug)]
pub(crate) struct TetherTrack {
    pub name: String,
    pub from: MotionTrack<Rigid>,
    /// Least and greatest distance (m).
    pub distances_m: [f64; 2],
}

/// A part of the limb, a target that it may not come near, and the least distance between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CollisionPair {
    /// The part, by its number.
    pub part: usize,
    /// The thing that the part keeps away from.
    pub target: CollisionTarget,
    /// Least distance between surfaces (m).
    pub gap: f64,
    /// Time in which they may touch (s).
    pub allowed: Option<[f64; 2]>,
}

/// Two things that are too near each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CollisionHit {
    pub(crate) pair: usize,
    /// Depth by which they are too near (m, > 0).
    pub depth_m: f64,
}

impl Problem {
    /// World transform of the joint that carries the chain.
    pub fn base_at(&self, time_s: f64) -> Rigid {
        self.base.sample_at(time_s)
    }

    /// World transforms of the planned joints.
    pub fn place_chain(&self, state: &LimbState) -> [Rigid; LIMB_JOINTS] {
        self.chain.place_joints(&self.base.sample_at(state.time_s), &state.pose)
    }

    /// Pose of the limb in the external motion.
    pub fn external_pose_at(&self, time_s: f64) -> LimbPose {
        let last = self.external_poses.len() - 1;
        let at = ((time_s - self.init.time_s) / EXTERNAL_STEP_S).clamp(0.0, last as f64);
        let i = (at as usize).min(last.saturating_sub(1));
        let (a, b) = (&self.external_poses[i], &self.external_poses[(i + 1).min(last)]);
        a.slerp(b, at - i as f64)
    }

    /// Names of the two things that are too near each other.
    pub fn hit_names(&self, hit: &CollisionHit) -> [String; 2] {
        let pair = &self.pairs[hit.pair];
        [self.parts[pair.part].name.clone(), self.target_name(pair.target)]
    }

    pub(crate) fn target_name(&self, target: CollisionTarget) -> String {
        match target {
            CollisionTarget::Solid(i) => self.solids[i].solid.name.clone(),
            CollisionTarget::Body(i) => self.bodies[i].name(),
            CollisionTarget::Tether => self.tether.as_ref().map_or_else(String::new, |t| t.name.clone()),
            CollisionTarget::Upright => "how far it may tilt".into(),
        }
    }

    /// Least time that the joints need from one pose to another (s), and the joint that needs it.
    pub fn least_time(&self, from: &LimbPose, to: &LimbPose) -> (f64, Joint) {
        let joints = self.chain.limb.joints();
        let need = |i: usize| crate::rotation::angle_between(from.0[i], to.0[i]) / self.limits[i].speed;
        let all = (0..LIMB_JOINTS).map(|i| (need(i), joints[i]));
        all.fold((0.0, joints[0]), |a, b| if b.0 > a.0 { b } else { a })
    }
}

impl BodyPart {
    /// Its name, for messages.
    pub fn name(&self) -> String {
        match &self.character {
            Some(who) => format!("{who}'s {}", self.joint.name()),
            None => self.joint.name().into(),
        }
    }
}
