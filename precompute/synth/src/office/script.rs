//! Timeline of a clip: steps, stays on the chair, keys of trunk, head and hands, and tags.

use super::{ChairStay, KeyedHandPose, KeyedPosture};
use crate::side::{LateralSide, forward, leftward};
use crate::walk::footsteps::{FeetStance, LAST_STAND, SHIFT, timing};
use crate::walk::gait::{StepShape, pivot_step};
use crate::walk::wander::{Intent, STANDING_WIDTH, TOE_OUT};
use crate::{attitude::Attitude, track::KeyTrack};
use glam::DVec2;
use rand::{Rng, RngExt};
use throng_core::planar::wrap_angle;

/// Timeline of a clip, to which events are appended.
pub struct MotionScript {
    /// Initial stance.
    pub start: FeetStance,
    /// The steps.
    pub steps: Vec<Intent>,
    /// Keys of hips and chest.
    pub body: KeyTrack<KeyedPosture>,
    /// Keys of the head.
    pub head: KeyTrack<Attitude>,
    /// Keys of the left and the right hand.
    pub hands: [KeyTrack<KeyedHandPose>; 2],
    /// Stays on the chair, in order.
    pub sittings: Vec<ChairStay>,
    /// Times in which the left and the right hand rest on something (s).
    pub rests: [Vec<[f64; 2]>; 2],
    /// Tags: name, begin and end (s).
    pub tags: Vec<(&'static str, f64, f64)>,
    /// Factor on the usual variation.
    pub variation: f64,
    /// Current stance.
    pub stance: FeetStance,
    landed: f64,
    /// End of the events so far (s).
    pub now: f64,
}

/// A single step, as taken by [`MotionScript::step`].
#[derive(Clone, Copy, Debug)]
pub struct ScriptStep {
    /// The foot.
    pub side: LateralSide,
    /// Stance after the step, once the other foot has followed.
    pub to: FeetStance,
    /// Distance of the ankles across (m).
    pub width: f64,
    /// Outward turn of the foot (rad).
    pub toe_out: f64,
    /// Time from landing to landing (s).
    pub period: f64,
    /// Time on both feet at the beginning (s).
    pub double_support: f64,
}

impl ScriptStep {
    /// A step on the spot or aside.
    pub fn aside(side: LateralSide, to: FeetStance) -> Self {
        Self { side, to, width: STANDING_WIDTH, toe_out: TOE_OUT, period: 0.6, double_support: 0.16 }
    }
}

/// Largest turn in place by one step of the inner foot, for small and for large heading changes (rad).
const OPENING: [f64; 2] = [0.85, 1.1];
/// Largest turn in place by one step of the outer foot (rad).
const CLOSING: f64 = 0.3;

/// Least stand between two steps of the same foot (s).
const LANDED: f64 = 0.15;

impl MotionScript {
    /// A timeline that begins standing.
    pub fn new(start: FeetStance, variation: f64) -> Self {
        let hand = KeyedHandPose::HANGING;
        Self {
            start,
            steps: Vec::new(),
            body: KeyTrack::new(KeyedPosture::default()),
            head: KeyTrack::new(Attitude::default()),
            hands: [hand, hand.mirrored()].map(KeyTrack::new),
            sittings: Vec::new(),
            rests: [Vec::new(), Vec::new()],
            tags: Vec::new(),
            variation,
            stance: start,
            landed: 0.0,
            now: 0.0,
        }
    }

    /// Duration of the stand after the last step (s).
    pub fn last_stand(&self) -> f64 {
        LAST_STAND.max(self.now - self.landed + 1.1)
    }

    /// Length of the clip (s).
    pub fn duration(&self) -> f64 {
        self.landed + self.last_stand()
    }

    /// Extends the timeline to `t`.
    pub fn wait_until(&mut self, t: f64) {
        self.now = self.now.max(t);
    }

    /// Random offset between `-amount` and `amount`, scaled by the variation.
    pub fn random_offset(&self, amount: f64, rng: &mut impl Rng) -> f64 {
        self.variation * amount * rng.random_range(-1.0..1.0)
    }

    /// Takes a step, after waiting for events that last longer than the last landing.
    pub fn step(&mut self, step: ScriptStep) {
        let ScriptStep { side, to, width, toe_out, period, double_support } = step;
        let turn = f64::from(wrap_angle((to.heading - self.stance.heading) as f32));
        let along = self.stance.heading + 0.5 * turn;
        let offset = to.at - self.stance.at;
        let shape = StepShape { length: offset.dot(forward(along)), period, double_support };
        // A foot that has just landed carries for a while before it steps again.
        let pause = match self.now - self.landed {
            waits if waits > 0.02 => waits,
            _ if self.steps.last().is_some_and(|s| s.side == side) => LANDED,
            _ => 0.0,
        };
        let intent = Intent { side, pause, turn, aside: offset.dot(leftward(along)), width, toe_out, shape };
        self.stance = self.stance.after_step(&intent);
        self.landed = timing(&intent, self.landed).1;
        self.now = self.landed;
        self.steps.push(intent);
    }

    /// Time at which the next step lifts its foot, if after standing still (s).
    pub fn next_lift(&self) -> f64 {
        self.now.max(self.landed) + SHIFT
    }

    /// Foot that can step at once, in the middle of stepping.
    pub fn free_foot(&self) -> Option<LateralSide> {
        self.steps.last().filter(|_| self.now <= self.landed + 0.02).map(|s| s.side.other())
    }

    /// Rests a hand on something from a little after `from` until a little before `to`.
    pub fn rest_hand(&mut self, side: LateralSide, from: f64, to: f64) {
        if to - from > 0.4 {
            self.rests[side.index()].push([from + 0.1, to - 0.12]);
        }
    }

    /// Turns on the spot by `angle` in alternating steps, the inner foot first.
    pub fn turn_in_place(&mut self, angle: f64) {
        let opening = OPENING[usize::from(angle.abs() > 1.2)];
        let (mut left, mut side, mut behind) = (angle, LateralSide::inside(angle), 0.0);
        while f64::abs(left) > 0.03 || f64::abs(behind) > 0.03 {
            let most = if side == LateralSide::inside(angle) { opening } else { CLOSING };
            let bend = left.clamp(-most, most);
            let StepShape { period, double_support, .. } = pivot_step(bend + behind);
            let to = FeetStance { at: self.stance.at, heading: self.stance.heading + bend };
            self.step(ScriptStep { period, double_support, ..ScriptStep::aside(side, to) });
            left -= bend;
            behind = bend;
            side = side.other();
        }
    }

    /// Steps sideways to a stance in closing steps, turning meanwhile.
    ///
    /// - `path`: position at each share of the way (m).
    pub fn side_step(&mut self, to: FeetStance, path: impl Fn(f64) -> DVec2, rng: &mut impl Rng) {
        const STRIDE: f64 = 0.3;
        let from = self.stance;
        let turn = f64::from(wrap_angle((to.heading - from.heading) as f32));
        let distance = (to.at - from.at).length();
        let pairs = (distance / STRIDE).max(turn.abs() / 0.5).ceil().max(1.0);
        let mean = from.heading + 0.5 * turn;
        let lead = if (to.at - from.at).dot(leftward(mean)) >= 0.0 { LateralSide::Left } else { LateralSide::Right };
        for k in 1..=pairs as usize {
            let share = k as f64 / pairs;
            let at = FeetStance { at: path(share), heading: from.heading + turn * share };
            let period = 0.56 + self.random_offset(0.03, rng);
            self.step(ScriptStep { period, ..ScriptStep::aside(lead, at) });
            self.step(ScriptStep { period: period - 0.02, ..ScriptStep::aside(lead.other(), at) });
        }
    }

    /// Brings hips and chest to a posture at `t`, starting `over` seconds before.
    pub fn pose(&mut self, t: f64, over: f64, posture: KeyedPosture) {
        self.body.hold(t - over);
        self.body.push(t, posture);
    }

    /// Brings the head to an attitude at `t`, starting `over` seconds before.
    pub fn turn_head(&mut self, t: f64, over: f64, yaw: f64, pitch: f64, list: f64) {
        self.head.hold(t - over);
        self.head.push(t, Attitude { yaw, pitch, list });
    }

    /// Brings a hand to a pose at `t`, starting `over` seconds before, or at its last key.
    pub fn hand(&mut self, side: LateralSide, t: f64, over: f64, pose: KeyedHandPose) {
        let track = &mut self.hands[side.index()];
        track.hold(t - over);
        track.push(t, pose);
    }

    /// Pose of a hand at its last key.
    pub fn hand_now(&self, side: LateralSide) -> KeyedHandPose {
        self.hands[side.index()].last().1
    }

    /// Lets a hand hang from `t - over` until `t`, forgetting its held position.
    pub fn let_hang(&mut self, side: LateralSide, t: f64, over: f64) {
        let last = self.hand_now(side);
        self.hand(side, t, over, KeyedHandPose { held: 0.0, flex: 0.0, reach: 0.0, shrug: 0.0, ..last });
    }

    /// Returns to the neutral stand at `t`.
    pub fn relax(&mut self, t: f64, over: f64) {
        self.pose(t, over, KeyedPosture::default());
        self.turn_head(t, over, 0.0, 0.0, 0.0);
        LateralSide::BOTH.into_iter().for_each(|side| self.let_hang(side, t, over));
    }

    /// Tags the time from `from` to now.
    pub fn tag(&mut self, name: &'static str, from: f64) {
        self.tags.push((name, from, self.now));
    }
}
