//! Runs of frames of one kind, and the removal of short ones.

use crate::clip::FrameRange;

/// The longest runs of frames with one value, in order.
pub(super) fn runs_of<T: PartialEq>(num_frames: usize, value: impl Fn(usize) -> T) -> Vec<FrameRange> {
    let mut out: Vec<FrameRange> = Vec::new();
    for f in 0..num_frames {
        match out.last_mut() {
            Some(run) if value(run.start) == value(f) => run.end = f + 1,
            _ => out.push(f..f + 1),
        }
    }
    out
}

/// Gives runs that are shorter than `least` the value of their longer neighbour, the shortest first.
pub(super) fn settle<T: PartialEq + Copy>(values: &mut [T], least: usize) {
    let mut runs: Vec<(T, usize)> =
        runs_of(values.len(), |f| values[f]).into_iter().map(|r| (values[r.start], r.len())).collect();
    while let Some(i) = (0..runs.len()).filter(|&i| runs[i].1 < least).min_by_key(|&i| runs[i].1) {
        let beside = [i.checked_sub(1), Some(i + 1)].into_iter().flatten().filter(|&k| k < runs.len());
        let Some(longest) = beside.max_by_key(|&k| runs[k].1) else { break };
        runs[i].0 = runs[longest].0;
        runs.dedup_by(|b, a| {
            let same = a.0 == b.0;
            a.1 += if same { b.1 } else { 0 };
            same
        });
    }
    let settled = runs.into_iter().flat_map(|(value, len)| std::iter::repeat_n(value, len));
    values.iter_mut().zip(settled).for_each(|(value, settled)| *value = settled);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_runs_become_part_of_their_longer_neighbours() {
        let settled = |text: &str, least| {
            let mut values: Vec<char> = text.chars().collect();
            settle(&mut values, least);
            values.into_iter().collect::<String>()
        };
        assert_eq!(settled("aaaabaaacccc", 2), "aaaaaaaacccc");
        assert_eq!(settled("aaabbcccc", 3), "aaacccccc");
        assert_eq!(settled("ab", 3), "bb");
        assert_eq!((settled("a", 3), settled("", 3)), ("a".into(), String::new()));
    }
}
