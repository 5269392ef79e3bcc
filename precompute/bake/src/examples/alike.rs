//! Found examples sorted into spaces of one posture and manner each, without those that do not look like the others.

use super::{AxisConfig, AxisKind, ClipTrack, Cycle, ExampleCandidate, ExampleSource};
use glam::Vec3;
use std::collections::BTreeMap;
use throng_base::{maths::quantile, thresholds::WALKING_MPS};
use throng_core::format::{Gait, MotionClass, Posture};
use throng_core::{Contacts, Joint, Skeleton};
use throng_motion::annotate::classes::{HELD_OTHERWISE, named_manner};
use throng_motion::clip::{Exclusion, ExclusionReason, FrameRange, joint_transforms, runs_where};

/// Phases of a cycle over which a carriage is averaged.
const PHASES: usize = 16;
/// Parts of a body whose mean directions are compared: trunk, head, arms; and how far they may be from the usual (deg).
const PARTS: [(Joint, Joint, f32, &str); 6] = [
    (Joint::Hips, Joint::Neck, 16.0, "trunk"),
    (Joint::Neck, Joint::Head, 25.0, "head"),
    (Joint::LeftUpperArm, Joint::LeftForearm, 32.0, "left arm"),
    (Joint::RightUpperArm, Joint::RightForearm, 32.0, "right arm"),
    (Joint::LeftForearm, Joint::LeftHand, 55.0, "left forearm"),
    (Joint::RightForearm, Joint::RightHand, 55.0, "right forearm"),
];
/// Lowest hips of a cycle, over those that are usual.
const LOWEST_HIPS: f32 = 0.93;
/// Most speed to the side over that ahead, beyond that of a body which lags behind its turns by some time (s).
const SIDEWAYS: f64 = 0.18;
const LAG_S: f64 = 0.17;
/// Fastest two steps (s).
const FASTEST_S: f64 = 0.5;
/// Least and greatest share of a cycle that its first step takes.
const EVEN: std::ops::RangeInclusive<f64> = 0.4..=0.6;
/// Least calm of a stand: its parts turn by some 8 degrees to either side.
const CALM: f32 = 0.99;
/// Shortest standing that makes an example (s).
const STAND_S: f64 = 1.2;

/// Posture, load and manner of the examples of one space.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct SpaceClass {
    posture: Posture,
    carrying: bool,
    manner: String,
}

impl SpaceClass {
    fn from_motion(class: &MotionClass) -> Self {
        Self { posture: class.posture, carrying: class.carrying, manner: class.manner.clone() }
    }

    /// True for a stand of this class, or one in no special manner.
    fn allows_stand(&self, stand: &MotionClass) -> bool {
        let fits = stand.manner.is_empty() || named_manner(&self.manner) == stand.manner;
        fits && (self.posture, self.carrying) == (stand.posture, stand.carrying)
    }

    /// Words that set it apart, joined by hyphens; empty for upright walking in no special manner.
    pub fn words(&self) -> String {
        let posture = if self.posture == Posture::Upright { "" } else { self.posture.name() };
        let words = [posture, if self.carrying { "carrying" } else { "" }, &self.manner];
        words.into_iter().filter(|w| !w.is_empty()).collect::<Vec<_>>().join("-")
    }
}

/// Names of clips and reasons why nothing was taken from them.
pub type Refusals = BTreeMap<String, String>;

/// Sorts candidates by class: upright ones in no special manner, then the space with most of them.
///
/// - `refused`: collects clips whose cycles are no steady gait ahead.
pub fn sort_by_class<'a>(
    all: Vec<ExampleCandidate<'a>>,
    refused: &mut Refusals,
) -> Vec<(SpaceClass, Vec<ExampleCandidate<'a>>)> {
    let mut sorted: BTreeMap<SpaceClass, Vec<_>> = BTreeMap::new();
    for c in all {
        let (class, why) = (class_over(c.source, c.cycle.frames()), uneven(&c));
        let gait = match class.gait {
            Gait::Walk | Gait::Run | Gait::Sneak => None,
            other => Some(format!("its gait is `{}`", other.name())),
        };
        match gait.or(why) {
            Some(why) => _ = refused.entry(c.original().to_owned()).or_insert(why),
            None => sorted.entry(SpaceClass::from_motion(&class)).or_default().push(c),
        }
    }
    let is_usual = |class: &SpaceClass| !HELD_OTHERWISE.contains(&&*class.manner);
    if sorted.keys().any(is_usual) {
        for (class, of) in sorted.extract_if(.., |class, _| !is_usual(class)) {
            for c in of {
                let why = || format!("its body is held otherwise ({})", class.manner);
                refused.entry(c.original().to_owned()).or_insert_with(why);
            }
        }
    }
    let mut sorted: Vec<_> = sorted.into_iter().collect();
    sorted.sort_by_key(|(class, of)| std::cmp::Reverse((class.words().is_empty(), of.len())));
    sorted
}

/// Class of most of some frames; that of a walk where none is known.
fn class_over(source: &ExampleSource, (first, count): (usize, usize)) -> MotionClass {
    let mut votes: BTreeMap<&MotionClass, usize> = BTreeMap::new();
    (first..first + count).filter_map(|f| source.clip.class_at(f)).for_each(|c| *votes.entry(c).or_default() += 1);
    let most = votes.into_iter().max_by_key(|v| v.1).map(|v| v.0.clone());
    most.unwrap_or_else(|| MotionClass { gait: Gait::Walk, ..MotionClass::default() })
}

/// Reason why a cycle is no steady gait ahead.
fn uneven(c: &ExampleCandidate<'_>) -> Option<String> {
    let (twist, steps) = (c.cycle.course.twist, &c.cycle.steps);
    let (ahead, side) = (twist.velocity.y, (twist.velocity.x + LAG_S * twist.gyration * twist.velocity.y).abs());
    let first = (steps.right_strike - steps.start) / (steps.end - steps.start);
    if ahead < f64::from(WALKING_MPS) {
        Some(format!("it goes ahead at {ahead:.1} m/s"))
    } else if side > SIDEWAYS * ahead {
        Some(format!("it goes aside at {side:.1} of {ahead:.1} m/s"))
    } else if c.cycle.duration_s() < FASTEST_S {
        Some(format!("two steps take {:.2} s", c.cycle.duration_s()))
    } else if !EVEN.contains(&first) {
        Some(format!("one of two steps takes {:.0} % of the time", 100.0 * first.max(1.0 - first)))
    } else {
        None
    }
}

/// Axes along which the examples differ enough; that of turning rates goes where all of them are about straight.
pub fn keep_wide_axes(axes: &[AxisConfig], all: &mut Vec<ExampleCandidate<'_>>) -> Vec<AxisConfig> {
    /// Extent of turning rates below which they make no axis (rad/s).
    const WIDE: f64 = 0.8;
    let Some(turns) = axes.iter().position(|a| a.kind == AxisKind::Gyration) else { return axes.to_vec() };
    let rate = |c: &ExampleCandidate<'_>| c.parameters[turns].abs();
    if axes.len() < 2 || 2.0 * all.iter().map(rate).fold(0.0, f64::max) >= WIDE {
        return axes.to_vec();
    }
    all.iter_mut().for_each(|c| _ = c.parameters.remove(turns));
    axes.iter().filter(|a| a.kind != AxisKind::Gyration).cloned().collect()
}

/// Mean directions of the parts of a body over a cycle, the lowest height of its hips, and how calm it is: 1 if nothing turns.
#[derive(Clone, Debug)]
struct Carriage {
    parts: [Vec3; PARTS.len()],
    hips_m: f32,
    calm: f32,
}

impl Carriage {
    fn over_cycle(cycle: &Cycle<'_>, skeleton: &Skeleton) -> Self {
        let (mut parts, mut hips_m) = ([Vec3::ZERO; PARTS.len()], f32::INFINITY);
        for k in 0..PHASES {
            let pose = cycle.pose(k as f64 / PHASES as f64);
            let at = joint_transforms(skeleton, pose.hips, |j| pose.rotations[j]);
            for (sum, (from, to, ..)) in parts.iter_mut().zip(PARTS) {
                *sum += (at[to.index()].0 - at[from.index()].0).normalize_or_zero();
            }
            hips_m = hips_m.min(pose.hips.y);
        }
        let calm = parts.iter().map(|sum| sum.length() / PHASES as f32).fold(1.0, f32::min);
        Self { parts: parts.map(Vec3::normalize_or_zero), hips_m, calm }
    }

    /// The part farthest from another carriage, over what is allowed.
    fn farthest(&self, other: &Self) -> (f32, &'static str) {
        let over = |k: usize| {
            let (.., most_deg, name) = PARTS[k];
            (self.parts[k].angle_between(other.parts[k]).to_degrees() / most_deg, name)
        };
        (0..PARTS.len()).map(over).fold((0.0, ""), |a, b| if b.0 > a.0 { b } else { a })
    }
}

/// True if both feet are off the ground between steps.
fn runs(c: &ExampleCandidate<'_>) -> bool {
    c.cycle.steps.left_off < c.cycle.steps.right_strike
}

/// Usual carriage of candidates.
pub struct UsualCarriage(Carriage);

impl UsualCarriage {
    /// Keeps candidates that carry themselves as most do, walks among walks and runs among runs, the most usual first.
    ///
    /// - returns the usual walk, or the usual run if nobody walks; `None` if there is neither.
    pub fn keep_usual(all: &mut Vec<ExampleCandidate<'_>>, body: &Skeleton, refused: &mut Refusals) -> Option<Self> {
        /// Most by which runs may be carried otherwise than walks, over what may differ among walks.
        const OTHERWISE: f32 = 2.2;
        let (mut running, mut walking): (Vec<_>, Vec<_>) = all.drain(..).partition(runs);
        let walk = Self::keep_usual_gait(&mut walking, body, refused);
        let run = Self::keep_usual_gait(&mut running, body, refused);
        if let (Some(walk), Some(run)) = (&walk, &run) {
            let (over, part) = run.0.farthest(&walk.0);
            if over > OTHERWISE {
                let why = format!("in runs, the {part} is held otherwise than in walks");
                running.drain(..).for_each(|c| _ = refused.entry(c.original().to_owned()).or_insert(why.clone()));
            }
        }
        all.extend(walking.into_iter().chain(running));
        walk.or(run)
    }

    fn keep_usual_gait(all: &mut Vec<ExampleCandidate<'_>>, body: &Skeleton, refused: &mut Refusals) -> Option<Self> {
        let carriages: Vec<Carriage> = all.iter().map(|c| Carriage::over_cycle(&c.cycle, body)).collect();
        let far = |c: &Carriage| carriages.iter().map(|o| c.farthest(o).0.min(2.0)).sum::<f32>();
        let mut usual = carriages.iter().map(|c| (far(c), c)).min_by(|a, b| a.0.total_cmp(&b.0))?.1.clone();
        usual.hips_m = quantile(carriages.iter().map(|c| c.hips_m), [1, 2])?;
        let usual = Self(usual);
        let mut order: Vec<(f32, ExampleCandidate<'_>)> = Vec::new();
        for (c, carriage) in all.drain(..).zip(&carriages) {
            match usual.differs(carriage) {
                Some(why) => _ = refused.entry(c.original().to_owned()).or_insert(why),
                // A cycle that closes well is worth a little oddness.
                None => order.push((carriage.farthest(&usual.0).0 + c.cycle.closing.to_degrees() as f32 / 6.0, c)),
            }
        }
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.extend(order.into_iter().map(|o| o.1));
        Some(usual)
    }

    /// Reason why a carriage is another one.
    fn differs(&self, carriage: &Carriage) -> Option<String> {
        let (over, part) = carriage.farthest(&self.0);
        let low = carriage.hips_m / self.0.hips_m;
        if low < LOWEST_HIPS {
            Some(format!("the hips go down to {:.0} % of the height that is usual here", 100.0 * low))
        } else if over > 1.0 {
            Some(format!("the {part} is held otherwise than usual here"))
        } else {
            None
        }
    }

    /// The best standing of a class in this carriage, as an example.
    pub fn standing<'a>(
        &self,
        sources: &'a [ExampleSource],
        class: &SpaceClass,
        skeleton: &Skeleton,
    ) -> Option<(&'a ExampleSource, Cycle<'a>)> {
        let stands = |s: &'a ExampleSource| {
            let neutral = move |f: usize| {
                let known = s.clip.class_at(f);
                let at_ease = known.is_none_or(|c| c.gait == Gait::Stand && c.neutral && class.allows_stand(c));
                let used = |e: &Exclusion| e.reason == ExclusionReason::Still || !e.range.contains(&f);
                at_ease
                    && s.clip.excluded.iter().all(used)
                    && s.clip.contacts[f].any(Contacts::LEFT)
                    && s.clip.contacts[f].any(Contacts::RIGHT)
            };
            let long = move |r: &FrameRange| r.len() as f64 >= STAND_S * s.clip.rate_hz;
            runs_where(0..s.clip.num_frames(), neutral).into_iter().filter(long).map(move |r| (s, r))
        };
        let originals = sources.iter().filter(|s| !s.clip.mirrored);
        let cycles = originals.flat_map(stands).filter_map(|(source, range)| {
            let cycle = Cycle::from_still(ClipTrack::new(&source.clip), &range);
            let carriage = Carriage::over_cycle(&cycle, skeleton);
            let odd = carriage.farthest(&self.0).0 + cycle.closing.to_degrees() as f32 / 6.0;
            (carriage.calm > CALM && self.differs(&carriage).is_none()).then_some((odd, (source, cycle)))
        });
        cycles.min_by(|a, b| a.0.total_cmp(&b.0)).map(|best| best.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stands_are_of_the_manner_of_the_walks_or_of_none() {
        let class = |manner: &str| MotionClass { manner: manner.into(), ..MotionClass::default() };
        let allows = |walk: &str, stand: &str| SpaceClass::from_motion(&class(walk)).allows_stand(&class(stand));
        assert!(allows("", "") && allows("sad", "sad") && allows("sad", "") && allows("bent", ""));
        assert!(!allows("", "sad") && !allows("happy", "sad") && !allows("bent", "sad"));
        let crouched = MotionClass { posture: Posture::Crouched, ..class("") };
        assert!(!SpaceClass::from_motion(&class("")).allows_stand(&crouched));
    }
}
