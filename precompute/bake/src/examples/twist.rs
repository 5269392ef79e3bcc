//! Steady movement over the ground: constant velocity in a frame that turns at a constant rate.

use super::{Arc, ClipTrack, StepCycle, wrap_angle};
use glam::DVec2;
use throng_base::thresholds::STANDING_MPS_F64;

/// Constant velocity and turning rate of a facing frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FacingTwist {
    /// Velocity to the left and ahead (m/s).
    pub velocity: DVec2,
    /// Turning rate, positive to the left (rad/s).
    pub gyration: f64,
}

impl FacingTwist {
    /// Displacement after a time, in the starting frame: (left, ahead) and angle.
    pub fn advance(&self, seconds: f64) -> (DVec2, f64) {
        let angle = self.gyration * seconds;
        let (along, across) = integrals(angle, seconds);
        let v = self.velocity;
        (DVec2::new(along * v.x + across * v.y, along * v.y - across * v.x), angle)
    }

    /// Movement with a given displacement in a time: the inverse of [`FacingTwist::advance`].
    pub fn steering_to(place: DVec2, angle: f64, seconds: f64) -> Self {
        let (along, across) = integrals(angle, seconds);
        let velocity = DVec2::new(along * place.x - across * place.y, along * place.y + across * place.x);
        Self { velocity: velocity / (along * along + across * across), gyration: angle / seconds }
    }

    /// Mean movement of a run of consecutive cycles (Kim, Kim and Shin 2003a, section 4.1).
    ///
    /// The root's path is averaged over one cycle around every moment, so that its sway from foot to foot does not bend
    /// the arc; the radius lost by averaging is given back. A single cycle, which has no average, and one that hardly
    /// travels are measured from end to end.
    ///
    /// - `period`: time of a cycle (frames).
    pub fn mean_of_cycles(track: &ClipTrack<'_>, cycles: &[StepCycle], period: f64) -> Self {
        let (start, end) = (cycles[0].start, cycles[cycles.len() - 1].end);
        if cycles.len() < 2 {
            let turn = track.facing_at(end) - track.facing_at(start);
            // The body swings with every step, so its mean facing counts, not that at the strike.
            let heading = track.mean_over(start, end, |t| track.facing_at(t) - turn * (t - start) / (end - start));
            let seconds = (end - start) / track.rate();
            let [from, to] = [start, end].map(|t| track.position_at(t));
            return Self::from_motion(from, heading, to, heading + turn, seconds);
        }
        let n = (end - start - period).floor().max(2.0) as usize;
        let middle = |i: usize| start + 0.5 * period + (end - start - period) * i as f64 / n as f64;
        let mean = |i: usize| {
            let (a, b) = (middle(i) - 0.5 * period, middle(i) + 0.5 * period);
            (track.mean_over(a, b, |t| track.position_at(t)), track.mean_over(a, b, |t| track.facing_at(t)))
        };
        let (path, facing): (Vec<DVec2>, Vec<f64>) = (0..=n).map(mean).unzip();
        let seconds = (end - start - period) / track.rate();
        let chord = Self::from_motion(path[0], facing[0], path[n], facing[n], seconds);
        match Arc::fit(&path) {
            Some(arc) if arc.length > STANDING_MPS_F64 * seconds => {
                Self::from_arc(&arc, &path, &facing, seconds, period / track.rate())
            }
            _ => chord,
        }
    }

    fn from_arc(arc: &Arc, path: &[DVec2], facing: &[f64], seconds: f64, period: f64) -> Self {
        let gyration = arc.angle() / seconds;
        let half = 0.5 * gyration * period;
        let shrunk = if half.abs() < 1e-4 { 1.0 } else { half.sin() / half };
        let speed = arc.length / seconds / shrunk.max(0.1);
        // The chord of an arc is parallel to the tangent at its middle, and more exact than the ends.
        let chord = path[path.len() - 1] - path[0];
        let middle = facing.iter().sum::<f64>() / facing.len() as f64;
        let apart =
            if gyration.abs() * seconds < 3.0 { chord.x.atan2(chord.y) } else { arc.heading + 0.5 * arc.angle() }
                - middle;
        Self { velocity: speed * DVec2::new(apart.sin(), apart.cos()), gyration }
    }

    fn from_motion(from: DVec2, from_facing: f64, to: DVec2, to_facing: f64, seconds: f64) -> Self {
        Self::steering_to(rotate_ground(to - from, -from_facing), to_facing - from_facing, seconds)
    }
}

/// A facing frame that moves steadily.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteadyCourse {
    /// Movement of the frame.
    pub twist: FacingTwist,
    origin: DVec2,
    heading: f64,
    start: f64,
    rate: f64,
}

impl SteadyCourse {
    /// Course that fits a body best between two times: on average the body faces ahead and is above it.
    pub fn fit_to_track(track: &ClipTrack<'_>, twist: FacingTwist, start: f64, end: f64) -> Self {
        let seconds = |t: f64| (t - start) / track.rate();
        let apart = |t: f64| DVec2::from_angle(track.facing_at(t) - twist.gyration * seconds(t));
        let heading = track.mean_over(start, end, apart).to_angle();
        let course = Self { twist, origin: DVec2::ZERO, heading, start, rate: track.rate() };
        let origin = track.mean_over(start, end, |t| track.position_at(t) - course.frame_at(t).0);
        Self { origin, ..course }
    }

    /// The straight course under one step that the other foot would repeat mirrored: the body sways and turns to one
    /// side as far as it then would to the other.
    pub fn from_step(track: &ClipTrack<'_>, start: f64, end: f64) -> Self {
        let heading = 0.5 * (track.facing_at(start) + track.facing_at(end));
        let offset = track.position_at(end) - track.position_at(start);
        let ahead = rotate_ground(offset, -heading).y * track.rate() / (end - start);
        let twist = FacingTwist { velocity: DVec2::new(0.0, ahead), gyration: 0.0 };
        let course = Self { twist, origin: track.position_at(start), heading, start, rate: track.rate() };
        let seen =
            track.mean_over(start, end, |t| rotate_ground(track.position_at(t) - course.frame_at(t).0, -heading)).y;
        // This half of the sideways displacement leads from one side to the middle.
        let aside = 0.5 * rotate_ground(offset, -heading).x;
        Self { origin: course.origin + rotate_ground(DVec2::new(aside, seen), heading), ..course }
    }

    /// Position on the ground and heading at a time (m, rad).
    pub fn frame_at(&self, time: f64) -> (DVec2, f64) {
        let (place, angle) = self.twist.advance((time - self.start) / self.rate);
        (self.origin + rotate_ground(place, self.heading), self.heading + angle)
    }

    /// Difference of a body's poses at two times relative to the course: in position and heading (m, rad).
    pub fn pose_gap(&self, track: &ClipTrack<'_>, a: f64, b: f64) -> (f64, f64) {
        let seen = |t: f64| {
            let (origin, heading) = self.frame_at(t);
            (rotate_ground(track.position_at(t) - origin, -heading), track.facing_at(t) - heading)
        };
        let ((p, f), (q, g)) = (seen(a), seen(b));
        (p.distance(q), wrap_angle(f - g).abs())
    }
}

/// Integrals of cosine and sine of a turn at constant rate, over its duration.
fn integrals(angle: f64, seconds: f64) -> (f64, f64) {
    match angle.abs() < 1e-6 {
        true => (seconds, 0.5 * angle * seconds),
        false => (seconds * angle.sin() / angle, seconds * (1.0 - angle.cos()) / angle),
    }
}

/// A ground vector (x, z) rotated about +Y: +z turns towards +x.
pub fn rotate_ground(p: DVec2, angle: f64) -> DVec2 {
    let (s, c) = angle.sin_cos();
    DVec2::new(c * p.x + s * p.y, c * p.y - s * p.x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_is_come_to_tells_the_movement(vx in -3.0f64..3.0, vz in -5.0f64..5.0, w in -2.0f64..2.0, s in 0.2f64..1.5) {
            let twist = FacingTwist { velocity: DVec2::new(vx, vz), gyration: w };
            let (place, angle) = twist.advance(s);
            let back = FacingTwist::steering_to(place, angle, s);
            prop_assert!((back.velocity - twist.velocity).length() < 1e-9 && (back.gyration - w).abs() < 1e-9);
        }

        #[test]
        fn advancing_is_many_small_steps(vx in -3.0f64..3.0, vz in -5.0f64..5.0, w in -2.0f64..2.0) {
            let (mut p, mut h) = (DVec2::ZERO, 0.0);
            for _ in 0..20_000 {
                p += rotate_ground(DVec2::new(vx, vz), h + 0.5 * w / 20_000.0) / 20_000.0;
                h += w / 20_000.0;
            }
            let (place, angle) = FacingTwist { velocity: DVec2::new(vx, vz), gyration: w }.advance(1.0);
            prop_assert!(place.distance(p) < 1e-6 && (angle - h).abs() < 1e-9);
        }
    }
}
