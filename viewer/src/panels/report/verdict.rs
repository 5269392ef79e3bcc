//! Meaning of the figures on contacts, in plain words.

use throng_base::thresholds::{FOOT_PLANTED_MPS, FOOT_SLIDES_MPS};
use throng_precompute::annotate::ContactSanity;
use throng_precompute::stance::Grade;

/// Difference of the contact shares of the two feet above which a limp, a turn, or a wrong floor is likely.
const UNEVEN: f32 = 0.25;

/// Whether something is as it should be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mood {
    /// All is well.
    Good,
    /// Something may be wrong.
    Odd,
}

/// Judges how the feet behave: how often they stand, how alike they are, whether they slide.
pub fn verdict(c: &ContactSanity) -> Vec<(Mood, String)> {
    let mut out = vec![stance(c)];
    if (c.left_share - c.right_share).abs() > UNEVEN {
        let more = if c.left_share > c.right_share { "left" } else { "right" };
        let text = format!("The {more} foot stands much more often than the other: a limp, or one side is wrong.");
        out.push((Mood::Odd, text));
    }
    if c.left_share.max(c.right_share) > 0.0 {
        out.push(sliding(c));
    }
    if c.stance.grade != Grade::Good {
        out.push((Mood::Odd, format!("Feet stand {}. Is the floor level?", c.stance)));
    }
    out
}

/// Walking has about 0.6 of each foot, running about 0.35.
fn stance(c: &ContactSanity) -> (Mood, String) {
    let mean = 0.5 * (c.left_share + c.right_share);
    let (mood, text) = match mean {
        m if m <= 0.0 => (Mood::Odd, "The feet never stand: wrong unit, wrong up axis, or no ground under the motion."),
        m if m < 0.2 => (Mood::Odd, "The feet stand rarely: a fast run or jumps, or the ground lies too low."),
        m if m < 0.45 => (Mood::Good, "The feet stand about as often as in running."),
        m if m < 0.8 => (Mood::Good, "The feet stand about as often as in walking."),
        _ => (Mood::Good, "The feet stand nearly all the time, as in standing or gestures on the spot."),
    };
    (mood, text.to_owned())
}

fn sliding(c: &ContactSanity) -> (Mood, String) {
    if c.p95_speed_mps > FOOT_SLIDES_MPS {
        (Mood::Odd, "Planted feet slide at times: expect foot skate, or set the contact thresholds lower.".to_owned())
    } else if c.mean_speed_mps > FOOT_PLANTED_MPS {
        (Mood::Odd, "Planted feet move a little: foot lock will have some work to do.".to_owned())
    } else {
        (Mood::Good, "Planted feet stay where they are.".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moods(left_share: f32, right_share: f32, mean_speed_mps: f32, p95_speed_mps: f32) -> Vec<Mood> {
        let c = ContactSanity { left_share, right_share, mean_speed_mps, p95_speed_mps, ..Default::default() };
        verdict(&c).into_iter().map(|v| v.0).collect()
    }

    #[test]
    fn plausible_contacts_pass_and_implausible_ones_are_flagged() {
        use Mood::{Good, Odd};
        assert_eq!(moods(0.6, 0.58, 0.05, 0.2), [Good, Good]);
        assert_eq!(moods(0.35, 0.36, 0.1, 0.3), [Good, Good]);
        assert_eq!(moods(0.0, 0.0, 0.0, 0.0), [Odd]);
        assert_eq!(moods(0.9, 0.4, 0.05, 0.2), [Good, Odd, Good]);
        assert_eq!(moods(0.6, 0.6, 0.3, 0.9), [Good, Odd]);
        assert_eq!(moods(0.1, 0.05, 0.2, 0.3), [Odd, Odd]);
    }
}
