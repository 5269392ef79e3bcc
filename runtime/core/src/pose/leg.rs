//! Legs that reach: the knee and ankle of a leg by analytic inverse kinematics.

use super::hierarchy::ModelPose;
use crate::skeleton::{Joint, Skeleton};
use throng_base::simd::{Lanes, Q, V};
use throng_geometry::two_bone_offsets;

/// Share of the leg's length past which a corrected leg is not stretched, so that the knee stays soft.
const SOFT_REACH: f32 = 0.995;

/// Squared length of a correction that is none (m^2).
pub(crate) const NO_CORRECTION: f32 = 1e-10;

/// The joints of one leg and their lengths.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LegJoints {
    pub thigh: usize,
    pub shin: usize,
    pub foot: usize,
    pub toe: usize,
    thigh_length: f32,
    shin_length: f32,
    /// Height of the toe over the ground when the foot stands flat (m).
    pub toe_height: f32,
}

impl LegJoints {
    /// Left and right leg of a skeleton.
    pub fn left_and_right(skeleton: &Skeleton) -> [Self; 2] {
        use Joint::*;
        let rest = skeleton.rest_positions();
        [[LeftThigh, LeftShin, LeftFoot, LeftToe], [RightThigh, RightShin, RightFoot, RightToe]].map(|leg| {
            let [thigh, shin, foot, toe] = leg.map(Joint::index);
            Self {
                thigh,
                shin,
                foot,
                toe,
                thigh_length: skeleton.offsets[shin].length(),
                shin_length: skeleton.offsets[foot].length(),
                toe_height: rest[toe].y,
            }
        })
    }
}

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
pub(crate) fn move_leg<F: Lanes>(leg: &LegJoints, correction: V<F>, pose: &mut ModelPose<F>) {
    let one = F::splat(1.0);
    let (hip, knee, ankle) = (pose.positions[leg.thigh], pose.positions[leg.shin], pose.positions[leg.foot]);
    let (l1, l2) = (F::splat(leg.thigh_length), F::splat(leg.shin_length));
    let before = ankle - hip;
    let aim = before + correction;
    let reach = (F::splat(leg.thigh_length + leg.shin_length) * F::splat(SOFT_REACH)).max(before.length());
    let distance = aim.length().max(F::splat(1e-4));
    let d = distance.min(reach).max((l1 - l2).abs() + F::splat(1e-3));
    let direction = aim * (one / distance);

    // The leg swings as a whole, then its knee bends in the plane it bent in before: it would point the other way where the
    // hip comes past the ankle. Where the leg is straight, it bends towards the toes.
    let swing = Q::shortest_arc(before, aim);
    let forward = pose.rotations[leg.thigh].rotate(V::splat(glam::Vec3::Z));
    let (upper, lower) = (swing.rotate(knee - hip), swing.rotate(ankle - knee));
    let new_knee = bent_middle(hip, direction, d, [l1, l2], upper + swing.rotate(forward) * F::splat(0.02));
    let new_ankle = hip + direction * d;

    // Lanes that need no correction keep their leg to the last bit, whatever their neighbours do.
    let amount = correction.dot(correction);
    let (thigh, shin) = (pose.rotations[leg.thigh], pose.rotations[leg.shin]);
    pose.rotations[leg.thigh] = chosen_q(amount, thigh, Q::shortest_arc(upper, new_knee - hip) * swing * thigh);
    pose.rotations[leg.shin] = chosen_q(amount, shin, Q::shortest_arc(lower, new_ankle - new_knee) * swing * shin);
    let toe = pose.positions[leg.toe];
    pose.positions[leg.toe] = chosen_v(amount, toe, toe + (new_ankle - ankle));
    pose.positions[leg.shin] = chosen_v(amount, knee, new_knee);
    pose.positions[leg.foot] = chosen_v(amount, ankle, new_ankle);
}

/// Turns the foot about its ankle, so that the vector to its toe changes by `turn` (model space).
#[inline(always)]
pub(crate) fn turn_foot<F: Lanes>(leg: &LegJoints, turn: V<F>, pose: &mut ModelPose<F>) {
    let (ankle, toe) = (pose.positions[leg.foot], pose.positions[leg.toe]);
    let by = Q::shortest_arc(toe - ankle, toe - ankle + turn);
    let amount = turn.dot(turn);
    for joint in [leg.foot, leg.toe] {
        pose.rotations[joint] = chosen_q(amount, pose.rotations[joint], by * pose.rotations[joint]);
    }
    pose.positions[leg.toe] = chosen_v(amount, toe, toe + turn);
}

/// Vector `new` where the correction is not negligible, else `old` (`amount`: m^2).
#[inline(always)]
fn chosen_v<F: Lanes>(amount: F, old: V<F>, new: V<F>) -> V<F> {
    V::select_lt(F::splat(NO_CORRECTION), amount, new, old)
}

/// Rotation `new` where the correction is not negligible, else `old` (`amount`: m^2).
#[inline(always)]
fn chosen_q<F: Lanes>(amount: F, old: Q<F>, new: Q<F>) -> Q<F> {
    Q::new(chosen_v(amount, old.v, new.v), F::select_lt(F::splat(NO_CORRECTION), amount, new.w, old.w))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose::hierarchy::{shared, to_model};
    use crate::pose::sample::LanePose;
    use glam::{Quat, Vec3};
    use proptest::prelude::*;
    use throng_base::simd::ArrayLanes;

    /// The axis that the knee bends about, in the thigh's own frame; longer where it bends more.
    fn hinge(leg: &LegJoints, pose: &ModelPose<ArrayLanes>) -> Vec3 {
        let vec = |v: V<ArrayLanes>| Vec3::from_array([v.x, v.y, v.z].map(|x| x.to_array()[0]));
        let [hip, knee, ankle] = [leg.thigh, leg.shin, leg.foot].map(|j| vec(pose.positions[j]));
        let thigh = pose.rotations[leg.thigh];
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
            let leg = &LegJoints::left_and_right(&skeleton)[0];
            let all = |q: Quat| Q::new(V::<ArrayLanes>::splat(q.xyz()), ArrayLanes::splat(q.w));
            let mut rotations = [all(Quat::IDENTITY); crate::skeleton::NUM_JOINTS];
            rotations[leg.thigh] = all(Quat::from_scaled_axis(Vec3::from_array(thigh)));
            rotations[leg.shin] = all(Quat::from_rotation_x(bent));
            let mut pose = to_model(shared(&skeleton), LanePose { root: V::<ArrayLanes>::splat(Vec3::Y), rotations });
            let before = hinge(leg, &pose);
            let [hip, ankle] = [leg.thigh, leg.foot].map(|j| pose.positions[j]);
            let aim = V::splat(Vec3::from_array(to));
            // Half a turn has no axis of its own.
            let [was, now] = [ankle - hip, aim].map(|v| v * (ArrayLanes::splat(1.0) / v.length()));
            prop_assume!(was.dot(now).to_array()[0] > -0.98 && aim.length().to_array()[0] > 0.15);
            move_leg(leg, aim - (ankle - hip), &mut pose);
            let after = hinge(leg, &pose);
            prop_assert!(after.dot(before) > 0.0 && after.angle_between(before) < 0.02, "{} {}", before, after);
        }
    }
}
