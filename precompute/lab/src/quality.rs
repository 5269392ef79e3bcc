//! How much motion at run time looks like the clips that it comes from: speed of low toes, knees, jumps at changes of
//! segment, smoothness between frames, life of the hands.

mod apart;

use crate::frames::{of_classes, runs};
pub use apart::ApartFigures;
use apart::ApartMeter;
pub(crate) use apart::median;
use glam::Vec3;
use serde::Serialize;
use std::f32::consts::TAU;
use throng_base::{maths, thresholds::TOE_LOW_M};
use throng_core::{Bundle, Joint, NUM_JOINTS, Planar, skeleton::LEGS};
use throng_motion::clip::joint_transforms;

/// Frames on either side of a change of segment that count as near it.
const NEAR: usize = 5;
/// Frames whose spectrum is taken at a time: two seconds at 30 Hz.
const WINDOW: usize = 64;
/// Power of accelerations is told above this (Hz).
const FAST_HZ: f32 = 6.0;
/// Hands that accelerate less do not move (m/s2, root mean square of a window).
const HANDS_AT_REST_MPS2: f32 = 0.5;

/// Rate of a knee that snaps, over the 99.9th percentile of the clips.
const SNAP: f64 = 1.2;

/// Joints in the world (m), sample by sample.
#[derive(Clone, Debug, Default)]
pub struct Track {
    /// (samples)
    pub positions: Vec<[Vec3; NUM_JOINTS]>,
    /// Number of them on the way; what comes later is measured apart alone.
    pub on_the_way: usize,
    /// Where segments began that do not go on where the last one ended, in the order of the samples.
    pub changes: Vec<Change>,
}

impl Track {
    /// A track without changes of segment.
    pub fn without_changes(positions: Vec<[Vec3; NUM_JOINTS]>) -> Self {
        Self { on_the_way: positions.len(), positions, changes: Vec::new() }
    }
}

/// A change of segment.
#[derive(Clone, Copy, Debug)]
pub struct Change {
    /// The first sample of the new segment.
    pub sample: usize,
    /// Last frame of the old segment, and first frame of the new one.
    pub frames: [u32; 2],
}

/// What tracks show together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotionFigures {
    /// 95th percentile of the speed of toes within 15 mm of their lowest place, planted or not (m/s).
    pub toe_speed_low_p95_mps: f64,
    /// Fastest turn of a knee (degrees/s).
    pub knee_rate_max_dps: f64,
    /// 99.9th percentile of it (degrees/s).
    pub knee_rate_p999_dps: f64,
    /// Mean acceleration of all joints within 5 frames of a change of segment, over that elsewhere; none without changes.
    pub change_acceleration_ratio: Option<f64>,
    /// Mean acceleration elsewhere, summed over joints (m/frame^2).
    pub acceleration_elsewhere: f64,
    /// Root mean square of the hips' acceleration as seen at the rate of the samples, over that at the rate of the frames:
    /// about 1 where motion is smooth between frames, 1.4 where it goes straight at 60 Hz between frames at 30 Hz.
    pub hips_acceleration_between_frames: f64,
    /// Share of the power of the right hand's acceleration above 6 Hz, where it moves.
    pub hand_power_above_6hz: f64,
}

/// Motion at run time beside the clips that it comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct MotionQuality {
    /// 95th percentile of the speed of toes within 15 mm of their lowest place, planted or not (m/s).
    pub toe_speed_low_p95_mps: f64,
    /// 95th percentile of the speed of toes within 15 mm of their lowest place, of the clips (m/s).
    pub source_toe_speed_low_p95_mps: f64,
    /// Fastest turn of a knee over that of the clips.
    pub knee_rate_max_ratio: f64,
    /// 99.9th percentile of the turn of knees over that of the clips.
    pub knee_rate_p999_ratio: f64,
    /// Knees that turn more than 1.2 times as fast as that percentile of the clips, a minute of a character.
    pub knee_snaps_per_min: f64,
    /// Mean acceleration of all joints within 5 frames of a change of segment, over that elsewhere; none without changes.
    pub change_acceleration_ratio: Option<f64>,
    /// Mean acceleration of the clips within 5 frames of the same changes, over that of characters elsewhere.
    /// It is 1 where segments end at moments like any other.
    pub source_change_acceleration_ratio: Option<f64>,
    /// Root mean square of the hips' acceleration as seen at the rate of the steps, over that at the rate of the clips:
    /// about 1 where motion is smooth between frames, 1.4 where it goes straight between them at two steps a frame.
    pub hips_acceleration_between_frames: f64,
    /// Share of the power of the right hand's acceleration above 6 Hz, where it moves.
    pub hand_power_above_6hz: f64,
    /// Share of the power of the right hand's acceleration above 6 Hz, of the clips, where it moves.
    pub source_hand_power_above_6hz: f64,
    /// Moving, standing and changing, each by itself.
    pub apart: ApartFigures,
    /// Moving, standing and changing of the clips, where it is about single frames and spans.
    pub source_apart: ApartFigures,
}

impl MotionQuality {
    /// - `tables`: the bundle that characters move by.
    /// - `tracks`: what they show, with `sample_hz` samples a second.
    pub fn new(tables: &Bundle, tracks: &[Track], sample_hz: f32) -> Self {
        let frame_hz = tables.meta().rate_hz as f32;
        let mut meter = QualityMeter::new(sample_hz.max(frame_hz), frame_hz);
        tracks.iter().for_each(|t| meter.add(t));
        let mut names = vec![""];
        let manners = of_classes(tables, 0, |class| match names.iter().position(|n| *n == class.manner) {
            Some(number) => number as u16,
            None => {
                names.push(&class.manner);
                names.len() as u16 - 1
            }
        });
        let mut apart = ApartMeter::new(meter.stride, meter.frame_hz, &manners);
        tracks.iter().for_each(|t| apart.add(t));
        let mut of_clips = (QualityMeter::new(frame_hz, frame_hz), ApartMeter::new(1, frame_hz, &manners));
        for run in runs(tables) {
            let track = Track::without_changes(run.map(|f| clip_joints(tables, f).map(|joint| joint.0)).collect());
            of_clips.0.add(&track);
            of_clips.1.add(&track);
        }
        let source = of_clips.0.figures();
        let snaps = meter.snaps_per_min(SNAP * source.knee_rate_p999_dps);
        let here = meter.figures();
        let at_changes = acceleration_at(tables, tracks.iter().flat_map(|t| &t.changes));
        let of_source = at_changes.map(|a| a / here.acceleration_elsewhere);
        Self {
            toe_speed_low_p95_mps: here.toe_speed_low_p95_mps,
            source_toe_speed_low_p95_mps: source.toe_speed_low_p95_mps,
            knee_rate_max_ratio: here.knee_rate_max_dps / source.knee_rate_max_dps.max(1e-6),
            knee_rate_p999_ratio: here.knee_rate_p999_dps / source.knee_rate_p999_dps.max(1e-6),
            knee_snaps_per_min: snaps,
            change_acceleration_ratio: here.change_acceleration_ratio,
            source_change_acceleration_ratio: here.change_acceleration_ratio.and(of_source),
            hips_acceleration_between_frames: here.hips_acceleration_between_frames,
            hand_power_above_6hz: here.hand_power_above_6hz,
            source_hand_power_above_6hz: source.hand_power_above_6hz,
            apart: apart.figures(),
            source_apart: of_clips.1.figures(),
        }
    }
}

/// Measures tracks with so many samples a second, as they look at the rate of the frames.
#[derive(Clone, Debug, Default)]
pub struct QualityMeter {
    /// Samples a frame.
    stride: usize,
    frame_hz: f32,
    low_speeds: Vec<f32>,
    knee_rates: Vec<f32>,
    /// Sum and number of accelerations near changes, and elsewhere.
    near: (f64, u64),
    elsewhere: (f64, u64),
    /// Sums of squares of the hips' acceleration between samples, and between frames, and their numbers.
    hips: [(f64, u64); 2],
    /// Power above [`FAST_HZ`], and all.
    power: [f64; 2],
}

impl QualityMeter {
    /// - `sample_hz`: of the tracks; a whole multiple of `frame_hz`, or nearly.
    pub fn new(sample_hz: f32, frame_hz: f32) -> Self {
        let stride = (sample_hz / frame_hz).round().max(1.0);
        Self { stride: stride as usize, frame_hz: sample_hz / stride, ..Self::default() }
    }

    /// Adds a track, as far as it is on the way.
    pub fn add(&mut self, track: &Track) {
        let positions = &track.positions[..track.on_the_way];
        self.add_legs(positions);
        self.add_changes(track);
        let hips = |i: usize| positions[i][Joint::Hips.index()];
        for (sums, step) in self.hips.iter_mut().zip([1, self.stride]) {
            let rate = self.frame_hz * (self.stride / step) as f32;
            for i in step..positions.len().saturating_sub(step) {
                let a = (hips(i + step) - 2.0 * hips(i) + hips(i - step)) * rate * rate;
                *sums = (sums.0 + f64::from(a.length_squared()), sums.1 + 1);
            }
        }
        self.add_hand(positions);
    }

    /// Speeds of toes that are low, and of knees.
    fn add_legs(&mut self, positions: &[[Vec3; NUM_JOINTS]]) {
        let at = |i: usize, joint: Joint| positions[i][joint.index()];
        for [hip, knee, ankle, toe] in LEGS {
            let lowest = positions.iter().map(|p| p[toe.index()].y).fold(f32::INFINITY, f32::min);
            let bend = |i: usize| (at(i, hip) - at(i, knee)).angle_between(at(i, ankle) - at(i, knee));
            for i in self.stride..positions.len() {
                let before = i - self.stride;
                if at(i, toe).y.max(at(before, toe).y) < lowest + TOE_LOW_M {
                    self.low_speeds.push((at(i, toe) - at(before, toe)).length() * self.frame_hz);
                }
                self.knee_rates.push((bend(i) - bend(before)).abs() * self.frame_hz);
            }
        }
    }

    /// Accelerations near changes of segment, and elsewhere.
    fn add_changes(&mut self, track: &Track) {
        let (s, n) = (self.stride, track.on_the_way);
        let mut changes = track.changes.iter().map(|c| c.sample).filter(|c| *c < n).peekable();
        let mut last = None;
        for i in s..n.saturating_sub(s) {
            while let Some(change) = changes.next_if(|c| *c <= i) {
                last = Some(change);
            }
            let is_near = last.is_some_and(|l| i - l <= NEAR * s) || changes.peek().is_some_and(|c| c - i <= NEAR * s);
            let sums = if is_near { &mut self.near } else { &mut self.elsewhere };
            *sums = (sums.0 + acceleration([i - s, i, i + s].map(|k| &track.positions[k])), sums.1 + 1);
        }
    }

    /// The spectrum of the right hand's acceleration, as seen from the hips, window by window.
    fn add_hand(&mut self, positions: &[[Vec3; NUM_JOINTS]]) {
        let from_hips = |p: &[Vec3; NUM_JOINTS]| p[Joint::RightHand.index()] - p[Joint::Hips.index()];
        let hand: Vec<Vec3> = positions.iter().step_by(self.stride).map(from_hips).collect();
        let rate = self.frame_hz;
        let acceleration: Vec<Vec3> = hand.windows(3).map(|w| (w[2] - 2.0 * w[1] + w[0]) * rate * rate).collect();
        for window in acceleration.chunks_exact(WINDOW) {
            let power: f32 = window.iter().map(|a| a.length_squared()).sum();
            if power < HANDS_AT_REST_MPS2 * HANDS_AT_REST_MPS2 * WINDOW as f32 {
                continue;
            }
            for k in 1..WINDOW / 2 {
                let (mut cos, mut sin) = (Vec3::ZERO, Vec3::ZERO);
                for (i, a) in window.iter().enumerate() {
                    let (s, c) = (TAU * (k * i % WINDOW) as f32 / WINDOW as f32).sin_cos();
                    let hann = 0.5 - 0.5 * (TAU * i as f32 / WINDOW as f32).cos();
                    (cos, sin) = (cos + *a * (c * hann), sin + *a * (s * hann));
                }
                let power = f64::from(cos.length_squared() + sin.length_squared());
                self.power[0] += if k as f32 * rate / WINDOW as f32 > FAST_HZ { power } else { 0.0 };
                self.power[1] += power;
            }
        }
    }

    /// Turns of a knee that begin to be faster than a rate, a minute of a character (degrees/s).
    fn snaps_per_min(&self, above_dps: f64) -> f64 {
        let is_fast = |rate: &f32| f64::from(rate.to_degrees()) > above_dps;
        let snaps = self.knee_rates.windows(2).filter(|w| !is_fast(&w[0]) && is_fast(&w[1])).count();
        // Two knees a character.
        let minutes = self.knee_rates.len() as f64 / f64::from(120.0 * self.frame_hz * self.stride as f32);
        snaps as f64 / minutes.max(1e-9)
    }

    /// Returns the figures of all tracks.
    pub fn figures(mut self) -> MotionFigures {
        let mean = |(sum, count): (f64, u64)| sum / count.max(1) as f64;
        let [samples, frames] = self.hips.map(mean);
        let changes = self.near.1 > 0 && self.elsewhere.0 > 0.0;
        MotionFigures {
            toe_speed_low_p95_mps: quantile(&mut self.low_speeds, 0.95),
            knee_rate_max_dps: quantile(&mut self.knee_rates, 1.0).to_degrees(),
            knee_rate_p999_dps: quantile(&mut self.knee_rates, 0.999).to_degrees(),
            change_acceleration_ratio: changes.then(|| mean(self.near) / mean(self.elsewhere)),
            acceleration_elsewhere: mean(self.elsewhere),
            hips_acceleration_between_frames: (samples / frames.max(1e-12)).sqrt(),
            hand_power_above_6hz: self.power[0] / self.power[1].max(1e-12),
        }
    }
}

/// Acceleration of all joints, a frame apart (m/frame^2).
fn acceleration([a, b, c]: [&[Vec3; NUM_JOINTS]; 3]) -> f64 {
    f64::from((0..NUM_JOINTS).map(|j| (a[j] - 2.0 * b[j] + c[j]).length()).sum::<f32>())
}

/// Mean acceleration of the clips within [`NEAR`] frames before the end of old segments and after the begin of new ones;
/// none where no clip goes on so far (m/frame^2).
fn acceleration_at<'a>(tables: &Bundle, changes: impl Iterator<Item = &'a Change>) -> Option<f64> {
    let (mut runs, near) = (runs(tables), NEAR as u32);
    runs.sort_by_key(|r| r.start);
    let (mut sum, mut count) = (0.0, 0u64);
    for [from, to] in changes.map(|c| c.frames) {
        for frame in (from.saturating_sub(near)..=from).chain(to..=to + near) {
            let run = &runs[runs.partition_point(|r| r.start <= frame).saturating_sub(1)];
            if (run.start + 1..run.end.saturating_sub(1)).contains(&frame) {
                let at = [frame - 1, frame, frame + 1].map(|f| clip_joints(tables, f).map(|joint| joint.0));
                (sum, count) = (sum + acceleration(at.each_ref()), count + 1);
            }
        }
    }
    (count > 0).then(|| sum / count as f64)
}

/// Joints of a frame, where its clip has them: positions (m) and rotations (frame < number of frames).
pub(crate) fn clip_joints(tables: &Bundle, frame: u32) -> [(Vec3, glam::Quat); NUM_JOINTS] {
    let (row, code) = (&tables.frames()[frame as usize], tables.rotation_code());
    let root = Planar::from_array(row.planar);
    let at = root.translation().with_y(row.height);
    let local =
        |j: usize| if j == 0 { maths::compose(root.rotation(), code.rotation(row, 0)) } else { code.rotation(row, j) };
    joint_transforms(tables.skeleton(), at, local)
}

/// The value below which a share of them lies; 0 of none.
fn quantile(values: &mut [f32], share: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let at = ((values.len() as f64 * share).ceil() as usize).clamp(1, values.len()) - 1;
    f64::from(*values.select_nth_unstable_by(at, f32::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All joints at one place, which moves.
    fn track(num: usize, at: impl Fn(usize) -> Vec3) -> Track {
        Track::without_changes((0..num).map(|i| [at(i); NUM_JOINTS]).collect())
    }

    fn figures(sample_hz: f32, track: &Track) -> MotionFigures {
        let mut meter = QualityMeter::new(sample_hz, 30.0);
        meter.add(track);
        meter.figures()
    }

    #[test]
    fn toes_count_while_they_are_low() {
        // 0.6 m/s on the ground, then 3 m/s in the air.
        let slides =
            track(60, |i| Vec3::new(0.02 * i.min(30) as f32, if i > 30 { 0.1 * (i - 30) as f32 } else { 0.0 }, 0.0));
        assert!((figures(30.0, &slides).toe_speed_low_p95_mps - 0.6).abs() < 1e-4);
    }

    #[test]
    fn straight_pieces_between_frames_show() {
        let at = |t: f32| Vec3::X * (0.3 * t * TAU).sin();
        let smooth = track(240, |i| at(i as f32 / 60.0));
        let straight = track(240, |i| {
            let half = i / 2;
            let [a, b] = [half, half + 1].map(|k| at(k as f32 / 30.0));
            if i % 2 == 0 { a } else { a.lerp(b, 0.5) }
        });
        assert!((figures(60.0, &smooth).hips_acceleration_between_frames - 1.0).abs() < 0.02);
        assert!((figures(60.0, &straight).hips_acceleration_between_frames - 2f32.sqrt() as f64).abs() < 0.02);
    }

    #[test]
    fn a_jolt_at_a_change_shows() {
        // Falls at 1 m/s2 all the time, and at 2 within five frames of a change.
        let mut place = (Vec3::ZERO, Vec3::ZERO);
        let mut positions = Vec::new();
        for i in 0..100 {
            positions.push([place.0; NUM_JOINTS]);
            let a = if (45..=55).contains(&i) { 2.0 } else { 1.0 };
            place.1 += Vec3::NEG_Y * (a / 900.0);
            place.0 += place.1;
        }
        // The acceleration at a sample is that between it and its neighbours.
        let changes = vec![Change { sample: 50, frames: [0, 0] }];
        let ratio = figures(30.0, &Track { changes, ..Track::without_changes(positions) }).change_acceleration_ratio;
        assert!((ratio.unwrap_or_default() - 2.0).abs() < 0.05, "{ratio:?}");
    }

    #[test]
    fn power_is_told_apart_by_frequency() {
        let swings = |hz: f32| {
            let mut swings = track(300, |_| Vec3::ZERO);
            for (i, p) in swings.positions.iter_mut().enumerate() {
                p[Joint::RightHand.index()] = Vec3::X * (TAU * hz * i as f32 / 30.0).sin();
            }
            figures(30.0, &swings).hand_power_above_6hz
        };
        assert!(swings(2.0) < 1e-3 && swings(9.0) > 0.999);
    }

    #[test]
    fn quantiles_are_of_the_values() {
        assert_eq!(quantile(&mut [3.0, 1.0, 2.0, 4.0], 0.5), 2.0);
        assert_eq!(quantile(&mut [3.0, 1.0, 2.0, 4.0], 1.0), 4.0);
        assert_eq!(quantile(&mut [], 0.5), 0.0);
    }
}
