//! Geometry of limbs that touch: forearms and shins as segments of fixed length (Müller et al. 2007, position based
//! dynamics), and reaching limbs of two bones.

use glam::{Quat, Vec3};
use throng_base::maths;
use throng_geometry::{Capsule, nearest_points, share_along, two_bone_offsets};

/// Overlap below which a limb counts as free (m).
const ENOUGH_M: f32 = 1e-3;
/// Margin for the displacement of a limb in a piece, in the search for obstacles (m).
const ROOM_M: f32 = 0.08;
/// Distance from the straight line below which elbows bend outwards and down, and knees ahead (m).
pub(super) const SOFT_ELBOW_M: f32 = 0.02;
/// Share of its length by which a limb stays shorter than straight (1).
const STRETCH: f32 = 5e-4;
/// Least lever of a knee: it moves at most one over this farther than a point near the ankle has to (1).
const LEAST_LEVER: f32 = 0.5;

/// Constant shape of a limb.
#[derive(Clone, Copy, Debug)]
pub(super) struct LimbShape {
    /// Lengths of its two bones (m).
    pub lengths: [f32; 2],
    /// Length of the axis beyond its end, into the fist; 0 for legs (m).
    pub hand_m: f32,
    /// Radius of the forearm or shin (m).
    pub radius: f32,
    /// Radius of the upper arm or thigh (m).
    pub upper_radius: f32,
}

/// Freedom of a limb to move out of an obstacle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LimbFreedom {
    /// Only the knee moves, aside: a leg that carries weight.
    Stays,
    /// Moves along the ground: a leg that steps.
    Level,
    /// Moves anywhere: an arm, or a leg that kicks.
    Free,
}

/// Forearm or shin as a movable segment.
#[derive(Clone, Copy, Debug)]
pub(super) struct LimbSegment {
    /// Elbow and wrist, or knee and ankle (m).
    pub ends: [Vec3; 2],
    /// Vector from the ankle to the toes; zero for arms (m).
    pub foot: Vec3,
    pub freedom: LimbFreedom,
    pub moved: bool,
}

impl LimbSegment {
    /// Axis from the elbow to where the fist begins to round, or from knee to ankle (m).
    pub fn axis(&self, shape: &LimbShape) -> [Vec3; 2] {
        let [elbow, wrist] = self.ends;
        [elbow, wrist + (wrist - elbow) * (shape.hand_m / shape.lengths[1])]
    }

    /// Axis, or the foot if there is one (m).
    fn bone_or_foot(&self, shape: &LimbShape, is_foot: bool) -> Option<[Vec3; 2]> {
        match is_foot {
            false => Some(self.axis(shape)),
            true => (self.foot != Vec3::ZERO).then(|| [self.ends[1], self.ends[1] + self.foot]),
        }
    }

    /// Ball around the segment and its foot.
    pub fn bounding_ball(&self, shape: &LimbShape) -> BoundingBall {
        BoundingBall::around_segment(self.axis(shape), shape.radius + self.foot.length())
    }

    /// Moves a point of the axis; a point near the elbow carries the wrist along, and the foot the ankle (m).
    fn shift_point(&mut self, at: Vec3, by: Vec3) {
        let by = if self.freedom == LimbFreedom::Free { by } else { by.with_y(0.0) };
        let ([elbow, wrist], s) = (self.ends, share_along(at, self.ends));
        if self.freedom == LimbFreedom::Stays {
            self.ends[0] += by / (1.0 - s).max(LEAST_LEVER);
            self.moved |= s < 1.0;
            return;
        }
        let per = 1.0 / ((1.0 - s) * (1.0 - s) + s);
        self.ends = [elbow + by * ((1.0 - s) * per), wrist + by * per];
        self.moved = true;
    }

    /// Moves the segment out of a fixed capsule; false where they do not overlap.
    pub fn leave_capsule(&mut self, shape: &LimbShape, capsule: &Capsule, give_m: f32) -> bool {
        let allowed_m = shape.radius + capsule.radius - give_m;
        let mut found = penetration(self.axis(shape), capsule.ends, allowed_m);
        found.into_iter().for_each(|(at, _, by)| self.shift_point(at, by));
        if let Some(foot) = self.bone_or_foot(shape, true) {
            let of_foot = penetration(foot, capsule.ends, allowed_m);
            of_foot.into_iter().for_each(|(_, _, by)| self.shift_point(foot[0], by));
            found = found.or(of_foot);
        }
        found.is_some()
    }

    /// Moves the elbow or knee, and all beyond it, so that the upper arm or thigh leaves a fixed capsule; false where they do not overlap.
    pub fn lift_out_of(&mut self, shoulder: Vec3, shape: &LimbShape, capsule: &Capsule, give_m: f32) -> bool {
        /// Share of its length below which a point is so near to the root that the elbow or knee cannot move it (1).
        const LEAST: f32 = 0.4;
        let allowed_m = shape.upper_radius + capsule.radius - give_m;
        let found = penetration([shoulder, self.ends[0]], capsule.ends, allowed_m);
        let found = found.filter(|(at, ..)| at.distance(shoulder) > LEAST * shape.lengths[0]);
        if let Some((at, _, by)) = found {
            self.shift_point(self.ends[0], by * (shape.lengths[0] / at.distance(shoulder)));
        }
        found.is_some()
    }
}

/// Moves two forearms, or shins and feet, apart, each by half, or only the one that can move; false where they do not overlap.
pub(super) fn separate_segments(
    a: &mut LimbSegment,
    shape_a: &LimbShape,
    b: &mut LimbSegment,
    shape_b: &LimbShape,
    give_m: f32,
) -> bool {
    let allowed_m = shape_a.radius + shape_b.radius - give_m;
    let mut any = false;
    for (of_a, of_b) in [(false, false), (false, true), (true, false), (true, true)] {
        let [Some(mut p), Some(mut q)] = [a.bone_or_foot(shape_a, of_a), b.bone_or_foot(shape_b, of_b)] else {
            continue;
        };
        if of_a && of_b && a.freedom != LimbFreedom::Free && b.freedom != LimbFreedom::Free {
            // A foot cannot come down on another one, so that feet part along the ground.
            p.iter_mut().chain(&mut q).for_each(|end| end.y = 0.0);
        }
        // A foot that carries weight stays.
        let gives =
            [(a.freedom, of_a), (b.freedom, of_b)].map(|(freedom, is_foot)| freedom != LimbFreedom::Stays || !is_foot);
        let share = match gives {
            [true, true] => [0.5, -0.5],
            [true, false] => [1.0, 0.0],
            [false, true] => [0.0, -1.0],
            [false, false] => continue,
        };
        if let Some((at_a, at_b, by)) = penetration(p, q, allowed_m) {
            for (segment, at, is_foot, share) in [(&mut *a, at_a, of_a, share[0]), (&mut *b, at_b, of_b, share[1])] {
                if share != 0.0 {
                    segment.shift_point(if is_foot { segment.ends[1] } else { at }, by * share);
                }
            }
            any = true;
        }
    }
    any
}

/// Rotation about the root of an arm that brings its forearm out of a fixed capsule; `None` where they do not
/// overlap.
pub(super) fn swing_rotation(joints: [Vec3; 3], shape: &LimbShape, capsule: &Capsule, give_m: f32) -> Option<Quat> {
    let [root, middle, end] = joints;
    let segment = LimbSegment { ends: [middle, end], foot: Vec3::ZERO, freedom: LimbFreedom::Free, moved: false };
    let (at, _, by) = penetration(segment.axis(shape), capsule.ends, shape.radius + capsule.radius - give_m)?;
    Some(shortest_arc(at - root, at + by - root))
}

/// Nearest points of two axes, and the displacement of the first one, if they are nearer than allowed (m).
fn penetration(a: [Vec3; 2], b: [Vec3; 2], allowed_m: f32) -> Option<(Vec3, Vec3, Vec3)> {
    let limit_m = allowed_m - ENOUGH_M;
    if are_surely_apart(a, b, limit_m) {
        return None;
    }
    let [p, q] = nearest_points(a, b);
    let way = p - q;
    let distance = way.length();
    (distance < limit_m).then(|| {
        // Crossing axes separate in the direction from which the arm came.
        let out = if distance > 1e-5 { way / distance } else { (a[0] - q).normalize_or(Vec3::Y) };
        (p, q, out * (allowed_m - distance))
    })
}

/// True where two axes are at least `limit_m` apart along the line between their middles; false says nothing. This takes
/// a fraction of what their nearest points take, and holds for most axes that are apart.
///
/// Along this line, the axes are as far apart as their middles, less half of the extent of each. A margin covers rounding:
/// where the test holds, the distance of the computed [`nearest_points`] is not below the limit either, for axes up to
/// 10 m long.
fn are_surely_apart([a0, a1]: [Vec3; 2], [b0, b1]: [Vec3; 2], limit_m: f32) -> bool {
    let limit_m = limit_m + 1e-5 + 1e-6 * (a0.x.abs() + a0.y.abs() + a0.z.abs());
    // Twice the vector between the middles.
    let between = (a0 - b0) + (a1 - b1);
    let square = between.length_squared();
    let gap = square - between.dot(a1 - a0).abs() - between.dot(b1 - b0).abs();
    gap > 0.0 && gap * gap >= 4.0 * limit_m * limit_m * square
}

/// Positions of middle and end as near to those of `joints` as a limb of these lengths can reach (m).
///
/// - `out`: direction in which a straight limb bends; `soft`: share of that bend (0 to 1).
pub(super) fn solve_two_bones(joints: [Vec3; 3], shape: &LimbShape, out: Vec3, soft: f32) -> [Vec3; 2] {
    let [shoulder, elbow, wrist] = joints;
    let [l1, l2] = shape.lengths;
    let offset = wrist - shoulder;
    let direction = offset.normalize_or(Vec3::NEG_Y);
    // The least distance goes last: for very short bones it exceeds the greatest one.
    let d = offset.length().min((l1 + l2) * (1.0 - STRETCH * soft * soft)).max((l1 - l2).abs() + 1e-3);
    let across = |v: Vec3| v - direction * v.dot(direction);
    let pole = across(elbow - shoulder);
    let soft = (SOFT_ELBOW_M * soft - pole.length()).max(0.0);
    let pole = (pole + across(out).normalize_or_zero() * soft).normalize_or_zero();
    let [along, across] = two_bone_offsets(shape.lengths, d, |v| v.max(0.0).sqrt());
    [shoulder + direction * along + pole * across, shoulder + direction * d]
}
/// Ball around a capsule.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoundingBall {
    centre: Vec3,
    radius: f32,
}

impl BoundingBall {
    pub fn around_segment(ends: [Vec3; 2], radius: f32) -> Self {
        Self { centre: (ends[0] + ends[1]) * 0.5, radius: 0.5 * ends[0].distance(ends[1]) + radius }
    }

    pub fn is_near(&self, other: &Self) -> bool {
        let reach = self.radius + other.radius + ROOM_M;
        self.centre.distance_squared(other.centre) < reach * reach
    }
}

/// Angle at an elbow or a knee (rad).
pub(super) fn elbow_angle([shoulder, elbow, wrist]: [Vec3; 3]) -> f32 {
    let (upper, lower) = (shoulder - elbow, wrist - elbow);
    maths::atan2(upper.cross(lower).length(), upper.dot(lower))
}

/// Rotation from one direction to another; the identity where either has no length. Small rotations are exact, unlike those
/// of glam, which omits rotations below 0.7 mrad.
fn shortest_arc(from: Vec3, to: Vec3) -> Quat {
    let (Some(from), Some(to)) = (from.try_normalize(), to.try_normalize()) else { return Quat::IDENTITY };
    let w = 1.0 + from.dot(to);
    if w < 1e-6 {
        // Any axis across will do.
        let axis = from.any_orthonormal_vector();
        return Quat::from_xyzw(axis.x, axis.y, axis.z, 0.0);
    }
    let axis = from.cross(to);
    maths::normalize_or_identity(Quat::from_xyzw(axis.x, axis.y, axis.z, w))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector(most: f32) -> impl Strategy<Value = Vec3> {
        prop::array::uniform3(-most..most).prop_map(Vec3::from_array)
    }

    /// Two axes near each other, any distance from the origin: crossing, parallel, and without length too (m).
    fn axes() -> impl Strategy<Value = [[Vec3; 2]; 2]> {
        let far = prop_oneof![Just(0.0f32), 0.0f32..10.0, 0.0f32..1e3, 0.0f32..2e6];
        let length = || prop_oneof![Just(0.0f32), 0.0f32..1e-3, 0.0f32..0.5, 0.0f32..5.0];
        let directions = (vector(1.0), vector(1.0), vector(1.0), vector(1.0), any::<bool>());
        (far, directions, length(), length(), 0.0f32..1.0).prop_map(
            |(far, (from, u, v, to, are_parallel), a, b, apart)| {
                let start = from * far;
                let v = if are_parallel { u } else { v };
                let other = start + to * apart;
                [[start - u * a, start + u * a], [other - v * b, other + v * b]]
            },
        )
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]
        #[test]
        fn axes_that_are_surely_apart_are_no_nearer_than_the_limit([a, b] in axes(), limit_m in 0.0f32..0.5) {
            let [p, q] = nearest_points(a, b);
            prop_assert!(!are_surely_apart(a, b, limit_m) || (p - q).length() >= limit_m);
            // The limit where a wrong answer is likeliest.
            let just_above = (p - q).length() * 1.0001;
            prop_assert!(!are_surely_apart(a, b, just_above), "{a:?} {b:?}");
        }
    }

    #[test]
    fn most_axes_that_are_apart_are_known_to_be_so() {
        let forearm = [Vec3::new(0.2, 1.3, 0.3), Vec3::new(0.1, 1.4, 0.6)];
        let trunk = [Vec3::new(0.0, 1.0, 0.9), Vec3::new(0.0, 1.4, 0.9)];
        assert!(are_surely_apart(forearm, trunk, 0.15));
        assert!(!are_surely_apart(forearm, trunk, 0.35), "{:?}", nearest_points(forearm, trunk));
    }
}
