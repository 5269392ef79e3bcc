//! Frame rate of a clip whose file only has keys.

use std::collections::{BTreeMap, HashMap};

/// Frame rate where keys do not tell (Hz).
pub const FALLBACK_HZ: f64 = 30.0;
/// Distance of keys above which they are poses that somebody set, not frames (s).
const FRAMES_S: f64 = 0.05;
/// Distance of keys below which they are one key whose value jumps (s).
const JUMP_S: f64 = 0.001;
/// Difference of spacings that count as one (s).
const BUCKET_S: f64 = 1e-5;
/// Most keys that are examined one by one, shared ones each time; of more, shared ones are examined once.
const MAX_KEYS: usize = 1 << 28;
/// Largest distance of a rate from the whole number that is meant: far below that of 29.97 and 30, above the rounding of times.
const ROUNDING: f64 = 3e-4;

/// Frames a second by the most frequent spacing of keys, and a sentence that says why (Hz).
///
/// - `tracks`: times of keys, in order (s).
pub fn rate_of_keys<'a>(tracks: impl Iterator<Item = &'a [f64]>) -> Option<f64> {
    rate_of(tracks, MAX_KEYS)
}

fn rate_of<'a>(tracks: impl Iterator<Item = &'a [f64]>, max_keys: usize) -> Option<f64> {
    // Spacings, each with its number.
    let mut all: Vec<(&[f64], usize)> = tracks.map(|t| (t, 1)).collect();
    if all.iter().map(|(t, _)| t.len()).sum::<usize>() > max_keys {
        let mut times = HashMap::<_, usize>::new();
        all.iter().for_each(|(t, _)| *times.entry((t.as_ptr(), t.len())).or_default() += 1);
        all.retain_mut(|(t, n)| {
            let often = times.remove(&(t.as_ptr(), t.len()));
            *n = often.unwrap_or(0);
            often.is_some()
        });
    }
    let spacings = || {
        all.iter()
            .flat_map(|&(t, n)| t.windows(2).map(move |w| (w[1] - w[0], n)))
            .filter(|(s, _)| (JUMP_S..=FRAMES_S + BUCKET_S).contains(s))
    };
    let mut counts = BTreeMap::<u64, usize>::new();
    spacings().for_each(|(s, n)| *counts.entry((s / BUCKET_S).round() as u64).or_default() += n);
    let most = counts.into_iter().max_by_key(|&(bucket, count)| (count, std::cmp::Reverse(bucket)))?;
    let near = most.0 as f64 * BUCKET_S;
    // Rounding of times spreads one spacing over several buckets.
    let (sum, count) = spacings()
        .filter(|(s, _)| (s - near).abs() < 0.02 * near)
        .fold((0.0, 0usize), |(sum, count), (s, n)| (sum + n as f64 * s, count + n));
    Some(without_rounding(count as f64 / sum))
}

/// The whole number that a rate is but for rounding, or else the rate (Hz).
pub fn without_rounding(rate_hz: f64) -> f64 {
    let whole = rate_hz.round();
    if (rate_hz - whole).abs() <= whole * ROUNDING { whole } else { rate_hz }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(rate_hz: f64, from: f64, n: usize) -> Vec<f64> {
        (0..n).map(|i| f64::from((from + i as f64 / rate_hz) as f32)).collect()
    }

    fn rate(tracks: &[Vec<f64>]) -> Option<f64> {
        rate_of_keys(tracks.iter().map(Vec::as_slice))
    }

    #[test]
    fn the_most_frequent_spacing_counts_and_rounding_does_not() {
        for hz in [24.0, 25.0, 30.0, 60.0, 120.0, 240.0] {
            // Times of single precision are rounded to 8 microseconds at 90 s.
            for from in [0.0, 0.041_666_668, 90.0] {
                assert_eq!(rate(&[keys(hz, from, 50)]), Some(hz), "{hz} from {from}");
            }
        }
        for hz in [24_000.0 / 1001.0, 30_000.0 / 1001.0] {
            let got = rate(&[keys(hz, 0.0, 500)]).unwrap();
            assert!((got - hz).abs() < 1e-4 * hz && got != hz.round(), "{hz}: {got}");
        }
        assert_eq!(rate(&[vec![0.0, 1.0, 3.0], keys(60.0, 0.0, 9), vec![0.0, 0.04, 0.08]]), Some(60.0));
    }

    #[test]
    fn keys_that_are_shared_count_as_often_when_they_are_looked_at_once() {
        let (shared, own) = (keys(30.0, 0.0, 10), keys(60.0, 0.0, 20));
        let tracks = || std::iter::repeat_n(&shared[..], 3).chain([&own[..]]);
        assert_eq!((rate_of(tracks(), MAX_KEYS), rate_of(tracks(), 40)), (Some(30.0), Some(30.0)));
        assert_eq!(rate_of(tracks().skip(2), 10), Some(60.0));
    }

    #[test]
    fn poses_far_apart_and_jumps_tell_no_rate() {
        for keys in [vec![], vec![0.0], vec![0.0, 0.5, 1.0], vec![0.0, 1.0, 1.0, 2.0, 2.000_01], vec![0.0, 60.0]] {
            assert_eq!(rate(std::slice::from_ref(&keys)), None, "{keys:?}");
        }
    }
}
