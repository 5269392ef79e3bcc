//! Sample times of an act, with the skeleton and the amount of variation.

use crate::frame::Samples;
use std::ops::Range;
use throng_core::Skeleton;

/// Time computed before and after the clip, so that it is steady from its first frame to its last (s).
const MARGIN: f64 = 2.5;

/// Sample times of an act: the clip begins at 0, and the margins before and after it are cut off.
pub struct ActTimes {
    /// The body.
    pub skeleton: Skeleton,
    /// The samples.
    pub samples: Samples,
    /// Factor on the usual variation of steps and gaze.
    pub variation: f64,
    /// Samples of the clip's frames, in order.
    pub frames: Vec<usize>,
}

impl ActTimes {
    /// Samples of a clip of `seconds`, both ends included.
    pub fn new(skeleton: Skeleton, seconds: f64, rate_hz: f64, variation: f64) -> Self {
        let margin = (MARGIN * rate_hz).ceil() as usize;
        let wanted = (seconds * rate_hz).round() as usize + 1;
        let before = margin as f64 / rate_hz;
        let mut samples = Samples::for_clip((wanted + 2 * margin) as f64 / rate_hz, rate_hz);
        samples.times.iter_mut().for_each(|t| *t -= before);
        let frames = samples.frames().skip(margin).take(wanted).collect();
        Self { skeleton, samples, variation, frames }
    }

    /// Time of the first and of the last sample (s).
    pub fn time(&self) -> Range<f64> {
        self.samples.times[0]..self.samples.times[self.samples.times.len() - 1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_clip_begins_at_zero_and_has_both_its_ends() {
        for rate_hz in [24.0, 30.0, 60.0] {
            let scene = ActTimes::new(Skeleton::default(), 4.0, rate_hz, 1.0);
            let times: Vec<f64> = scene.frames.iter().map(|&i| scene.samples.times[i]).collect();
            assert!(times[0].abs() < 1e-9 && (times[times.len() - 1] - 4.0).abs() < 1e-9);
            assert_eq!(times.len(), (4.0 * rate_hz) as usize + 1);
            assert!(scene.time().start <= -MARGIN && scene.time().end >= 4.0 + MARGIN);
        }
    }
}
