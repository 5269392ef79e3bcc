//! Cross-fading without time-warping, the baseline of blending. The nearest example plays at its own rate; when another
//! example becomes the nearest, the two are cross-faded without regard to their feet.

use glam::{Quat, Vec3};
use throng_core::blend::{BlendSpace, BlendedPosture, MAX_AXES, channel};
use throng_core::walkers::Control;
use throng_core::{Contacts, Joint, NUM_JOINTS, Skeleton};
use throng_lab::slip::Soles;
use throng_motion::clip::joint_transforms;

/// Ankle and ball of both feet.
const FEET: [[Joint; 2]; 2] = [[Joint::LeftFoot, Joint::LeftToe], [Joint::RightFoot, Joint::RightToe]];
/// Duration of a fade (s).
const FADE_S: f32 = 0.3;
/// Largest height difference of heel and ball at which both stand (m).
const FLAT_M: f32 = 0.005;

/// A playing example.
#[derive(Clone, Copy, Debug, Default)]
struct PlayingExample {
    example: usize,
    phase: f32,
}

/// A character whose examples are cross-faded.
#[derive(Clone, Debug)]
pub(super) struct CrossFadedBody {
    now: PlayingExample,
    before: PlayingExample,
    /// Time since the fade began (s).
    age_s: f32,
    weights: Vec<f32>,
    /// World positions of the joints (m).
    pub joints: [Vec3; NUM_JOINTS],
    /// Feet on the ground, of the example that is faded in.
    pub contacts: Contacts,
    /// Soles of both feet.
    pub soles: Soles,
}

impl CrossFadedBody {
    /// Starts with the first example.
    pub fn new(space: &BlendSpace) -> Self {
        Self {
            now: PlayingExample::default(),
            before: PlayingExample::default(),
            age_s: FADE_S,
            weights: vec![0.0; space.stride()],
            joints: [Vec3::ZERO; NUM_JOINTS],
            contacts: Contacts::NONE,
            soles: Soles::default(),
        }
    }

    /// Advances by `dt_s` to a sample of the trajectory.
    ///
    /// # Errors
    /// None for a space that was checked when its bundle was opened.
    pub fn step(
        &mut self,
        space: &BlendSpace,
        skeleton: &Skeleton,
        parameters: &[f32; MAX_AXES],
        control: &Control,
        dt_s: f32,
    ) -> Result<(), throng_core::Error> {
        let nearest = nearest_example(space, parameters);
        self.age_s += dt_s;
        if nearest != self.now.example && self.age_s >= FADE_S {
            self.before = self.now;
            self.now = PlayingExample { example: nearest, phase: 0.0 };
            self.age_s = 0.0;
        }
        let share = (self.age_s / FADE_S).min(1.0);
        let mut play = |p: &mut PlayingExample| -> Result<BlendedPosture, throng_core::Error> {
            self.weights.fill(0.0);
            self.weights[p.example] = 1.0;
            let mut phase = [p.phase];
            space.advance(&self.weights, &[dt_s], &mut phase)?;
            p.phase = phase[0];
            let mut out = [BlendedPosture::default()];
            space.blend_postures(&self.weights, &phase, &mut out)?;
            Ok(out[0])
        };
        let (from, to) = (play(&mut self.before)?, play(&mut self.now)?);
        let rotation = |j: usize| from.rotation(Joint::ALL[j]).slerp(to.rotation(Joint::ALL[j]), share);
        let hips = from.vector(channel::HIPS).lerp(to.vector(channel::HIPS), share);
        let turn = Quat::from_rotation_y(control.heading.unwrap_or(0.0));
        let at = control.position.unwrap_or_default();
        let place = |p: Vec3| turn * p + Vec3::new(at.x, 0.0, at.y);
        let joints = joint_transforms(skeleton, hips, rotation);
        self.joints = joints.map(|t| place(t.0));
        let heels = skeleton.heels();
        self.soles = std::array::from_fn(|side| {
            let [(ankle, turned), (ball, _)] = FEET[side].map(|j| joints[j.index()]);
            [place(ankle + turned * heels[side]), place(ball)]
        });
        let balls = FEET.map(|[_, toe]| skeleton.rest_positions()[toe.index()].y);
        self.contacts = foot_contacts(&to, &self.soles, balls);
        Ok(())
    }
}

/// The example nearest to a point of the box, each axis from 0 to 1.
fn nearest_example(space: &BlendSpace, parameters: &[f32; MAX_AXES]) -> usize {
    let distance = |e: &[f32; MAX_AXES]| -> f32 {
        let axes = space.axes().iter().enumerate();
        axes.map(|(k, a)| ((e[k] - parameters[k]) / (a.high - a.low)).powi(2)).sum()
    };
    let all = space.examples().iter().map(|e| distance(&e.parameters)).enumerate();
    all.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(i, _)| i)
}

/// Planted parts of the feet: of a planted foot, heel and ball unless one is higher than the other.
///
/// - `balls`: heights of the balls of flat feet (m).
fn foot_contacts(posture: &BlendedPosture, soles: &Soles, balls: [f32; 2]) -> Contacts {
    let feet = [
        (channel::LEFT_CONTACT, [Contacts::LEFT_HEEL, Contacts::LEFT_TOE]),
        (channel::RIGHT_CONTACT, [Contacts::RIGHT_HEEL, Contacts::RIGHT_TOE]),
    ];
    let mut out = Contacts::NONE;
    for (((channel, parts), [heel, ball]), flat) in feet.into_iter().zip(soles).zip(balls) {
        let higher = heel.y - (ball.y - flat);
        for (part, over) in parts.into_iter().zip([higher, -higher]) {
            if posture.channel(channel) > 0.5 && over < FLAT_M {
                out.insert(part);
            }
        }
    }
    out
}
