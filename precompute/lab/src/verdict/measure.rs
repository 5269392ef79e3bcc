//! Measures of a verdict, each with its limits, its word, its sentence and its advice.

use crate::abilities::{Abilities, MOSTLY_BACKWARDS};
use crate::trial::{ReachShare, TrialReport};
use serde::Serialize;
use throng_bake::examples::judge::{BLEND_WORDS, BlendQuality, ONE_SPEED};
use throng_bake::examples::{BlendReport, ExampleReport, WIDEST_SEAM};
use throng_bake::policy::{ENOUGH_KEPT, LEAST_KEPT, Promise, PromisePart};
use throng_base::thresholds::{SLIP_UNSEEN_MPS_F64, TOES_SLOW_MPS_F64};
use throng_core::Bundle;
use throng_motion::stance::{self, StanceReport};

/// Words of a measure, from the best.
pub(super) const WORDS: [&str; 3] = ["good", "fair", "poor"];
/// Share of reached targets from which on reaching is good.
pub(super) const GOOD_REACH: f64 = 0.95;
/// Least number of characters of a meaningful group.
const MIN_GROUP: usize = 10;
/// A group of targets is reported if its share is below the mean by this much.
const BEHIND_SHARE: f64 = 0.1;
/// Share of a wait below which its longest action does not explain it, so that other characters are the reason.
const HELD_UP_SHARE: f64 = 0.7;
/// Limits of a good and of a fair share of moving time that goes backwards.
const BACKWARDS: [f64; 2] = [0.05, 0.25];
/// Limits of good and fair changes of manner (1/min).
const MANNERS_PER_MIN: [f64; 2] = [1.0, 6.0];
/// Limits of a good and of a fair wait for a choice (s).
const WAIT_S: [f64; 2] = [4.0, 8.0];
/// Limits of good and of fair slip of feet in the clips: mean and 95th percentile (m/s).
const SOURCE_SLIP_MPS: [[f64; 2]; 2] = [[0.1, 0.2], [0.2, 0.3]];
/// Share of clips up to which bad ones are few, beside a single one of at least so many.
const FEW: (f64, usize) = (0.1, 4);
/// Most clips that are named.
const MAX_NAMED_CLIPS: usize = 3;

/// One measure of a verdict.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Measure {
    /// Name of the measure.
    pub name: &'static str,
    /// Measured value.
    pub value: f64,
    /// Limits of good and of fair.
    pub limits: [f64; 2],
    /// `good`, `fair` or `poor`.
    pub word: &'static str,
    /// The measured value, in words.
    pub sentence: String,
    /// Remedies; empty if it is good.
    pub advice: Vec<String>,
    /// True if it is reported even if it is good.
    #[serde(skip)]
    pub(super) is_reported: bool,
}

/// Inputs of a verdict.
pub(super) struct VerdictInputs<'a> {
    pub trial: &'a TrialReport,
    pub motion: &'a Abilities,
    /// True if the bundle has mirrored copies.
    pub mirrored: bool,
    pub source: SourceFeet,
    pub longest: Option<LongestAction>,
    /// Names of policies, the promise of each, and the remedy.
    pub promises: Vec<(&'a str, Promise, String)>,
    pub blends: &'a [BlendReport],
}

/// Speeds of planted heels and toes in the clips, and distances of standing feet from the ground.
#[derive(Default)]
pub(super) struct SourceFeet {
    /// Mean speed (m/s).
    pub mean_mps: f64,
    /// 95th percentile of the speed (m/s).
    pub p95_mps: f64,
    /// Mean speed in each clip, the fastest first (m/s).
    pub of_clips: Vec<(String, f64)>,
    /// Stance in all clips; none if heights are kept as captured.
    pub stance: Option<StanceReport>,
    /// Stance in each clip, the farthest from the ground first.
    pub stances: Vec<(String, StanceReport)>,
}

/// The longest action, within which no choice is made.
pub(super) struct LongestAction {
    pub clip: String,
    pub seconds: f64,
    /// True if no other clip has one so long that characters wait badly long.
    pub is_alone: bool,
}

impl LongestAction {
    /// The longest of all actions of a bundle.
    pub fn of_bundle(tables: &Bundle) -> Option<Self> {
        let longest = tables.graph().segments.iter().max_by_key(|s| s.num_frames)?;
        let clip = tables.clips().partition_point(|c| c.first_frame <= longest.start).saturating_sub(1);
        let seconds = f64::from(longest.num_frames) / tables.meta().rate_hz;
        let is_of_clip = |s: &throng_core::graph::MotionSegment| {
            tables.clips()[clip].first_frame <= s.start
                && s.start < tables.clips()[clip].first_frame + tables.clips()[clip].num_frames
        };
        let is_long =
            |s: &throng_core::graph::MotionSegment| f64::from(s.num_frames) / tables.meta().rate_hz > WAIT_S[1];
        let is_alone = tables.graph().segments.iter().filter(|s| is_long(s)).all(is_of_clip);
        Some(Self { clip: tables.meta().clips.get(clip)?.name.clone(), seconds, is_alone })
    }
}

/// All measures, in the order in which they are reported.
pub(super) fn all_measures(facts: &VerdictInputs<'_>) -> Vec<Measure> {
    let mut all = vec![targets_reached(facts)];
    all.extend(worst_targets(facts.trial));
    all.extend(staying_at_targets(facts));
    all.extend(standing_at_targets(facts));
    all.push(walking_backwards(facts));
    all.extend(what_nobody_asked_for(facts.trial));
    all.push(standing_before_arrival(facts.trial));
    all.push(longest_wait(facts));
    all.extend(foot_slip(facts));
    all.extend(source_slip(&facts.source));
    all.extend(feet_from_ground(&facts.source));
    all.push(low_toes(facts.trial));
    all.extend(promises_kept(facts));
    all.extend(worst_blend(facts.blends));
    all.extend(widest_seam(facts.blends));
    all
}

/// A measure; larger values are better if the first limit is above the second, otherwise smaller ones.
fn measure(name: &'static str, value: f64, limits: [f64; 2], sentence: String) -> Measure {
    let [good, fair] = limits;
    let within = |limit: f64| if good > fair { value >= limit } else { value <= limit };
    let word = WORDS[limits.iter().take_while(|limit| !within(**limit)).count()];
    Measure { name, value, limits, word, sentence, advice: Vec::new(), is_reported: word != WORDS[0] }
}

impl Measure {
    fn always_reported(self) -> Self {
        Self { is_reported: true, ..self }
    }

    /// Calls a poor measure fair if few clips make it so: the others can do without them.
    fn fair_if(self, few: bool) -> Self {
        if few && self.word == WORDS[2] { Self { word: WORDS[1], ..self } } else { self }
    }

    /// Adds advice if the measure is not good.
    fn with_advice(mut self, advice: impl FnOnce() -> Vec<String>) -> Self {
        if self.word != WORDS[0] {
            self.advice = advice();
        }
        self
    }
}

/// True if some of all clips are few.
fn are_few(some: usize, all: usize) -> bool {
    some as f64 <= FEW.0 * all as f64 || some <= 1 && all >= FEW.1
}

fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

fn targets_reached(facts: &VerdictInputs<'_>) -> Measure {
    let trial = facts.trial;
    let after = trial.mean_arrival_s.map_or(String::new(), |s| format!(", {s:.1} s on average"));
    let share = percent(trial.reached_fraction);
    let alone = if trial.avoiding { "" } else { ", each as if alone" };
    let sentence = format!("{share} of the targets were reached within {:.0} s{after}{alone}", trial.simulated_s);
    measure("targets reached", trial.reached_fraction, [GOOD_REACH, 0.8], sentence).always_reported().with_advice(|| {
        let mut advice = facts.motion.missing(facts.mirrored);
        if !advice.is_empty() {
            return advice;
        }
        if trial.avoiding {
            advice.push(
                "others were in the way, or the time was short: fewer characters or more seconds show which, and `--no-avoid` \
                 shows each as if alone"
                    .into(),
            );
        } else {
            advice.push(
                "the motion shows all that is needed, in clips that do not lead to each other soon enough: add clips that walk, \
                 turn and stop in one take, so that all of them hang together, or give them more seconds"
                    .into(),
            );
        }
        advice
    })
}

/// The group of targets of which fewest are reached, by direction and by distance.
fn worst_targets(trial: &TrialReport) -> impl Iterator<Item = Measure> {
    let worst = |shares: &[ReachShare]| {
        let enough = shares.iter().filter(|s| s.characters >= MIN_GROUP);
        enough.min_by(|a, b| a.reached_fraction.total_cmp(&b.reached_fraction)).cloned()
    };
    let groups = [
        ("targets of the worst direction", worst(&trial.reached_by_direction)),
        ("targets of the worst distance", worst(&trial.reached_by_distance)),
    ];
    let reached = trial.reached_fraction;
    groups.into_iter().filter_map(move |(name, share)| {
        let s = share?;
        let sentence = format!("of those {}: {}", s.targets, percent(s.reached_fraction));
        let m = measure(name, s.reached_fraction, [0.8, 0.5], sentence);
        Some(Measure { is_reported: m.value < reached - BEHIND_SHARE, ..m })
    })
}

/// Share of the characters that stay, of those that have reached their target.
fn staying_at_targets(facts: &VerdictInputs<'_>) -> Option<Measure> {
    let (trial, advice) = (facts.trial, || stop_advice(facts));
    if trial.reached_fraction * (trial.characters as f64) < MIN_GROUP as f64 {
        return None;
    }
    let share = (trial.stayed_fraction / trial.reached_fraction).min(1.0);
    let sentence = format!("only {} of those who came are still there at the end", percent(share));
    Some(measure("staying at targets", share, [0.7, 0.2], sentence).with_advice(advice))
}

/// Share of the characters that stand, of those that have stayed.
fn standing_at_targets(facts: &VerdictInputs<'_>) -> Option<Measure> {
    let (trial, share) = (facts.trial, facts.trial.standing_fraction);
    if trial.stayed_fraction * (trial.characters as f64) < MIN_GROUP as f64 {
        return None;
    }
    let sentence = match share {
        0.5.. => format!("{} of those who stayed there stand still", percent(share)),
        _ => format!("only {} of those who stayed there stand still; the others go on moving", percent(share)),
    };
    // They have reached their targets all the same.
    let m = measure("standing at targets", share, [0.5, 0.0], sentence).always_reported();
    Some(m.with_advice(|| stop_advice(facts)))
}

/// Advice on motion that lets characters stay and stand.
fn stop_advice(facts: &VerdictInputs<'_>) -> Vec<String> {
    let missing = facts.motion.missing(facts.mirrored);
    match missing.is_empty() {
        true => vec!["add clips that come to stand, with both feet on the ground for some seconds".into()],
        false => missing,
    }
}

/// Share of backwards walking; motion whose front was misread reaches targets as well as any, but backwards.
fn walking_backwards(facts: &VerdictInputs<'_>) -> Measure {
    let share = facts.motion.backwards_share();
    let sentence = format!("{} of the walking is backwards", percent(share));
    let m = measure("walking backwards", share, [MOSTLY_BACKWARDS, 0.75], sentence);
    m.with_advice(|| facts.motion.missing(facts.mirrored))
}

/// Travel against the front, and changes of manner, of people who only have a target.
fn what_nobody_asked_for(trial: &TrialReport) -> [Measure; 2] {
    let (share, per_min) = (trial.quality.apart.backwards_share, trial.quality.apart.manner_changes_per_min);
    let back = format!("people go backwards for {} of the time in which they move", percent(share));
    let manners = format!("people change their manner {per_min:.1} times a minute");
    [
        measure("going backwards", share, BACKWARDS, back).with_advice(|| {
            vec!["set `costs.backwards` of the behaviour, or leave clips that go backwards out (`--leave NAME`)".into()]
        }),
        measure("changes of manner (1/min)", per_min, MANNERS_PER_MIN, manners).with_advice(|| {
            vec!["set `costs.manner_change_s` of the behaviour, or build each manner by itself".into()]
        }),
    ]
}

fn standing_before_arrival(trial: &TrialReport) -> Measure {
    let sentence = format!("on their way they stand for {} of the time", percent(trial.stopped_share));
    // Others may be in the way, which is no fault of the motion.
    measure("standing on the way", trial.stopped_share, [0.25, 1.0], sentence)
}

fn longest_wait(facts: &VerdictInputs<'_>) -> Measure {
    let wait = facts.trial.longest_wait_s;
    let sentence = format!("a character waits {wait:.1} s for its next choice at the longest");
    // A character that waits for others plays its action more slowly.
    let own = facts.longest.as_ref().filter(|l| l.seconds > HELD_UP_SHARE * wait || !facts.trial.avoiding);
    let m = measure("longest wait for a choice (s)", wait, WAIT_S, sentence).always_reported();
    m.fair_if(own.is_some_and(|l| l.is_alone)).with_advice(|| {
        if own.is_none() && facts.longest.is_some() {
            return vec!["others hold it up, and not its clips: fewer characters, or more room".into()];
        }
        let longest = own.map_or(String::new(), |l| {
            format!("; the longest stretch without one is {:.1} s of `{}`", l.seconds, l.clip)
        });
        let out = "lower `graph.max_action_s`, or add clips of walking that are short, or that begin and end as the \
                   others do";
        vec![format!("for {wait:.0} s a character makes no choice{longest}: {out}")]
    })
}

/// Foot slip of characters, beside that of the clips.
fn foot_slip(facts: &VerdictInputs<'_>) -> Vec<Measure> {
    let (here, there) = (facts.trial.foot_slip_mean_mps, facts.source.mean_mps);
    if there <= 0.0 {
        return Vec::new();
    }
    let ratio = here / there.max(1e-6);
    let [mm, source_mm] = [here, there].map(|mps| 1000.0 * mps);
    let sentence = format!("planted feet slip {mm:.0} mm/s, {ratio:.1} times as fast as in the clips ({source_mm:.0})");
    // Relative to the slip of the clips, or to an invisible slip.
    // People who skate as their clips do skate all the same.
    let limit = |times: f64| (times * there).clamp(SLIP_UNSEEN_MPS_F64, times / 1.5 * SOURCE_SLIP_MPS[0][0]);
    let m = measure("foot slip (m/s)", here, [limit(1.5), limit(2.5)], sentence).always_reported();
    vec![m.with_advice(|| {
        let out = "add clips that lie between the poses of the others, so that nearer ones can follow each other, or \
                   lower `graph.max_error`";
        vec![format!("feet slip where clips are joined: {out}")]
    })]
}

/// Foot slip of the clips themselves.
fn source_slip(slip: &SourceFeet) -> Vec<Measure> {
    let (mps, p95) = (slip.mean_mps, slip.p95_mps);
    if mps <= 0.0 {
        return Vec::new();
    }
    let sentence = format!("feet that should be planted slip {:.0} mm/s in the clips themselves", 1000.0 * mps);
    let sentence_p95 = format!("one planted foot in twenty slips {:.0} mm/s or more in the clips", 1000.0 * p95);
    let few = are_few(slip.of_clips.iter().filter(|c| c.1 > SOURCE_SLIP_MPS[0][1]).count(), slip.of_clips.len());
    let all = [
        measure("foot slip in the clips (m/s)", mps, SOURCE_SLIP_MPS[0], sentence),
        measure("foot slip in the clips, 95th percentile (m/s)", p95, SOURCE_SLIP_MPS[1], sentence_p95),
    ];
    let advised = all.map(|m| {
        m.fair_if(few).with_advice(|| {
            let most: Vec<String> = slip
                .of_clips
                .iter()
                .take(MAX_NAMED_CLIPS)
                .map(|(clip, mps)| format!("`{clip}` {:.0}", 1000.0 * mps))
                .collect();
            vec![format!(
                "most in {} mm/s: capture them again, smooth them, or leave them out (`--leave NAME`)",
                most.join(", ")
            )]
        })
    });
    advised.into()
}

/// Distance of standing feet from the ground in the clips.
fn feet_from_ground(source: &SourceFeet) -> Option<Measure> {
    let StanceReport { p95_cm: far, worst_cm, .. } = source.stance?;
    let sentence = format!("feet stand up to {far:.1} cm from the ground in the clips, {worst_cm:.1} cm at worst");
    let m = measure("feet from the ground (cm)", f64::from(far), stance::FAR_CM.map(f64::from), sentence);
    let poor = source.stances.iter().filter(|(_, s)| s.grade == stance::Grade::Poor).count();
    Some(m.fair_if(are_few(poor, source.stances.len())).with_advice(|| {
        let off = source.stances.iter().filter(|(_, s)| s.grade != stance::Grade::Good);
        let most: Vec<String> =
            off.take(MAX_NAMED_CLIPS).map(|(clip, s)| format!("`{clip}` {:.0}", s.p95_cm)).collect();
        vec![format!(
            "farthest in {} cm: level the floor where it was captured, or leave out what steps onto things",
            most.join(", ")
        )]
    }))
}

fn low_toes(trial: &TrialReport) -> Measure {
    let (here, there) = (trial.quality.toe_speed_low_p95_mps, trial.quality.source_toe_speed_low_p95_mps);
    let sentence = format!("toes near the ground move at up to {here:.2} m/s ({there:.2} in the clips)");
    let limit = |times: f64| (times * there).max(times / 1.5 * TOES_SLOW_MPS_F64);
    let m = measure("low toes, 95th percentile (m/s)", here, [limit(1.5), limit(3.0)], sentence);
    m.with_advice(|| vec!["add walks whose steps are alike, or lower `graph.max_error`".into()])
}

/// Kept share of the policies' promises, in total and at the 5th percentile, each of the policy that keeps least.
fn promises_kept(facts: &VerdictInputs<'_>) -> Vec<Measure> {
    let least = |of: fn(&Promise) -> Option<f64>, of_part: fn(&PromisePart) -> f64| {
        let all = facts.promises.iter().filter_map(move |(name, p, help)| Some((*name, of(p)?, p, help)));
        let (name, kept, promise, help) = all.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let worst = promise.parts.iter().min_by(|a, b| of_part(a).total_cmp(&of_part(b)));
        let where_least = worst.map_or(String::new(), |p| {
            format!(" (least {:.1} to {:.1} m away, {})", p.distance_m[0], p.distance_m[1], p.direction)
        });
        Some((name, kept, format!("policy `{name}`{where_least}: {help}")))
    };
    let mut out = Vec::new();
    if let Some((name, kept, advice)) = least(|p| p.kept, |p| p.kept) {
        let sentence = format!("policy `{name}` collects {} of what its values promise", percent(kept));
        out.push(measure("promises kept", kept, [ENOUGH_KEPT, 0.5], sentence).with_advice(|| vec![advice]));
    }
    if let Some((name, kept, advice)) = least(|p| p.kept_p05, |p| p.kept_p05) {
        let share = percent(kept.max(0.0));
        let sentence =
            format!("for one target in twenty, policy `{name}` collects {share} of what it promises, or less");
        // A policy is not poor because a few targets are unattainable.
        let m = measure("promises kept, 5th percentile", kept, [LEAST_KEPT, f64::MIN], sentence);
        out.push(m.with_advice(|| vec![advice]));
    }
    out
}

/// The blend space of the worst quality.
fn worst_blend(blends: &[BlendReport]) -> Option<Measure> {
    // Crowds that play a policy do not miss the speeds that a space lacks.
    let is_judged = |b: &&BlendReport| !b.quality.reason.starts_with(ONE_SPEED);
    let rank = |b: &BlendReport| BLEND_WORDS.iter().position(|w| *w == b.quality.word).unwrap_or(0);
    let worst = blends.iter().rev().filter(is_judged).max_by_key(|b| rank(b))?;
    let (name, BlendQuality { word, reason, .. }) = (&worst.name, &worst.quality);
    let sentence = format!("blend space `{name}` is {word}: {reason}");
    let m = measure("worst blend space", rank(worst) as f64, [0.0, 1.0], sentence);
    Some(m.with_advice(|| {
        vec![format!("`throng inspect BUNDLE --blends-png FILE` shows `{name}`; leave out the clip that differs, or add some between")]
    }))
}

/// The widest seam of all blend spaces, over the widest that is accepted by default.
fn widest_seam(blends: &[BlendReport]) -> Option<Measure> {
    let all = blends.iter().flat_map(|b| b.examples.iter().map(move |e| (b, e)));
    let (b, e) = all.max_by(|x, y| x.1.seam().total_cmp(&y.1.seam()))?;
    let ExampleReport { name, closing_m, closing_rad, .. } = e;
    let (space, cm, deg) = (&b.name, 100.0 * closing_m, closing_rad.to_degrees());
    let sentence = format!(
        "the cycle of `{name}` in blend space `{space}` is {cm:.0} cm and {deg:.0} deg a joint apart at its seam"
    );
    let wide = b.examples.iter().filter(|e| e.seam() > 2.0).count();
    let m = measure("widest seam of a blend", e.seam(), [1.0, 2.0], sentence).fair_if(are_few(wide, b.examples.len()));
    let (widest_m, widest_deg) = WIDEST_SEAM;
    Some(m.with_advice(|| {
        vec![format!(
            "name other `frames` of `{name}`, or leave it out: steady cycles are within {:.0} cm and {widest_deg:.0} deg",
            100.0 * widest_m
        )]
    }))
}

#[cfg(test)]
mod tests;
