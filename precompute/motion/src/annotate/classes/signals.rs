//! What is measured of every frame to tell its class.

use super::{ClassSpan, Gait, HELD_OTHERWISE, MotionClass};
use crate::annotate::contacts::speeds;
use crate::clip::{Clip, FrameRange, runs_where};
use glam::{Vec2, Vec3, Vec3Swizzles};
use throng_base::maths::quantile;
use throng_core::{Joint, Skeleton, skeleton::ARMS};

/// Half of the time over which the speed of the hips is measured: about a step in all (s).
const STEP_S: f64 = 0.3;
/// Half of the time over which the front is averaged, and hips are compared with the stride: about two steps in all (s).
const STRIDE_S: f64 = 0.5;
/// Half of the time over which hands are observed (s).
const HANDS_S: f64 = 0.15;
/// Height of the lowest foot above its lowest place near by, and speed, from which the feet carry nobody (m, m/s).
const AIR: (f32, f32) = (0.08, 0.6);
/// Least time in the air: runners are down again sooner (s).
const AIR_S: f64 = 0.22;
/// Time before and after the air that belongs to a jump (s).
const JUMP_S: f64 = 0.3;
/// Limits beyond which motion has a manner of its own: lean of walking and running (degrees), angle of an arm (degrees),
/// height of the hips.
const APART: ([f32; 2], f32, f32) = ([20.0, 36.0], 55.0, 0.87);

/// Measurements of every frame (num_frames each).
#[derive(Default)]
pub(super) struct Signals {
    /// Places of the hips over the ground (m).
    places: Vec<Vec2>,
    /// Speed of the hips over the ground (m/s).
    pub speed: Vec<f32>,
    /// Direction of travel relative to the front of hips, chest and head, left positive (degrees).
    pub travel_deg: Vec<f32>,
    /// Correlation of the height of the hips with the distance of the feet over two steps (-1 to 1).
    pub bounce: Vec<f32>,
    /// Height of the hips over the lower foot, over that of the rest pose.
    pub height: Vec<f32>,
    /// Way from the middle of the feet to the hips over the ground (legs).
    pub behind: Vec<f32>,
    /// Lean of the trunk from upright (degrees).
    pub lean_deg: Vec<f32>,
    /// True in a jump.
    pub airborne: Vec<bool>,
    /// Angle of each arm, shoulder to hand, from straight down (degrees).
    pub arm_deg: Vec<[f32; 2]>,
    /// Bend of each elbow (degrees).
    pub elbow_deg: Vec<[f32; 2]>,
    /// Speed of each hand relative to the hips (m/s).
    hand_mps: Vec<[f32; 2]>,
    /// Standard deviation of the distance of the hands over two steps (m).
    pub gap_change: Vec<f32>,
    /// How far ahead of the chest the hand is that is less so (m).
    pub hands_ahead: Vec<f32>,
    /// Distance of the feet over the ground (m).
    stride: Vec<f32>,
}

impl Signals {
    pub fn of_clip(clip: &Clip, skeleton: &Skeleton) -> Self {
        let (n, rest) = (clip.num_frames(), skeleton.rest_positions());
        let half = |s: f64| ((s * clip.rate_hz).round() as usize).max(1);
        let (leg, rest_hips) = (skeleton.leg_length(), rest[0].y - rest[Joint::LeftFoot.index()].y);
        let mut s = Self::default();
        let (mut fronts, mut gaps, mut hips_y, mut lows) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut hands = [Vec::new(), Vec::new()];
        let mut feet: [Vec<Vec3>; 4] = Default::default();
        for f in 0..n {
            let joints = clip.joint_transforms(skeleton, f);
            let at = |j: Joint| joints[j.index()].0;
            let front = |j: Joint| (joints[j.index()].1 * Vec3::Z).xz().normalize_or_zero();
            let facing = front(Joint::Hips) + front(Joint::UpperChest) + front(Joint::Head);
            let (hips, [left, right]) = (at(Joint::Hips), [Joint::LeftFoot, Joint::RightFoot].map(at));
            s.places.push(hips.xz());
            fronts.push(facing);
            hips_y.push(hips.y);
            s.height.push((hips.y - left.y.min(right.y)) / rest_hips);
            s.behind.push((hips - 0.5 * (left + right)).xz().length() / leg);
            s.stride.push((left - right).xz().length());
            s.lean_deg.push((at(Joint::Neck) - hips).angle_between(Vec3::Y).to_degrees());
            s.arm_deg.push(ARMS.map(|[a, _, hand]| (at(hand) - at(a)).angle_between(Vec3::NEG_Y).to_degrees()));
            s.elbow_deg.push(
                ARMS.map(|[a, elbow, hand]| (at(elbow) - at(a)).angle_between(at(hand) - at(elbow)).to_degrees()),
            );
            let ahead = ARMS.map(|[.., hand]| (at(hand) - at(Joint::UpperChest)).xz().dot(facing.normalize_or_zero()));
            s.hands_ahead.push(ahead[0].min(ahead[1]));
            gaps.push((at(Joint::LeftHand) - at(Joint::RightHand)).length());
            (0..2).for_each(|side| hands[side].push(at(ARMS[side][2]) - hips));
            let parts = crate::stance::FEET.map(|j| (at(j), at(j).y - rest[j.index()].y));
            lows.push(parts.iter().map(|p| p.1).fold(f32::INFINITY, f32::min));
            (0..4).for_each(|i| feet[i].push(parts[i].0));
        }
        let step = half(STEP_S);
        let velocities: Vec<Vec2> = (0..n).map(|f| velocity(&s.places, f, step, clip.rate_hz)).collect();
        s.speed = velocities.iter().map(|v| v.length()).collect();
        let stride = half(STRIDE_S);
        let travel = |f: usize| {
            let [way, front] = [&velocities, &fronts].map(|v| window(v, f, stride).iter().copied().sum::<Vec2>());
            if s.speed[f] < 0.05 { 0.0 } else { way.angle_to(front).to_degrees() + 0.0 }
        };
        s.travel_deg = (0..n).map(travel).collect();
        let bounce = |f: usize| correlation(window(&hips_y, f, stride), window(&s.stride, f, stride));
        s.bounce = (0..n).map(bounce).collect();
        s.gap_change = (0..n).map(|f| deviation(window(&gaps, f, stride))).collect();
        let moved = |side: usize, f: usize| {
            let (a, b) = bounds(n, f, half(HANDS_S));
            (hands[side][b - 1] - hands[side][a]).length() * clip.rate_hz as f32 / (b - 1 - a).max(1) as f32
        };
        s.hand_mps = (0..n).map(|f| [moved(0, f), moved(1, f)]).collect();
        let foot_mps = feet.map(|track| speeds(&track, clip.rate_hz));
        let free = |f: usize| {
            let floor = window(&lows, f, half(2.0 * STEP_S)).iter().copied().fold(f32::INFINITY, f32::min);
            lows[f] - floor > AIR.0 && foot_mps.iter().all(|mps| mps[f] > AIR.1)
        };
        s.airborne = vec![false; n];
        for air in runs_where(0..n, free).into_iter().filter(|r| r.len() >= half(AIR_S)) {
            s.airborne[air.start.saturating_sub(half(JUMP_S))..(air.end + half(JUMP_S)).min(n)].fill(true);
        }
        for values in [&mut s.height, &mut s.lean_deg, &mut s.behind] {
            *values = (0..n).map(|f| mean(window(values, f, half(HANDS_S)))).collect();
        }
        s
    }

    /// Distance between the hips in two frames (m).
    pub fn distance_between(&self, from: usize, to: usize) -> f32 {
        self.places[from].distance(self.places[to])
    }

    /// True where arms hang and the body is still: within limits of the arms (degrees), the lean (degrees), the speed of the
    /// hands (m/s), the height of the hips and the distance of the feet (m).
    pub fn is_at_rest(&self, f: usize, [arm, lean, hands, height, feet]: [f32; 5]) -> bool {
        self.arm_deg[f].iter().all(|a| *a < arm)
            && self.lean_deg[f] < lean
            && self.hand_mps[f].iter().all(|mps| *mps < hands)
            && self.height[f] > height
            && self.stride[f] < feet
    }

    /// Manner of motion whose name says nothing: by lean, arms and height.
    pub fn manner(&self, run: FrameRange, gait: Gait) -> &'static str {
        let median = |value: &dyn Fn(usize) -> f32| quantile(run.clone().map(value), [1, 2]).unwrap_or_default();
        let (lean, arm, height) = APART;
        // Gestures are no manner.
        let goes = !matches!(gait, Gait::Stand | Gait::Other);
        match () {
            () if goes && median(&|f| self.lean_deg[f]) > lean[usize::from(gait == Gait::Run)] => HELD_OTHERWISE[0],
            () if goes && median(&|f| self.arm_deg[f][0].max(self.arm_deg[f][1])) > arm => HELD_OTHERWISE[1],
            () if goes && gait != Gait::Run && median(&|f| self.height[f]) < height => HELD_OTHERWISE[2],
            () => "",
        }
    }

    /// A span with its mean speed and direction of travel.
    pub fn span(&self, run: FrameRange, class: MotionClass) -> ClassSpan {
        let speed_mps = mean(&self.speed[run.clone()]);
        let angles = self.travel_deg[run.clone()].iter().map(|deg| Vec2::from_angle(deg.to_radians()));
        let stays = matches!(class.gait, Gait::Stand);
        let travel_deg = if stays { 0.0 } else { angles.sum::<Vec2>().to_angle().to_degrees() };
        ClassSpan { frames: run.start as u32..run.end as u32, class, speed_mps, travel_deg }
    }
}

/// First frame of the window around a frame, and the frame after its last.
fn bounds(n: usize, f: usize, half: usize) -> (usize, usize) {
    (f.saturating_sub(half), (f + half + 1).min(n))
}

fn window<T>(values: &[T], f: usize, half: usize) -> &[T] {
    let (from, to) = bounds(values.len(), f, half);
    &values[from..to]
}

fn mean(values: &[f32]) -> f32 {
    values.iter().sum::<f32>() / values.len().max(1) as f32
}

fn deviation(values: &[f32]) -> f32 {
    let middle = mean(values);
    (values.iter().map(|v| (v - middle).powi(2)).sum::<f32>() / values.len().max(1) as f32).sqrt()
}

fn correlation(a: &[f32], b: &[f32]) -> f32 {
    let [ma, mb] = [a, b].map(mean);
    let product: f32 = a.iter().zip(b).map(|(x, y)| (x - ma) * (y - mb)).sum();
    product / (a.len() as f32 * deviation(a) * deviation(b)).max(1e-6)
}

fn velocity(places: &[Vec2], f: usize, half: usize, rate_hz: f64) -> Vec2 {
    let (from, to) = bounds(places.len(), f, half);
    (places[to - 1] - places[from]) * rate_hz as f32 / (to - 1 - from).max(1) as f32
}
