//! Steady movement over the ground: constant velocity in a frame that turns at a constant rate.

use super::arc::{Arc, wrap};
use super::steps::Steps;
use super::track::Track;
use glam::DVec2;

/// Speed below which a path shows no direction, so that the body's heading gives the turn (m/s).
const SLOW: f64 = 0.15;

/// Constant velocity and turning rate of a facing frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist {
    /// Velocity to the left and ahead (m/s).
    pub velocity: DVec2,
    /// Turning rate, positive to the left (rad/s).
    pub gyration: f64,
}

impl Twist {
    /// Displacement after a time, in the starting frame: (left, ahead) and angle.
    pub fn advance(&self, seconds: f64) -> (DVec2, f64) {
        let angle = self.gyration * seconds;
        let (along, across) = integrals(angle, seconds);
        let v = self.velocity;
        (DVec2::new(along * v.x + across * v.y, along * v.y - across * v.x), angle)
    }

    /// Movement with a given displacement in a time: the inverse of [`Twist::advance`].
    pub fn towards(place: DVec2, angle: f64, seconds: f64) -> Self {
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
    pub fn of_cycles(track: &Track<'_>, cycles: &[Steps], period: f64) -> Self {
        let (start, end) = (cycles[0].start, cycles[cycles.len() - 1].end);
        if cycles.len() < 2 {
            let turn = track.facing(end) - track.facing(start);
            // The body swings with every step, so its mean facing counts, not that at the strike.
            let heading = track.mean(start, end, |t| track.facing(t) - turn * (t - start) / (end - start));
            let seconds = (end - start) / track.rate();
            return Self::between(track.place(start), heading, track.place(end), heading + turn, seconds);
        }
        let n = (end - start - period).floor().max(2.0) as usize;
        let middle = |i: usize| start + 0.5 * period + (end - start - period) * i as f64 / n as f64;
        let mean = |i: usize| {
            let (a, b) = (middle(i) - 0.5 * period, middle(i) + 0.5 * period);
            (track.mean(a, b, |t| track.place(t)), track.mean(a, b, |t| track.facing(t)))
        };
        let (path, facing): (Vec<DVec2>, Vec<f64>) = (0..=n).map(mean).unzip();
        let seconds = (end - start - period) / track.rate();
        let chord = Self::between(path[0], facing[0], path[n], facing[n], seconds);
        match Arc::fit(&path) {
            Some(arc) if arc.length > SLOW * seconds => {
                Self::of_arc(&arc, &path, &facing, seconds, period / track.rate())
            }
            _ => chord,
        }
    }

    fn of_arc(arc: &Arc, path: &[DVec2], facing: &[f64], seconds: f64, period: f64) -> Self {
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

    fn between(from: DVec2, from_facing: f64, to: DVec2, to_facing: f64, seconds: f64) -> Self {
        Self::towards(turned(to - from, -from_facing), to_facing - from_facing, seconds)
    }
}

/// A facing frame that moves steadily.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course {
    /// Movement of the frame.
    pub twist: Twist,
    origin: DVec2,
    heading: f64,
    start: f64,
    rate: f64,
}

impl Course {
    /// Course that fits a body best between two times: on average the body faces ahead and is above it.
    pub fn under(track: &Track<'_>, twist: Twist, start: f64, end: f64) -> Self {
        let seconds = |t: f64| (t - start) / track.rate();
        let apart = |t: f64| DVec2::from_angle(track.facing(t) - twist.gyration * seconds(t));
        let heading = track.mean(start, end, apart).to_angle();
        let course = Self { twist, origin: DVec2::ZERO, heading, start, rate: track.rate() };
        let origin = track.mean(start, end, |t| track.place(t) - course.at(t).0);
        Self { origin, ..course }
    }

    /// The straight course under one step that the other foot would repeat mirrored: the body sways and turns to one
    /// side as far as it then would to the other.
    pub fn of_step(track: &Track<'_>, start: f64, end: f64) -> Self {
        let heading = 0.5 * (track.facing(start) + track.facing(end));
        let way = track.place(end) - track.place(start);
        let ahead = turned(way, -heading).y * track.rate() / (end - start);
        let twist = Twist { velocity: DVec2::new(0.0, ahead), gyration: 0.0 };
        let course = Self { twist, origin: track.place(start), heading, start, rate: track.rate() };
        let seen = track.mean(start, end, |t| turned(track.place(t) - course.at(t).0, -heading)).y;
        // This half of the sideways displacement leads from one side to the middle.
        let aside = 0.5 * turned(way, -heading).x;
        Self { origin: course.origin + turned(DVec2::new(aside, seen), heading), ..course }
    }

    /// Position on the ground and heading at a time (m, rad).
    pub fn at(&self, time: f64) -> (DVec2, f64) {
        let (place, angle) = self.twist.advance((time - self.start) / self.rate);
        (self.origin + turned(place, self.heading), self.heading + angle)
    }

    /// Difference of a body's poses at two times relative to the course: in position and heading (m, rad).
    pub fn apart(&self, track: &Track<'_>, a: f64, b: f64) -> (f64, f64) {
        let seen = |t: f64| {
            let (origin, heading) = self.at(t);
            (turned(track.place(t) - origin, -heading), track.facing(t) - heading)
        };
        let ((p, f), (q, g)) = (seen(a), seen(b));
        (p.distance(q), wrap(f - g).abs())
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
pub fn turned(p: DVec2, angle: f64) -> DVec2 {
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
            let twist = Twist { velocity: DVec2::new(vx, vz), gyration: w };
            let (place, angle) = twist.advance(s);
            let back = Twist::towards(place, angle, s);
            prop_assert!((back.velocity - twist.velocity).length() < 1e-9 && (back.gyration - w).abs() < 1e-9);
        }

        #[test]
        fn advancing_is_many_small_steps(vx in -3.0f64..3.0, vz in -5.0f64..5.0, w in -2.0f64..2.0) {
            let (mut p, mut h) = (DVec2::ZERO, 0.0);
            for _ in 0..20_000 {
                p += turned(DVec2::new(vx, vz), h + 0.5 * w / 20_000.0) / 20_000.0;
                h += w / 20_000.0;
            }
            let (place, angle) = Twist { velocity: DVec2::new(vx, vz), gyration: w }.advance(1.0);
            prop_assert!(place.distance(p) < 1e-6 && (angle - h).abs() < 1e-9);
        }
    }
}
