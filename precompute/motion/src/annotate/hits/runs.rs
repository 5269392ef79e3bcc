//! Outward runs of a limb: from where it is folded to where it is longest.

use crate::clip::FrameRange;

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
