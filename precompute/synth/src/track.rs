//! Keys of several channels over time, and the smooth signals through them.

use super::{frame::Samples, signal::smooth};
use bytemuck::Pod;

/// Time between keys below which they count as one intention: the later one wins (s).
const APART: f64 = 0.045;

/// Keys of a value, ascending in time. Each `f64` of the value is a channel.
#[derive(Clone, Debug)]
pub struct KeyTrack<T> {
    keys: Vec<(f64, T)>,
}

impl<T: Pod> KeyTrack<T> {
    /// A track that begins with `value`.
    pub fn new(value: T) -> Self {
        Self { keys: vec![(0.0, value)] }
    }

    /// Adds a key, replacing keys at that time and later.
    pub fn push(&mut self, t: f64, value: T) {
        while self.keys.len() > 1 && self.keys.last().is_some_and(|k| k.0 > t - APART) {
            self.keys.pop();
        }
        self.keys.push((t, value));
    }

    /// Repeats the last value at `t`, so that the next motion begins there; no effect if the last key is later.
    pub fn hold(&mut self, t: f64) {
        let (last, value) = self.last();
        if t > last + APART {
            self.keys.push((t, value));
        }
    }

    /// The last key.
    pub fn last(&self) -> (f64, T) {
        self.keys.last().copied().unwrap_or((0.0, T::zeroed()))
    }

    /// Samples the signals: a monotone cubic through the keys, which neither overshoots them nor stops at intermediate
    /// keys, smoothed over `radius` seconds.
    ///
    /// - `ahead`: time by which each channel precedes its keys; 0 for channels without one (s).
    pub fn sample(&self, samples: &Samples, ahead: &[f64], radius: f64) -> Vec<T> {
        let mut out = vec![T::zeroed(); samples.times.len()];
        let num_channels = size_of::<T>() / size_of::<f64>();
        for c in 0..num_channels {
            let ahead = ahead.get(c).copied().unwrap_or(0.0);
            let channel = |value: T| bytemuck::cast_slice::<T, f64>(&[value])[c];
            let knots: Vec<(f64, f64)> = self.keys.iter().map(|k| (k.0 - ahead, channel(k.1))).collect();
            let slopes = slopes(&knots);
            let raw: Vec<f64> = samples.times.iter().map(|&t| hermite(&knots, &slopes, t)).collect();
            let values = bytemuck::cast_slice_mut(&mut out).iter_mut().skip(c).step_by(num_channels);
            values.zip(smooth(&raw, samples.count_within(radius))).for_each(|(value, v)| *value = v);
        }
        out
    }
}

/// Slopes that keep the cubic between its knots.
///
/// # Source
/// Fritsch and Butland 1984, *A method for constructing local monotone piecewise cubic interpolants*.
fn slopes(knots: &[(f64, f64)]) -> Vec<f64> {
    let mut out = vec![0.0; knots.len()];
    for (i, w) in knots.windows(3).enumerate() {
        let (h0, h1) = (w[1].0 - w[0].0, w[2].0 - w[1].0);
        let (d0, d1) = ((w[1].1 - w[0].1) / h0, (w[2].1 - w[1].1) / h1);
        if d0 * d1 > 0.0 {
            let (w0, w1) = (2.0 * h1 + h0, h1 + 2.0 * h0);
            out[i + 1] = (w0 + w1) / (w0 / d0 + w1 / d1);
        }
    }
    out
}

fn hermite(knots: &[(f64, f64)], slopes: &[f64], t: f64) -> f64 {
    let next = knots.partition_point(|k| k.0 <= t);
    if next == 0 {
        return knots[0].1;
    }
    let (a, Some(b)) = (knots[next - 1], knots.get(next)) else { return knots[next - 1].1 };
    hermite_piece([a, *b], [slopes[next - 1], slopes[next]], t)
}

/// Value at time `t` of Hermite's cubic between two knots, each a time and a value, with given rates at them.
pub fn hermite_piece([a, b]: [(f64, f64); 2], rates: [f64; 2], t: f64) -> f64 {
    let h = b.0 - a.0;
    let u = (t - a.0) / h;
    let (u2, u3) = (u * u, u * u * u);
    a.1 * (2.0 * u3 - 3.0 * u2 + 1.0)
        + b.1 * (3.0 * u2 - 2.0 * u3)
        + h * (rates[0] * (u3 - 2.0 * u2 + u) + rates[1] * (u3 - u2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn sample_at<T: Pod>(track: &KeyTrack<T>, ahead: &[f64], t: f64) -> T {
        track.sample(&Samples { times: vec![t], dt: 1.0, per_frame: 1 }, ahead, 0.0)[0]
    }

    fn at(track: &KeyTrack<[f64; 1]>, t: f64) -> f64 {
        sample_at(track, &[0.0], t)[0]
    }

    #[test]
    fn later_intentions_replace_what_they_overlap() {
        let mut track = KeyTrack::new([0.0]);
        track.push(1.0, [1.0]);
        track.push(2.0, [5.0]);
        track.push(1.5, [2.0]);
        track.hold(3.0);
        track.hold(2.5);
        assert_eq!(track.last(), (3.0, [2.0]));
        assert_eq!([0.0, 1.0, 1.5, 2.2, 9.0].map(|t| at(&track, t)), [0.0, 1.0, 2.0, 2.0, 2.0]);
    }

    #[test]
    fn channels_may_run_ahead() {
        let mut track = KeyTrack::new([0.0, 0.0]);
        track.push(1.0, [1.0, 1.0]);
        track.push(2.0, [0.0, 0.0]);
        assert_eq!(sample_at(&track, &[0.1, 0.0], 0.9)[0], 1.0);
    }

    proptest! {
        #[test]
        fn signals_stay_between_their_keys(values in prop::collection::vec(-2.0f64..2.0, 2..12), u in 0.0f64..1.0) {
            let mut track = KeyTrack::new([values[0]]);
            for (i, v) in values.iter().enumerate().skip(1) {
                track.push(0.3 * i as f64, [*v]);
            }
            let t = u * 0.3 * (values.len() - 1) as f64;
            let i = ((t / 0.3) as usize).min(values.len() - 2);
            let (low, high) = (values[i].min(values[i + 1]), values[i].max(values[i + 1]));
            prop_assert!((low - 1e-9..=high + 1e-9).contains(&at(&track, t)));
        }
    }
}
