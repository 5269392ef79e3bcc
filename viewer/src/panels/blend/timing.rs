//! When feet stand, over generic time: of every example, and of the blend.

use std::ops::Range;
use throng_core::Error;
use throng_core::blend::{BlendSpace, BlendedPosture, ExampleRecord, channel};
use throng_precompute::clip;

/// Moments at which a blend is sampled.
const MOMENTS: usize = 96;

/// Contact intervals of a foot, as parts of a cycle; intervals across the end of the cycle are cut there.
pub type StanceIntervals = Vec<Range<f32>>;

/// The steps of a cycle of generic time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CycleContacts {
    /// When the left foot stands, and the right one.
    pub feet: [StanceIntervals; 2],
    /// Time of the cycle (s).
    pub seconds: f32,
}

impl CycleContacts {
    /// Contacts of an example, from its keytimes.
    pub fn from_example(e: &ExampleRecord) -> Self {
        let whole = || vec![0.0..1.0];
        let [left_off, right_strike, right_off] = e.keytimes;
        let feet = match e.flags & ExampleRecord::IS_STILL != 0 {
            true => [whole(), whole()],
            false => [cut(0.0, left_off), cut(right_strike, right_off)],
        };
        Self { feet, seconds: e.duration_s }
    }

    /// Contacts of a blend as shown: where more than half of it has a foot on the ground.
    ///
    /// - `weights`: a row of the space's weights.
    ///
    /// # Errors
    /// [`Error`] where the weights are not a row of the space.
    pub fn from_blend(space: &BlendSpace, weights: &[f32]) -> Result<Self, Error> {
        let phases: Vec<f32> = (0..MOMENTS).map(|i| (i as f32 + 0.5) / MOMENTS as f32).collect();
        let rows = weights.repeat(MOMENTS);
        let mut postures = vec![BlendedPosture::default(); MOMENTS];
        space.blend_postures(&rows, &phases, &mut postures)?;
        let feet = [channel::LEFT_CONTACT, channel::RIGHT_CONTACT].map(|c| {
            let down: Vec<bool> = postures.iter().map(|p| p.channel(c) > 0.5).collect();
            runs(&down)
        });
        let seconds = postures.iter().map(|p| p.channel(channel::RATE)).sum::<f32>() / MOMENTS as f32;
        Ok(Self { feet, seconds })
    }
}

/// From a strike to a lift, cut where the cycle ends.
fn cut(strike: f32, off: f32) -> StanceIntervals {
    match off > strike {
        true => vec![strike..off],
        false => [strike..1.0, 0.0..off].into_iter().filter(|r| r.end > r.start).collect(),
    }
}

/// Intervals of samples that are true, as parts of the whole.
fn runs(down: &[bool]) -> StanceIntervals {
    let part = |i: usize| i as f32 / down.len() as f32;
    clip::runs_where(0..down.len(), |i| down[i]).into_iter().map(|r| part(r.start)..part(r.end)).collect()
}

/// The examples of a blend in the order of how much they matter.
///
/// - `all`: also includes negligible examples; otherwise only the others, and at least one.
pub fn order(weights: &[f32], all: bool) -> Vec<usize> {
    let mut order: Vec<usize> = (0..weights.len()).collect();
    order.sort_by(|&a, &b| weights[b].abs().total_cmp(&weights[a].abs()));
    let shown = order.iter().take_while(|&&e| weights[e].abs() >= LEAST).count().max(1);
    if !all {
        order.truncate(shown);
    }
    order
}

/// Smaller weights are not seen.
const LEAST: f32 = 0.005;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bundle::OpenBundle;
    use crate::fixtures::paces::Paces;

    #[test]
    fn a_contact_across_the_end_of_the_cycle_shows_at_both_ends() {
        assert_eq!(cut(0.5, 0.9), vec![0.5..0.9]);
        assert_eq!(cut(0.5, 0.1), vec![0.5..1.0, 0.0..0.1]);
        assert_eq!(cut(0.5, 0.0), vec![0.5..1.0]);
        assert_eq!(runs(&[true, false, true, true]), vec![0.0..0.25, 0.5..1.0]);
        assert_eq!(runs(&[false; 3]), StanceIntervals::new());
    }

    #[test]
    fn the_blend_at_an_example_steps_as_the_example_does() {
        let paces = Paces::new();
        let bundle = OpenBundle::open(&paces.bundle()).unwrap();
        let space = &bundle.blends[0];
        for e in [0, 6, 13] {
            let mut weights = vec![0.0; space.stride()];
            weights[e] = 1.0;
            let (blend, own) = (
                CycleContacts::from_blend(space, &weights).unwrap(),
                CycleContacts::from_example(&space.examples()[e]),
            );
            assert!((blend.seconds / own.seconds - 1.0).abs() < 0.03, "{} {}", blend.seconds, own.seconds);
            for (a, b) in blend.feet.iter().zip(&own.feet) {
                let length = |s: &StanceIntervals| s.iter().map(|r| r.end - r.start).sum::<f32>();
                assert!((length(a) - length(b)).abs() < 0.08, "{a:?} {b:?}");
            }
        }
        assert!(CycleContacts::from_blend(space, &[1.0]).is_err());
    }

    #[test]
    fn the_largest_weights_come_first_of_either_sign() {
        assert_eq!(order(&[0.3, -0.4, 0.001, 0.9], false), [3, 1, 0]);
        assert_eq!(order(&[0.3, -0.4, 0.001, 0.9], true), [3, 1, 0, 2]);
        assert_eq!(order(&[0.0, 0.0], false).len(), 1);
    }
}
