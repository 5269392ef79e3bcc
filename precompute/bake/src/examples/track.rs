//! Motion of a clip's body at any time between its frames.

use super::arc::wrap_angle;
use glam::{DVec2, Quat, Vec3};
use throng_base::maths;
use throng_core::{Contacts, Joint, NUM_JOINTS};
use throng_motion::clip::{Clip, FrameRange};

/// A clip with its root's ground path and its body's heading. Times are in frames of the clip.
#[derive(Clone, Debug)]
pub struct ClipTrack<'a> {
    /// The clip.
    pub clip: &'a Clip,
    /// Position of the root on the ground (x, z) (m, num_frames).
    path: Vec<DVec2>,
    /// Heading of the body: the mean of hips and shoulders, unwrapped (rad, num_frames).
    facing: Vec<f64>,
}

/// A pose between frames.
#[derive(Clone, Debug, PartialEq)]
pub struct FractionalPose {
    /// Position of the hips (m).
    pub hips: Vec3,
    /// Joint rotations; the hips' in the frame of `hips`.
    pub rotations: [Quat; NUM_JOINTS],
}

impl<'a> ClipTrack<'a> {
    /// The track of a clip.
    pub fn new(clip: &'a Clip) -> Self {
        let path = clip.root_positions.iter().map(|p| DVec2::new(f64::from(p.x), f64::from(p.z))).collect();
        let mut facing: Vec<f64> = Vec::with_capacity(clip.num_frames());
        for frame in 0..clip.num_frames() {
            let heading = facing_of(clip.frame_rotations(frame));
            facing.push(facing.last().map_or(heading, |last| last + wrap_angle(heading - last)));
        }
        Self { clip, path, facing }
    }

    /// Frame rate (Hz).
    pub fn rate(&self) -> f64 {
        self.clip.rate_hz
    }

    /// Position of the root on the ground at a time (m).
    pub fn position_at(&self, time: f64) -> DVec2 {
        let (a, b, part) = self.frames_around(time);
        self.path[a].lerp(self.path[b], part)
    }

    /// Heading of the body at a time, unwrapped (rad).
    pub fn facing_at(&self, time: f64) -> f64 {
        let (a, b, part) = self.frames_around(time);
        self.facing[a] + (self.facing[b] - self.facing[a]) * part
    }

    /// Pose at a time, in the world: on smooth paths through the frames (Catmull and Rom 1974).
    pub fn pose_at(&self, time: f64) -> FractionalPose {
        let (a, b, part) = self.frames_around(time);
        let (t, left) = (part as f32, 1.0 - part as f32);
        let [before, after] = [-0.5 * t * left * left, -0.5 * t * t * left];
        let frames = [a.saturating_sub(1), a, b, (b + 1).min(self.path.len() - 1)];
        let shares = [before, left - 2.0 * before + after, t - 2.0 * after + before, after];
        let (mut hips, mut rotations) = (Vec3::ZERO, [Quat::from_array([0.0; 4]); NUM_JOINTS]);
        for (frame, share) in frames.into_iter().zip(shares) {
            hips += self.clip.root_positions[frame] * share;
            let pairs = self.clip.frame_rotations(a).iter().zip(self.clip.frame_rotations(frame));
            for (q, (near, of)) in rotations.iter_mut().zip(pairs) {
                *q += *of * share.copysign(share * near.dot(*of));
            }
        }
        FractionalPose { hips, rotations: rotations.map(Quat::normalize) }
    }

    /// Share of contact of some parts of the body at a time: 0 or 1 at frames.
    pub fn touch_at(&self, time: f64, parts: Contacts) -> f64 {
        let (a, b, part) = self.frames_around(time);
        let at = |f: usize| f64::from(u8::from(self.clip.contacts[f].any(parts)));
        at(a) * (1.0 - part) + at(b) * part
    }

    /// Mean of a quantity over a span of time, sampled four times a frame.
    pub fn mean_over<T>(&self, from: f64, to: f64, of: impl Fn(f64) -> T) -> T
    where
        T: std::ops::Add<Output = T> + std::ops::Mul<f64, Output = T> + Default,
    {
        let n = ((to - from) * 4.0).ceil().max(1.0) as usize;
        let at = |i: usize| from + (to - from) * (i as f64 + 0.5) / n as f64;
        (0..n).fold(T::default(), |sum, i| sum + of(at(i))) * (1.0 / n as f64)
    }

    /// Runs of frames within `range` in which a foot stands, in order.
    pub fn stances(&self, range: &FrameRange, foot: Contacts) -> Vec<FrameRange> {
        throng_motion::clip::runs_where(range.clone(), |f| self.clip.contacts[f].any(foot))
    }

    /// The frames around a time, and its ratio between them.
    fn frames_around(&self, time: f64) -> (usize, usize, f64) {
        let last = self.path.len() - 1;
        let time = time.clamp(0.0, last as f64);
        let a = (time.floor() as usize).min(last);
        (a, (a + 1).min(last), time - a as f64)
    }
}

/// Mean heading of hips and shoulders (rad).
fn facing_of(local: &[Quat]) -> f64 {
    let chain = [Joint::Hips, Joint::Spine, Joint::Chest, Joint::UpperChest];
    let shoulders = chain.iter().fold(Quat::IDENTITY, |q, j| maths::compose(q, local[j.index()]));
    // Sideways axes stay level in a body that bends forward, unlike forward axes.
    let left =
        (local[0] * Vec3::X).with_y(0.0).normalize_or_zero() + (shoulders * Vec3::X).with_y(0.0).normalize_or_zero();
    f64::from(-left.z).atan2(f64::from(left.x))
}
