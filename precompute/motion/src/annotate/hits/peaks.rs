//! Blows in a row of speeds: local peaks, far enough from each other, during which the limb grows longer.

use crate::clip::FrameRange;

/// What makes a peak a blow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    /// Least speed at the peak (m/s).
    pub speed: f32,
    /// A blow lasts as long as it has at least this share of its peak's speed.
    pub lasting_share: f32,
    /// Least growth of the limb while it lasts, up to the peak and beyond.
    pub extension: f32,
    /// Least number of frames it lasts: what is shorter is a fault of the recording.
    pub min_frames: usize,
    /// Least number of frames between two peaks.
    pub min_gap: usize,
    /// Share of the peak's speed that is left where the blow lands.
    pub landing_share: f32,
}

/// A blow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Blow {
    /// Frame of the greatest speed.
    pub peak: usize,
    /// Frame at which it lands, not before the peak.
    pub landing: usize,
}

/// The blows within a range of frames, ascending.
///
/// - `speeds`, `extensions`: of all frames.
pub fn blows(speeds: &[f32], extensions: &[f32], range: FrameRange, rule: &Rule) -> Vec<Blow> {
    let mut peaks: Vec<usize> = range.clone().filter(|&f| is_peak(speeds, &range, f, rule.speed)).collect();
    peaks.retain(|&peak| {
        let blow = around(speeds, &range, peak, rule.lasting_share * speeds[peak]);
        let shortest = extensions[blow.start..=peak].iter().copied().fold(f32::INFINITY, f32::min);
        let longest = extensions[peak..blow.end].iter().copied().fold(0.0, f32::max);
        longest - shortest >= rule.extension && blow.len() >= rule.min_frames
    });
    let landing = |peak: usize| around(speeds, &range, peak, rule.landing_share * speeds[peak]).end - 1;
    strongest(peaks, speeds, rule.min_gap).into_iter().map(|peak| Blow { peak, landing: landing(peak) }).collect()
}

/// Of peaks that are too near to each other, the fastest; ascending.
fn strongest(mut peaks: Vec<usize>, speeds: &[f32], min_gap: usize) -> Vec<usize> {
    peaks.sort_by(|&a, &b| speeds[b].total_cmp(&speeds[a]).then(a.cmp(&b)));
    let mut kept: Vec<usize> = Vec::new();
    for peak in peaks {
        if kept.iter().all(|k| k.abs_diff(peak) >= min_gap) {
            kept.push(peak);
        }
    }
    kept.sort_unstable();
    kept
}

/// True where a frame inside the range is fast enough and no slower than its neighbours; the first of equals.
fn is_peak(speeds: &[f32], range: &FrameRange, f: usize, least: f32) -> bool {
    let inside = f > range.start && f + 1 < range.end;
    inside && speeds[f] >= least && speeds[f] > speeds[f - 1] && speeds[f] >= speeds[f + 1]
}

/// The frames around a peak, it among them, that are all at least that fast.
fn around(speeds: &[f32], range: &FrameRange, peak: usize, least: f32) -> FrameRange {
    let before = (range.start..peak).rev().take_while(|&f| speeds[f] >= least).count();
    let after = (peak + 1..range.end).take_while(|&f| speeds[f] >= least).count();
    peak - before..peak + 1 + after
}

#[cfg(test)]
mod tests {
    use super::*;

    const RULE: Rule =
        Rule { speed: 2.0, lasting_share: 0.25, extension: 0.2, min_frames: 2, min_gap: 4, landing_share: 0.7 };

    /// Speeds, and the extension they add up to.
    fn find(speeds: &[f32], rule: &Rule) -> Vec<Blow> {
        let mut length = 0.3;
        let extensions: Vec<f32> = speeds
            .iter()
            .map(|v| {
                length += 0.05 * v;
                length
            })
            .collect();
        blows(speeds, &extensions, 0..speeds.len(), rule)
    }

    #[test]
    fn a_blow_lands_after_its_peak_with_most_of_its_speed_left() {
        let speeds = [0.0, 1.0, 3.0, 5.0, 4.0, 3.6, 2.0, 0.0, -4.0];
        assert_eq!(find(&speeds, &RULE), [Blow { peak: 3, landing: 5 }]);
        assert_eq!(find(&speeds, &Rule { landing_share: 1.0, ..RULE }), [Blow { peak: 3, landing: 3 }]);
        assert!(find(&speeds, &Rule { speed: 5.1, ..RULE }).is_empty());
    }

    #[test]
    fn of_peaks_near_each_other_the_fastest_stays() {
        let speeds = [0.0, 3.0, 2.5, 4.0, 1.0, 3.0, 3.0, 1.0, 0.0];
        let peaks = |gap| find(&speeds, &Rule { min_gap: gap, ..RULE }).iter().map(|b| b.peak).collect::<Vec<_>>();
        assert_eq!(peaks(0), [1, 3, 5]);
        assert_eq!(peaks(2), [1, 3, 5]);
        assert_eq!(peaks(3), [3]);
    }

    #[test]
    fn a_limb_that_keeps_its_length_and_a_jump_of_one_frame_are_no_blows() {
        let speeds = [0.0, 1.0, 3.0, 5.0, 3.0, 1.0, 0.0];
        assert!(blows(&speeds, &[0.6; 7], 0..7, &RULE).is_empty());
        let jump = [0.0, 0.0, 9.0, 0.0, 0.0];
        assert!(find(&jump, &RULE).is_empty());
        assert_eq!(find(&jump, &Rule { min_frames: 1, extension: 0.0, ..RULE }).len(), 1);
    }

    #[test]
    fn nothing_outside_the_range_is_looked_at() {
        let speeds = [0.0, 1.0, 3.0, 5.0, 4.0, 3.6, 2.0];
        let extensions = [0.3, 0.4, 0.5, 0.7, 0.9, 1.0, 1.0];
        assert!(blows(&speeds, &extensions, 3..7, &RULE).is_empty());
        assert_eq!(blows(&speeds, &extensions, 1..5, &RULE), [Blow { peak: 3, landing: 4 }]);
        assert!(blows(&speeds, &extensions, 2..2, &RULE).is_empty());
    }
}
