//! Which swivels cannot be within limits, by a few products: the rotations of shoulder and forearm are linear in cosine and
//! sine of half the swivel.

use super::{LimbIk, Reach};
use crate::limits::{JointLimits, Swing};
use crate::rotation::mirrored;
use glam::{DQuat, DVec3};
use std::f64::consts::PI;
use std::sync::LazyLock;
use throng_base::maths;

/// Room, so that nothing is refused that rounding alone has outside (rad).
const ROOM: f64 = 1e-6;

/// Half of each offset that is tried, cosine and sine.
pub(super) static HALVES: LazyLock<Vec<[f64; 2]>> = LazyLock::new(|| {
    let half = |offset: f64| {
        let (sin, cos) = maths::sin_cos(0.5 * offset);
        [cos, sin]
    };
    super::swivel::offsets().map(half).collect()
});

/// Tangents of half the least and the greatest twist; none where a side is open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Twist([Option<f64>; 2]);

impl Twist {
    /// - `turned`: the other way round, as in a mirror.
    pub fn new(limits: &JointLimits, turned: bool) -> Self {
        let side = |angle: f64| (angle.abs() < PI - 0.01).then(|| maths::sin(0.5 * angle) / maths::cos(0.5 * angle));
        let (least, most) = (side(limits.twist.least - ROOM), side(limits.twist.most + ROOM));
        Self(if turned { [most.map(|t| -t), least.map(|t| -t)] } else { [least, most] })
    }

    /// True where a twist cannot be within: of a quaternion, its part along the axis and its scalar part.
    fn is_outside(self, along: f64, w: f64) -> bool {
        let (along, w) = if w < 0.0 { (-along, -w) } else { (along, w) };
        self.0[0].is_some_and(|t| along < t * w) || self.0[1].is_some_and(|t| along > t * w)
    }
}

/// Two quaternions, which cosine and sine of half the swivel weigh.
struct Linear {
    cos: DQuat,
    sin: DQuat,
}

impl Linear {
    fn at(&self, [cos, sin]: [f64; 2]) -> DQuat {
        self.cos * cos + self.sin * sin
    }
}

/// What does not depend on the swivel.
pub(super) struct Swivels<'a> {
    ik: &'a LimbIk,
    /// Of the swivel where the search begins.
    start: [f64; 2],
    /// In the shoulder's own frame.
    shoulder: Linear,
    /// Twist and wrist together, in the forearm's frame.
    rest: Linear,
}

impl<'a> Swivels<'a> {
    pub fn new(ik: &'a LimbIk, reach: &Reach, start: f64) -> Self {
        let (sin, cos) = maths::sin_cos(0.5 * start);
        let line = DQuat::from_vec4(reach.line.extend(0.0));
        let limits = &ik.limits[0];
        let own = |q: DQuat| limits.centre.inverse() * if limits.mirrored { mirrored(q) } else { q };
        let back = (reach.onto * reach.bent).inverse();
        Self {
            ik,
            start: [cos, sin],
            shoulder: Linear { cos: own(reach.onto), sin: own(line * reach.onto) },
            rest: Linear { cos: back * reach.hand, sin: -(back * line) * reach.hand },
        }
    }

    /// False where the swivel at an offset is outside limits for certain.
    pub fn may_be_within(&self, [cos, sin]: [f64; 2]) -> bool {
        let [c, s] = self.start;
        let half = [c * cos - s * sin, s * cos + c * sin];
        let rest = self.rest.at(half);
        if self.ik.twists[1].is_outside(rest.xyz().dot(self.ik.elbow.along), rest.w) {
            return false;
        }
        let shoulder = self.shoulder.at(half);
        let limits = &self.ik.limits[0];
        let v = shoulder.xyz();
        let along = v.dot(limits.bone);
        !self.ik.twists[0].is_outside(along, shoulder.w) && !self.swings_too_far(v, along, shoulder.w)
    }

    /// - `v`, `along`, `w`: of the shoulder's quaternion in its own frame.
    fn swings_too_far(&self, v: DVec3, along: f64, w: f64) -> bool {
        let limits = &self.ik.limits[0];
        let Swing::Ellipse(radii) = limits.swing else { return false };
        let cos = maths::hypot(along, w);
        let across = v - limits.bone * along;
        let sin = across.length();
        if cos < 1e-9 || sin < 1e-9 {
            return false;
        }
        // The swing's axis: what is across, turned back by half the twist.
        let swing = (across * w - across.cross(limits.bone) * along) * (2.0 * maths::atan2(sin, cos) / (sin * cos));
        let [x, y] = [swing.dot(limits.axes[0]) / radii[0], swing.dot(limits.axes[1]) / radii[1]];
        x * x + y * y > (1.0 + ROOM / radii[0].min(radii[1])).powi(2)
    }
}
