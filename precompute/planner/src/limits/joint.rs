//! The limits of one joint.

use crate::rotation::{exp, log, mirror_rotation_x, rotation_about, swing_twist};
use glam::{DQuat, DVec3};
use throng_base::maths;

/// Interval from the least to the greatest angle (rad).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AngleInterval {
    /// Least angle (rad).
    pub least: f64,
    /// Greatest angle (rad, >= least).
    pub most: f64,
}

impl AngleInterval {
    /// From `least` to `most` (rad).
    pub const fn new(least: f64, most: f64) -> Self {
        Self { least, most }
    }

    /// Interval from `-most` to `most` (rad).
    pub const fn around_zero(most: f64) -> Self {
        Self { least: -most, most }
    }

    /// Distance of an angle outside the interval; negative inside (rad).
    pub fn excess(self, angle: f64) -> f64 {
        (self.least - angle).max(angle - self.most)
    }

    /// Intersection with another interval; the nearest end where there is none.
    pub fn intersection(self, other: Self) -> Self {
        let least = self.least.max(other.least).min(other.most);
        Self { least, most: self.most.min(other.most).max(least) }
    }

    /// Angle at a share of the interval.
    pub fn angle_at(self, share: f64) -> f64 {
        self.least + share * (self.most - self.least)
    }

    /// Length (rad).
    pub fn length(self) -> f64 {
        self.most - self.least
    }

    fn extended_to(self, angle: f64) -> Self {
        Self { least: self.least.min(angle), most: self.most.max(angle) }
    }
}

/// Directions that a segment may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SwingLimit {
    /// Rotation vectors in an ellipse around the middle: its radii about the first and the second axis (rad).
    Ellipse([f64; 2]),
    /// A hinge about the first axis, with a little play about the second one (rad).
    Hinge {
        /// Flexion about the first axis.
        flexion: AngleInterval,
        /// Play to either side about the second axis.
        play: f64,
    },
}

impl SwingLimit {
    /// Excess of a swing over the limit; negative inside (rad).
    pub(crate) fn excess(self, [x, y]: [f64; 2]) -> f64 {
        match self {
            Self::Ellipse(radii) => (ellipse_distance([x, y], radii) - 1.0) * radii[0].min(radii[1]),
            Self::Hinge { flexion, play } => flexion.excess(x).max(y.abs() - play),
        }
    }
}

/// Distance from the middle of an ellipse, 1 on its rim.
pub(super) fn ellipse_distance(point: [f64; 2], radii: [f64; 2]) -> f64 {
    let [x, y] = [point[0] / radii[0], point[1] / radii[1]];
    (x * x + y * y).sqrt()
}

/// A rotation within a joint: swing about the two axes at right angles to the segment, and twist about it (rad).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coordinates {
    /// Rotation vector of the swing, about the first and the second axis; the first is the flexion of a hinge (rad).
    pub swing: [f64; 2],
    /// Twist (rad).
    pub twist: f64,
}

/// The limits of one joint.
///
/// A rotation is `centre * swing * twist`: the segment twists about itself, swings from the middle of its range, and the
/// middle is turned from the rest pose. A swing is in an ellipse if its rotation vector is: (s1 / r1)^2 + (s2 / r2)^2 <= 1.
///
/// # Source
/// Grassia 1998, section 5; Shapiro, Kallmann and Faloutsos 2007, section 4.2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimits {
    /// Middle of the range, relative to the rest pose.
    pub centre: DQuat,
    /// Direction of the segment at rest; twist is about it (unit).
    pub segment: DVec3,
    /// Axes about which swings are measured, at right angles to the segment (unit).
    pub axes: [DVec3; 2],
    /// Range of swings.
    pub swing: SwingLimit,
    /// Range of twists.
    pub twist: AngleInterval,
    /// Greatest turning speed (rad/s).
    pub speed: f64,
    /// True for a joint of the right side: all other fields are those of its mirror image.
    pub mirrored: bool,
}

/// Swings are smaller than this: nearer to half a turn, a segment's direction says little about its swing (rad).
pub const MAX_SWING: f64 = 2.8;

impl JointLimits {
    /// Coordinates of a rotation within the joint.
    pub fn coordinates(&self, q: DQuat) -> Coordinates {
        let q = if self.mirrored { mirror_rotation_x(q) } else { q };
        let (swing, twist) = swing_twist(self.centre.inverse() * q, self.segment);
        let vector = log(swing);
        Coordinates { swing: self.axes.map(|a| vector.dot(a)), twist }
    }

    /// The rotation of coordinates.
    pub fn rotation(&self, c: Coordinates) -> DQuat {
        let swing = exp(self.axes[0] * c.swing[0] + self.axes[1] * c.swing[1]);
        let q = self.centre * swing * rotation_about(self.segment, c.twist);
        if self.mirrored { mirror_rotation_x(q) } else { q }
    }

    /// Excess of coordinates over the limits; where negative, they are inside by at least that (rad).
    pub fn coordinate_excess(&self, c: Coordinates) -> f64 {
        self.swing.excess(c.swing).max(self.twist.excess(c.twist))
    }

    /// Excess of a rotation over the limits; where negative, it is inside by at least that (rad).
    pub fn excess(&self, q: DQuat) -> f64 {
        self.coordinate_excess(self.coordinates(q))
    }

    /// Bound on the growth of [`JointLimits::excess`] for each radian that the joint turns inside its limits.
    ///
    /// A direction at an angle s from the middle, moved on the sphere, moves s / sin s times as far on the map of rotation
    /// vectors; twist changes at most by 1 / cos(s / 2) times the rotation.
    pub fn stiffness(&self) -> f64 {
        let s = self.widest_swing().clamp(1e-3, MAX_SWING);
        (s / maths::sin(s)).max(1.0 / maths::cos(0.5 * s))
    }

    /// The largest angle from the middle to the segment (rad).
    pub fn widest_swing(&self) -> f64 {
        match self.swing {
            SwingLimit::Ellipse(radii) => radii[0].max(radii[1]),
            SwingLimit::Hinge { flexion, play } => maths::hypot(flexion.least.abs().max(flexion.most.abs()), play),
        }
    }

    /// These limits, widened until a rotation is within them, with a little room: a clip's poses are admitted even where its
    /// performer bent farther. A swing beyond 2.8 rad stays outside.
    pub fn widened_to_admit(&self, q: DQuat) -> Self {
        /// Room beyond the rotation (rad).
        const ROOM: f64 = 1e-3;
        let c = self.coordinates(q);
        let mut out = *self;
        if self.twist.excess(c.twist) > -ROOM {
            out.twist = self.twist.extended_to(c.twist - ROOM).extended_to(c.twist + ROOM);
        }
        out.swing = match self.swing {
            SwingLimit::Ellipse(radii) => {
                let grow = (ellipse_distance(c.swing, radii) + ROOM / radii[0].min(radii[1])).max(1.0);
                SwingLimit::Ellipse(radii.map(|r| (r * grow).min(MAX_SWING)))
            }
            SwingLimit::Hinge { flexion, play } => {
                let wide = |angle: f64| angle.clamp(-MAX_SWING, MAX_SWING);
                let flexion = flexion.extended_to(wide(c.swing[0] - ROOM)).extended_to(wide(c.swing[0] + ROOM));
                SwingLimit::Hinge { flexion, play: play.max(c.swing[1].abs() + ROOM).min(1.0) }
            }
        };
        if self.coordinate_excess(c) <= -ROOM { *self } else { out }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::rotation::angle_between;
    use proptest::prelude::*;

    /// A shoulder that looks ahead, with an ellipse of 1.5 by 0.8.
    pub fn shoulder() -> JointLimits {
        JointLimits {
            centre: rotation_about(DVec3::Y, -0.7),
            segment: DVec3::X,
            axes: [DVec3::Y, DVec3::Z],
            swing: SwingLimit::Ellipse([1.5, 0.8]),
            twist: AngleInterval::new(-1.0, 1.5),
            speed: 10.0,
            mirrored: false,
        }
    }

    pub fn elbow() -> JointLimits {
        JointLimits {
            centre: DQuat::IDENTITY,
            axes: [DVec3::NEG_Y, DVec3::Z],
            swing: SwingLimit::Hinge { flexion: AngleInterval::new(0.0, 2.6), play: 0.2 },
            ..shoulder()
        }
    }

    #[test]
    fn an_ellipse_holds_what_was_worked_out_by_hand() {
        let s = shoulder();
        let at = |x: f64, y: f64| s.coordinate_excess(Coordinates { swing: [x, y], twist: 0.0 });
        assert!((at(1.5, 0.0)).abs() < 1e-12 && (at(0.0, -0.8)).abs() < 1e-12);
        // On the ellipse at 60 degrees: 1.5 cos, 0.8 sin.
        assert!(at(0.75, 0.8 * 0.75f64.sqrt()).abs() < 1e-12);
        // Half way out: half the smaller radius is left.
        assert!((at(0.75, 0.0) + 0.4).abs() < 1e-12);
        assert!((at(0.0, 1.6) - 0.8).abs() < 1e-12);
        let twisted = Coordinates { swing: [0.0; 2], twist: 1.7 };
        assert!((s.coordinate_excess(twisted) - 0.2).abs() < 1e-12);
        // The arm at rest is 0.7 rad from the middle, about the first axis.
        let rest = s.coordinates(DQuat::IDENTITY);
        assert!((rest.swing[0] - 0.7).abs() < 1e-12 && rest.swing[1].abs() < 1e-12 && rest.twist.abs() < 1e-12);
    }

    #[test]
    fn the_area_of_an_ellipse_is_that_of_the_book() {
        // Counted on a grid of rotation vectors, against pi r1 r2.
        let (s, n) = (shoulder(), 800);
        let step = 4.0 / f64::from(n);
        let inside = (0..n * n).filter(|i| {
            let at = |k: i32| (f64::from(k) + 0.5) * step - 2.0;
            s.excess(s.rotation(Coordinates { swing: [at(i % n), at(i / n)], twist: 0.1 })) <= 0.0
        });
        let area = inside.count() as f64 * step * step;
        assert!((area - std::f64::consts::PI * 1.5 * 0.8).abs() < 0.01, "{area}");
    }

    #[test]
    fn the_right_side_is_the_left_one_in_a_mirror() {
        let left = shoulder();
        let right = JointLimits { mirrored: true, ..left };
        let c = Coordinates { swing: [0.4, -0.3], twist: 0.2 };
        let (a, b) = (left.rotation(c) * DVec3::X, right.rotation(c) * DVec3::NEG_X);
        assert!((a - DVec3::new(-b.x, b.y, b.z)).length() < 1e-12);
        assert!((right.coordinates(right.rotation(c)).twist - 0.2).abs() < 1e-12);
    }

    fn any_rotation() -> impl Strategy<Value = DQuat> {
        prop::array::uniform3(-3.0f64..3.0).prop_map(|v| exp(DVec3::from(v)))
    }

    proptest! {
        #[test]
        fn coordinates_and_rotations_agree(x in -1.6f64..1.6, y in -1.0f64..1.0, twist in -1.5f64..1.5, right in any::<bool>()) {
            for limits in [shoulder(), elbow()] {
                let limits = JointLimits { mirrored: right, ..limits };
                let c = Coordinates { swing: [x, y], twist };
                let found = limits.coordinates(limits.rotation(c));
                prop_assert!((found.swing[0] - x).abs() < 1e-9 && (found.swing[1] - y).abs() < 1e-9);
                prop_assert!((found.twist - twist).abs() < 1e-9);
            }
        }

        #[test]
        fn admitted_rotations_are_inside(x in -2.2f64..2.2, y in -0.9f64..0.9, twist in -3.0f64..3.0) {
            for limits in [shoulder(), elbow()] {
                let q = limits.rotation(Coordinates { swing: [x, y], twist });
                let wide = limits.widened_to_admit(q);
                prop_assert!(wide.excess(q) < 0.0, "{}", wide.excess(q));
                if limits.excess(q) < -1e-2 {
                    prop_assert_eq!(wide, limits);
                }
            }
        }

        #[test]
        fn inside_no_turn_eats_more_margin_than_the_stiffness_says(a in any_rotation(), turn in prop::array::uniform3(-0.02f64..0.02)) {
            for limits in [shoulder(), elbow()] {
                let b = exp(DVec3::from(turn)) * a;
                let [from, to] = [a, b].map(|q| limits.excess(q));
                if from < 0.0 && to < 0.0 {
                    prop_assert!((to - from).abs() <= limits.stiffness() * angle_between(a, b) * 1.02 + 1e-9);
                }
            }
        }
    }
}
