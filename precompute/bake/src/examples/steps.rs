//! Keytimes from foot contacts: the strikes and offs of a cycle of two steps (Kim, Kim and Shin 2003a, section 4.2.2).

use super::track::ClipTrack;
use throng_core::Contacts;
use throng_motion::clip::FrameRange;

/// Shortest and longest cycle of two steps (s).
const CYCLE_S: std::ops::RangeInclusive<f64> = 0.3..=4.0;
/// Time with both feet on the ground after one strike and in the air before the other beyond which motion is no gait:
/// neither a walk nor a run (s).
const MIXED_S: f64 = 0.085;

/// A cycle of two steps in a clip. Times are in frames, halfway between the last frame before and the first after.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepCycle {
    /// Strike of the left foot: the cycle begins.
    pub start: f64,
    /// Left foot leaves the ground, before `end`.
    pub left_off: f64,
    /// Strike of the right foot.
    pub right_strike: f64,
    /// Right foot leaves the ground after that strike; past `end` if both feet stand when the left one strikes.
    pub right_off: f64,
    /// Next strike of the left foot: the cycle ends.
    pub end: f64,
}

/// Reason why some frames hold no cycle.
#[derive(Clone, Debug, PartialEq)]
pub struct StepFault {
    /// Description, with frames.
    pub what: String,
    /// Time of the fault (frames).
    pub at: f64,
}

/// Cycles and faults of a range of frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StepSequence {
    /// All cycles, in order. One ends where the next begins, unless a fault lies between.
    pub cycles: Vec<StepCycle>,
    /// Faults that keep other frames from being cycles, in order.
    pub faults: Vec<StepFault>,
}

/// A strike of a foot and the duration of its stance; unknown if the range ends before.
#[derive(Clone, Copy, Debug)]
struct FootStrike {
    left: bool,
    time: f64,
    off: Option<f64>,
}

/// Finds all cycles of a range: strikes of the left, right, and left foot.
pub fn sequence(track: &ClipTrack<'_>, range: &FrameRange) -> StepSequence {
    let strikes = strikes(track, range);
    let mut out = StepSequence::default();
    out.faults.extend(strikes.windows(2).filter(|p| p[0].left == p[1].left).map(|p| repeated(&p[0], &p[1])));
    for pair in strikes.windows(2).filter(|p| both_together(&p[0], &p[1])) {
        out.faults
            .push(StepFault { what: format!("both feet strike at frame {:.0}", pair[0].time + 0.5), at: pair[0].time });
    }
    for (i, three) in strikes.windows(3).enumerate() {
        let [left, right, next] = three else { continue };
        let both = both_together(left, right) || both_together(right, next);
        if !left.left || right.left || !next.left || both {
            continue;
        }
        let before = i.checked_sub(1).map(|k| &strikes[k]);
        match cycle(track.rate(), left, right, next, before) {
            Ok(cycle) => out.cycles.push(cycle),
            Err(fault) => out.faults.push(fault),
        }
    }
    if out.cycles.is_empty() && out.faults.is_empty() {
        let what = format!(
            "frames {} to {} hold no two whole steps: {} strikes of the left foot, {} of the right one",
            range.start,
            range.end.saturating_sub(1),
            strikes.iter().filter(|s| s.left).count(),
            strikes.iter().filter(|s| !s.left).count()
        );
        out.faults.push(StepFault { what, at: range.start as f64 });
    }
    out.faults.sort_by(|a, b| a.at.total_cmp(&b.at));
    out
}

/// Finds all single steps of a range from the left foot's strike to the right one's, as halves of cycles.
pub fn find_half_cycles(track: &ClipTrack<'_>, range: &FrameRange) -> Vec<StepCycle> {
    let strikes = strikes(track, range);
    let length = |s: &FootStrike| s.off.map(|off| off - s.time);
    // A stance cut off by the range is assumed to be as long as the other foot's.
    let usual = strikes.iter().find_map(length);
    let step = |pair: &[FootStrike]| {
        let [left, right] = pair else { return None };
        let half = right.time - left.time;
        let stance = length(left).or(length(right)).or(usual)?;
        let whole = left.left && !right.left && CYCLE_S.contains(&(2.0 * half / track.rate())) && stance < 2.0 * half;
        let (start, right_strike) = (left.time, right.time);
        let [left_off, right_off] = [start, right_strike].map(|strike| strike + stance);
        let steps = StepCycle { start, left_off, right_strike, right_off, end: right_strike + half };
        whole.then_some(steps)
    };
    strikes.windows(2).filter_map(step).collect()
}

/// Strikes of both feet in order of time.
fn strikes(track: &ClipTrack<'_>, range: &FrameRange) -> Vec<FootStrike> {
    let of = |foot: Contacts, left: bool| {
        let stances = track.stances(range, foot).into_iter().filter(|s| s.start > range.start);
        stances.map(move |s| FootStrike {
            left,
            time: s.start as f64 - 0.5,
            off: (s.end < range.end).then_some(s.end as f64 - 0.5),
        })
    };
    let mut strikes: Vec<FootStrike> = of(Contacts::LEFT, true).chain(of(Contacts::RIGHT, false)).collect();
    strikes.sort_by(|a, b| a.time.total_cmp(&b.time));
    strikes
}

/// True if both feet strike in the same frame, so that no time passes in between.
fn both_together(a: &FootStrike, b: &FootStrike) -> bool {
    a.left != b.left && b.time - a.time < 1.0
}

/// Fault of two strikes of one foot without the other in between.
fn repeated(a: &FootStrike, b: &FootStrike) -> StepFault {
    let (foot, other) = if a.left { ("left", "right") } else { ("right", "left") };
    let (from, to) = (a.time + 0.5, b.time + 0.5);
    let what = format!(
        "the {foot} foot strikes at frame {from:.0} and again at frame {to:.0}, the {other} one not in between"
    );
    StepFault { what, at: a.time }
}

/// Cycle of three strikes.
fn cycle(
    rate: f64,
    left: &FootStrike,
    right: &FootStrike,
    next: &FootStrike,
    before: Option<&FootStrike>,
) -> Result<StepCycle, StepFault> {
    let (start, right_strike, end) = (left.time, right.time, next.time);
    let fault = |what: String| StepFault { what, at: start };
    let frames = format!("frames {:.0} to {:.0}", start + 0.5, end - 0.5);
    if !CYCLE_S.contains(&((end - start) / rate)) {
        return Err(fault(format!("two steps in {:.2} s ({frames}) are no gait", (end - start) / rate)));
    }
    // A stance cut off by the range is assumed to be as long as the one before it.
    let before = before.and_then(|b| Some(right_strike + b.off? - b.time));
    let (Some(left_off), Some(right_off)) = (left.off, right.off.or(before)) else {
        return Err(fault(format!("the right foot never leaves the ground in {frames}")));
    };
    let (after_right, after_left) = (left_off - right_strike, right_off - end);
    let limit = MIXED_S * rate;
    if after_right.max(after_left) > limit && after_right.min(after_left) < -limit {
        let what = format!(
            "{frames} are neither a walk nor a run: both feet stand after one strike, neither before the other"
        );
        return Err(fault(what));
    }
    Ok(StepCycle { start, left_off, right_strike, right_off, end })
}

impl StepCycle {
    /// Generic times at which the left foot leaves the ground, the right one strikes, the right one leaves: the left
    /// strike is at 0 and the right one at 0.5.
    pub fn keytimes(&self) -> [f64; 3] {
        let generic = |time: f64| {
            let time = if time >= self.end { time - (self.end - self.start) } else { time };
            match time < self.right_strike {
                true => 0.5 * (time - self.start) / (self.right_strike - self.start),
                false => 0.5 + 0.5 * (time - self.right_strike) / (self.end - self.right_strike),
            }
        };
        [generic(self.left_off), 0.5, generic(self.right_off)].map(|g| g.clamp(0.0, 1.0 - 1e-6))
    }

    /// Clip time of a generic time in [0, 1]: linear between the strikes (frames).
    pub fn time(&self, generic: f64) -> f64 {
        match generic < 0.5 {
            true => self.start + 2.0 * generic * (self.right_strike - self.start),
            false => self.right_strike + (2.0 * generic - 1.0) * (self.end - self.right_strike),
        }
    }

    /// First step of a cycle with another end, followed by its mirrored image as the second one.
    pub fn first_half(self, right_strike: f64) -> Self {
        let half = right_strike - self.start;
        Self { right_strike, right_off: self.left_off + half, end: right_strike + half, ..self }
    }

    /// This cycle with another end; the second step takes the change.
    pub fn with_end(self, end: f64) -> Self {
        Self { end, ..self }
    }
}
