//! Quick classification of swivels by limits, with a few products: rotations of shoulder and forearm are linear in cosine and
//! sine of half the swivel. Swivels near a limit are left to the exact check.

use super::swivel::{half_angle, offsets};
use super::{LimbIk, ReachGeometry};
use crate::{limits::JointLimits, rotation::mirror_rotation_x};
use glam::{DQuat, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::LazyLock;
use throng_base::maths;

/// Accuracy of the angles here: an angle nearer to a limit may be on either side (rad).
const ROOM: f64 = 2e-5;

/// Cosine and sine of half of each offset that is tried.
pub(super) static HALVES: LazyLock<Vec<[f64; 2]>> = LazyLock::new(|| offsets().map(half_angle).collect());

/// Position of a rotation relative to limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LimitFit {
    Inside,
    Outside,
    /// The rotation is too near to a limit for a quick check.
    OnEdge,
}

impl LimitFit {
    /// - `excess`: distance outside the limits, negative inside (rad).
    fn from_excess(excess: f64) -> Self {
        match excess {
            outside if outside > ROOM => Self::Outside,
            inside if inside < -ROOM => Self::Inside,
            _ => Self::OnEdge,
        }
    }

    /// Combines two conditions.
    fn combine(self, other: Self) -> Self {
        match (self, other) {
            (Self::Outside, _) | (_, Self::Outside) => Self::Outside,
            (Self::Inside, Self::Inside) => Self::Inside,
            _ => Self::OnEdge,
        }
    }
}

/// Tangents of half the least and the greatest twist, with a little room outside and inside; none where a side is open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TwistBounds {
    outside: [Option<f64>; 2],
    inside: [Option<f64>; 2],
}

impl TwistBounds {
    /// - `turned`: true for the other sense of rotation, as in a mirror.
    pub fn new(limits: &JointLimits, turned: bool) -> Self {
        let side = |angle: f64| (angle.abs() < PI - 0.01).then(|| maths::sin(0.5 * angle) / maths::cos(0.5 * angle));
        let sides = |room: f64| {
            let [least, most] = [side(limits.twist.least - room), side(limits.twist.most + room)];
            if turned { [most.map(|t| -t), least.map(|t| -t)] } else { [least, most] }
        };
        Self { outside: sides(ROOM), inside: sides(-ROOM) }
    }

    /// - `along`, `w`: component along the axis, and scalar part, of a quaternion.
    fn fit(&self, along: f64, w: f64) -> LimitFit {
        let (along, w) = if w < 0.0 { (-along, -w) } else { (along, w) };
        let [least, most] = self.outside;
        if least.is_some_and(|t| along < t * w) || most.is_some_and(|t| along > t * w) {
            return LimitFit::Outside;
        }
        let [least, most] = self.inside;
        let is_inside = least.is_some_and(|t| along > t * w) && most.is_some_and(|t| along < t * w);
        if is_inside { LimitFit::Inside } else { LimitFit::OnEdge }
    }
}

/// Limits of a joint, for quick checks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct QuickLimits {
    twist: TwistBounds,
    centre_back: DQuat,
}

impl QuickLimits {
    pub fn new(limits: &JointLimits) -> Self {
        Self { twist: TwistBounds::new(limits, false), centre_back: limits.centre.inverse() }
    }

    /// Approximate excess of a rotation over limits (rad).
    ///
    /// - `q`: in the frame of the limits, from [`QuickLimits::in_limit_frame`].
    fn excess(&self, limits: &JointLimits, q: DQuat) -> f64 {
        let v = q.xyz();
        let along = v.dot(limits.segment);
        let swing = swing_excess(limits, v, along, q.w).unwrap_or(PI);
        swing.max(limits.twist.excess(quick_twist(along, q.w)))
    }

    /// A rotation in the frame of the joint's limits.
    fn in_limit_frame(&self, limits: &JointLimits, q: DQuat) -> DQuat {
        self.centre_back * if limits.mirrored { mirror_rotation_x(q) } else { q }
    }

    /// - `q`: in the frame of the limits, from [`QuickLimits::in_limit_frame`].
    fn fit(&self, limits: &JointLimits, q: DQuat) -> LimitFit {
        let v = q.xyz();
        let along = v.dot(limits.segment);
        match self.twist.fit(along, q.w) {
            LimitFit::Outside => LimitFit::Outside,
            twist => twist.combine(swing_excess(limits, v, along, q.w).map_or(LimitFit::OnEdge, LimitFit::from_excess)),
        }
    }
}

/// Excess of a swing over limits; `None` near half a turn (rad).
///
/// - `v`, `along`, `w`: of a quaternion in the frame of the limits.
fn swing_excess(limits: &JointLimits, v: DVec3, along: f64, w: f64) -> Option<f64> {
    let across = v - limits.segment * along;
    let (sin, cos) = (across.length(), (along * along + w * w).sqrt());
    if cos < 1e-3 {
        return None;
    }
    // The swing's rotation vector: the component across the axis, turned back by half the twist.
    let scale = if sin < 1e-9 { 2.0 } else { 2.0 * quick_angle(sin, cos) / sin };
    let swing = (across * w - across.cross(limits.segment) * along) * (scale / cos);
    Some(limits.swing.excess(limits.axes.map(|a| swing.dot(a))))
}

/// A twist, in [-pi, pi] (rad).
fn quick_twist(along: f64, w: f64) -> f64 {
    let angle = 2.0 * quick_angle(along.abs(), w.abs());
    if (along < 0.0) == (w < 0.0) { angle } else { -angle }
}

/// The angle of a sine and a cosine that are not negative, within 4e-6 rad.
///
/// # Source
/// A polynomial of least greatest error for the arcus tangent on [0, 1].
fn quick_angle(sin: f64, cos: f64) -> f64 {
    let is_steep = sin > cos;
    let t = if is_steep { cos / sin } else { sin / cos };
    let u = t * t;
    let series = 0.193_543_46 + u * (-0.116_432_87 + u * (0.052_653_32 - u * 0.011_721_20));
    let angle = t * (0.999_977_26 + u * (-0.332_623_47 + u * series));
    if is_steep { FRAC_PI_2 - angle } else { angle }
}

/// A rotation that is linear in cosine and sine of half the swivel: one quaternion for each.
struct LinearRotation {
    cos: DQuat,
    sin: DQuat,
}

impl LinearRotation {
    fn rotation_at(&self, [cos, sin]: [f64; 2]) -> DQuat {
        self.cos * cos + self.sin * sin
    }

    /// Components along an axis, and scalar parts: each for cosine and sine.
    fn twist(&self, axis: DVec3) -> [[f64; 2]; 2] {
        [[self.cos.xyz().dot(axis), self.sin.xyz().dot(axis)], [self.cos.w, self.sin.w]]
    }
}

fn weighted_sum([a, b]: [f64; 2], [cos, sin]: [f64; 2]) -> f64 {
    a * cos + b * sin
}

/// Parts of a reach that do not depend on the swivel, for quick checks.
pub(super) struct SwivelLimits<'a> {
    ik: &'a LimbIk,
    bent: DQuat,
    shoulder: LinearRotation,
    /// Shoulder rotation in the frame of its limits.
    own_shoulder: LinearRotation,
    /// Twist and wrist together, in the forearm's frame.
    rest: LinearRotation,
    /// Component along the segment, and scalar part, of shoulder and rest.
    twists: [[[f64; 2]; 2]; 2],
}

impl<'a> SwivelLimits<'a> {
    pub fn new(ik: &'a LimbIk, reach: &ReachGeometry) -> Self {
        let line = DQuat::from_vec4(reach.line.extend(0.0));
        let shoulder = LinearRotation { cos: reach.onto, sin: line * reach.onto };
        let [cos, sin] = [shoulder.cos, shoulder.sin].map(|q| ik.quick[0].in_limit_frame(&ik.limits[0], q));
        let back = (reach.onto * reach.bent).inverse();
        let rest = LinearRotation { cos: back * reach.hand, sin: -(back * line) * reach.hand };
        let own_shoulder = LinearRotation { cos, sin };
        let twists = [own_shoulder.twist(ik.limits[0].segment), rest.twist(ik.elbow.along)];
        Self { ik, bent: reach.bent, shoulder, own_shoulder, rest, twists }
    }

    /// Position of a swivel relative to limits, and its pose where it is within them.
    ///
    /// - `half_angle`: cosine and sine of half of the swivel.
    pub fn check_swivel(&self, half: [f64; 2]) -> (LimitFit, [DQuat; 3]) {
        let ik = self.ik;
        let none = [DQuat::IDENTITY; 3];
        // Twists and the sizes of swings come first: they need two products each.
        let [[upper, upper_w], [along, w]] = self.twists.map(|t| t.map(|t| weighted_sum(t, half)));
        let twist = ik.elbow_twist.fit(along, w);
        if twist == LimitFit::Outside
            || upper * upper + upper_w * upper_w < ik.widest[0]
            || along * along + w * w < ik.widest[1]
            || ik.quick[0].twist.fit(upper, upper_w) == LimitFit::Outside
        {
            return (LimitFit::Outside, none);
        }
        let rest = self.rest.rotation_at(half);
        let (rest, along) = if w < 0.0 { (-rest, -along) } else { (rest, along) };
        let shoulder = ik.quick[0].fit(&ik.limits[0], self.own_shoulder.rotation_at(half));
        if shoulder == LimitFit::Outside {
            return (shoulder, none);
        }
        let length = (along * along + rest.w * rest.w).sqrt();
        if length < 1e-6 {
            return (LimitFit::OnEdge, none);
        }
        let v = ik.elbow.along * (along / length);
        let twisted = DQuat::from_xyzw(v.x, v.y, v.z, rest.w / length);
        let hand = twisted.inverse() * rest;
        let wrist = ik.quick[1].fit(&ik.limits[2], ik.quick[1].in_limit_frame(&ik.limits[2], hand));
        let fit = twist.combine(shoulder).combine(wrist);
        let pose =
            if fit == LimitFit::Inside { [self.shoulder.rotation_at(half), self.bent * twisted, hand] } else { none };
        (fit, pose)
    }

    /// Approximate excess of a swivel over limits; where it is more than `enough`, a lower bound of it (rad).
    ///
    /// - `half_angle`: cosine and sine of half of the swivel.
    pub fn excess(&self, half: [f64; 2], enough: f64) -> f64 {
        let ik = self.ik;
        let [along, w] = self.twists[1].map(|t| weighted_sum(t, half));
        let twist = ik.elbow.twist_excess(quick_twist(along, w));
        if twist > enough {
            return twist;
        }
        let shoulder = ik.quick[0].excess(&ik.limits[0], self.own_shoulder.rotation_at(half)).max(twist);
        if shoulder > enough {
            return shoulder;
        }
        let length = (along * along + w * w).sqrt();
        let twisted = if length < 1e-6 {
            DQuat::IDENTITY
        } else {
            let v = ik.elbow.along * (along / length);
            DQuat::from_xyzw(v.x, v.y, v.z, w / length)
        };
        let hand = twisted.inverse() * self.rest.rotation_at(half);
        ik.quick[1].excess(&ik.limits[2], ik.quick[1].in_limit_frame(&ik.limits[2], hand)).max(shoulder)
    }
}

/// Square of the cosine of half the widest swing: a swing with a smaller one is outside limits; 0, so that none is, where the
/// joint's own twist, or its middle, is turned away from the forearm.
///
/// - `along`: axis of the twist before the swing, if there is one.
pub(super) fn widest_swing_square(limits: &JointLimits, along: Option<DVec3>) -> f64 {
    let side = if limits.mirrored { -1.0 } else { 1.0 };
    let bone = limits.segment.with_x(side * limits.segment.x);
    let is_aligned = along.is_none_or(|a| bone.distance(a) < 1e-9 && limits.centre == DQuat::IDENTITY);
    let cos = maths::cos(0.5 * (limits.widest_swing() + ROOM).min(PI));
    if is_aligned { cos * cos } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::{AngleInterval, BodyLimits};
    use crate::rotation::exp;
    use proptest::prelude::*;
    use throng_core::{Joint, Skeleton};

    #[test]
    fn quick_angles_are_near() {
        for i in 0..=20_000 {
            let angle = f64::from(i) * FRAC_PI_2 / 20_000.0;
            let (sin, cos) = maths::sin_cos(angle);
            assert!((quick_angle(sin, cos.max(0.0)) - angle).abs() < 4e-6, "{angle}");
            for (along, w, twist) in [(sin, cos, angle), (-sin, cos, -angle), (-sin, -cos, angle), (sin, -cos, -angle)]
            {
                assert!((quick_twist(along, w) - 2.0 * twist).abs() < 1e-5 || angle > 1.57, "{along} {w}");
            }
        }
    }

    proptest! {
        #[test]
        fn quick_looks_say_what_exact_ones_do(v in prop::array::uniform3(-3.0f64..3.0), open in any::<bool>()) {
            let all = BodyLimits::built_in(&Skeleton::default());
            let q = exp(DVec3::from(v));
            for joint in [Joint::LeftUpperArm, Joint::RightUpperArm, Joint::RightThigh, Joint::LeftHand, Joint::RightFoot, Joint::LeftShin] {
                let mut limits = all.joints[joint.index()].expect("limits");
                if open {
                    limits.twist = AngleInterval::new(-PI, PI);
                }
                let quick = QuickLimits::new(&limits);
                let excess = limits.excess(q);
                let about = quick.excess(&limits, quick.in_limit_frame(&limits, q));
                prop_assert!((about - excess).abs() < 2e-5 || excess > 1.0, "{joint:?} {about} {excess}");
                match quick.fit(&limits, quick.in_limit_frame(&limits, q)) {
                    LimitFit::Inside => prop_assert!(excess < 0.0, "{joint:?} {excess}"),
                    LimitFit::Outside => prop_assert!(excess > 0.0, "{joint:?} {excess}"),
                    LimitFit::OnEdge => prop_assert!(excess.abs() < 1e-3 || open, "{joint:?} {excess}"),
                }
            }
        }
    }
}
