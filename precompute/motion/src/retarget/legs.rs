//! Legs that reach: ankles and toes go where the source has them, so that feet that stand there stand here.
//!
//! Legs of other proportions that turn as the source's do put the feet elsewhere at every step, and feet that stand
//! slide. The knee stays in the plane that the source bends it in; the foot turns as the source's does.

use super::body::RolePose;
use glam::{Quat, Vec3};
use throng_base::maths;
use throng_core::{Joint, NUM_JOINTS, Skeleton, skeleton::LEGS};
use throng_geometry::two_bone_offsets;

/// Rise of the heel below which a foot stands on the heel, and above which it stands on the toe (sine of the angle).
const RAISED: (f32, f32) = (0.1, 0.5);
/// Height of the knee above the ankle, as a share of the shin: above the second number the leg reaches fully, below the first
/// it turns as the source's does, as kneeling people stand on their knees.
const UPRIGHT: (f32, f32) = (0.15, 0.45);
/// Height of an ankle above the other one from which its leg need not reach less, and from which it need not reach (m).
const LIFTED: (f32, f32) = (0.02, 0.2);
/// Share of their length to which short legs are straightened.
const REACH: f32 = 0.99;
/// Distance from their goal below which feet stay (m).
const NEAR: f32 = 1e-5;

/// Transfers the legs of one skeleton to another.
pub struct LegTransfer<'a> {
    target: &'a Skeleton,
    scale: f32,
    has_toes: [bool; 2],
    /// Height of ankles and toes above the source's scaled ones (m).
    ankle: f32,
    toe: f32,
}

impl<'a> LegTransfer<'a> {
    /// - `own`: `target` with the source's proportions.
    pub fn new(own: &Skeleton, target: &'a Skeleton, scale: f32, has_toes: [bool; 2]) -> Self {
        let (from, to) = (own.rest_positions(), target.rest_positions());
        let higher = |part: usize| {
            let of = |leg: [Joint; 4]| to[leg[part].index()].y - scale * from[leg[part].index()].y;
            0.5 * (of(LEGS[0]) + of(LEGS[1]))
        };
        Self { target, scale, has_toes, ankle: higher(2), toe: higher(3) }
    }

    /// Position of the hips: the middle between the thighs is where the source has it, but for the height of the ankles (m).
    ///
    /// - `turned`: world rotation of the hips.
    pub fn hips(&self, turned: Quat, pose: &RolePose) -> Vec3 {
        let [left, right] = LEGS.map(|leg| leg[0].index());
        let between = (pose[left].0 + pose[right].0) * 0.5 * self.scale + Vec3::Y * self.ankle;
        between - turned * ((self.target.offsets[left] + self.target.offsets[right]) * 0.5)
    }

    /// Turns thighs and shins so that the feet are at the places of the source's.
    ///
    /// - `model`: world rotation of every joint.
    /// - `root`: position of the hips.
    pub fn reach_feet(&self, model: &mut [Quat; NUM_JOINTS], root: Vec3, pose: &RolePose) {
        for (leg, has_toe) in LEGS.into_iter().zip(self.has_toes) {
            let [thigh, shin, foot, toe] = leg.map(Joint::index);
            let hip = root + model[0] * self.target.offsets[thigh];
            let goal = self.goal(model, [foot, toe], has_toe, pose);
            let turned = hip + model[thigh] * self.target.offsets[shin] + model[shin] * self.target.offsets[foot];
            let up = (pose[shin].0 - pose[foot].0).normalize_or_zero().y;
            bend_leg(self.target, model, [thigh, shin, foot], hip, turned.lerp(goal, ramp(up, UPRIGHT)));
        }
    }

    /// Place of an ankle that puts the foot where the source's is.
    fn goal(&self, model: &[Quat; NUM_JOINTS], [foot, toe]: [usize; 2], has_toe: bool, pose: &RolePose) -> Vec3 {
        let from_ankle = pose[foot].0 * self.scale + Vec3::Y * self.ankle;
        let from_toe = pose[toe].0 * self.scale + Vec3::Y * self.toe - model[foot] * self.target.offsets[toe];
        let share = if has_toe { ramp(-(model[foot] * Vec3::Z).y, RAISED) } else { 0.0 };
        from_ankle.lerp(from_toe, share)
    }

    /// Height by which the hips must be lower for short legs to reach the feet, of which the lower one counts more (m).
    ///
    /// - `root`: position of the hips without that.
    pub fn shortfall(&self, model: &[Quat; NUM_JOINTS], root: Vec3, pose: &RolePose) -> f32 {
        let of = |(leg, has_toe): ([Joint; 4], bool)| {
            let [thigh, shin, foot, toe] = leg.map(Joint::index);
            let goal = self.goal(model, [foot, toe], has_toe, pose);
            let to_hip = root + model[0] * self.target.offsets[thigh] - goal;
            let reach = REACH * (self.target.offsets[shin].length() + self.target.offsets[foot].length());
            let level = to_hip.with_y(0.0).length();
            (goal.y, to_hip.y - (reach * reach - level * level).max(0.1 * reach * reach).sqrt())
        };
        let [left, right] = [of((LEGS[0], self.has_toes[0])), of((LEGS[1], self.has_toes[1]))];
        let lowest = left.0.min(right.0);
        let counted = |(height, lack): (f32, f32)| lack * (1.0 - ramp(height - lowest, LIFTED));
        counted(left).max(counted(right)).max(0.0)
    }
}

/// Turns one leg so that its ankle is at `goal`, or as near to it as it reaches.
///
/// - `model`: world rotation of every joint.
/// - `thigh`, `shin`, `foot`: indices of the leg's joints.
/// - `hip`: position of the thigh (m).
pub fn bend_leg(
    skeleton: &Skeleton,
    model: &mut [Quat; NUM_JOINTS],
    [thigh, shin, foot]: [usize; 3],
    hip: Vec3,
    goal: Vec3,
) {
    let upper = model[thigh] * skeleton.offsets[shin];
    let lower = model[shin] * skeleton.offsets[foot];
    if (hip + upper + lower).distance(goal) < NEAR {
        return;
    }
    let (a, b) = (upper.length(), lower.length());
    let (Some(along), Some(to)) = ((upper + lower).try_normalize(), (goal - hip).try_normalize()) else { return };
    // For segments shorter than NEAR, the least distance is above the greatest one.
    let distance = goal.distance(hip).min(a + b).max((a - b).abs() + NEAR);
    let ahead = upper.reject_from_normalized(along).try_normalize();
    let ahead = ahead.unwrap_or_else(|| (model[thigh] * Vec3::Z).reject_from_normalized(along).normalize_or(Vec3::Z));
    let ahead = Quat::from_rotation_arc(along, to) * ahead;
    let [along, across] = two_bone_offsets([a, b], distance, |v| v.max(0.0).sqrt());
    let knee = to * along + ahead * across;
    let turned = |from: Vec3, to: Vec3, by: Quat| match (from.try_normalize(), to.try_normalize()) {
        (Some(from), Some(to)) => maths::compose(Quat::from_rotation_arc(from, to), by).normalize(),
        _ => by,
    };
    model[thigh] = turned(upper, knee, model[thigh]);
    model[shin] = turned(lower, to * distance - knee, model[shin]);
}

/// From 0 at the first of two values to 1 at the second, smoothly.
fn ramp(value: f32, (from, to): (f32, f32)) -> f32 {
    let t = ((value - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bones_without_length_do_no_harm() {
        for (thigh, shin) in [(0.0, 0.0), (0.45, 0.0), (0.0, 0.45), (4e-6, 4e-6), (0.4, 5e-6), (5e-6, 0.4)] {
            let mut target = Skeleton::default();
            for side in LEGS {
                target.offsets[side[1].index()] = Vec3::NEG_Y * thigh;
                target.offsets[side[2].index()] = Vec3::NEG_Y * shin;
            }
            let legs = LegTransfer::new(&Skeleton::default(), &target, 1.0, [true; 2]);
            let pose: RolePose = Skeleton::default().rest_positions().map(|p| (p + Vec3::X * 0.1, Quat::IDENTITY));
            let mut model = [Quat::from_rotation_x(0.3); NUM_JOINTS];
            legs.reach_feet(&mut model, Vec3::Y, &pose);
            assert!(model.iter().all(|q| q.is_finite() && q.is_normalized()), "{thigh} {shin}");
        }
    }
}
