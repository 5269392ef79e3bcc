//! Legs that reach: the knee and ankle of a leg by analytic inverse kinematics.

use super::hierarchy::ModelPose;
use super::lane_body::{LEGS, LaneBody};
use crate::skeleton::Joint;
use throng_base::simd::{Lanes, Q, V};
use throng_geometry::two_bone_offsets;

/// Share of the leg's length past which a corrected leg is not stretched, so that the knee stays soft.
const SOFT_REACH: f32 = 0.995;

/// Squared length of a correction that is none (m^2).
pub(crate) const NO_CORRECTION: f32 = 1e-10;

/// Position of the knee of a leg (or the elbow of an arm) that begins at `start` and ends `d` away in a direction.
///
/// - `lengths`: of the upper and the lower part (m).
/// - `pole`: direction of the knee; its component along the leg has no effect.
#[inline(always)]
pub(crate) fn bent_middle<F: Lanes>(start: V<F>, direction: V<F>, d: F, lengths: [F; 2], pole: V<F>) -> V<F> {
    let pole = pole - direction * pole.dot(direction);
    let pole = pole * (F::splat(1.0) / pole.length().max(F::splat(1e-6)));
    let [along, across] = two_bone_offsets(lengths, d, |v| v.max(F::splat(0.0)).sqrt());
    start + direction * along + pole * across
}

/// Moves the ankle by `correction` (model space) and bends the leg to reach; the foot keeps its orientation.
#[inline(always)]
pub(crate) fn move_leg<F: Lanes>(body: &LaneBody, side: usize, correction: V<F>, pose: &mut ModelPose<F>) {
    let [thigh_at, shin_at, foot_at, toe_at] = LEGS[side].map(Joint::index);
    let one = F::splat(1.0);
    let (hip, knee, ankle) = (pose.positions[thigh_at], pose.positions[shin_at], pose.positions[foot_at]);
    let [l1, l2] = body.legs[side].lengths.each_ref().map(|length| F::load(length));
    let before = ankle - hip;
    let aim = before + correction;
    let reach = ((l1 + l2) * F::splat(SOFT_REACH)).max(before.length());
    let distance = aim.length().max(F::splat(1e-4));
    let d = distance.min(reach).max((l1 - l2).abs() + F::splat(1e-3));
    let direction = aim * (one / distance);

    // The leg swings as a whole, then its knee bends in the plane it bent in before: it would point the other way where the
    // hip comes past the ankle. Where the leg is straight, it bends towards the toes.
    let swing = Q::shortest_arc(before, aim);
    let forward = pose.rotations[thigh_at].rotate(V::splat(glam::Vec3::Z));
    let (upper, lower) = (swing.rotate(knee - hip), swing.rotate(ankle - knee));
    let new_knee = bent_middle(hip, direction, d, [l1, l2], upper + swing.rotate(forward) * F::splat(0.02));
    let new_ankle = hip + direction * d;

    // Lanes that need no correction keep their leg to the last bit, whatever their neighbours do.
    let amount = correction.dot(correction);
    let (thigh, shin) = (pose.rotations[thigh_at], pose.rotations[shin_at]);
    pose.rotations[thigh_at] = chosen_q(amount, thigh, Q::shortest_arc(upper, new_knee - hip) * swing * thigh);
    pose.rotations[shin_at] = chosen_q(amount, shin, Q::shortest_arc(lower, new_ankle - new_knee) * swing * shin);
    let toe = pose.positions[toe_at];
    pose.positions[toe_at] = chosen_v(amount, toe, toe + (new_ankle - ankle));
    pose.positions[shin_at] = chosen_v(amount, knee, new_knee);
    pose.positions[foot_at] = chosen_v(amount, ankle, new_ankle);
}

/// Vector `new` where the correction is not negligible, else `old` (`amount`: m^2).
#[inline(always)]
pub(super) fn chosen_v<F: Lanes>(amount: F, old: V<F>, new: V<F>) -> V<F> {
    V::select_lt(F::splat(NO_CORRECTION), amount, new, old)
}

/// Rotation `new` where the correction is not negligible, else `old` (`amount`: m^2).
#[inline(always)]
pub(super) fn chosen_q<F: Lanes>(amount: F, old: Q<F>, new: Q<F>) -> Q<F> {
    Q::new(chosen_v(amount, old.v, new.v), F::select_lt(F::splat(NO_CORRECTION), amount, new.w, old.w))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::hierarchy::{shared, to_model};
    use crate::body::sample::LanePose;
    use crate::skeleton::Skeleton;
    use glam::{Quat, Vec3};
    use proptest::prelude::*;
    use throng_base::simd::ArrayLanes;

    /// The axis that the knee bends about, in the thigh's own frame; longer where it bends more.
    fn hinge(pose: &ModelPose<ArrayLanes>) -> Vec3 {
        let [thigh_at, shin_at, foot_at, _] = LEGS[0].map(Joint::index);
        let vec = |v: V<ArrayLanes>| Vec3::from_array([v.x, v.y, v.z].map(|x| x.to_array()[0]));
        let [hip, knee, ankle] = [thigh_at, shin_at, foot_at].map(|j| vec(pose.positions[j]));
        let thigh = pose.rotations[thigh_at];
        let turned = Quat::from_vec4(vec(thigh.v).extend(thigh.w.to_array()[0]));
        turned.inverse() * (knee - hip).normalize().cross((ankle - knee).normalize())
    }

    proptest! {
        /// Wherever the ankle is taken, as far as beyond the hip: a knee bends about the axis that it bent about, to the same side.
        #[test]
        fn knees_bend_about_their_hinges(
            bent in 0.05f32..2.0,
            thigh in prop::array::uniform3(-1.2f32..1.2),
            to in prop::array::uniform3(-1.0f32..1.0),
        ) {
            let skeleton = Skeleton::default();
            let [thigh_at, shin_at, foot_at, _] = LEGS[0].map(Joint::index);
            let all = |q: Quat| Q::new(V::<ArrayLanes>::splat(q.xyz()), ArrayLanes::splat(q.w));
            let mut rotations = [all(Quat::IDENTITY); crate::skeleton::NUM_JOINTS];
            rotations[thigh_at] = all(Quat::from_scaled_axis(Vec3::from_array(thigh)));
            rotations[shin_at] = all(Quat::from_rotation_x(bent));
            let mut pose = to_model(shared(&skeleton), &LanePose { root: V::<ArrayLanes>::splat(Vec3::Y), rotations });
            let before = hinge(&pose);
            let [hip, ankle] = [thigh_at, foot_at].map(|j| pose.positions[j]);
            let aim = V::splat(Vec3::from_array(to));
            // Half a turn has no axis of its own.
            let [was, now] = [ankle - hip, aim].map(|v| v * (ArrayLanes::splat(1.0) / v.length()));
            prop_assume!(was.dot(now).to_array()[0] > -0.98 && aim.length().to_array()[0] > 0.15);
            move_leg(&LaneBody::from_skeleton(&skeleton), 0, aim - (ankle - hip), &mut pose);
            let after = hinge(&pose);
            prop_assert!(after.dot(before) > 0.0 && after.angle_between(before) < 0.02, "{} {}", before, after);
        }
    }
}
