//! Moving, standing and changing, measured apart, from joints alone.

use super::Track;
use glam::{Vec2, Vec3, Vec3Swizzles};
use serde::Serialize;
use throng_base::thresholds::{STANDING_MPS, WALKING_MPS};
use throng_core::{Joint, NUM_JOINTS};

/// Half of the time over which a speed is measured (s).
const HALF_S: f32 = 0.25;
/// Cosines of the angle between travel and front below which travel is sideways, and backwards: 45 and 120 degrees.
const OFF_FRONT: [f32; 2] = [std::f32::consts::FRAC_1_SQRT_2, -0.5];
/// Time over which standing is observed (s).
const SPAN_S: f32 = 8.0;
/// Shares of the largest difference from the first pose at which it has left, and is there again.
const LEFT_BACK: [f32; 2] = [0.5, 0.3];
/// Ankles and toes.
const FEET: [[Joint; 2]; 2] = [[Joint::LeftFoot, Joint::RightFoot], [Joint::LeftToe, Joint::RightToe]];
/// Left and right joints whose line is across the front.
const ACROSS: [[Joint; 2]; 2] = [[Joint::LeftThigh, Joint::RightThigh], [Joint::LeftUpperArm, Joint::RightUpperArm]];

/// Moving, standing and changing, each by itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct ApartFigures {
    /// Share of the moving time that goes backwards, more than 120 degrees off the front.
    pub backwards_share: f64,
    /// Share of the moving time that goes sideways, 45 to 120 degrees off the front.
    pub sideways_share: f64,
    /// Mean angle between travel and front while moving (degrees).
    pub facing_error_deg: f64,
    /// Farthest that a standing toe gets from its place within 8 s, median; none where nobody stands so long (cm).
    pub standing_drift_cm: Option<f64>,
    /// Distance of the hips from the middle of the feet while standing, median (cm).
    pub hips_off_feet_cm: Option<f64>,
    /// Time after which standing people repeat themselves, median of those that do within 6 s (s).
    pub repeat_s: Option<f64>,
    /// Changes of clip a minute of moving.
    pub changes_moving_per_min: f64,
    /// Changes of clip a minute of standing.
    pub changes_standing_per_min: f64,
    /// Changes to a clip of another manner a minute.
    pub manner_changes_per_min: f64,
}

/// Measures tracks, one by one.
#[derive(Clone, Debug, Default)]
pub(super) struct ApartMeter<'a> {
    stride: usize,
    frame_hz: f32,
    manners: &'a [u16],
    /// Frames: all, standing, moving, of these backwards, sideways.
    all: u64,
    standing: u64,
    moving: u64,
    off_front: [u64; 2],
    error_deg: f64,
    /// Changes of clip while moving, while standing, and to another manner.
    changes: [u64; 3],
    drifts: Vec<f32>,
    offs: Vec<f32>,
    repeats: Vec<f32>,
}

impl<'a> ApartMeter<'a> {
    /// - `stride`: samples a frame, of so many a second.
    /// - `manners`: manner of each frame of the clips.
    pub fn new(stride: usize, frame_hz: f32, manners: &'a [u16]) -> Self {
        Self { stride, frame_hz, manners, ..Self::default() }
    }

    /// Adds a whole track.
    pub fn add(&mut self, track: &Track) {
        let frames: Vec<&[Vec3; NUM_JOINTS]> = track.positions.iter().step_by(self.stride).collect();
        let (hz, half, last) = (self.frame_hz, (HALF_S * self.frame_hz) as usize, frames.len().saturating_sub(1));
        let ground = |f: usize, j: Joint| frames[f][j.index()].xz();
        let velocity = |f: usize| {
            let (from, to) = (f.saturating_sub(half), (f + half).min(last));
            (ground(to, Joint::Hips) - ground(from, Joint::Hips)) * hz / (to - from).max(1) as f32
        };
        let velocities: Vec<Vec2> = (0..frames.len()).map(velocity).collect();
        let stands = |f: usize| velocities[f].length() < STANDING_MPS;
        let moves = |f: usize| velocities[f].length() > WALKING_MPS;
        self.all += frames.len() as u64;
        self.standing += (0..frames.len()).filter(|f| stands(*f)).count() as u64;
        for f in (0..frames.len()).filter(|f| moves(*f)) {
            let across: Vec2 = ACROSS.iter().map(|[left, right]| ground(f, *left) - ground(f, *right)).sum();
            let front = Vec2::new(-across.y, across.x).normalize_or_zero();
            let ahead = front.dot(velocities[f].normalize_or_zero());
            self.moving += 1;
            self.off_front[0] += u64::from(ahead < OFF_FRONT[1]);
            self.off_front[1] += u64::from((OFF_FRONT[1]..OFF_FRONT[0]).contains(&ahead));
            self.error_deg += f64::from(ahead.clamp(-1.0, 1.0).acos().to_degrees());
        }
        for change in &track.changes {
            let f = (change.sample / self.stride).min(last);
            let [from, to] = change.frames.map(|f| self.manners.get(f as usize));
            let is = [moves(f), stands(f), from != to];
            self.changes.iter_mut().zip(is).for_each(|(count, is)| *count += u64::from(is));
        }
        let span = (SPAN_S * hz) as usize;
        for from in (0..frames.len().saturating_sub(span)).step_by((span / 2).max(1)) {
            let of = from..from + span;
            if !of.clone().all(stands) {
                continue;
            }
            let away = |toe: Joint| of.clone().map(|f| ground(f, toe).distance(ground(from, toe))).fold(0.0, f32::max);
            let between = |f: usize| 0.5 * (ground(f, FEET[0][0]) + ground(f, FEET[0][1]));
            let off: f32 = of.clone().map(|f| ground(f, Joint::Hips).distance(between(f))).sum();
            self.drifts.extend(FEET[1].map(away));
            self.offs.push(off / span as f32);
            self.repeats.extend(repeat_after(&frames[of]).map(|after| after as f32 / hz));
        }
    }

    /// What all tracks show.
    pub fn figures(mut self) -> ApartFigures {
        let share = |part: u64| part as f64 / self.moving.max(1) as f64;
        let per_min = |count: u64, frames: u64| 60.0 * f64::from(self.frame_hz) * count as f64 / frames.max(1) as f64;
        ApartFigures {
            backwards_share: share(self.off_front[0]),
            sideways_share: share(self.off_front[1]),
            facing_error_deg: self.error_deg / self.moving.max(1) as f64,
            standing_drift_cm: median(&mut self.drifts).map(|m| 100.0 * m),
            hips_off_feet_cm: median(&mut self.offs).map(|m| 100.0 * m),
            repeat_s: median(&mut self.repeats),
            changes_moving_per_min: per_min(self.changes[0], self.moving),
            changes_standing_per_min: per_min(self.changes[1], self.standing),
            manner_changes_per_min: per_min(self.changes[2], self.all),
        }
    }
}

/// Frames after which the poses of a span, seen from the hips, are there again; none where they are not within three
/// quarters of it.
fn repeat_after(frames: &[&[Vec3; NUM_JOINTS]]) -> Option<usize> {
    let seen = |f: usize, j: usize| frames[f][j] - frames[f][Joint::Hips.index()];
    let apart = |lag: usize| {
        let off = |f: usize| (0..NUM_JOINTS).map(|j| seen(f, j).distance_squared(seen(f + lag, j))).sum::<f32>().sqrt();
        let times = frames.len() - lag;
        (0..times).map(off).sum::<f32>() / times as f32
    };
    let apart: Vec<f32> = (1..frames.len() * 3 / 4).map(apart).collect();
    let most = apart.iter().copied().fold(0.0, f32::max);
    let left = apart.iter().position(|d| *d > LEFT_BACK[0] * most)?;
    Some(left + 1 + apart[left..].iter().position(|d| *d < LEFT_BACK[1] * most)?)
}

/// The median; none of none.
pub(crate) fn median(values: &mut [f32]) -> Option<f64> {
    let at = values.len().checked_sub(1)? / 2;
    Some(f64::from(*values.select_nth_unstable_by(at, f32::total_cmp).1))
}

#[cfg(test)]
mod tests {
    use super::super::Change;
    use super::*;
    use std::f32::consts::TAU;
    use throng_core::Skeleton;

    /// A body that faces along +Z, at places; its right hand is ahead by so much (m).
    fn track(num: usize, at: impl Fn(f32) -> (Vec3, f32)) -> Track {
        let rest = Skeleton::default().rest_positions();
        let pose = |i: usize| {
            let (place, hand) = at(i as f32 / 30.0);
            let mut pose = rest.map(|p| p + place);
            pose[Joint::RightHand.index()].z += hand;
            pose
        };
        Track::without_changes((0..num).map(pose).collect())
    }

    fn measure(track: &Track, manners: &[u16]) -> ApartFigures {
        let mut meter = ApartMeter::new(1, 30.0, manners);
        meter.add(track);
        meter.figures()
    }

    #[test]
    fn travel_is_told_apart_by_the_front() {
        let walk = |way: Vec3| measure(&track(300, |t| (way * t, 0.0)), &[]);
        let (ahead, back, side) = (walk(Vec3::Z), walk(-Vec3::Z), walk(Vec3::X));
        assert_eq!((ahead.backwards_share, back.backwards_share, side.sideways_share), (0.0, 1.0, 1.0));
        assert!(ahead.facing_error_deg < 1.0 && (side.facing_error_deg - 90.0).abs() < 1.0);
        assert_eq!(ahead.standing_drift_cm, None);
    }

    #[test]
    fn standing_people_drift_and_repeat_themselves() {
        let stands =
            |m_per_s: f32| measure(&track(300, |t| (Vec3::X * (m_per_s * t), 0.3 * (TAU * t / 1.5).sin())), &[]);
        let [still, drifts] = [0.0, 0.01].map(stands);
        assert!(still.standing_drift_cm.is_some_and(|cm| cm < 1e-3));
        assert!(drifts.standing_drift_cm.is_some_and(|cm| (cm - 8.0).abs() < 0.1), "{drifts:?}");
        assert!(still.repeat_s.is_some_and(|s| (s - 1.5).abs() < 0.2), "{still:?}");
        let reaches = measure(&track(300, |t| (Vec3::ZERO, 0.1 * t)), &[]);
        assert_eq!(reaches.repeat_s, None);
    }

    #[test]
    fn changes_are_counted_where_they_happen() {
        let mut walks = track(600, |t| (Vec3::Z * (t - 10.0).max(0.0), 0.0));
        walks.changes =
            [(60, [0, 1]), (120, [0, 2]), (450, [1, 2])].map(|(sample, frames)| Change { sample, frames }).to_vec();
        let figures = measure(&walks, &[0, 0, 1]);
        assert!((figures.changes_standing_per_min - 12.0).abs() < 0.4, "{figures:?}");
        assert!((figures.changes_moving_per_min - 6.0).abs() < 0.4, "{figures:?}");
        assert!((figures.manner_changes_per_min - 6.0).abs() < 1e-6, "{figures:?}");
    }
}
