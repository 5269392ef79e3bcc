//! Reaching: hips low enough for both legs, then legs and arms by analytic inverse kinematics.

use super::foot_lock::{Bearing, FootLock, SolePose};
use super::lane_body::{ARMS, LEGS, LaneBody};
use super::lanes::{Lane, load};
use super::lean::{hips_sink, lean_trunk};
use super::springs::DampedSpring;
use super::{arms::ArmLayer, feet::FeetMotion, hierarchy::ModelPose, limbs::bent_middle, step::BodyState};
use crate::{hits::FIST_PER_FOREARM, planar::Planar, skeleton::NUM_JOINTS};
use glam::{Vec2, Vec3};
use throng_base::simd::{Functions, LANES, Lanes, Q, V};

/// Share of a leg's length beyond which its distance is softened, and the share that it never exceeds.
const SOFT: f32 = 0.97;
const HARD: f32 = 0.999;
/// Share of a leg's length up to which it stretches where its motion is known: the knee stays soft.
const NATURAL: f32 = 0.995;
/// Share of a leg's length past which a planted foot is released: it does not quite reach it any more.
const STRETCH: f32 = 1.0;
/// The same as a share of the length that the leg has in its motion.
const NATURAL_STRETCH: f32 = 1.05;
/// Distance of the hip ahead of the ankle at which a heel may wholly rise to lengthen a leg (m, of the database
/// skeleton).
const TRAILING_M: f32 = 0.1;
/// Rise of the heel up to which it still bears (m).
const LIFTED_M: f32 = 0.002;
/// Furthest that the hips are lowered for legs (m, of the database skeleton).
const LOWEST_M: f32 = 0.08;

/// Time in which a difference in how far the hips are lowered halves (s).
const DROP_HALF_LIFE_S: f32 = 0.06;

/// Spring by which hips are lowered.
pub(crate) fn drop_spring(dt_s: f32) -> DampedSpring {
    DampedSpring::new(dt_s, DROP_HALF_LIFE_S)
}

/// Lowers the whole body so that both legs reach their ankles softly, each as far as its foot's place matters.
///
/// - `spring`: how a difference to what is needed fades.
#[inline(always)]
pub(crate) fn lower_body<F: Lanes>(
    body: &LaneBody,
    soles: &[SolePose<F>; 2],
    motion: &FeetMotion<'_, F>,
    state: &mut BodyState,
    spring: &DampedSpring,
    pose: &mut ModelPose<F>,
) {
    let mut drop = F::splat(0.0);
    for (side, (sole, foot)) in soles.iter().zip(&motion.feet).enumerate() {
        // As far as its motion has the leg, where that is known.
        let reach = soft_length::<F>(&body.legs[side].lengths).max(foot.leg);
        let hip = pose.positions[LEGS[side][0].index()];
        let offset = hip - sole.ankle;
        let up = (reach * reach - offset.x * offset.x - offset.z * offset.z).max(reach * reach * F::splat(0.1)).sqrt();
        // Whole where the foot stands: half of the blend is enough for that.
        drop = drop.max((offset.y - up) * (foot.importance + foot.importance).min(F::splat(1.0)));
    }
    let drop = drop.min(F::splat(LOWEST_M) * F::load(&body.scale)).max(motion.sunk);
    let (off, rate) = spring.pull_lanes(F::load(&state.drop) - drop, F::load(&state.drop_rate));
    let drop = drop + off;
    (state.drop, state.drop_rate) = (drop.to_array(), rate.to_array());
    for j in 0..NUM_JOINTS {
        pose.positions[j].y = pose.positions[j].y - drop;
    }
}

/// Raises the heel over the ball, which stays in place, where the leg is too short for a trailing flat foot, as people
/// do before the foot leaves the ground.
///
/// - `natural`: length up to which the leg is as the motion has it (m).
/// - `bearing`: its heel no longer bears where it has risen.
#[inline(always)]
pub(crate) fn raise_heel<F: Lanes>(
    body: &LaneBody,
    side: usize,
    natural: F,
    sole: &mut SolePose<F>,
    bearing: &mut Bearing,
    pose: &ModelPose<F>,
) {
    let (zero, one, tiny) = (F::splat(0.0), F::splat(1.0), F::splat(1e-3));
    let leg = &body.legs[side];
    let hip = pose.positions[LEGS[side][0].index()];
    let offset = hip - sole.ankle;
    let leg_now = offset.length();
    // Where its motion is known, the heel rises there.
    let reach = F::select_lt(zero, natural, F::splat(f32::MAX), soft_length(&leg.lengths));
    // Only where the hip is ahead of the foot.
    let share = (offset.z / (F::load(&body.scale) * F::splat(TRAILING_M))).min(one).max(zero);
    let to_ball = sole.foot.rotate(load(&leg.ball));
    let wanted = leg_now - (leg_now - reach).max(zero) * share;
    let (ball, foot) = (sole.ankle + to_ball, to_ball.length());
    let from_ball = hip - ball;
    let distance = from_ball.length().max(tiny);
    let d = distance.min((foot + wanted) * F::splat(HARD));
    let ankle = bent_middle(ball, from_ball * (one / distance), d, [foot, wanted], sole.ankle - ball);
    let ankle = V::select_lt(reach, leg_now, ankle, sole.ankle);
    let raised = Q::shortest_arc(V::new(zero, zero, zero) - to_ball, ankle - ball);
    let risen = ankle.y - sole.ankle.y;
    bearing[0] = F::select_lt(F::splat(LIFTED_M), risen, zero, F::load(&bearing[0])).to_array();
    sole.foot = raised * sole.foot;
    sole.ankle = ankle;
}

/// 1 where a leg, the hips lowered as they are, is too short for its foot by more than what cannot be seen, else 0.
#[inline(always)]
pub fn is_stretched<F: Lanes>(body: &LaneBody, side: usize, natural: F, sole: &SolePose<F>, pose: &ModelPose<F>) -> F {
    let leg = &body.legs[side];
    let reach = ((F::load(&leg.lengths[0]) + F::load(&leg.lengths[1])) * F::splat(STRETCH))
        .max(natural * F::splat(NATURAL_STRETCH));
    let distance = (sole.ankle - pose.positions[LEGS[side][0].index()]).length();
    F::select_lt(reach, distance, F::splat(1.0), F::splat(0.0))
}

/// Length of a leg that reaches for its foot (m). In the air the rate of the knee is limited: the foot comes a little later, since a
/// small displacement of the foot turns the knee of a nearly straight leg far.
///
/// - `change`: largest turn of the knee in this tick (rad).
#[inline(always)]
pub(crate) fn limit_leg_length<F: Lanes>(
    body: &LaneBody,
    side: usize,
    natural: F,
    foot: &mut FootLock,
    sole: &SolePose<F>,
    change: F,
    pose: &ModelPose<F>,
) -> F {
    let (zero, half, one) = (F::splat(0.0), F::splat(0.5), F::splat(1.0));
    let lengths = pair_lengths(&body.legs[side].lengths);
    let (longest, shortest) = (lengths[0] + lengths[1], lengths[0] - lengths[1]);
    let room = longest * longest - shortest * shortest;
    let hip = pose.positions[LEGS[side][0].index()];
    // The cosine of half the angle at the knee: 0 where the leg is straight.
    let reached = soft_distance((sole.ankle - hip).length(), lengths, natural);
    let aim = ((longest * longest - reached * reached) / room).max(zero).min(one).sqrt();
    let was = F::load(&foot.bent);
    let free = (one - F::load(&foot.down)) * F::load(&foot.seen);
    let most = half * change * (one - was * was).max(F::splat(0.01)).sqrt();
    let slow = was + (aim - was).min(most).max(-most);
    let now = F::select_lt(half, free, slow, aim);
    now.store(&mut foot.bent);
    F::select_lt(half, free, (longest * longest - now * now * room).max(zero).sqrt(), reached)
}

/// Bends a leg so that its foot lies in the direction of where it goes, at a distance from the hip (m).
#[inline(always)]
pub(crate) fn reach_foot<F: Lanes>(
    body: &LaneBody,
    side: usize,
    natural: F,
    distance: F,
    sole: &SolePose<F>,
    pose: &mut ModelPose<F>,
) {
    let [thigh, shin, foot, toe] = LEGS[side].map(|j| j.index());
    let lengths = pair_lengths(&body.legs[side].lengths);
    // Where the leg is straight, it bends towards the toes.
    let bend = F::select_lt(F::splat(0.0), natural, F::splat(0.02), F::splat(0.06));
    let hint = pose.rotations[thigh].rotate(V::splat(Vec3::Z)) * bend;
    reach_with_limb([thigh, shin, foot], lengths, distance, hint, sole.ankle, pose);
    pose.rotations[foot] = sole.foot;
    pose.rotations[toe] = sole.toe;
    pose.positions[toe] = pose.positions[foot] + sole.foot.rotate(load(&body.offsets[toe]));
}

/// Bends an arm so that its hand lies where it touches.
///
/// - `touch`: how far it is taken there, 0 to 1.
#[inline(always)]
pub(crate) fn reach_hand<F: Lanes>(body: &LaneBody, side: usize, to: V<F>, touch: F, pose: &mut ModelPose<F>) {
    let arm = ARMS[side].map(|j| j.index());
    let lengths = pair_lengths(&body.arms[side]);
    let hint = pose.rotations[arm[0]].rotate(V::splat(Vec3::NEG_Z * 0.02));
    let hand = pose.positions[arm[2]];
    let before = arm.map(|j| (pose.positions[j], pose.rotations[j]));
    let to = hand + (to - hand) * touch;
    let distance = soft_distance((to - pose.positions[arm[0]]).length(), lengths, F::splat(0.0));
    reach_with_limb(arm, lengths, distance, hint, to, pose);
    // Arms without a target stay as they are, whatever the other lanes do.
    let zero = F::splat(0.0);
    for (j, (position, rotation)) in arm.into_iter().zip(before) {
        pose.positions[j] = V::select_lt(zero, touch, pose.positions[j], position);
        let (new, v) = (pose.rotations[j], V::select_lt(zero, touch, pose.rotations[j].v, rotation.v));
        pose.rotations[j] = Q::new(v, F::select_lt(zero, touch, new.w, rotation.w));
    }
}

/// Targets of the hands of eight characters.
pub(crate) struct Hands {
    /// Position of the left and right palm in model space (m), and its weight: a place in the world, for which the
    /// trunk leans.
    place: [([Lane; 3], Lane); 2],
    /// Position and weight of a palm target that moves with the body.
    to: [([Lane; 3], Lane); 2],
}

impl Hands {
    /// Hand targets of the characters of a block; none where no hand has one.
    ///
    /// - `root`: planar root of a lane.
    /// - `base`: height of the ground that the hips are held over (m).
    pub fn from_orders(
        orders: impl Iterator<Item = [Option<ArmLayer>; 2]> + Clone,
        root: impl Fn(usize) -> Planar,
        base: &Lane,
    ) -> Option<Self> {
        if !orders.clone().flatten().flatten().any(|arm| matches!(arm, ArmLayer::Reach { .. })) {
            return None;
        }
        let none = [([[0.0; LANES]; 3], [0.0; LANES]); 2];
        let mut out = Self { place: none, to: none };
        for (lane, hands) in orders.enumerate() {
            for (side, reach) in hands.iter().enumerate() {
                let Some(ArmLayer::Reach { place: (place, near), level: (level, raised) }) = *reach else { continue };
                let flat = root(lane).inverse_transform_point(Vec2::new(place.x, place.z));
                let place = Vec3::new(flat.x, place.y, flat.y);
                let level = level + Vec3::Y * base[lane];
                let share = near + raised;
                let to = (place * near + level * raised) / share.max(f32::MIN_POSITIVE);
                let set = |(lanes, shares): &mut ([Lane; 3], Lane), at: Vec3, share: f32| {
                    at.to_array().into_iter().zip(lanes).for_each(|(v, lanes)| lanes[lane] = v);
                    shares[lane] = share;
                };
                set(&mut out.place[side], place, near);
                set(&mut out.to[side], to, share.min(1.0));
            }
        }
        Some(out)
    }

    /// Distance by which hips sink so that hands reach low targets (m).
    #[inline(always)]
    pub fn hips_sink<F: Lanes>(&self, body: &LaneBody, pose: &ModelPose<F>) -> F {
        let of = |side: usize| {
            let (place, share) = &self.place[side];
            hips_sink(body, side, wrist(body, side, place, pose), F::load(share), pose)
        };
        of(0).max(of(1))
    }

    /// Bends arms so that palms lie there, and leans where they are too short.
    #[inline(always)]
    pub fn reach_places<F: Lanes>(&self, body: &LaneBody, pose: &mut ModelPose<F>) {
        let wrists = [0, 1].map(|side| [&self.place, &self.to].map(|of| wrist(body, side, &of[side].0, pose)));
        let arms = ARMS.map(|arm| arm.map(|j| (pose.positions[j.index()], pose.rotations[j.index()])));
        for (side, [place, _]) in wrists.iter().enumerate() {
            lean_trunk(body, side, *place, F::load(&self.place[side].1), pose);
        }
        let leans = F::load(&self.place[0].1).max(F::load(&self.place[1].1));
        for (joints, arm) in ARMS.into_iter().zip(arms) {
            hang_arm(joints.map(|j| j.index()), &arm, leans, pose);
        }
        for (side, &[_, to]) in wrists.iter().enumerate() {
            let share = F::load(&self.to[side].1);
            reach_hand(body, side, to, share, pose);
        }
    }
}

/// Arms keep their directions, however the trunk leans: one that reaches for nothing hangs.
///
/// - `arm`: positions and rotations before the trunk leaned.
/// - `leans`: how far it leans; where it does not, nothing is changed.
#[inline(always)]
fn hang_arm<F: Lanes>(joints: [usize; 3], arm: &[(V<F>, Q<F>); 3], leans: F, pose: &mut ModelPose<F>) {
    let (zero, shoulder) = (F::splat(0.0), pose.positions[joints[0]]);
    for (j, (position, rotation)) in joints.into_iter().zip(arm) {
        let hanging = shoulder + (*position - arm[0].0);
        pose.positions[j] = V::select_lt(zero, leans, hanging, pose.positions[j]);
        let now = pose.rotations[j];
        let w = F::select_lt(zero, leans, rotation.w, now.w);
        pose.rotations[j] = Q::new(V::select_lt(zero, leans, rotation.v, now.v), w);
    }
}

/// Position of a wrist that brings the palm to a place.
#[inline(always)]
fn wrist<F: Lanes>(body: &LaneBody, side: usize, place: &[Lane; 3], pose: &ModelPose<F>) -> V<F> {
    let hand = ARMS[side][2].index();
    let palm = pose.rotations[hand].rotate(load(&body.offsets[hand]) * F::splat(FIST_PER_FOREARM));
    let [x, y, z] = place.each_ref().map(|v| F::load(v));
    V::new(x, y, z) - palm
}

/// Length of a limb up to which it stretches for anything (m).
#[inline(always)]
pub(super) fn soft_length<F: Lanes>([l1, l2]: &[Lane; 2]) -> F {
    (F::load(l1) + F::load(l2)) * F::splat(SOFT)
}

#[inline(always)]
pub(super) fn pair_lengths<F: Lanes>(lengths: &[Lane; 2]) -> [F; 2] {
    [F::load(&lengths[0]), F::load(&lengths[1])]
}

/// Turns both parts of a limb so that its end lies in the direction of a place, its middle staying in the plane in which the limb
/// bends.
///
/// - `d`: distance of the end from the start of the limb (m).
/// - `hint`: where the middle of a straight limb goes (m).
#[inline(always)]
fn reach_with_limb<F: Lanes>(
    [upper, lower, end]: [usize; 3],
    lengths: [F; 2],
    d: F,
    hint: V<F>,
    to: V<F>,
    pose: &mut ModelPose<F>,
) {
    let (start, middle, was) = (pose.positions[upper], pose.positions[lower], pose.positions[end]);
    let aim = to - start;
    let direction = aim * (F::splat(1.0) / aim.length().max(F::splat(1e-4)));
    // The middle turns with the limb: it would point the other way where the end goes past it.
    let pole = Q::shortest_arc(was - start, aim).rotate((middle - start) + hint);
    let new_middle = bent_middle(start, direction, d, lengths, pole);
    let new_end = start + direction * d;
    pose.rotations[upper] = Q::shortest_arc(middle - start, new_middle - start) * pose.rotations[upper];
    pose.rotations[lower] = Q::shortest_arc(was - middle, new_end - new_middle) * pose.rotations[lower];
    pose.positions[lower] = new_middle;
    pose.positions[end] = new_end;
}

/// A distance that never quite stretches a limb: as it is up to a share of the length, or to the length that the limb has in its
/// motion; then ever less.
///
/// - `natural`: the length in its motion; 0 where none is known (m).
#[inline(always)]
pub(super) fn soft_distance<F: Lanes>(distance: F, [l1, l2]: [F; 2], natural: F) -> F {
    let length = l1 + l2;
    let from = natural.max(length * F::splat(SOFT)).min(length * F::splat(NATURAL));
    let room = length * F::splat(HARD) - from;
    let over = (distance - from).max(F::splat(0.0));
    let soft = from + room * (F::splat(1.0) - (-(over / room)).exp8());
    let soft = F::select_lt(from, distance, soft, distance);
    soft.max(distance.min(natural)).max((l1 - l2).abs() + F::splat(1e-3))
}
