//! Settings, starts and orders of walkers, and the limits of their numbers.

use crate::body::{ARMS, BodyLayers, FootLockConfig, LEGS, ReactionConfig};
use crate::skeleton::{Joint, Skeleton};
use crate::{blend::MAX_AXES, planar::Planar};
use glam::Vec2;
use serde::{Deserialize, Serialize};
use throng_base::error::{check_index, check_range, check_value};
use throng_base::{Id, Result, maths, thresholds::PACE_CHANGES_MPS2};

/// Limit of positions, speeds and angles (m, m/s, rad).
const FAR: f32 = 1e6;

/// Settings of walkers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WalkersConfig {
    /// Half-life of the difference between the parameters asked for and those blended, after a jump. Parameters that
    /// change steadily are followed without delay; 0 follows jumps at once too (s, 0 to 10).
    pub parameter_half_life_s: f32,
    /// Half-life of the difference between the heading aimed at and that of the body, after a jump. A heading that turns
    /// steadily is followed without delay (s, 0 to 10).
    pub heading_half_life_s: f32,
    /// Fastest turn of the body, and of the trajectory where its positions are not given (rad/s, > 0).
    pub max_turning_rate: f32,
    /// Limits of the trajectory where its positions are not given.
    pub inertia: InertiaConfig,
    /// Least and greatest tempo of the steps relative to the examples, to match strides to the speed of the trajectory
    /// (0.2 to 1, 1 to 5; 1 and 1 keep the blended rates).
    pub tempo: [f32; 2],
    /// How planted feet are held, and legs retargeted to the body.
    pub foot_lock: FootLockConfig,
    /// Effect of pushes, see [`Walkers::push`](super::Walkers::push).
    pub reaction: ReactionConfig,
    /// Also write local transforms.
    pub local_transforms: bool,
    /// Also write a record of each for GPUs, see [`Walkers::instances`](super::Walkers::instances).
    pub instances: bool,
}

impl Default for WalkersConfig {
    fn default() -> Self {
        Self {
            parameter_half_life_s: 0.25,
            heading_half_life_s: 0.12,
            max_turning_rate: 3.0,
            inertia: InertiaConfig::default(),
            tempo: [0.8, 1.25],
            foot_lock: FootLockConfig { reach_m: [0.088, 0.22], ..FootLockConfig::default() },
            reaction: ReactionConfig::default(),
            local_transforms: false,
            instances: false,
        }
    }
}

/// Largest accelerations of a walker that is on no given positions (m/s^2, 0.01 to 1e6).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InertiaConfig {
    /// While it gains speed.
    pub speeding_up_mps2: f32,
    /// While it loses speed.
    pub slowing_down_mps2: f32,
    /// To its sides, in curves: who has to turn faster at once slows down first.
    pub sideways_mps2: f32,
}

impl Default for InertiaConfig {
    /// The largest accelerations of captured people.
    fn default() -> Self {
        let [speeding_up_mps2, slowing_down_mps2, sideways_mps2] = PACE_CHANGES_MPS2;
        Self { speeding_up_mps2, slowing_down_mps2, sideways_mps2 }
    }
}

/// Start of a walker.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WalkerStart {
    /// Number of its body (< number of bodies).
    pub body: usize,
    /// Planar root in the world.
    pub root: Planar,
    /// Generic time at the start; different values keep walkers out of step.
    pub phase: f32,
}

/// A sample of a walker's trajectory, and how to move there. It may come from any path, or from a crowd.
///
/// It is for the end of the next step. Without another order the walker goes on from there: along the velocity, on an
/// arc where a turning rate is given. A walker without a given position changes speed and direction within the limits of
/// [`WalkersConfig::inertia`], unless it is to [`cut`](Self::cut); it starts from rest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Control {
    /// x and z in the world; `None` goes on from where the walker is (m).
    pub position: Option<Vec2>,
    /// Along x and z (m/s).
    pub velocity: Vec2,
    /// Heading of the body; `None` is that of the velocity (rad).
    pub heading: Option<f32>,
    /// Turning rate, positive to the left; `None` is that of the body (rad/s).
    pub turning_rate: Option<f32>,
    /// Takes velocity and direction at once, whatever the inertia.
    pub cut: bool,
    /// Values of the style axes, in their order.
    pub style: [f32; MAX_AXES],
    /// What the body does beside walking.
    pub layers: BodyLayers,
}

impl Control {
    /// Walks from where the walker is, at a velocity along x and z (m/s).
    pub fn walk(velocity: Vec2) -> Self {
        Self { velocity, ..Self::default() }
    }

    /// Continues the turn of the order.
    pub(super) fn continue_turn(&mut self, dt_s: f32) {
        if let Some(rate) = self.turning_rate {
            let (sin, cos) = maths::sin_cos(rate * dt_s);
            let v = self.velocity;
            self.velocity = Vec2::new(v.x * cos + v.y * sin, v.y * cos - v.x * sin);
            self.heading = self.heading.map(|heading| heading + rate * dt_s);
        }
    }

    /// Checks all numbers.
    ///
    /// - `num_frames`: of the bundle, which layers may show.
    ///
    /// # Errors
    /// [`throng_base::Error::Value`] for one that is not finite, or 1e6 and more, [`throng_base::Error::Index`] for frames that
    /// do not exist.
    pub(super) fn check(&self, who: Id, num_frames: usize) -> Result<()> {
        let position = self.position.unwrap_or_default();
        for (what, got) in [
            ("position x", position.x),
            ("position z", position.y),
            ("velocity x", self.velocity.x),
            ("velocity z", self.velocity.y),
            ("heading", self.heading.unwrap_or(0.0)),
            ("turning_rate", self.turning_rate.unwrap_or(0.0)),
        ] {
            check_moderate(what, Some(who), got)?;
        }
        self.layers.check(Some(who), num_frames)?;
        self.style.iter().try_for_each(|&got| check_moderate("style", Some(who), got))
    }
}

impl WalkerStart {
    pub(super) fn check(&self, num_bodies: usize) -> Result<()> {
        check_index("body", None, self.body, num_bodies)?;
        check_moderate("phase", None, self.phase)?;
        check_root(None, self.root)
    }
}

pub(super) fn check_root(who: Option<Id>, root: Planar) -> Result<()> {
    let numbers = [("root x", root.x), ("root z", root.z), ("root heading", root.heading)];
    numbers.into_iter().try_for_each(|(what, got)| check_moderate(what, who, got))
}

impl WalkersConfig {
    pub(super) fn check(&self) -> Result<()> {
        self.reaction.check()?;
        check_range("parameter_half_life_s", self.parameter_half_life_s, 0.0..=10.0, "between 0 and 10")?;
        check_range("heading_half_life_s", self.heading_half_life_s, 0.0..=10.0, "between 0 and 10")?;
        check_range("tempo[0]", self.tempo[0], 0.2..=1.0, "between 0.2 and 1")?;
        check_range("tempo[1]", self.tempo[1], 1.0..=5.0, "between 1 and 5")?;
        let rate = self.max_turning_rate;
        check_value("max_turning_rate", None, rate, rate > 0.0 && rate < 1e3, "above 0 and below 1000")?;
        let InertiaConfig { speeding_up_mps2, slowing_down_mps2, sideways_mps2 } = self.inertia;
        for (what, got) in [
            ("inertia.speeding_up_mps2", speeding_up_mps2),
            ("inertia.slowing_down_mps2", slowing_down_mps2),
            ("inertia.sideways_mps2", sideways_mps2),
        ] {
            check_range(what, got, 0.01..=1e6, "between 0.01 and 1e6")?;
        }
        self.foot_lock.check()
    }
}

/// Checks that legs and arms have a length, and that the rest pose stands on the ground.
pub(super) fn check_body(s: &Skeleton) -> Result<()> {
    let rest = s.rest_positions();
    let size = s.offsets.iter().chain(&s.tips).fold(0.0f32, |l, o| l.max(o.length()));
    let finite = s.offsets.iter().chain(&s.tips).all(|o| o.is_finite());
    check_value("offset of a body's joint", None, size, finite && size < 100.0, "finite and below 100")?;
    for limb in [LEGS.map(|l| [l[1], l[2]]), ARMS.map(|a| [a[1], a[2]])].concat() {
        for joint in limb {
            let length = s.offsets[joint.index()].length();
            check_value("length of a body's limb", None, length, length > 0.01, "above 0.01")?;
        }
    }
    for foot in [Joint::LeftFoot, Joint::RightFoot] {
        check_range("height of a body's ankle", rest[foot.index()].y, -0.01..1.0, "in rest pose between 0 and 1")?;
    }
    Ok(())
}

pub(super) fn check_moderate(what: &'static str, who: Option<Id>, got: f32) -> Result<()> {
    check_value(what, who, got, got.abs() < FAR, "a finite number below 1e6")
}
