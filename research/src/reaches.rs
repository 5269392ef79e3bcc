//! Measures of how natural planned reaches look: speed of the hand, height of the elbow, jerk; and reaches in captured motion.

use glam::DVec3;
use throng_core::{Joint, Skeleton};
use throng_motion::Clip;
use throng_planner::driven::DrivenMotion;
use throng_planner::linkage::Limb;

/// Sampling rate of everything that is compared: no more than clips have (Hz).
const RATE_HZ: f64 = 30.0;
/// Half window over which places are averaged (samples): noise of captured motion is faster.
const SMOOTH: usize = 1;
/// A dip to this share of the lower of its neighbours parts two peaks; lower peaks than this share do not count.
const DIP: f64 = 0.75;
const PEAK: f64 = 0.3;
/// Captured reaches: least peak (m/s), begin and end (share of the peak), times (s), length of the path and stretch (m).
const LEAST_MPS: f64 = 0.5;
const REST: f64 = 0.12;
const TIMES_S: [f64; 2] = [0.3, 2.0];
const WAY_M: f64 = 0.2;
const STRETCH_M: f64 = 0.08;

/// Figures of a hand's path from rest to rest, relative to the upper chest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReachFigures {
    /// Greatest speed (m/s).
    pub peak_mps: f64,
    /// Number of main peaks of its speed: people's have one.
    pub peaks: usize,
    /// Largest height of the elbow above the middle between shoulder and hand (m).
    pub elbow_m: f64,
    /// Height of the hand above the shoulder at the end (m).
    pub hand_up_m: f64,
    /// Root mean square of its jerk, times the cube of the time, over the length of the path: 26.8 is the least.
    ///
    /// # Source
    /// Flash and Hogan 1985, *The Coordination of Arm Movements*: the motion of least jerk.
    pub jerk: f64,
}

/// Positions of shoulder, elbow and hand in the frame of the upper chest, and the elbow's height, sample by sample.
struct Arm {
    hand: Vec<DVec3>,
    stretch_m: Vec<f64>,
    elbow_m: Vec<f64>,
    /// The hand's height above the shoulder.
    hand_up_m: Vec<f64>,
}

impl Arm {
    fn from_clip(clip: &Clip, skeleton: &Skeleton, limb: Limb, [from_s, to_s]: [f64; 2]) -> Self {
        let driven = DrivenMotion::from_clip(clip, skeleton, from_s, to_s);
        let [first, last] = driven.window_s();
        let step_s = (last - first) / (driven.places().len() - 1).max(1) as f64;
        let every = ((1.0 / RATE_HZ) / step_s.max(1e-9)).round().max(1.0) as usize;
        let [shoulder, elbow, wrist] = limb.joints().map(Joint::index);
        let rows = driven.places().iter().step_by(every);
        let mut arm = Self { hand: Vec::new(), stretch_m: Vec::new(), elbow_m: Vec::new(), hand_up_m: Vec::new() };
        for p in rows {
            let [s, e, w] = [shoulder, elbow, wrist].map(|j| p[j].position);
            arm.hand.push(p[Joint::UpperChest.index()].local_point(w));
            arm.stretch_m.push(s.distance(w));
            arm.elbow_m.push(e.y - 0.5 * (s.y + w.y));
            arm.hand_up_m.push(w.y - s.y);
        }
        let raw = arm.hand.clone();
        for (i, out) in arm.hand.iter_mut().enumerate() {
            let around = SMOOTH.min(i).min(raw.len() - 1 - i);
            let part = &raw[i - around..=i + around];
            *out = part.iter().sum::<DVec3>() / part.len() as f64;
        }
        arm
    }

    fn speeds(&self) -> Vec<f64> {
        let n = self.hand.len();
        let at = |i: usize| {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(n - 1));
            self.hand[a].distance(self.hand[b]) * RATE_HZ / (b - a).max(1) as f64
        };
        (0..n).map(at).collect()
    }

    fn figures(&self, from: usize, to: usize) -> Option<ReachFigures> {
        let hand = self.hand.get(from..=to).filter(|h| h.len() >= 8)?;
        let speeds = &self.speeds()[from..=to];
        let length: f64 = hand.windows(2).map(|w| w[0].distance(w[1])).sum();
        let seconds = (hand.len() - 1) as f64 / RATE_HZ;
        let jerks = hand.windows(4).map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]) * RATE_HZ.powi(3));
        let square: f64 = jerks.map(|j| j.length_squared()).sum::<f64>() / (hand.len() - 3) as f64;
        (length > 0.02).then(|| ReachFigures {
            peak_mps: speeds.iter().copied().fold(0.0, f64::max),
            peaks: main_peaks(speeds),
            elbow_m: self.elbow_m[from..=to].iter().copied().fold(f64::NEG_INFINITY, f64::max),
            hand_up_m: self.hand_up_m[to],
            jerk: square.sqrt() * seconds.powi(3) / length,
        })
    }
}

/// Figures of an arm in a stretch of a clip; none where the hand hardly moves, or for less than an eighth of a second.
pub fn reach_figures(clip: &Clip, skeleton: &Skeleton, limb: Limb, window_s: [f64; 2]) -> Option<ReachFigures> {
    let arm = Arm::from_clip(clip, skeleton, limb, window_s);
    arm.figures(0, arm.hand.len().checked_sub(1)?)
}

/// Reaches of both arms in captured motion: from rest to rest relative to the chest, with the arm longer at the end.
pub fn captured_reaches(clip: &Clip, skeleton: &Skeleton) -> Vec<ReachFigures> {
    let end_s = clip.num_frames().saturating_sub(1) as f64 / clip.rate_hz;
    let mut out = Vec::new();
    for limb in [Limb::LeftArm, Limb::RightArm] {
        let arm = Arm::from_clip(clip, skeleton, limb, [0.0, end_s]);
        let speeds = arm.speeds();
        let mut next = 0;
        while let Some(start) = (next..speeds.len()).find(|i| speeds[*i] > LEAST_MPS) {
            // The peak of this burst, and the samples at rest before and after it.
            let mut peak = start;
            let mut end = start;
            while end + 1 < speeds.len() && speeds[end] > (REST * speeds[peak]).max(0.03) {
                end += 1;
                peak = if speeds[end] > speeds[peak] { end } else { peak };
            }
            let rest = (REST * speeds[peak]).max(0.03);
            let first = (0..start).rev().find(|i| speeds[*i] <= rest);
            next = end + 1;
            let Some(first) = first.filter(|_| speeds[end] <= rest) else { continue };
            let seconds = (end - first) as f64 / RATE_HZ;
            let far = arm.hand[first].distance(arm.hand[end]) > WAY_M
                && arm.stretch_m[end] > arm.stretch_m[first] + STRETCH_M;
            if far && (TIMES_S[0]..=TIMES_S[1]).contains(&seconds) {
                out.extend(arm.figures(first, end));
            }
        }
    }
    out
}

/// Number of peaks that are high enough, with dips in speed between them.
fn main_peaks(speeds: &[f64]) -> usize {
    let most = speeds.iter().copied().fold(0.0, f64::max);
    let (mut count, mut top, mut low) = (0, 0.0f64, 0.0f64);
    let mut rises = true;
    for &v in speeds {
        if rises {
            top = top.max(v);
            if v < DIP * top && top > PEAK * most {
                (count, rises, low) = (count + 1, false, v);
            }
        } else {
            low = low.min(v);
            if low < DIP * v && v > PEAK * most {
                (rises, top) = (true, v);
            }
        }
    }
    count + usize::from(rises && top > PEAK * most)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Somebody;
    use glam::Quat;
    use throng_core::NUM_JOINTS;

    #[test]
    fn peaks_are_counted_where_speed_dips_between_them() {
        assert_eq!(main_peaks(&[0.0, 0.5, 1.0, 0.5, 0.0]), 1);
        assert_eq!(main_peaks(&[0.0, 1.0, 0.9, 1.0, 0.0]), 1);
        assert_eq!(main_peaks(&[0.0, 1.0, 0.4, 0.8, 0.0]), 2);
        assert_eq!(main_peaks(&[0.0, 1.0, 0.1, 0.2, 0.0]), 1);
        assert_eq!(main_peaks(&[0.0, 0.6, 0.2, 1.0]), 2);
    }

    /// An elbow that unfolds as least jerk has it, between two rests.
    fn reaching(s: &Somebody) -> Clip {
        let rows = (0..90).map(|f| {
            let x = (f64::from(f) / 30.0 - 1.0).clamp(0.0, 1.0);
            let share = x * x * x * (x * (6.0 * x - 15.0) + 10.0);
            let arm = s.pose(0.0, -0.9, 2.2 - 1.8 * share);
            let mut row = vec![Quat::IDENTITY; NUM_JOINTS];
            for (i, j) in s.limb.joints().into_iter().enumerate() {
                row[j.index()] = arm.0[i].as_quat();
            }
            row
        });
        Clip::new("reach", 30.0, vec![s.skeleton.offsets[0]; 90], rows.flatten().collect())
    }

    #[test]
    fn a_reach_of_least_jerk_has_one_peak_and_is_found() {
        let s = Somebody::standing();
        let clip = reaching(&s);
        let found = captured_reaches(&clip, &s.skeleton);
        let [one] = &found[..] else { panic!("{found:?}") };
        let whole = reach_figures(&clip, &s.skeleton, Limb::LeftArm, [1.0, 2.0]).expect("a reach");
        for r in [*one, whole] {
            // A hinge's hand goes on a circle, and smoothing takes a little of the peak.
            // The arm hangs down and forwards.
            assert!(r.hand_up_m < -0.2 && r.hand_up_m > -0.55, "{r:?}");
            assert!(r.peaks == 1 && (15.0..60.0).contains(&r.jerk), "{r:?}");
        }
        // Least jerk: the peak is 1.875 times the mean.
        let way = 2.0 * 0.9f64.sin();
        assert!(whole.peak_mps > 0.2 && whole.peak_mps < way && (whole.peak_mps - one.peak_mps).abs() < 0.02);
        let still = Clip::new("still", 30.0, vec![s.skeleton.offsets[0]; 60], vec![Quat::IDENTITY; 60 * NUM_JOINTS]);
        assert!(captured_reaches(&still, &s.skeleton).is_empty());
        assert_eq!(reach_figures(&still, &s.skeleton, Limb::LeftArm, [0.0, 1.0]), None);
    }
}
