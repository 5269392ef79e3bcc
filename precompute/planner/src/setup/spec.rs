//! Specifications of problems, as applications write them.

use crate::problem::{LimbState, MovingSolid, UprightConstraint};
use crate::{body::BodyCapsules, driven::DrivenMotion, limits::BodyLimits, linkage::Limb};
use glam::DVec3;
use throng_base::thresholds::FLESH_GIVES_M;
use throng_core::{Joint, Skeleton};
use throng_geometry::Segment;

/// Depth to which parts of the own body press into each other where clothes give, and the flesh of one of them (m). Chosen.
pub const SELF_PRESS_M: f64 = 0.02 + FLESH_GIVES_M as f64;

/// Another character.
#[derive(Clone, Copy, Debug)]
pub struct OtherCharacter<'a> {
    /// Name in messages and allowances.
    pub name: &'a str,
    /// Motion.
    pub motion: &'a DrivenMotion,
    /// Capsules of its body.
    pub shape: &'a BodyCapsules,
}

/// A capsule that hand or foot carries: a stick, a rib of an umbrella.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldCapsule {
    /// Name in messages and allowances.
    pub name: String,
    /// Core in the frame of the limb's last joint (m).
    pub core: Segment,
    /// Radius (m, > 0).
    pub radius: f64,
}

/// Two things that may touch.
#[derive(Clone, Debug, PartialEq)]
pub struct AllowedContact {
    /// Name of a joint or of a held capsule; `None` for all of the own body and what it holds.
    pub part: Option<String>,
    /// Name of a solid, of another character, or of a joint of the own body.
    pub other: String,
    /// Time in which they may touch (s); `None` for always.
    pub window_s: Option<[f64; 2]>,
}

/// Constraint of a second hand at a held object: a place in the frame of the hand or foot stays within reach of another joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tether {
    /// The joint from which it is reached: the other shoulder.
    pub from: Joint,
    /// The other wrist, in the frame of the limb's last joint (m).
    pub wrist: DVec3,
    /// Least and greatest distance between both (m).
    pub distances_m: [f64; 2],
}

/// A problem before it is checked.
#[derive(Clone, Debug)]
pub struct ProblemSpec<'a> {
    /// Proportions of the character.
    pub skeleton: &'a Skeleton,
    /// Joints that are planned.
    pub limb: Limb,
    /// Limits of angles and speeds.
    pub limits: &'a BodyLimits,
    /// Motion of all joints, the planned ones as they are before.
    pub motion: &'a DrivenMotion,
    /// Capsules of the body.
    pub shape: &'a BodyCapsules,
    /// Start of the plan.
    pub init: LimbState,
    /// Goal of the plan.
    pub goal: LimbState,
    /// Solids around.
    pub solids: &'a [MovingSolid],
    /// Other characters around.
    pub others: &'a [OtherCharacter<'a>],
    /// Capsules that hand or foot carries.
    pub held: &'a [HeldCapsule],
    /// Contacts that are allowed.
    pub allowed: &'a [AllowedContact],
    /// Constraint of the other hand at the held object.
    pub tether: Option<Tether>,
    /// Constraint that keeps the held object upright.
    pub upright: Option<UprightConstraint>,
    /// Least distance from solids and other characters (m, >= 0).
    pub clearance_m: f64,
    /// Depth to which parts of the own body may press into each other, as flesh does; [`SELF_PRESS_M`] unless a task says otherwise
    /// (m, >= 0).
    pub self_press_m: f64,
    /// True widens limits until both ends are within them: performers bend farther than books say.
    pub admit_ends: bool,
    /// True plans although the driven part of the body collides by itself: the limb gives way all the same.
    pub admit_driven: bool,
}

impl<'a> ProblemSpec<'a> {
    /// A specification with the usual clearances, in an empty world.
    pub fn new(
        skeleton: &'a Skeleton,
        limb: Limb,
        limits: &'a BodyLimits,
        motion: &'a DrivenMotion,
        shape: &'a BodyCapsules,
        [init, goal]: [LimbState; 2],
    ) -> Self {
        Self {
            skeleton,
            limb,
            limits,
            motion,
            shape,
            init,
            goal,
            solids: &[],
            others: &[],
            held: &[],
            allowed: &[],
            tether: None,
            upright: None,
            clearance_m: 0.005,
            self_press_m: SELF_PRESS_M,
            admit_ends: false,
            admit_driven: false,
        }
    }

    /// The specification between other ends, which limits admit.
    pub(crate) fn between(&self, [init, goal]: [LimbState; 2]) -> Self {
        Self { init, goal, admit_ends: true, ..self.clone() }
    }

    /// The specification between the poses of the motion itself at two times (s), which limits admit.
    pub(crate) fn between_times(&self, window_s: [f64; 2]) -> Self {
        self.between(window_s.map(|time_s| self.motion.limb_state(self.limb, time_s)))
    }
}
