//! Arms over any motion: they point, wave, carry and hold a telephone, each within limits of speed.
//!
//! A posture of an arm is a place of its wrist, the side to which its elbow points and the direction of its hand, as seen from
//! chest or head. The limb's inverse kinematics finds the elbow; joints then turn from the motion's rotations to these by a
//! share, which a spring moves.

use super::lane_body::{ARMS, LaneBody};
use super::lanes::{Lane3, get_lane, load, set_lane};
use super::reach::{pair_lengths, soft_distance};
use super::upper::{BodyLayers, LayerState, LayerStates, LayerTick, Share};
use super::{hierarchy::ModelPose, limbs::bent_middle};
use crate::skeleton::Joint;
use bytemuck::Zeroable;
use glam::{Mat3, Quat, Vec3};
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;
use throng_base::simd::{LANES, Lanes};
use throng_base::{Id, Result, error::check_value, maths, thresholds::REFERENCE_LEG_M};

/// What an arm does beside the motion of its body. All but the reach leave trunk and legs as they are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ArmLayer {
    /// The palm is taken to places by turning upper arm and forearm; the hand keeps its direction.
    Reach {
        /// A place in the world (m), and how far the palm is taken there (0 to 1): the trunk leans and hips sink for it as far,
        /// where the arm is too short.
        place: (Vec3, f32),
        /// A place relative to the root, on the ground below the hips (m), and the weight with which the palm is taken
        /// there (0 to 1, and no more than the other one leaves).
        level: (Vec3, f32),
    },
    /// The straight arm points at a place in the world (m), while it lies no more than 110 degrees outwards and 50 inwards, 70
    /// up and 60 down of where the chest faces.
    Point(Vec3),
    /// The raised hand waves.
    Wave,
    /// The arm hangs as with a bag in its hand.
    CarryBeside,
    /// The hand is before the belly: both arms hold a box between them.
    CarryBefore,
    /// The hand holds something on its own shoulder.
    CarryOnShoulder,
    /// The hand holds a telephone at its own ear.
    Phone,
}

/// Fastest that a hand moves with its share (m/s).
const HAND_MPS: f32 = 2.2;
/// Most that the rate of an angle of pointing changes, and its fastest (rad/s^2, rad/s).
const AIM_CHANGE: f32 = 30.0;
const AIM_RATE: f32 = 3.0;
/// Angles outwards and up between which an arm points (rad), and distance below which it does not (m).
const OUTWARDS: RangeInclusive<f32> = -50.0 * RADIANS..=110.0 * RADIANS;
const UPWARDS: RangeInclusive<f32> = -60.0 * RADIANS..=70.0 * RADIANS;
const RADIANS: f32 = std::f32::consts::PI / 180.0;
const NEAR_M: f32 = 0.4;
/// Direction outwards of the left and the right arm.
const OUT: [f32; 2] = [1.0, -1.0];
/// Number of the posture that points.
const POINT: u32 = 1;
/// Waves of a hand a second, and the turn of the forearm to either side (Hz, rad).
const WAVES_HZ: f32 = 1.4;
const WAVE: f32 = 0.38;
/// Distance of the wrist from the shoulder of an arm that bends as far as elbows do, by 148 degrees (lengths of the arm).
const FOLDED: f32 = 0.283;
/// Largest angle between forearm and hand (cosine of 50 degrees).
const WRIST_COS: f32 = 0.643;

/// State of one arm's layer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Zeroable)]
#[repr(C)]
pub(crate) struct ArmState {
    /// Number of the posture; 0 for none.
    kind: u32,
    share: Share,
    /// Time since it began (s).
    clock_s: f32,
    /// Angles of pointing, outwards and up (rad), and their rates (rad/s).
    aim: [f32; 2],
    aim_rate: [f32; 2],
}

/// Where an arm is taken, in model space.
struct ArmAim {
    wrist: Vec3,
    /// To the side of which the elbow lies, from the line between shoulder and wrist.
    pole: Vec3,
    /// Directions of the palm and of the hand.
    palm: Vec3,
    hand: Vec3,
}

/// A posture for the left arm: x outwards, y up, z ahead, as the chest has them. Place of the wrist from the shoulder (lengths
/// of the arm), or from the middle of the head for a telephone (m, of an adult); then directions as those of [`ArmAim`], where
/// a hand of zero goes on as the forearm.
type Posture = (ArmLayer, [[f32; 3]; 4]);

/// Postures by number, from 1 on.
const POSTURES: [Posture; 6] = [
    (ArmLayer::Point(Vec3::ZERO), [[0.0; 3], [0.3, -1.0, -0.2], [-0.4, -1.0, 0.0], [0.0; 3]]),
    (ArmLayer::Wave, [[0.34, 0.4, 0.26], [-0.2, -1.0, -0.4], [0.0, 0.0, 1.0], [0.0; 3]]),
    (ArmLayer::CarryBeside, [[0.16, -0.96, 0.07], [0.35, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0; 3]]),
    (ArmLayer::CarryBefore, [[-0.06, -0.5, 0.5], [0.45, -0.5, -0.75], [-1.0, 0.25, 0.0], [-0.15, 0.1, 1.0]]),
    (ArmLayer::CarryOnShoulder, [[0.04, 0.2, 0.26], [0.5, -0.3, 0.8], [0.0, -0.8, -0.6], [-0.1, 0.5, -0.85]]),
    (ArmLayer::Phone, [[0.15, -0.17, 0.12], [0.55, -1.0, 0.0], [-1.0, -0.1, -0.2], [-0.25, 0.85, -0.65]]),
];

impl ArmLayer {
    /// The layer of a number, from that of none: point, wave, carry beside, before and on the shoulder, phone, reach (0 to 7).
    ///
    /// - `at`: where it points or reaches, if it does either (m).
    pub fn from_number(number: usize, at: Vec3) -> Option<Self> {
        match number {
            1 => Some(Self::Point(at)),
            7 => Some(Self::Reach { place: (at, 1.0), level: (Vec3::ZERO, 0.0) }),
            _ => POSTURES.get(number.wrapping_sub(1)).map(|posture| posture.0),
        }
    }

    /// Checks all numbers.
    ///
    /// # Errors
    /// [`throng_base::Error::Value`] for a place that is not finite, or shares that are none.
    pub(crate) fn check(&self, who: Option<Id>) -> Result<()> {
        let ([a, b], [near, raised]) = match *self {
            Self::Reach { place, level } => ([place.0, level.0], [place.1, level.1]),
            Self::Point(at) => ([at; 2], [0.0; 2]),
            _ => return Ok(()),
        };
        for got in [a.to_array(), b.to_array()].as_flattened() {
            check_value("place of a hand", who, *got, got.abs() < 1e6, "a finite number below 1e6")?;
        }
        for share in [near, raised] {
            check_value("share of a reach", who, share, (0.0..=1.0).contains(&share), "between 0 and 1")?;
        }
        check_value("shares of a reach", who, near + raised, near + raised <= 1.0 + 1e-6, "at most 1 together")
    }

    /// Number of its posture; 0 for none.
    fn kind(&self) -> u32 {
        let is_it = |posture: &Posture| std::mem::discriminant(&posture.0) == std::mem::discriminant(self);
        POSTURES.iter().position(is_it).map_or(0, |at| at as u32 + 1)
    }
}

impl ArmState {
    pub const ZERO: Self = Self { kind: 0, share: Share::ZERO, clock_s: 0.0, aim: [0.0; 2], aim_rate: [0.0; 2] };

    /// True where its numbers can be.
    pub fn is_sound(&self) -> bool {
        self.kind as usize <= POSTURES.len()
            && self.share.is_sound()
            && self.aim.iter().chain(&self.aim_rate).chain([&self.clock_s]).all(|v| v.abs() < 1e6)
    }

    /// Moves on towards a layer; one that is replaced is left first.
    ///
    /// - `aim`: angles of pointing, where that is possible (rad).
    /// - `way`: of the hand between motion and posture (m).
    fn follow(&mut self, tick: &LayerTick<'_>, kind: u32, aim: Option<[f32; 2]>, way: f32) {
        if self.share.value == 0.0 && kind != 0 && kind != self.kind {
            *self = Self { kind, aim: aim.unwrap_or_default(), ..Self::ZERO };
        }
        let is_on = kind == self.kind && (kind != POINT || aim.is_some());
        for (k, to) in aim.into_iter().flatten().enumerate() {
            tick.follow(&mut self.aim[k], &mut self.aim_rate[k], to, [AIM_RATE, AIM_CHANGE]);
        }
        self.clock_s = (self.clock_s + tick.dt_s) % 1e3;
        if self.share.follow(tick, is_on, HAND_MPS / way.max(0.3)) {
            *self = Self::ZERO;
        }
    }

    /// The arm as its posture has it.
    ///
    /// - `place`: position and rotation of a joint in model space.
    fn find_aim(&self, body: &LaneBody, lane: usize, side: usize, place: impl Fn(Joint) -> (Vec3, Quat)) -> ArmAim {
        let out = OUT[side];
        let (layer, posture) = &POSTURES[self.kind as usize - 1];
        let [mut wrist, pole, palm, mut hand] = posture.map(Vec3::from_array);
        let lengths = body.arms[side].map(|length| length[lane]);
        let (mut middle, mut turn, mut size) =
            (place(ARMS[side][0]).0, place(Joint::UpperChest).1, lengths[0] + lengths[1]);
        match layer {
            ArmLayer::Point(_) => wrist = direction_of(self.aim),
            ArmLayer::Wave => {
                let angle = WAVE * maths::sin(std::f32::consts::TAU * WAVES_HZ * self.clock_s);
                let (sin, cos) = maths::sin_cos(angle);
                wrist += Vec3::new(sin, cos - 1.0, 0.0) * (lengths[1] / size);
                hand = Vec3::new(1.5 * sin, cos, 0.1);
            }
            ArmLayer::Phone => {
                let leg = &body.legs[side].lengths;
                size = (leg[0][lane] + leg[1][lane]) / REFERENCE_LEG_M;
                (middle, turn) = place(Joint::Head);
                middle += maths::rotate(turn, get_lane(&body.head_centre, lane));
            }
            _ => {}
        }
        let to_model = |v: Vec3| maths::rotate(turn, v * Vec3::new(out, 1.0, 1.0));
        ArmAim {
            wrist: middle + to_model(wrist * size),
            pole: to_model(pole),
            palm: to_model(palm),
            hand: to_model(hand),
        }
    }
}

/// Angles outwards and up of a direction as the chest has it, where an arm points there (rad).
fn pointing_angles(to: Vec3) -> Option<[f32; 2]> {
    let aim = [maths::atan2(to.x, to.z), maths::atan2(to.y, maths::hypot(to.x, to.z))];
    (OUTWARDS.contains(&aim[0]) && UPWARDS.contains(&aim[1]) && to.length() > NEAR_M).then_some(aim)
}

fn direction_of([out, up]: [f32; 2]) -> Vec3 {
    let ((sin, cos), (y, flat)) = (maths::sin_cos(out), maths::sin_cos(up));
    Vec3::new(sin * flat, y, cos * flat)
}

/// Moves the layers of eight characters' arms on and turns their joints.
///
/// - `layers`: places are in model space.
#[inline(always)]
pub(crate) fn layer_arms<F: Lanes>(
    body: &LaneBody,
    tick: &LayerTick<'_>,
    layers: &[BodyLayers; LANES],
    states: &mut LayerStates,
    pose: &mut ModelPose<F>,
) {
    for (side, arm) in ARMS.into_iter().enumerate() {
        let (mut wrists, mut poles): (Lane3, Lane3) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
        let mut aims: [Option<ArmAim>; LANES] = std::array::from_fn(|_| None);
        for (lane, aim) in aims.iter_mut().enumerate() {
            let (order, state) = (layers[lane].arms[side], &mut states.lanes[lane].arms[side]);
            let kind = order.map_or(0, |layer| layer.kind());
            if kind == 0 && state.kind == 0 {
                continue;
            }
            let place = |joint: Joint| place_of(pose, joint, lane);
            if tick.dt_s > 0.0 {
                let angles = match order {
                    Some(ArmLayer::Point(at)) => {
                        let to = maths::rotate(place(Joint::UpperChest).1.conjugate(), at - place(arm[0]).0);
                        pointing_angles(to * Vec3::new(OUT[side], 1.0, 1.0))
                    }
                    _ => None,
                };
                let shown = ArmState { kind: if state.kind == 0 { kind } else { state.kind }, ..*state };
                let way = shown.find_aim(body, lane, side, place).wrist.distance(place(arm[2]).0);
                state.follow(tick, kind, angles, way);
            }
            if state.kind == 0 || state.share.value == 0.0 {
                continue;
            }
            let found = state.find_aim(body, lane, side, place);
            set_lane(&mut wrists, lane, found.wrist);
            set_lane(&mut poles, lane, found.pole);
            *aim = Some(found);
        }
        if aims.iter().all(Option::is_none) {
            continue;
        }
        let (start, lengths) = (pose.positions[arm[0].index()], pair_lengths::<F>(&body.arms[side]));
        let reach = load::<F>(&wrists) - start;
        let direction = reach * (F::splat(1.0) / reach.length().max(F::splat(1e-4)));
        let d = soft_distance(reach.length(), lengths, F::splat(0.0)).max((lengths[0] + lengths[1]) * F::splat(FOLDED));
        let middle = bent_middle(start, direction, d, lengths, load(&poles));
        for (lane, aim) in aims.iter().enumerate() {
            let Some(aim) = aim else { continue };
            let bent = [middle.lane(lane), (start + direction * d).lane(lane)];
            turn_arm(body, lane, side, aim, bent, states.lanes[lane].arms[side].share.value, pose);
        }
    }
    states.active = states.lanes.each_ref().map(|state| f32::from(u8::from(*state != LayerState::ZERO)));
}

/// Turns the joints of one arm from where they are to a posture.
fn turn_arm<F: Lanes>(
    body: &LaneBody,
    lane: usize,
    side: usize,
    aim: &ArmAim,
    [elbow, wrist]: [Vec3; 2],
    share: f32,
    pose: &mut ModelPose<F>,
) {
    let out = OUT[side];
    let arm = ARMS[side];
    let [(shoulder, upper), (_, lower), (_, hand)] = arm.map(|j| place_of(pose, j, lane));
    let [u, f] = [elbow - shoulder, wrist - elbow].map(|bone| bone.normalize_or(Vec3::X * out));
    // The elbow is a hinge: both parts bend about one axis, which is that of the flat rest pose.
    let hinge = (wrist - shoulder).cross(aim.pole).normalize_or(Vec3::Y) * out;
    let wanted = if aim.hand == Vec3::ZERO { f } else { aim.hand.normalize_or(f) };
    let along = f.dot(wanted).clamp(-1.0, 1.0);
    let across = (wanted - f * along).normalize_or_zero();
    let bent = f * WRIST_COS + across * (1.0 - WRIST_COS * WRIST_COS).sqrt();
    let h = if along < WRIST_COS { bent } else { wanted };
    let back = -aim.palm;
    let rolled = (hinge + (back - f * back.dot(f)).normalize_or(hinge)).normalize_or(hinge);
    let new = [facing(u * out, hinge), facing(f * out, rolled), facing(h * out, back)];
    // Joints turn relative to what carries them, so that an elbow stays a hinge on the way.
    let (_, clavicle) = place_of(pose, ARMS[side][0].parent().unwrap_or(Joint::UpperChest), lane);
    let (mut was, mut is, mut shown) = (clavicle, clavicle, clavicle);
    let mut at = shoulder;
    for (k, (old, new)) in [upper, lower, hand].into_iter().zip(new).enumerate() {
        let [a, b] = [(was, old), (is, new)].map(|(above, q)| maths::compose(above.conjugate(), q));
        (was, is) = (old, new);
        if k > 0 {
            at += maths::rotate(shown, get_lane(&body.offsets[arm[k].index()], lane));
        }
        shown = maths::normalize_or_identity(maths::compose(shown, maths::slerp_f32(a, b, share)));
        pose.positions[arm[k].index()].set_lane(lane, at);
        pose.rotations[arm[k].index()].set_lane(lane, shown);
    }
}

/// The rotation that takes +X to `x`, and +Y as near to `y` as it can (unit length).
fn facing(x: Vec3, y: Vec3) -> Quat {
    let y = (y - x * x.dot(y)).normalize_or(x.any_orthonormal_vector());
    maths::normalize_or_identity(Quat::from_mat3(&Mat3::from_cols(x, y, x.cross(y))))
}

/// Position and rotation of a joint of one lane.
fn place_of<F: Lanes>(pose: &ModelPose<F>, joint: Joint, lane: usize) -> (Vec3, Quat) {
    (pose.positions[joint.index()].lane(lane), pose.rotations[joint.index()].lane(lane))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::events::ClipRows;
    use crate::body::hierarchy::{shared, to_model};
    use crate::body::sample::LanePose;
    use crate::body::volume::BodyVolume;
    use crate::skeleton::{NUM_JOINTS, Skeleton};
    use throng_base::simd::{ArrayLanes, Q, V};
    use throng_geometry::overlap_depth;

    const DT_S: f32 = 1.0 / 60.0;
    /// Joints that no arm carries.
    const REST: [Joint; 14] = [
        Joint::Hips,
        Joint::Spine,
        Joint::Chest,
        Joint::UpperChest,
        Joint::Neck,
        Joint::Head,
        Joint::LeftThigh,
        Joint::LeftShin,
        Joint::LeftFoot,
        Joint::LeftToe,
        Joint::RightThigh,
        Joint::RightShin,
        Joint::RightFoot,
        Joint::RightToe,
    ];

    fn skeletons() -> [Skeleton; 3] {
        let scaled = |size: f32, arms: f32| {
            let mut s = Skeleton::default();
            s.offsets.iter_mut().chain(&mut s.tips).for_each(|o| *o *= size);
            for arm in ARMS {
                arm[1..].iter().for_each(|j| s.offsets[j.index()] *= arms);
            }
            s
        };
        [scaled(1.0, 1.0), scaled(0.62, 0.95), scaled(1.08, 1.06)]
    }

    /// Somebody who walks with swinging arms, turns trunk and head, each seed in its own way.
    fn motion(skeleton: &Skeleton, seed: usize, time_s: f32) -> ModelPose<ArrayLanes> {
        let wave = |k: usize, size: f32| size * maths::sin(6.0 * time_s + (1.7 * k as f32 + 2.3 * seed as f32));
        let mut rotations = [Quat::IDENTITY; NUM_JOINTS];
        let mut set = |j: Joint, q: Quat| rotations[j.index()] = q;
        set(Joint::Hips, Quat::from_rotation_y(wave(0, 0.1)));
        set(Joint::Spine, Quat::from_rotation_x(0.06 * (seed % 4) as f32 + wave(1, 0.04)));
        set(Joint::UpperChest, Quat::from_rotation_y(wave(2, 0.12)));
        set(Joint::Head, Quat::from_rotation_y(wave(3, 0.4)) * Quat::from_rotation_x(wave(4, 0.15)));
        for (side, [upper, lower, hand]) in ARMS.into_iter().enumerate() {
            let out = [1.0, -1.0][side];
            let swing = Quat::from_rotation_x(wave(5 + side, 0.1 + 0.08 * (seed % 5) as f32));
            set(upper, swing * Quat::from_rotation_z(-out * (1.37 - 0.02 * (seed % 3) as f32)));
            set(lower, Quat::from_rotation_y(-out * (0.35 + wave(7, 0.15))));
            set(hand, Quat::from_rotation_x(wave(8, 0.1)));
        }
        let all = |q: &Quat| Q::new(V::<ArrayLanes>::splat(q.xyz()), ArrayLanes::splat(q.w));
        let pose = LanePose { root: V::splat(skeleton.offsets[0]), rotations: rotations.each_ref().map(all) };
        to_model(shared(skeleton), &pose)
    }

    /// Deepest that forearms and hands are in trunk and head (m).
    fn depth(skeleton: &Skeleton, pose: &ModelPose<ArrayLanes>, side: usize) -> f32 {
        let volume = BodyVolume::new(skeleton);
        let place = |joint: Joint, p: Vec3| {
            let (at, turn) = place_of(pose, joint, 3);
            at + turn * p
        };
        let core = volume.place_core(place);
        let depth = |j: &Joint| {
            let arm = volume.capsules[j.index()].placed(place);
            core.iter().map(|c| overlap_depth(c, &arm)).fold(f32::NEG_INFINITY, f32::max)
        };
        ARMS[side][1..].iter().map(depth).fold(f32::NEG_INFINITY, f32::max)
    }

    fn bits(pose: &ModelPose<ArrayLanes>, joint: Joint) -> [u32; 7] {
        let (at, turn) = place_of(pose, joint, 3);
        let [x, y, z, w] = turn.to_array();
        [at.x, at.y, at.z, x, y, z, w].map(f32::to_bits)
    }

    /// Axis of the forearm in the frame of the upper arm, outwards positive: +X straight, +Z bent by a right angle.
    fn forearm(pose: &ModelPose<ArrayLanes>, side: usize) -> Vec3 {
        let [upper, lower, hand] = ARMS[side].map(|j| place_of(pose, j, 3));
        upper.1.inverse() * (hand.0 - lower.0).normalize() * Vec3::new([1.0, -1.0][side], 1.0, 1.0)
    }

    fn layers() -> Vec<ArmLayer> {
        let at = [[0.3, 1.2, 4.0], [-0.6, 2.4, 3.0], [2.5, 0.4, 1.5], [3.0, 1.5, -0.4]];
        let others = (2..7).filter_map(|n| ArmLayer::from_number(n, Vec3::ZERO));
        at.into_iter().map(|at| ArmLayer::Point(at.into())).chain(others).collect()
    }

    /// Each layer of both arms fades in, stays, and fades out, over many manners of walking and three sizes of bodies.
    #[test]
    fn arms_are_where_layers_have_them_without_haste_and_never_in_the_body() {
        let mut deepest = (f32::NEG_INFINITY, ArmLayer::Wave, 0);
        for skeleton in skeletons() {
            let body = LaneBody::from_skeleton(&skeleton);
            let size = skeleton.leg_length() / REFERENCE_LEG_M;
            for (seed, layer) in (0..12).flat_map(|seed| layers().into_iter().map(move |layer| (seed, layer))) {
                let out = |v: Vec3, side: usize| v * Vec3::new([1.0, -1.0][side], 1.0, 1.0);
                let at = |side: usize| if let ArmLayer::Point(at) = layer { out(at, side) * size } else { Vec3::ZERO };
                let orders = |is_on: bool| {
                    let arms = [0, 1].map(|side| match layer {
                        ArmLayer::Point(_) => Some(ArmLayer::Point(at(side))).filter(|_| is_on),
                        _ => Some(layer).filter(|_| is_on),
                    });
                    [BodyLayers { arms, ..BodyLayers::NONE }; LANES]
                };
                let mut states = LayerStates::ZERO;
                let rows = ClipRows::default();
                let tick = LayerTick::new(&rows, DT_S);
                let mut was: Option<[Vec3; 2]> = None;
                for k in 0..300 {
                    let time_s = k as f32 * DT_S;
                    let plain = motion(&skeleton, seed, time_s);
                    let mut pose = motion(&skeleton, seed, time_s);
                    let is_on = (20..180).contains(&k);
                    layer_arms(&body, &tick, &orders(is_on), &mut states, &mut pose);
                    for j in REST {
                        assert_eq!(bits(&pose, j), bits(&plain, j), "{layer:?} moves {}", j.name());
                    }
                    if !(20..290).contains(&k) {
                        let arms = ARMS.as_flattened();
                        assert!(arms.iter().all(|j| bits(&pose, *j) == bits(&plain, *j)), "{layer:?} is left at {k}");
                    }
                    let hands = ARMS.map(|arm| place_of(&pose, arm[2], 3).0);
                    let own = ARMS.map(|arm| place_of(&plain, arm[2], 3).0);
                    if let Some(was) = was.replace(hands) {
                        for side in 0..2 {
                            let mps = hands[side].distance(was[side]) / DT_S;
                            assert!(mps < 5.0, "{layer:?} of {seed}: a hand moves at {mps} m/s in frame {k}");
                        }
                    }
                    for side in 0..2 {
                        let bent = forearm(&pose, side);
                        assert!(
                            bent.z > -0.03,
                            "{layer:?} of {seed}: an elbow bends the wrong way in frame {k}: {bent}"
                        );
                        assert!(bent.x > -0.87, "{layer:?} of {seed}: an elbow bends too far: {bent}");
                        let in_body = depth(&skeleton, &pose, side) - depth(&skeleton, &plain, side).max(0.0);
                        if in_body > deepest.0 {
                            deepest = (in_body, layer, k);
                        }
                    }
                    if k == 150 {
                        check_posture(&skeleton, &pose, layer, at, own);
                    }
                }
            }
        }
        println!("deepest {deepest:?}");
        assert!(deepest.0 < 0.012, "a hand or a forearm is in the body: {deepest:?}");
    }

    /// What each posture looks like once it is there.
    fn check_posture(
        skeleton: &Skeleton,
        pose: &ModelPose<ArrayLanes>,
        layer: ArmLayer,
        at: impl Fn(usize) -> Vec3,
        own: [Vec3; 2],
    ) {
        let size = skeleton.leg_length() / REFERENCE_LEG_M;
        let head = place_of(pose, Joint::Head, 3);
        let ear = |side: usize| head.0 + head.1 * (skeleton.tips[0] * 0.5 + Vec3::X * [0.1, -0.1][side] * size);
        for side in 0..2 {
            let [shoulder, elbow, wrist] = ARMS[side].map(|j| place_of(pose, j, 3).0);
            let hand = place_of(pose, ARMS[side][2], 3).1;
            let palm = wrist + hand * (skeleton.offsets[ARMS[side][2].index()] * 0.35);
            match layer {
                ArmLayer::Point(_) => {
                    let off = (wrist - shoulder).angle_between(at(side) - shoulder).to_degrees();
                    assert!(off < 4.0, "{layer:?}: {off} degrees off");
                    assert!((wrist - shoulder).angle_between(elbow - shoulder) < 0.3);
                }
                ArmLayer::Wave => assert!(palm.y > shoulder.y + 0.2 * size && elbow.y > shoulder.y - 0.22 * size),
                ArmLayer::Phone => {
                    let fingers = wrist + hand * (Vec3::X * [0.18, -0.18][side] * size);
                    assert!(
                        fingers.distance(ear(side)) < 0.08 * size,
                        "{} m from the ear",
                        fingers.distance(ear(side))
                    );
                    let inwards = head.1.inverse() * (hand * Vec3::NEG_Y);
                    assert!(inwards.x * [1.0, -1.0][side] < -0.7, "the palm is turned to the head: {inwards}");
                }
                ArmLayer::CarryBefore => {
                    assert!(wrist.z > 0.1 * size && (0.2..0.5).contains(&((shoulder.y - wrist.y) / size)), "{wrist}");
                }
                ArmLayer::CarryBeside => assert!((wrist - own[side]).length() < 0.35 * size && wrist.y < elbow.y),
                ArmLayer::CarryOnShoulder => assert!(palm.y > shoulder.y && palm.distance(shoulder) < 0.3 * size),
                ArmLayer::Reach { .. } => {}
            }
        }
    }

    /// One that is replaced is left first, and what cannot be pointed at is not.
    #[test]
    fn layers_follow_each_other_and_arms_point_at_nothing_behind() {
        let skeleton = Skeleton::default();
        let (body, rows) = (LaneBody::from_skeleton(&skeleton), ClipRows::default());
        let tick = LayerTick::new(&rows, DT_S);
        let mut states = LayerStates::ZERO;
        let mut shown = Vec::new();
        for k in 0..360 {
            let mut pose = motion(&skeleton, 1, k as f32 * DT_S);
            let order = match k / 120 {
                0 => ArmLayer::Wave,
                1 => ArmLayer::Phone,
                _ => ArmLayer::Point(Vec3::new(-0.5, 1.0, -3.0)),
            };
            let layers = BodyLayers { arms: [Some(order), None], ..BodyLayers::NONE };
            layer_arms(&body, &tick, &[layers; LANES], &mut states, &mut pose);
            assert!(states.lanes.iter().all(|state| state.arms[0].is_sound() && state.arms[1] == ArmState::ZERO));
            shown.push((states.lanes[0].arms[0].kind, states.lanes[0].arms[0].share.value));
        }
        assert!(shown[100].0 == 2 && shown[100].1 > 0.95, "{:?}", shown[100]);
        assert!(shown[230].0 == 6 && shown[230].1 > 0.9, "{:?}", shown[230]);
        assert!(shown[350].1 < 0.01, "{:?}", shown[350]);
        let jumps = shown.windows(2).map(|w| (w[1].1 - w[0].1).abs());
        assert!(jumps.fold(0.0, f32::max) < 0.1);
    }
}
