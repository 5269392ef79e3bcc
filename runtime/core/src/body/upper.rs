//! Layers over any motion: what bodies do beside walking, from the waist up. Hips, legs and feet stay as they are.
//!
//! Frames of a clip turn joints of a mask, and a lean bends the trunk, before heads look; arms follow once feet stand.

use super::arms::{ArmLayer, ArmState};
use super::{events::ClipRows, lanes::Lane, lanewise::lanewise_fields, sample::LanePose, springs::DampedSpring};
use crate::skeleton::Joint;
use bytemuck::Zeroable;
use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};
use std::ops::{Range, RangeInclusive};
use throng_base::error::{check_index, check_range, check_value};
use throng_base::maths::{self, nlerp};
use throng_base::simd::{LANES, Lanes};
use throng_base::{Id, Result};

/// Time in which half of a change is made (s).
const HALF_LIFE_S: f32 = 0.16;
/// Most that the rate of a share changes (1/s^2), and the share that is none.
const CHANGE: f32 = 24.0;
const GONE: f32 = 1e-3;
/// Fastest that a clip fades in or out (1/s), and time in which the end of one that loops becomes its begin (s).
const CLIP_RATE: f32 = 2.5;
const CROSS_S: f32 = 0.35;
/// Furthest lean forwards or to a side (rad); its fastest, and the most that its rate changes (rad/s, rad/s^2).
const LEAN: f32 = 0.6;
const LEAN_LIMITS: [f32; 2] = [1.2, 8.0];
/// Joints above the hips, but for those of legs, by index.
const UPPER: RangeInclusive<usize> = Joint::Spine as usize..=Joint::RightHand as usize;
/// Joints that share a lean.
const LEANING: [Joint; 3] = [Joint::Spine, Joint::Chest, Joint::UpperChest];

/// What a body does beside its motion. Each layer fades in and out within limits of speed; one that is replaced is left first.
///
/// All but [`ArmLayer::Reach`] leave hips, legs and feet as they are, bit by bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BodyLayers {
    /// A point in the world that head and neck turn to, and the chest a little, while it lies within 70 degrees to the
    /// sides and 35 degrees up and down of where the body faces (m).
    pub look_at: Option<Vec3>,
    /// Layers of the left and the right arm.
    pub arms: [Option<ArmLayer>; 2],
    /// Bend of the trunk forwards and to the left, beside that of the motion (rad, -0.6 to 0.6).
    pub lean: [f32; 2],
    /// Frames of the bundle that joints show; see [`Self::with_clip`].
    pub clip: Option<ClipLayer>,
}

/// Frames of the bundle that turn joints above the hips.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Zeroable)]
#[serde(deny_unknown_fields)]
pub struct ClipLayer {
    /// First frame row.
    pub first_frame: u32,
    /// Number of frames (>= 2).
    pub num_frames: u32,
    /// A bit for each joint, from that of index 0; those of hips and legs have no effect.
    pub joints: u32,
    /// After the last frame the first follows; without it, the layer fades there.
    pub loops: bool,
}

/// State of the layers of one character.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Zeroable)]
#[repr(C)]
pub(crate) struct LayerState {
    pub arms: [ArmState; 2],
    lean: [f32; 2],
    lean_rate: [f32; 2],
    /// The clip that is shown; without frames, none.
    clip: ClipLayer,
    share: Share,
    /// Time within the clip (s).
    seconds: f32,
}

/// Share of a layer in what is shown, and its rate (1/s).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Zeroable)]
#[repr(C)]
pub(crate) struct Share {
    pub value: f32,
    rate: f32,
}

/// State of the layers of eight characters.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, Zeroable)]
#[repr(C)]
pub(crate) struct LayerStates {
    /// 1 where a layer shows, else 0.
    pub active: Lane,
    pub lanes: [LayerState; LANES],
}

/// Constants of one step, shared by all layers.
pub(crate) struct LayerTick<'a> {
    pub rows: &'a ClipRows,
    pub spring: DampedSpring,
    pub dt_s: f32,
}

impl BodyLayers {
    /// None.
    pub const NONE: Self = Self { look_at: None, arms: [None; 2], lean: [0.0; 2], clip: None };

    /// Shows frames of the bundle, as those of a clip or an activity, by joints above the hips.
    ///
    /// - `joints`: a bit for each, from that of index 0; those of hips and legs have no effect.
    /// - `loops`: after the last frame the first follows.
    pub fn with_clip(self, frames: Range<u32>, joints: u32, loops: bool) -> Self {
        let num_frames = frames.end.saturating_sub(frames.start);
        Self { clip: Some(ClipLayer { first_frame: frames.start, num_frames, joints, loops }), ..self }
    }

    /// Checks all numbers.
    ///
    /// - `num_frames`: of the bundle.
    ///
    /// # Errors
    /// [`throng_base::Error::Value`] for one that is out of its range, [`throng_base::Error::Index`] for frames that do not exist.
    pub(crate) fn check(&self, who: Option<Id>, num_frames: usize) -> Result<()> {
        for got in self.look_at.unwrap_or_default().to_array() {
            check_value("look_at", who, got, got.abs() < 1e6, "a finite number below 1e6 (m)")?;
        }
        for got in self.lean {
            check_range("lean", got, -LEAN..=LEAN, "between -0.6 and 0.6")?;
        }
        if let Some(clip) = self.clip {
            check_value("frames of a layer", who, clip.num_frames, clip.num_frames >= 2, "2 or more")?;
            check_index("frame", who, clip.first_frame as usize + clip.num_frames as usize - 1, num_frames)?;
        }
        self.arms.iter().flatten().try_for_each(|arm| arm.check(who))
    }

    /// True where nothing is ordered.
    pub(super) fn is_none(&self) -> bool {
        self.look_at.is_none() && self.clip.is_none() && self.lean == [0.0; 2] && self.arms.iter().all(Option::is_none)
    }

    /// True where nothing but a gaze or a reach is ordered, which have no state here. A layer
    /// with state in [`LayerState`] makes it false, or is never begun.
    pub(super) fn is_plain(&self) -> bool {
        let reaches = |arm: &Option<ArmLayer>| matches!(arm, None | Some(ArmLayer::Reach { .. }));
        self.lean == [0.0; 2] && self.clip.is_none() && self.arms.iter().all(reaches)
    }
}

impl<'a> LayerTick<'a> {
    pub fn new(rows: &'a ClipRows, dt_s: f32) -> Self {
        Self { rows, spring: DampedSpring::new(dt_s, HALF_LIFE_S), dt_s }
    }

    /// Moves a value towards another, no faster than two limits allow: of its rate, and of how that changes.
    pub fn follow(&self, value: &mut f32, rate: &mut f32, to: f32, [fastest, change]: [f32; 2]) {
        if self.dt_s > 0.0 {
            let (left, _) = self.spring.pull_towards_zero(*value - to, *rate);
            let (wanted, most) = ((to + left - *value) / self.dt_s, change * self.dt_s);
            *rate = wanted.clamp(*rate - most, *rate + most).clamp(-fastest, fastest);
            *value += *rate * self.dt_s;
        }
    }
}

impl Share {
    pub const ZERO: Self = Self { value: 0.0, rate: 0.0 };

    /// Moves on towards 1 or 0; returns true where nothing is left.
    ///
    /// - `fastest`: (1/s)
    pub fn follow(&mut self, tick: &LayerTick<'_>, is_on: bool, fastest: f32) -> bool {
        tick.follow(&mut self.value, &mut self.rate, f32::from(u8::from(is_on)), [fastest, CHANGE]);
        if !(0.0..=1.0).contains(&self.value) {
            *self = Self { value: self.value.clamp(0.0, 1.0), rate: 0.0 };
        }
        !is_on && self.value < GONE
    }

    /// True where its numbers can be.
    pub fn is_sound(&self) -> bool {
        (0.0..=1.0).contains(&self.value) && self.rate.abs() < 1e6
    }
}

impl LayerState {
    pub const ZERO: Self = {
        let clip = ClipLayer { first_frame: 0, num_frames: 0, joints: 0, loops: false };
        let (arms, lean, lean_rate) = ([ArmState::ZERO; 2], [0.0; 2], [0.0; 2]);
        Self { arms, lean, lean_rate, clip, share: Share::ZERO, seconds: 0.0 }
    };

    /// Moves clip and lean on, and turns the joints of one lane by them.
    pub fn turn_trunk<F: Lanes>(
        &mut self,
        tick: &LayerTick<'_>,
        layers: &BodyLayers,
        lane: usize,
        pose: &mut LanePose<F>,
    ) {
        if *self == Self::ZERO && layers.is_plain() {
            return;
        }
        for (k, to) in layers.lean.into_iter().enumerate() {
            tick.follow(&mut self.lean[k], &mut self.lean_rate[k], to, LEAN_LIMITS);
        }
        if layers.lean == [0.0; 2] && self.lean.iter().chain(&self.lean_rate).all(|v| v.abs() < 1e-4) {
            (self.lean, self.lean_rate) = ([0.0; 2], [0.0; 2]);
        }
        self.follow_clip(tick, layers.clip);
        for j in UPPER.filter(|j| self.clip.joints >> j & 1 == 1) {
            let Some(turn) = self.clip_rotation(tick.rows, j) else { break };
            pose.set_rotation(j, lane, nlerp(pose.rotation(j, lane), turn, self.share.value));
        }
        if self.lean != [0.0; 2] {
            let [ahead, left] = self.lean.map(|angle| angle / LEANING.len() as f32);
            let bend = maths::compose(maths::rotation_x(ahead), maths::rotation_z(-left));
            for j in LEANING.map(Joint::index) {
                pose.set_rotation(j, lane, maths::normalize_or_identity(maths::compose(bend, pose.rotation(j, lane))));
            }
        }
    }

    fn follow_clip(&mut self, tick: &LayerTick<'_>, order: Option<ClipLayer>) {
        if tick.dt_s == 0.0 {
            return;
        }
        if let (0, Some(clip)) = (self.clip.num_frames, order) {
            (self.clip, self.share, self.seconds) = (clip, Share::ZERO, 0.0);
        }
        let ([end, cross], is_shown) = (self.lengths_s(tick.rows.rate_hz), order == Some(self.clip));
        self.seconds += tick.dt_s;
        self.seconds = if self.clip.loops { self.seconds % (end - cross).max(1e-3) } else { self.seconds.min(end) };
        let is_on = is_shown && (self.clip.loops || self.seconds < end - 1.0 / CLIP_RATE);
        // One that has ended stays gone until another is ordered.
        if self.share.follow(tick, is_on, CLIP_RATE) && !is_shown {
            // The state of every other layer has to be named here, or it is cleared.
            *self = Self { arms: self.arms, lean: self.lean, lean_rate: self.lean_rate, ..Self::ZERO };
        }
    }

    /// True where its numbers can be.
    pub fn is_sound(&self) -> bool {
        let Self { arms, lean, lean_rate, clip: _, share, seconds } = self;
        let angles = lean.iter().chain(lean_rate).all(|v| v.abs() < 10.0);
        angles && (0.0..1e6).contains(seconds) && share.is_sound() && arms.iter().all(ArmState::is_sound)
    }

    /// Length of the clip, and of the part at which its end becomes its begin (s).
    fn lengths_s(&self, rate_hz: f32) -> [f32; 2] {
        let end = self.clip.num_frames.saturating_sub(1) as f32 / rate_hz.max(1.0);
        [end, CROSS_S.min(0.4 * end)]
    }

    /// Rotation of a joint in the clip, relative to its parent; none where no clip shows, or another bundle has other frames.
    fn clip_rotation(&self, rows: &ClipRows, joint: usize) -> Option<Quat> {
        let code = rows.code.first().filter(|_| self.clip.num_frames > 1 && self.share.value > 0.0)?;
        let frames = rows.frames.get(self.clip.first_frame as usize..)?.get(..self.clip.num_frames as usize)?;
        let at = |seconds: f32| {
            let at = seconds * rows.rate_hz;
            let first = (at as usize).min(frames.len() - 2);
            let [a, b] = [first, first + 1].map(|row| code.rotation(&frames[row], joint));
            nlerp(a, b, (at - first as f32).clamp(0.0, 1.0))
        };
        let [end, cross] = self.lengths_s(rows.rate_hz);
        Some(match self.clip.loops && self.seconds < cross {
            true => nlerp(at(end - cross + self.seconds), at(self.seconds), self.seconds / cross),
            false => at(self.seconds),
        })
    }
}

impl LayerStates {
    pub const ZERO: Self = Self { active: [0.0; LANES], lanes: [LayerState::ZERO; LANES] };
}

lanewise_fields!(LayerStates { active, lanes });
