//! Smoothness of bodies while the parameters of their blend space jump.

use super::cross_fade::CrossFadedBody;
use super::{STEP_S, advance_control, random_parameters, start_control};
use glam::Vec3;
use throng_core::blend::BlendSpace;
use throng_core::walkers::{WalkerStart, Walkers, WalkersConfig};
use throng_core::{Bundle, CharacterGroup, Contacts, Inline, NUM_JOINTS, Planar, Skeleton};
use throng_lab::measure::timing::fail;
use throng_lab::run::knee_angles;
use throng_lab::slip::{SlipMeter, Soles};
use throng_motion::error::BuildError;

/// Number of measured characters, and for how long (s).
const NUM_CHARACTERS: usize = 32;
const SECONDS: f32 = 40.0;
/// Time between jumps (s).
const JUMP_S: f32 = 2.0;
/// Time after a jump in which acceleration counts (s).
const ACCELERATION_WINDOW_S: f32 = 0.5;

/// Method that animates a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BlendMethod {
    /// Blended walkers: weights, incremental time-warping, retargeting.
    Blended,
    /// The nearest example, cross-faded.
    CrossFaded,
}

/// Figures of one method.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct JumpFigures {
    /// 95th percentile of the slip of planted feet, as [`SlipMeter`] measures it (m/s).
    pub slip_p95_mps: f64,
    /// Fastest change of a knee's angle (rad/s).
    pub knee_rate: f64,
    /// Largest acceleration of a joint soon after a jump (m/s^2).
    pub acceleration: f64,
}

/// Lets characters follow paths whose speed, turning rate and style jump to a random point every two seconds.
///
/// # Errors
/// [`BuildError::Stage`] where the space is broken.
pub(super) fn measure_jumps(
    tables: &Bundle,
    space: &BlendSpace,
    motion: BlendMethod,
) -> Result<JumpFigures, BuildError> {
    let places = random_parameters(space);
    let mut watch = JumpMeter::default();
    for who in 0..NUM_CHARACTERS {
        watch.forget_last_poses();
        let mut body = JumpingBody::new(space, motion)?;
        let mut path = start_control(space, &places[who], Planar::default());
        for step in 0..(SECONDS / STEP_S) as usize {
            let since = step as f32 * STEP_S;
            let aim = &places[(who * 37 + (since / JUMP_S) as usize) % places.len()];
            advance_control(space, &mut path, aim, STEP_S);
            let seen = match &mut body {
                JumpingBody::Blended(walkers) => {
                    let id = walkers.bodies().ids[0];
                    let stepped = walkers.order(id, path).and_then(|()| walkers.step(STEP_S, &Inline));
                    stepped.map_err(|e| fail(e.to_string()))?;
                    BodySample {
                        joints: walkers.joint_positions(0),
                        contacts: walkers.contacts(0),
                        soles: walkers.soles(0),
                    }
                }
                JumpingBody::CrossFaded(fade) => {
                    fade.step(space, tables.skeleton(), aim, &path, STEP_S).map_err(|e| fail(e.to_string()))?;
                    BodySample { joints: fade.joints, contacts: fade.contacts, soles: fade.soles }
                }
            };
            watch.observe(seen, since % JUMP_S < ACCELERATION_WINDOW_S && since > JUMP_S);
        }
    }
    Ok(watch.figures())
}

enum JumpingBody {
    Blended(Box<Walkers>),
    CrossFaded(Box<CrossFadedBody>),
}

impl JumpingBody {
    fn new(space: &BlendSpace, motion: BlendMethod) -> Result<Self, BuildError> {
        if motion == BlendMethod::CrossFaded {
            return Ok(Self::CrossFaded(Box::new(CrossFadedBody::new(space))));
        }
        let walkers =
            Walkers::with_capacity(space.clone(), &[], WalkersConfig::default(), 1).and_then(|mut walkers| {
                walkers.spawn(WalkerStart::default())?;
                Ok(walkers)
            });
        Ok(Self::Blended(Box::new(walkers.map_err(|e| fail(e.to_string()))?)))
    }
}

/// Joints and feet of one character at one time.
#[derive(Clone, Copy, Debug)]
struct BodySample {
    joints: [Vec3; NUM_JOINTS],
    contacts: Contacts,
    soles: Soles,
}

struct JumpMeter {
    /// The last poses, the latest first.
    last: Vec<[Vec3; NUM_JOINTS]>,
    slip: SlipMeter,
    knee_rate: f32,
    acceleration: f32,
}

impl Default for JumpMeter {
    fn default() -> Self {
        Self { last: Vec::new(), slip: SlipMeter::new(1, &Skeleton::default()), knee_rate: 0.0, acceleration: 0.0 }
    }
}

impl JumpMeter {
    fn forget_last_poses(&mut self) {
        self.last.clear();
        self.slip.forget_step();
    }

    fn observe(&mut self, BodySample { joints, contacts, soles }: BodySample, jumped: bool) {
        self.slip.observe(0, STEP_S, contacts, soles);
        if let Some(before) = self.last.first() {
            let (now, was) = (knee_angles(&joints), knee_angles(before));
            self.knee_rate = (0..2).map(|k| (now[k] - was[k]).abs() / STEP_S).fold(self.knee_rate, f32::max);
        }
        if let [before, earlier, ..] = &self.last[..]
            && jumped
        {
            for j in 0..NUM_JOINTS {
                let change = joints[j] - 2.0 * before[j] + earlier[j];
                self.acceleration = self.acceleration.max(change.length() / (STEP_S * STEP_S));
            }
        }
        self.last.insert(0, joints);
        self.last.truncate(2);
    }

    fn figures(self) -> JumpFigures {
        JumpFigures {
            slip_p95_mps: self.slip.p95_mps(),
            knee_rate: f64::from(self.knee_rate),
            acceleration: f64::from(self.acceleration),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_core::Joint;

    #[test]
    fn a_watch_sees_slipping_feet_bending_knees_and_jerks() {
        let mut watch = JumpMeter::default();
        let mut joints = [Vec3::ZERO; NUM_JOINTS];
        joints[Joint::LeftThigh.index()] = Vec3::Y;
        joints[Joint::LeftShin.index()] = Vec3::Y * 0.5;
        let slip = Vec3::X * 0.3 * STEP_S;
        for step in 0..4 {
            let mut now = joints;
            now[Joint::LeftFoot.index()] += slip * step as f32;
            let soles = [[slip * step as f32, 2.0 * slip * step as f32], [Vec3::ZERO; 2]];
            if step == 3 {
                now[Joint::Head.index()].y += 0.01;
            }
            watch.observe(BodySample { joints: now, contacts: Contacts::LEFT_HEEL, soles }, step == 3);
        }
        let seen = watch.figures();
        assert!((seen.slip_p95_mps - 0.3).abs() < 1e-3, "{seen:?}");
        assert!((seen.acceleration - 36.0).abs() < 0.1, "{seen:?}");
        assert!(seen.knee_rate > 0.3 && seen.knee_rate < 0.7, "{seen:?}");
    }
}
