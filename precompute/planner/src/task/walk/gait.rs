//! Records a walker of a blend space, frame by frame, into a clip.

use crate::{rotation::wrap_angle, task::entries::PaceEntry};
use glam::{DQuat, DVec2, DVec3};
use throng_base::{Id, Inline, Result, maths};
use throng_core::walkers::{Control, WalkerStart, Walkers, WalkersConfig};
use throng_core::{CharacterGroup, NUM_JOINTS, Planar, blend::BlendSpace, body::BodyLayers};
use throng_motion::{Clip, export::ActorPose};

/// Steps a second at least.
const STEP_HZ: f64 = 60.0;
/// Turning speed of a character that stands (rad/s).
const TURN: f64 = 1.6;
/// Acceleration at the beginning and end of a walk (m/s^2).
const START: f64 = 1.2;
/// Time until feet that turned on the spot are at rest (s).
const FEET_AT_REST_S: f64 = 0.3;
/// Smallest turn on the spot (rad).
const NO_TURN: f64 = 0.02;
/// Turn below which a walk begins with the turn itself (rad).
const ON_THE_WAY: f64 = 0.5;

/// A walker, and all frames so far.
#[derive(Clone)]
pub(super) struct WalkRecording {
    walkers: Walkers,
    who: Id,
    steps: usize,
    /// Position and heading of the walker while it stands.
    position: DVec2,
    heading: f64,
    /// All frames so far.
    clip: Clip,
    /// Gaze target (m).
    pub gaze_target: Option<DVec3>,
}

impl WalkRecording {
    /// Starts a walker that stands at a position (x and z, m) with a heading (rad), at frame 0.
    pub fn new(space: &BlendSpace, at: DVec2, heading: f64, rate_hz: f64) -> Result<Self> {
        let mut walkers = Walkers::with_capacity(space.clone(), &[], WalkersConfig::default(), 1)?;
        let root = Planar::new(at.x as f32, at.y as f32, heading as f32);
        let who = walkers.spawn(WalkerStart { root, ..WalkerStart::default() })?;
        let steps = (STEP_HZ / rate_hz).ceil().max(1.0) as usize;
        let clip = Clip::new("", rate_hz, Vec::new(), Vec::new());
        let mut gait = Self { walkers, who, steps, position: at, heading, clip, gaze_target: None };
        gait.record_frame();
        Ok(gait)
    }

    /// Time of the last frame (s).
    pub fn time_s(&self) -> f64 {
        (self.clip.num_frames() - 1) as f64 / self.clip.rate_hz
    }

    /// Position (x and z, m) and heading (rad) of the walker while it stands.
    pub fn place(&self) -> (DVec2, f64) {
        (self.position, self.heading)
    }

    /// Position of the hips and rotations of the last frame.
    pub fn pose(&self) -> (DVec3, [DQuat; NUM_JOINTS]) {
        self.frame_pose(self.clip.num_frames() - 1)
    }

    fn frame_pose(&self, frame: usize) -> (DVec3, [DQuat; NUM_JOINTS]) {
        let turns = std::array::from_fn(|j| self.clip.frame_rotations(frame)[j].as_dquat().normalize());
        (self.clip.root_positions[frame].as_dvec3(), turns)
    }

    /// Frames after a time: time, position of the hips and rotations.
    pub fn frames_after(&self, time_s: f64) -> Vec<(f64, (DVec3, [DQuat; NUM_JOINTS]))> {
        let first = (time_s * self.clip.rate_hz).round() as usize + 1;
        (first..self.clip.num_frames()).map(|f| (f as f64 / self.clip.rate_hz, self.frame_pose(f))).collect()
    }

    /// The clip so far.
    pub fn clip(&self, name: &str) -> Clip {
        Clip { name: name.into(), ..self.clip.clone() }
    }

    /// Stands until a time (s).
    pub fn stand_until(&mut self, until_s: f64) -> Result<()> {
        while self.time_s() + 0.5 / self.clip.rate_hz < until_s {
            let (at, heading) = self.place();
            self.step_frame(|_| (at, DVec2::ZERO, heading))?;
        }
        Ok(())
    }

    /// Goes straight on at speeds that change evenly between times (s, m/s; two at least, ascending from now on).
    pub fn walk_at_pace(&mut self, pace: &[PaceEntry]) -> Result<()> {
        let Some(end_s) = pace.last().map(|p| p.t_s) else { return Ok(()) };
        let (start_s, from, heading) = (self.time_s(), self.position, self.heading);
        let ahead = DVec2::new(maths::sin(heading), maths::cos(heading));
        // Distance (m) and speed (m/s).
        let along = |t: f64| {
            let mut walked_m = 0.0;
            for w in pace.windows(2) {
                let (length, t) = (w[1].t_s - w[0].t_s, (t - w[0].t_s).min(w[1].t_s - w[0].t_s));
                let gain = (w[1].speed_mps - w[0].speed_mps) / length;
                if t < length {
                    return (walked_m + t * (w[0].speed_mps + 0.5 * gain * t), w[0].speed_mps + gain * t);
                }
                walked_m += 0.5 * length * (w[0].speed_mps + w[1].speed_mps);
            }
            (walked_m, pace[pace.len() - 1].speed_mps)
        };
        while self.time_s() - start_s + 0.5 / self.clip.rate_hz < end_s {
            self.step_frame(|t| {
                let (walked_m, speed) = along(t - start_s);
                (from + ahead * walked_m, ahead * speed, heading)
            })?;
        }
        self.position = from + ahead * along(end_s).0;
        Ok(())
    }

    /// Turns on the spot to a heading, evenly eased.
    pub fn turn_to(&mut self, heading: f64) -> Result<()> {
        let by = wrap_angle(heading - self.heading);
        if by.abs() < NO_TURN {
            return Ok(());
        }
        // The turn is fastest in the middle, by half more than in the mean.
        let seconds = 1.5 * by.abs() / TURN;
        let (at, from, start_s) = (self.position, self.heading, self.time_s());
        while self.time_s() - start_s < seconds {
            self.step_frame(|t| {
                let share = ((t - start_s) / seconds).clamp(0.0, 1.0);
                (at, DVec2::ZERO, from + by * share * share * (3.0 - 2.0 * share))
            })?;
        }
        self.heading = heading;
        let until_s = self.time_s() + FEET_AT_REST_S;
        self.stand_until(until_s)
    }

    /// Walks along a path from where it stands.
    ///
    /// - `way`: x and z (m, two at least), the first where the walker stands.
    /// - returns the time at which the path ends (s).
    pub fn walk_along(&mut self, path: &[DVec2], speed_mps: f64) -> Result<f64> {
        let lengths: Vec<f64> = path.windows(2).map(|w| w[0].distance(w[1])).collect();
        let length: f64 = lengths.iter().sum();
        let Some(first) = path.windows(2).find(|w| w[0].distance(w[1]) > 1e-6) else { return Ok(self.time_s()) };
        let tangent = heading_of(first[1] - first[0]);
        if wrap_angle(tangent - self.heading).abs() > ON_THE_WAY {
            self.turn_to(tangent)?;
        }
        let top = speed_mps.min((START * length).sqrt());
        let (ramp_s, even_s) = (top / START, (length - top * top / START) / top);
        let total_s = 2.0 * ramp_s + even_s;
        let start_s = self.time_s();
        // Distance along the path (m), and speed (m/s).
        let along = |t: f64| {
            let t = (t - start_s).clamp(0.0, total_s);
            let left = total_s - t;
            if t < ramp_s {
                (0.5 * START * t * t, START * t)
            } else if left < ramp_s {
                (length - 0.5 * START * left * left, START * left)
            } else {
                (0.5 * START * ramp_s * ramp_s + top * (t - ramp_s), top)
            }
        };
        while self.time_s() - start_s < total_s {
            let mut heading = self.heading;
            self.step_frame(|t| {
                let (s, v) = along(t);
                let (at, tangent) = point_on_path(path, &lengths, s);
                heading = heading_of(tangent);
                (at, tangent * v, heading)
            })?;
            self.heading = heading;
        }
        self.position = path[path.len() - 1];
        self.heading = heading_of(point_on_path(path, &lengths, length).1);
        Ok(self.time_s())
    }

    /// Adds a frame: position (x and z, m), velocity (m/s) and heading (rad) are a function of time.
    fn step_frame(&mut self, mut path: impl FnMut(f64) -> (DVec2, DVec2, f64)) -> Result<()> {
        let from_s = self.time_s();
        let dt_s = 1.0 / (self.clip.rate_hz * self.steps as f64);
        let layers = BodyLayers { look_at: self.gaze_target.map(|p| p.as_vec3()), ..BodyLayers::default() };
        for k in 1..=self.steps {
            let (at, velocity, heading) = path(from_s + k as f64 * dt_s);
            let (position, velocity, heading) = (Some(at.as_vec2()), velocity.as_vec2(), Some(heading as f32));
            let control = Control { position, velocity, heading, layers, ..Control::default() };
            self.walkers.order(self.who, control)?;
            self.walkers.step(dt_s as f32, &Inline)?;
        }
        self.record_frame();
        Ok(())
    }

    fn record_frame(&mut self) {
        let pose = ActorPose::from_model(self.walkers.root(0), self.walkers.pose(0));
        self.clip.root_positions.push(pose.translations[0]);
        let before = self.clip.rotations.len().checked_sub(NUM_JOINTS);
        for (j, q) in pose.rotations.into_iter().enumerate() {
            // Neighbouring frames keep a positive dot product.
            let turned = before.is_some_and(|row| q.dot(self.clip.rotations[row + j]) < 0.0);
            self.clip.rotations.push(if turned { -q } else { q });
        }
        self.clip.contacts.push(self.walkers.contacts(0));
    }
}

/// Point of a path at a length, and its direction.
fn point_on_path(path: &[DVec2], lengths: &[f64], along: f64) -> (DVec2, DVec2) {
    let mut left = along;
    for (w, length) in path.windows(2).zip(lengths) {
        if left <= *length && *length > 1e-9 {
            return (w[0].lerp(w[1], left / length), (w[1] - w[0]) / *length);
        }
        left -= length;
    }
    let last = path.windows(2).rev().find(|w| w[0].distance(w[1]) > 1e-9);
    (path[path.len() - 1], last.map_or(DVec2::Y, |w| (w[1] - w[0]).normalize()))
}

/// The heading of a direction (x and z): 0 along z, a quarter turn along x (rad).
pub(super) fn heading_of(v: DVec2) -> f64 {
    maths::atan2(v.x, v.y)
}
