//! Motion as a function of time, with bounds on its speed over any stretch.

use crate::rotation::Rigid;
use std::sync::Arc;
use throng_geometry::Segment;

/// Times of samples.
#[derive(Clone, Debug, PartialEq)]
pub enum SampleTimes {
    /// Every `step_s` from `start_s` on.
    Even {
        /// (s)
        start_s: f64,
        /// (s, > 0)
        step_s: f64,
    },
    /// Times of all samples, ascending (s).
    At(Vec<f64>),
}

impl SampleTimes {
    /// Interval of a time, and the share of it that has passed: the start of the first one before all times, the end of the
    /// last one behind them.
    fn find_interval(&self, len: usize, t: f64) -> (usize, f64) {
        let last = len.saturating_sub(2);
        match self {
            Self::Even { start_s, step_s } => {
                let at = ((t - start_s) / step_s).clamp(0.0, (len - 1) as f64);
                let i = (at as usize).min(last);
                (i, at - i as f64)
            }
            Self::At(times) => {
                let i = times.partition_point(|x| *x <= t).saturating_sub(1).min(last);
                let Some(to) = times.get(i + 1) else { return (i, 0.0) };
                (i, ((t - times[i]) / (to - times[i])).clamp(0.0, 1.0))
            }
        }
    }

    fn interval_length(&self, i: usize) -> f64 {
        match self {
            Self::Even { step_s, .. } => *step_s,
            Self::At(times) => times[i + 1] - times[i],
        }
    }
}

/// Largest of any run of numbers, in two lookups.
#[derive(Clone, Debug, PartialEq)]
struct Peaks {
    /// Largest of the 2^k numbers from each one on.
    levels: Vec<Vec<f64>>,
}

impl Peaks {
    fn new(values: Vec<f64>) -> Self {
        let mut levels = vec![values];
        let mut span = 1;
        while 2 * span <= levels[0].len() {
            let below = &levels[levels.len() - 1];
            levels.push((0..below.len() - span).map(|i| below[i].max(below[i + span])).collect());
            span *= 2;
        }
        Self { levels }
    }

    /// Largest of numbers `first` to `last`, both included.
    fn peak_of(&self, first: usize, last: usize) -> f64 {
        let level = (last + 1 - first).ilog2() as usize;
        let row = &self.levels[level];
        row[first].max(row[last + 1 - (1 << level)])
    }
}

/// Samples of a motion, with the speeds between them.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionTrack<T> {
    clock: SampleTimes,
    samples: Vec<T>,
    /// Speeds of its origin, and of turns, in each interval (m/s, rad/s); of both ends for segments.
    speeds: Peaks,
    turns: Peaks,
}

impl<T: Copy> MotionTrack<T> {
    fn from_samples(clock: SampleTimes, samples: Vec<T>, speeds: impl Fn(&T, &T) -> [f64; 2]) -> Self {
        let pairs = samples.windows(2).enumerate();
        let each: Vec<[f64; 2]> =
            pairs.map(|(i, w)| speeds(&w[0], &w[1]).map(|distance| distance / clock.interval_length(i))).collect();
        let each = if each.is_empty() { vec![[0.0; 2]] } else { each };
        let peaks = |k: usize| Peaks::new(each.iter().map(|s| s[k]).collect());
        Self { clock, speeds: peaks(0), turns: peaks(1), samples }
    }

    fn interpolate(&self, t: f64, lerp: impl Fn(&T, &T, f64) -> T) -> T {
        let (i, share) = self.clock.find_interval(self.samples.len(), t);
        self.samples.get(i + 1).map_or(self.samples[i], |to| lerp(&self.samples[i], to, share))
    }

    fn peak_speeds(&self, from_s: f64, to_s: f64) -> [f64; 2] {
        let find = |t| self.clock.find_interval(self.samples.len(), t).0;
        let (first, last) = (find(from_s), find(to_s));
        [self.speeds.peak_of(first, last), self.turns.peak_of(first, last)]
    }
}

impl MotionTrack<Rigid> {
    /// Track of a rigid body; it stands still before the first and after the last sample.
    ///
    /// - `samples`: at least one, valid; of [`SampleTimes::At`] as many as times.
    pub fn rigid(clock: SampleTimes, samples: Vec<Rigid>) -> Self {
        Self::from_samples(clock, samples, |a, b| {
            let turn = a.travel_bound(b, 1.0) - a.travel_bound(b, 0.0);
            [a.travel_bound(b, 0.0), turn]
        })
    }

    /// Transform at a time.
    pub fn sample_at(&self, t: f64) -> Rigid {
        self.interpolate(t, Rigid::lerp)
    }

    /// Bound on the speed of a point within `reach` of its origin over a stretch of time (m/s).
    pub fn speed(&self, from_s: f64, to_s: f64, reach: f64) -> f64 {
        let [speed, turn] = self.peak_speeds(from_s, to_s);
        speed + turn * reach
    }
}

impl MotionTrack<Segment> {
    /// Track of a segment whose ends move in straight lines between samples.
    ///
    /// - `samples`: at least one; of [`SampleTimes::At`] as many as times.
    pub fn segment(clock: SampleTimes, samples: Vec<Segment>) -> Self {
        Self::from_samples(clock, samples, |p, q| [(q.a - p.a).length().max((q.b - p.b).length()), 0.0])
    }

    /// Segment at a time (m).
    pub fn sample_at(&self, t: f64) -> Segment {
        self.interpolate(t, Segment::lerp)
    }

    /// Bound on the speed of any of its points over a stretch of time (m/s).
    pub fn speed(&self, from_s: f64, to_s: f64) -> f64 {
        self.peak_speeds(from_s, to_s)[0]
    }
}

/// Motion of a rigid body in the world.
#[derive(Clone, Debug)]
pub enum RigidPath {
    /// Stands still.
    Still(Rigid),
    /// Through keys, or with a joint of a body.
    Track(Arc<MotionTrack<Rigid>>),
}

impl RigidPath {
    /// Motion through keys: in straight lines at even speed from one to the next, still before and after.
    ///
    /// - `keys`: times (s), ascending, and places; an empty list has no place, and no problem accepts it.
    pub fn from_keys(keys: &[(f64, Rigid)]) -> Self {
        if keys.is_empty() {
            return Self::Still(Rigid::from_position(glam::DVec3::NAN));
        }
        let clock = SampleTimes::At(keys.iter().map(|k| k.0).collect());
        Self::Track(Arc::new(MotionTrack::rigid(clock, keys.iter().map(|k| k.1).collect())))
    }

    /// This path, moved by an offset (m).
    #[must_use]
    pub fn moved_by(&self, by: glam::DVec3) -> Self {
        let moved = move |at: Rigid| Rigid { position: at.position + by, ..at };
        match self {
            Self::Still(at) => Self::Still(moved(*at)),
            Self::Track(track) => {
                let samples = track.samples.iter().map(|s| moved(*s)).collect();
                Self::Track(Arc::new(MotionTrack::rigid(track.clock.clone(), samples)))
            }
        }
    }

    /// Transform at a time.
    pub fn place_at(&self, t: f64) -> Rigid {
        match self {
            Self::Still(at) => *at,
            Self::Track(track) => track.sample_at(t),
        }
    }

    /// Bound on the speed of a point within `reach` of its origin over a stretch of time (m/s).
    pub fn speed(&self, from_s: f64, to_s: f64, reach: f64) -> f64 {
        match self {
            Self::Still(_) => 0.0,
            Self::Track(track) => track.speed(from_s, to_s, reach),
        }
    }

    /// True where times ascend, numbers are finite and rotations unit.
    pub fn is_valid(&self) -> bool {
        match self {
            Self::Still(at) => at.is_valid(),
            Self::Track(track) => {
                let times = match &track.clock {
                    SampleTimes::Even { start_s, step_s } => start_s.is_finite() && *step_s > 0.0,
                    SampleTimes::At(times) => {
                        times.len() == track.samples.len()
                            && times.iter().all(|t| t.is_finite())
                            && times.windows(2).all(|w| w[0] < w[1])
                    }
                };
                times && track.samples.iter().all(Rigid::is_valid)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rotation::exp;
    use glam::DVec3;
    use proptest::prelude::*;

    fn keys(n: usize) -> impl Strategy<Value = Vec<Rigid>> {
        let key = (prop::array::uniform3(-1.0f64..1.0), prop::array::uniform3(-1.4f64..1.4));
        prop::collection::vec(
            key.prop_map(|(p, v)| Rigid { position: DVec3::from(p), rotation: exp(DVec3::from(v)) }),
            n,
        )
    }

    proptest! {
        #[test]
        fn nothing_is_faster_than_said(keys in keys(9), even in any::<bool>(), from in -0.2f64..2.0, length in 0.0f64..1.0) {
            let clock = if even {
                SampleTimes::Even { start_s: 0.1, step_s: 0.2 }
            } else {
                SampleTimes::At((0..9).map(|i| 0.1 + 0.2 * f64::from(i) + 0.01 * f64::from(i * i)).collect())
            };
            let track = MotionTrack::rigid(clock.clone(), keys.clone());
            let p = DVec3::new(0.3, 0.4, -0.2);
            let cores: Vec<Segment> = keys.iter().map(|k| Segment::new(k.position, k.transform_point(p))).collect();
            let segments = MotionTrack::segment(clock, cores);
            let (mut distance, mut end_distance) = (0.0, 0.0f64);
            let n = 400;
            for i in 0..n {
                let at = |i: i32| from + length * f64::from(i) / f64::from(n);
                distance += (track.sample_at(at(i + 1)).transform_point(p) - track.sample_at(at(i)).transform_point(p)).length();
                end_distance += (segments.sample_at(at(i + 1)).b - segments.sample_at(at(i)).b).length();
            }
            prop_assert!(distance <= track.speed(from, from + length, p.length()) * length + 1e-9);
            prop_assert!(end_distance <= segments.speed(from, from + length) * length + 1e-9);
        }

        #[test]
        fn peaks_are_the_largest_of_a_run(values in prop::collection::vec(0.0f64..1.0, 1..40), a in 0usize..40, b in 0usize..40) {
            let (a, b) = (a % values.len(), b % values.len());
            let (first, last) = (a.min(b), a.max(b));
            let largest = values[first..=last].iter().copied().fold(0.0, f64::max);
            prop_assert_eq!(Peaks::new(values).peak_of(first, last), largest);
        }
    }

    #[test]
    fn keys_are_passed_at_their_times_and_kept_outside() {
        let place = |x: f64| Rigid::from_position(DVec3::X * x);
        let path = RigidPath::from_keys(&[(1.0, place(0.0)), (2.0, place(3.0)), (4.0, place(3.0))]);
        let x = |t: f64| path.place_at(t).position.x;
        assert_eq!((x(0.0), x(1.0), x(1.5), x(2.0), x(9.0)), (0.0, 0.0, 1.5, 3.0, 3.0));
        assert_eq!((path.speed(1.2, 1.3, 0.5), path.speed(2.5, 3.0, 0.5)), (3.0, 0.0));
        assert!(path.is_valid() && !RigidPath::from_keys(&[]).is_valid());
        assert!(!RigidPath::from_keys(&[(2.0, place(0.0)), (1.0, place(1.0))]).is_valid());
        assert_eq!(RigidPath::from_keys(&[(1.0, place(2.0))]).place_at(7.0), place(2.0));
        for path in [path, RigidPath::Still(place(2.0))] {
            let moved = path.moved_by(DVec3::Y);
            assert!(
                [0.5, 1.5, 9.0].iter().all(|t| moved.place_at(*t).position == path.place_at(*t).position + DVec3::Y)
            );
            assert_eq!(moved.speed(1.2, 1.3, 0.5), path.speed(1.2, 1.3, 0.5));
        }
    }
}
