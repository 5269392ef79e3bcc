//! Blows: peaks in a row of speeds, and where they land.

use crate::clip::FrameRange;

/// Share of its greatest speed down to which a swing lasts.
const SWING_LASTS: f32 = 0.25;

/// A blow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedPeak {
    /// Frame of the greatest speed.
    pub peak: usize,
    /// Frame at which it lands, not before the peak.
    pub landing: usize,
    /// Speed at the peak (m/s).
    pub speed: f32,
}

impl SpeedPeak {
    /// The fastest moment of a run outwards, and the last frame up to its full extension that keeps a share of it.
    pub fn from_run(speeds: &[f32], run: &ExtensionRun, landing_share: f32) -> Self {
        let peak = (run.start..=run.full).max_by(|&a, &b| speeds[a].total_cmp(&speeds[b]).then(b.cmp(&a)));
        let peak = peak.unwrap_or(run.full);
        Self::from_peak(speeds, peak, run.full + 1, landing_share)
    }

    fn from_peak(speeds: &[f32], peak: usize, end: usize, landing_share: f32) -> Self {
        let least = landing_share * speeds[peak];
        let after = (peak + 1..end).take_while(|&f| speeds[f] >= least).count();
        Self { peak, landing: peak + after, speed: speeds[peak] }
    }
}

/// Peaks of at least a speed within a range of frames, none of them shorter than a number of frames; ascending.
pub fn swings(speeds: &[f32], range: FrameRange, least: f32, min_frames: usize, landing_share: f32) -> Vec<SpeedPeak> {
    let lasts = |&peak: &usize| {
        let slow = |&f: &usize| speeds[f] >= SWING_LASTS * speeds[peak];
        let before = (range.start..peak).rev().take_while(slow).count();
        before + 1 + (peak + 1..range.end).take_while(slow).count() >= min_frames
    };
    let peaks = range.clone().filter(|&f| is_peak(speeds, &range, f, least)).filter(lasts);
    peaks.map(|peak| SpeedPeak::from_peak(speeds, peak, range.end, landing_share)).collect()
}

/// Keeps the fastest of blows that land too near to each other; ascending.
pub fn strongest(mut blows: Vec<SpeedPeak>, min_gap: usize) -> Vec<SpeedPeak> {
    blows.sort_by(|a, b| b.speed.total_cmp(&a.speed).then(a.landing.cmp(&b.landing)));
    let mut kept: Vec<SpeedPeak> = Vec::new();
    for blow in blows {
        if kept.iter().all(|k| k.landing.abs_diff(blow.landing) >= min_gap) {
            kept.push(blow);
        }
    }
    kept.sort_by_key(|b| b.landing);
    kept
}

/// True for a frame inside the range that is fast enough and no slower than its neighbours; the first of equals.
fn is_peak(speeds: &[f32], range: &FrameRange, f: usize, least: f32) -> bool {
    let inside = f > range.start && f + 1 < range.end;
    inside && speeds[f] >= least && speeds[f] > speeds[f - 1] && speeds[f] >= speeds[f + 1]
}

/// Change of length below which a limb does not turn round (share of its length).
const RIPPLE: f32 = 0.05;

/// Distance from its greatest length within which a limb is at its full extension (share of its length).
const FULL: f32 = 0.02;

/// One run of a limb outwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExtensionRun {
    /// Frame at which the limb is shortest.
    pub start: usize,
    /// First frame of its full extension, after the start.
    pub full: usize,
    /// Its greatest length, as a share of the limb's.
    pub longest: f32,
    /// Growth of its length, as a share of the limb's.
    pub growth: f32,
}

/// The runs within a range of frames, ascending.
///
/// - `extensions`: length of the limb at every frame, as a share of its greatest.
pub fn outward_runs(extensions: &[f32], range: FrameRange) -> Vec<ExtensionRun> {
    let x = extensions;
    let mut out = Vec::new();
    let run = |start: usize, peak: usize| {
        let full = (start..=peak).find(|&f| x[f] >= x[peak] - FULL).unwrap_or(peak);
        ExtensionRun { start, full, longest: x[peak], growth: x[peak] - x[start] }
    };
    let (mut lowest, mut highest) = (range.start, None);
    for f in range {
        match highest {
            None if x[f] < x[lowest] => lowest = f,
            None if x[f] - x[lowest] >= RIPPLE => highest = Some(f),
            None => (),
            Some(peak) if x[f] > x[peak] => highest = Some(f),
            Some(peak) if x[peak] - x[f] >= RIPPLE => {
                out.push(run(lowest, peak));
                (lowest, highest) = (f, None);
            }
            Some(_) => (),
        }
    }
    out.extend(highest.map(|peak| run(lowest, peak)));
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(speeds: &[f32], range: FrameRange) -> Vec<(usize, usize)> {
        swings(speeds, range, 2.0, 2, 0.7).iter().map(|b| (b.peak, b.landing)).collect()
    }

    #[test]
    fn a_blow_lands_after_its_peak_with_most_of_its_speed_left() {
        let speeds = [0.0, 1.0, 3.0, 5.0, 4.0, 3.6, 2.0, 0.0];
        assert_eq!(found(&speeds, 0..8), [(3, 5)]);
        assert_eq!(swings(&speeds, 0..8, 2.0, 2, 1.0)[0].landing, 3);
        assert!(swings(&speeds, 0..8, 5.1, 2, 0.7).is_empty());
        let run = |start, full| ExtensionRun { start, full, longest: 1.0, growth: 0.5 };
        assert_eq!(SpeedPeak::from_run(&speeds, &run(0, 4), 0.7), SpeedPeak { peak: 3, landing: 4, speed: 5.0 });
        assert_eq!(SpeedPeak::from_run(&speeds, &run(0, 7), 0.7).landing, 5);
        // The fastest moment comes after the limb was longest.
        assert_eq!(SpeedPeak::from_run(&speeds, &run(0, 2), 0.7), SpeedPeak { peak: 2, landing: 2, speed: 3.0 });
    }

    #[test]
    fn of_blows_near_each_other_the_fastest_stays() {
        let speeds = [0.0, 3.0, 2.5, 4.0, 1.0, 3.0, 3.0, 1.0, 0.0];
        let all = swings(&speeds, 0..9, 2.0, 1, 1.0);
        let peaks = |gap| strongest(all.clone(), gap).iter().map(|b| b.peak).collect::<Vec<_>>();
        assert_eq!(peaks(0), [1, 3, 5]);
        assert_eq!(peaks(2), [1, 3, 5]);
        assert_eq!(peaks(4), [3]);
    }

    #[test]
    fn a_jump_of_one_frame_and_what_is_outside_the_range_are_no_blows() {
        assert!(found(&[0.0, 0.0, 9.0, 0.0, 0.0], 0..5).is_empty());
        let speeds = [0.0, 1.0, 3.0, 5.0, 4.0, 3.6, 2.0];
        assert!(found(&speeds, 3..7).is_empty() && found(&speeds, 2..2).is_empty());
        assert_eq!(found(&speeds, 1..5), [(3, 4)]);
    }

    #[test]
    fn runs_go_from_the_shortest_to_the_full_extension() {
        let x = [0.5, 0.4, 0.41, 0.7, 0.96, 0.99, 0.98, 0.6, 0.5, 0.8, 0.78, 0.9];
        let runs = outward_runs(&x, 0..x.len());
        assert_eq!(runs.iter().map(|r| (r.start, r.full)).collect::<Vec<_>>(), [(1, 5), (8, 11)]);
        assert!((runs[0].growth - 0.59).abs() < 1e-6 && runs[0].longest == 0.99);
        assert_eq!(outward_runs(&[0.4, 0.7, 0.98, 0.99], 0..4)[0].full, 2);
    }

    #[test]
    fn ripples_and_what_is_outside_the_range_are_no_runs() {
        let x = [0.5, 0.52, 0.5, 0.53, 0.51, 0.2, 0.9];
        assert!(outward_runs(&x, 0..5).is_empty());
        assert!(outward_runs(&x, 3..3).is_empty());
        assert_eq!(outward_runs(&x, 0..7).len(), 1);
    }
}
