//! Course of a slide: the centre line of its bed, by distance over the ground.

use crate::side::{forward, left_direction, leftward, over_ground};
use crate::walk::footsteps::FeetStance;
use glam::DVec3;
use std::f64::consts::FRAC_PI_2;

/// Height of the lower end over the ground (m).
pub const END_HEIGHT: f64 = 0.3;
/// Length over which the bed flattens out (m).
const FLATTENING: f64 = 0.8;
/// Length of the level part at the lower end (m).
const RUN_OUT: f64 = 0.4;
/// Height of the sides over the bed (m).
pub const SIDE_HEIGHT: f64 = 0.12;
/// Distance of the middle of a side from the middle of the bed (m).
pub const SIDE_ASIDE: f64 = 0.32;
/// Distance to each side over which edges are rounded off for sliding (m).
const ROUNDING: f64 = 0.14;

/// A slide, from the deck before it to the ground behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlideCourse {
    /// Upper edge.
    pub start: FeetStance,
    /// Height of the upper edge (m).
    pub level: f64,
    /// Slope of the even part: drop over distance.
    slope: f64,
    /// Distance at which a quarter circle to the left begins, and its radius; `None` for a straight slide (m).
    bend: Option<(f64, f64)>,
}

/// A point of a course.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoursePoint {
    /// Position on the bed (m).
    pub at: DVec3,
    /// Downhill heading (rad).
    pub heading: f64,
    /// Downward angle (rad).
    pub pitch: f64,
}

impl CoursePoint {
    /// A point off the centre line: to the left along the ground, and off the bed (m).
    pub fn offset_point(&self, left: f64, up: f64) -> DVec3 {
        let (sin, cos) = self.pitch.sin_cos();
        let off_bed = over_ground(forward(self.heading) * sin, cos);
        self.at + left_direction(self.heading) * left + off_bed * up
    }
}

impl SlideCourse {
    /// A straight slide of pieces that drop three metres in four.
    pub fn straight(start: FeetStance, level: f64) -> Self {
        Self { start, level, slope: 0.75, bend: None }
    }

    /// A curved slide.
    pub fn curved(start: FeetStance, level: f64) -> Self {
        Self { start, level, slope: 0.7, bend: Some((0.4, 1.5)) }
    }

    /// Distance at which the bed begins to flatten out (m).
    fn flattening_start(&self) -> f64 {
        (self.level - END_HEIGHT) / self.slope - 0.5 * FLATTENING
    }

    /// Distance of the lower end (m).
    pub fn length(&self) -> f64 {
        self.flattening_start() + FLATTENING + RUN_OUT
    }

    /// Height of the bed; that of the deck before its upper edge, and that of its end beyond it (m).
    pub fn height(&self, s: f64) -> f64 {
        let u = (s - self.flattening_start()).clamp(0.0, FLATTENING);
        self.level - self.slope * s.clamp(0.0, self.flattening_start()) - self.slope * (u - u * u / (2.0 * FLATTENING))
    }

    /// Position and heading on the ground.
    pub fn ground_stance(&self, s: f64) -> FeetStance {
        let FeetStance { at, heading } = self.start;
        let Some((from, radius)) = self.bend else { return FeetStance { at: at + forward(heading) * s, heading } };
        let turn = ((s - from) / radius).clamp(0.0, FRAC_PI_2);
        let (before, after) = (s.min(from), (s - from - radius * FRAC_PI_2).max(0.0));
        let to_left = leftward(heading) * (radius * (1.0 - turn.cos()));
        let ahead = forward(heading) * (before + radius * turn.sin());
        FeetStance { at: at + to_left + ahead + forward(heading + turn) * after, heading: heading + turn }
    }

    /// Point at a distance, with rounded edges (m).
    pub fn point(&self, s: f64) -> CoursePoint {
        const SAMPLES: i32 = 8;
        let plan = self.ground_stance(s);
        let mean = |f: &dyn Fn(f64) -> f64| {
            let sum: f64 = (-SAMPLES..=SAMPLES).map(|k| f(s + ROUNDING * f64::from(k) / f64::from(SAMPLES))).sum();
            sum / f64::from(2 * SAMPLES + 1)
        };
        let height = mean(&|s| self.height(s));
        let drop = (self.height(s - ROUNDING) - self.height(s + ROUNDING)) / (2.0 * ROUNDING);
        let heading = mean(&|s| self.ground_stance(s).heading);
        CoursePoint { at: over_ground(plan.at, height), heading, pitch: drop.atan() }
    }

    /// True if the course bends to the left there.
    pub fn bends_left(&self, s: f64) -> bool {
        self.bend.is_some_and(|(from, radius)| (from..from + radius * FRAC_PI_2).contains(&s))
    }
}

#[cfg(test)]
mod tests {
    use super::super::gym::{LEVEL, SLIDE_A, SLIDE_CURVED};
    use super::*;

    #[test]
    fn a_course_ends_above_the_ground_without_a_step() {
        for course in [SlideCourse::straight(SLIDE_A, LEVEL), SlideCourse::curved(SLIDE_CURVED, LEVEL)] {
            assert_eq!(course.height(-1.0), LEVEL);
            assert!((course.height(course.length()) - END_HEIGHT).abs() < 1e-9);
            for k in 0..400 {
                let s = -0.5 + 0.01 * f64::from(k);
                let (a, b) = (course.point(s), course.point(s + 1e-3));
                assert!((b.at - a.at).length() < 1.5e-3 && (b.pitch - a.pitch).abs() < 0.01, "{s}");
            }
        }
    }

    #[test]
    fn the_straight_slide_is_three_pieces_long() {
        let course = SlideCourse::straight(SLIDE_A, LEVEL);
        assert!((course.length() - (2.8 + RUN_OUT)).abs() < 1e-9, "{}", course.length());
        assert!((course.height(2.8 / 3.0) - 1.4).abs() < 1e-9);
    }

    #[test]
    fn the_curved_slide_ends_to_the_left() {
        let course = SlideCourse::curved(FeetStance::default(), LEVEL);
        let end = course.ground_stance(course.length());
        assert!((end.heading - FRAC_PI_2).abs() < 1e-9 && end.at.x > 1.9 && (end.at.y - 1.9).abs() < 1e-9, "{end:?}");
    }
}
