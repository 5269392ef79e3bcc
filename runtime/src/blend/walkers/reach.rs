//! Reaching: hips low enough for both legs, then legs and arms by analytic inverse kinematics.

use super::body::{ARMS, LEGS, LaneBody};
use super::feet::Sole;
use crate::lanes::{Functions, Lanes, Q, V};
use crate::skeleton::NUM_JOINTS;
use crate::troupe::block::{Lane, load};
use crate::troupe::foot_lock::bend;
use crate::troupe::hierarchy::ModelPose;
use glam::Vec3;

/// Share of a leg's length past which it gives way softly, and what it never passes.
const SOFT: f32 = 0.98;
const HARD: f32 = 0.999;
/// Share of its length by which a leg may be too short for a planted foot before the foot is released.
const STRETCH: f32 = 0.004;
/// Furthest that the hips are lowered. [Unit: m, of the database skeleton]
const LOWEST_M: f32 = 0.08;

/// Lowers the whole body so that both legs reach their ankles softly, each as far as its foot's place matters.
///
/// - `drop`: how far it was lowered at the last step, and is now. [Unit: m]
/// - `keep`: what is left of a difference to that after the tick.
#[inline(always)]
pub(crate) fn lower<F: Lanes>(
    body: &LaneBody,
    soles: &[Sole<F>; 2],
    importance: [F; 2],
    (drop_before, keep): (&mut Lane, f32),
    pose: &mut ModelPose<F>,
) {
    let mut drop = F::splat(0.0);
    for (side, sole) in soles.iter().enumerate() {
        let leg = &body.legs[side];
        let reach = (F::load(&leg.lengths[0]) + F::load(&leg.lengths[1])) * F::splat(SOFT);
        let hip = pose.positions[LEGS[side][0].index()];
        let way = hip - sole.ankle;
        let up = (reach * reach - way.x * way.x - way.z * way.z).max(reach * reach * F::splat(0.1)).sqrt();
        // Whole where the foot stands: half of the blend is enough for that.
        drop = drop.max((way.y - up) * (importance[side] + importance[side]).min(F::splat(1.0)));
    }
    let drop = drop.min(F::splat(LOWEST_M) * F::load(&body.scale));
    let drop = drop + (F::load(drop_before) - drop) * F::splat(keep);
    *drop_before = drop.to_array();
    for j in 0..NUM_JOINTS {
        pose.positions[j].y = pose.positions[j].y - drop;
    }
}

/// 1 where a leg, the hips lowered as they are, is too short for its foot by more than what cannot be seen, else 0.
#[inline(always)]
pub(crate) fn stretched<F: Lanes>(body: &LaneBody, side: usize, sole: &Sole<F>, pose: &ModelPose<F>) -> F {
    let leg = &body.legs[side];
    let reach = (F::load(&leg.lengths[0]) + F::load(&leg.lengths[1])) * F::splat(1.0 + STRETCH);
    let distance = (sole.ankle - pose.positions[LEGS[side][0].index()]).length();
    F::select_lt(reach, distance, F::splat(1.0), F::splat(0.0))
}

/// Bends a leg so that its foot lies where it goes.
#[inline(always)]
pub(crate) fn reach_foot<F: Lanes>(body: &LaneBody, side: usize, sole: &Sole<F>, pose: &mut ModelPose<F>) {
    let [thigh, shin, foot, toe] = LEGS[side].map(|j| j.index());
    let lengths = both(&body.legs[side].lengths);
    // Where the leg is straight, it bends towards the toes.
    let hint = pose.rotations[thigh].rotate(V::splat(Vec3::Z * 0.02));
    reach([thigh, shin, foot], lengths, hint, sole.ankle, pose);
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
    let lengths = both(&body.arms[side]);
    let hint = pose.rotations[arm[0]].rotate(V::splat(Vec3::NEG_Z * 0.02));
    let hand = pose.positions[arm[2]];
    reach(arm, lengths, hint, hand + (to - hand) * touch, pose);
}

#[inline(always)]
fn both<F: Lanes>(lengths: &[Lane; 2]) -> [F; 2] {
    [F::load(&lengths[0]), F::load(&lengths[1])]
}

/// Turns both parts of a limb so that its end comes to a place, its middle staying in the plane that it bends in.
#[inline(always)]
fn reach<F: Lanes>([upper, lower, end]: [usize; 3], lengths: [F; 2], hint: V<F>, to: V<F>, pose: &mut ModelPose<F>) {
    let (start, middle, was) = (pose.positions[upper], pose.positions[lower], pose.positions[end]);
    let aim = to - start;
    let distance = aim.length().max(F::splat(1e-4));
    let direction = aim * (F::splat(1.0) / distance);
    let d = soft(distance, lengths);
    let new_middle = bend(start, direction, d, lengths, (middle - start) + hint);
    let new_end = start + direction * d;
    pose.rotations[upper] = Q::between(middle - start, new_middle - start) * pose.rotations[upper];
    pose.rotations[lower] = Q::between(was - middle, new_end - new_middle) * pose.rotations[lower];
    pose.positions[lower] = new_middle;
    pose.positions[end] = new_end;
}

/// A distance that never quite stretches a limb: as it is up to a share of the length, then ever less.
#[inline(always)]
fn soft<F: Lanes>(distance: F, [l1, l2]: [F; 2]) -> F {
    let length = l1 + l2;
    let (from, room) = (length * F::splat(SOFT), length * F::splat(HARD - SOFT));
    let over = (distance - from).max(F::splat(0.0));
    let soft = from + room * (F::splat(1.0) - (-(over / room)).exp());
    F::select_lt(from, distance, soft, distance).max((l1 - l2).abs() + F::splat(1e-3))
}
