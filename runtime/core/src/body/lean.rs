//! Leaning and stooping: what a hand reaches for may be farther than an arm is long.
//!
//! Hips sink where a thing lies low, and the trunk turns towards it at the waist and below the chest, only as far as the arm
//! is too short. A trunk, an arm and what it reaches for are a chain of two parts, as a leg is.

use super::lane_body::{ARMS, LaneBody};
use super::{hierarchy::ModelPose, limbs::bent_middle, reach::soft_length};
use crate::skeleton::Joint;
use glam::Vec3;
use std::ops::RangeInclusive;
use throng_base::simd::{Lanes, Q, V};

/// Most that a trunk leans at the waist, and as much again below the chest (tangent of a quarter of 0.7 rad).
const MOST: f32 = 0.1768;
/// Share of a lean that is made at the waist; the rest is made below the chest.
const AT_WAIST: f32 = 0.5;
/// Largest lean of a trunk before hips sink: up, and towards the target (cosine and sine of 0.8 rad).
const BEFORE_SINKING: [f32; 2] = [0.6967, 0.7174];
/// Furthest that hips sink (m, of the database skeleton).
const LOWEST_M: f32 = 0.5;
/// Share of the arm's length over which a hand is level with its shoulder at least, where hips sink.
const LEVEL: f32 = 0.3;
/// Joints above the waist, and above the middle of the trunk, by index.
const ABOVE: [RangeInclusive<usize>; 2] =
    [Joint::Spine as usize..=Joint::RightHand as usize, Joint::Chest as usize..=Joint::RightHand as usize];

/// Distance by which hips sink for a hand that reaches `to` (m).
///
/// - `share`: weight with which the hand is taken there (0 to 1).
#[inline(always)]
pub(crate) fn hips_sink<F: Lanes>(body: &LaneBody, side: usize, to: V<F>, share: F, pose: &ModelPose<F>) -> F {
    let (zero, tiny) = (F::splat(0.0), F::splat(1e-3));
    let [waist, shoulder] = [Joint::Spine, ARMS[side][0]].map(|j| pose.positions[j.index()]);
    let (trunk, arm): (F, F) = ((shoulder - waist).length(), soft_length(&body.arms[side]));
    let offset = to - waist;
    let ahead = V::new(offset.x, zero, offset.z);
    let ahead = ahead * (F::splat(1.0) / ahead.length().max(tiny));
    let [up, along] = BEFORE_SINKING.map(F::splat);
    let leaned = waist + V::new(zero, trunk * up, zero) + ahead * (trunk * along);
    let off = to - leaned;
    let down = (arm * arm - off.x * off.x - off.z * off.z).max(arm * arm * F::splat(LEVEL * LEVEL)).sqrt();
    (-off.y - down).max(zero).min(F::splat(LOWEST_M) * F::load(&body.scale)) * share
}

/// Leans a trunk so that an arm reaches `to`, if it is too short.
///
/// - `share`: how far the hand is taken there (0 to 1).
#[inline(always)]
pub(crate) fn lean_trunk<F: Lanes>(body: &LaneBody, side: usize, to: V<F>, share: F, pose: &mut ModelPose<F>) {
    let (one, tiny) = (F::splat(1.0), F::splat(1e-4));
    let arm: F = soft_length(&body.arms[side]);
    for (above, part) in ABOVE.into_iter().zip([AT_WAIST, 1.0]) {
        let (pivot, shoulder) = (pose.positions[*above.start()], pose.positions[ARMS[side][0].index()]);
        let (trunk, offset) = (shoulder - pivot, to - pivot);
        let (length, distance) = (trunk.length().max(tiny), offset.length().max(tiny));
        let direction = offset * (one / distance);
        let most = (length + arm) * F::splat(0.999);
        let least = (length - arm).abs() + F::splat(1e-3);
        let pole = trunk + V::splat(Vec3::Z * 1e-3);
        let aim = bent_middle(pivot, direction, distance.min(most).max(least), [length, arm], pole);
        let turn = Q::shortest_arc(trunk, aim - pivot).to_mrp();
        let angle = turn.length().max(tiny);
        let is_short = F::select_lt(arm, (to - shoulder).length(), one, F::splat(0.0));
        let kept = (F::splat(MOST) / angle).min(F::splat(part)) * share * is_short;
        let turn = Q::from_mrp(turn * kept);
        for j in above {
            pose.positions[j] = pivot + turn.rotate(pose.positions[j] - pivot);
            pose.rotations[j] = turn * pose.rotations[j];
        }
    }
}
