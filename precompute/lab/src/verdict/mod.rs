//! Verdict on a bundle in words: how many targets characters reach, what keeps them from it, and remedies.

mod measure;

use crate::abilities::{Abilities, LITTLE_WALKING_S, played_frames, unused_clips};
use crate::frames::{of_classes, runs};
use crate::trial::{self, TrialConfig, TrialReport};
use crate::{made::made_frames, quality::clip_joints, slip::SlipMeter};
pub use measure::Measure;
use measure::{GOOD_REACH, LongestAction, SourceFeet, VerdictInputs};
use serde::Serialize;
use throng_bake::policy::{self, BehaviourKind, promise};
use throng_bake::{config::BuildConfig, examples::BlendReport, graph::TakenMotion};
use throng_core::{Bundle, characters::CharactersConfig};
use throng_motion::error::Result;
use throng_motion::stance::{self, StanceReport};

/// Most unused clips that are named.
const MAX_NAMED_CLIPS: usize = 4;
/// Number of characters of the short trial at the end of a build.
const CHARACTERS: usize = 200;

/// A verdict on a trial.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Verdict {
    /// Word of the worst measure: `good`, `fair` or `poor`.
    pub word: &'static str,
    /// Name of the worst measure; empty if all are good.
    pub worst: &'static str,
    /// The verdict and the measures, one sentence each, the worst measure first.
    pub sentences: Vec<String>,
    /// Remedies.
    pub advice: Vec<String>,
    /// All measures, each judged by its own limits.
    pub measures: Vec<Measure>,
    /// Abilities in the motion that actions play.
    pub motion: Abilities,
    /// Walking that no action plays, as it is not connected with the rest (s).
    pub walking_unused_s: f64,
    /// Mean speed of planted heels and toes in the clips themselves (m/s).
    pub source_slip_mean_mps: f64,
}

/// Runs a short trial of the first behaviour of a bundle, and judges it.
///
/// - `blends`: reports of its build on blend spaces.
/// - returns `None` for a bundle whose first behaviour does not go to a target.
///
/// # Errors
/// As [`trial::run`].
pub fn try_out(tables: &Bundle, blends: &[BlendReport]) -> Result<Option<(TrialReport, Verdict)>> {
    let config = BuildConfig::parse(&tables.meta().config, "bundle".as_ref());
    // Behaviours that the motion does not allow are not in the bundle.
    let first = tables.meta().behaviours.first();
    let is_approach =
        |c: BuildConfig| c.behaviours.iter().any(|b| Some(&b.name) == first && b.kind == BehaviourKind::Approach);
    if tables.policies().is_empty() || !config.is_ok_and(is_approach) {
        return Ok(None);
    }
    // Without avoidance, the trial only measures the motion.
    let (motion, recorded) = (CharactersConfig::default(), None);
    let config =
        TrialConfig { characters: CHARACTERS, seconds: 15.0, step_hz: 30.0, recorded, motion, ..Default::default() };
    let (report, _) = trial::run(tables, &config)?;
    let verdict = Verdict::new(tables, &report, blends);
    Ok(Some((report, verdict)))
}

impl Verdict {
    /// Judges a trial of a bundle, and the promises of its policies.
    ///
    /// - `blends`: reports of its build on blend spaces, as a bundle does not keep their seams.
    pub fn new(tables: &Bundle, trial: &TrialReport, blends: &[BlendReport]) -> Self {
        // Walking of other classes is left out on purpose.
        let is_taken = class_is_taken(tables);
        let mirrored = tables.clips().iter().any(|c| c.mirrored != 0);
        let motion = Abilities::of_played_frames(tables);
        let all = Abilities::of_frames(tables, |f| is_taken[f]);
        let [made, played] = [made_frames(tables), played_frames(tables)];
        let captured_s = |counts: &[bool]| Abilities::of_frames(tables, |f| counts[f] && !made[f]).walking_s;
        let unused_s = captured_s(&is_taken) - captured_s(&played);
        let policies = tables.meta().behaviours.iter().zip(tables.policies().iter());
        let promises =
            policies.map(|(name, table)| (name.as_str(), promise(table, name), policy::help(table))).collect();
        let (source, longest, motion) = (source_feet(tables), LongestAction::of_bundle(tables), &motion);
        let facts = VerdictInputs { trial, motion, mirrored, source, longest, promises, blends };
        let mut verdict = Self { walking_unused_s: unused_s, ..Self::from_inputs(&facts) };
        if unused_s > verdict.motion.walking_s.max(1.0) {
            let mut unused = advice_on_unused(unused_s, &unused_clips(tables), &all, mirrored);
            if trial.reached_fraction >= GOOD_REACH {
                unused.truncate(1);
            }
            // Abilities in unused clips are not missing.
            let missing = verdict.motion.missing(mirrored);
            verdict.advice.retain(|a| !missing.contains(a));
            verdict.advice.splice(..0, unused);
        }
        verdict
    }

    fn from_inputs(facts: &VerdictInputs<'_>) -> Self {
        let measures = measure::all_measures(facts);
        let rank = |m: &Measure| measure::WORDS.iter().position(|w| *w == m.word).unwrap_or(0);
        // The first of the worst ones.
        let worst = (0..measures.len()).rev().max_by_key(|&i| rank(&measures[i])).unwrap_or(0);
        let (word, name) = (measures[worst].word, measures[worst].name);
        let sentence = |(i, m): (usize, &Measure)| match m.word {
            _ if i == worst => format!("{word}: {}", m.sentence),
            "good" => m.sentence.clone(),
            other => format!("{} ({other})", m.sentence),
        };
        let mut sentences: Vec<String> =
            measures.iter().enumerate().filter(|(_, m)| m.is_reported).map(sentence).collect();
        let at = measures[..worst].iter().filter(|m| m.is_reported).count();
        sentences[..=at].rotate_right(1);
        let mut advice: Vec<String> = Vec::new();
        for a in measures.iter().flat_map(|m| &m.advice) {
            if !advice.contains(a) {
                advice.push(a.clone());
            }
        }
        let (motion, source_slip_mean_mps) = (facts.motion.clone(), facts.source.mean_mps);
        let worst = if word == "good" { "" } else { name };
        Self { word, worst, sentences, advice, motion, walking_unused_s: 0.0, source_slip_mean_mps, measures }
    }
}

/// True for every frame whose class the motion graph takes.
fn class_is_taken(tables: &Bundle) -> Vec<bool> {
    let config = BuildConfig::parse(&tables.meta().config, "bundle".as_ref());
    let take =
        config.map_or_else(|_| Vec::new(), |c| if c.select.wanted.is_empty() { c.graph.take } else { Vec::new() });
    of_classes(tables, true, |class| {
        let what = TakenMotion::of_class(class);
        take.is_empty() || take.contains(&what) || what == TakenMotion::Gestures
    })
}

/// Advice for a set of which most walking is played by no action, as it leads to no other motion.
///
/// - `all_measures`: abilities in all clips; those that are missing here are not in the unused clips either.
fn advice_on_unused(unused_s: f64, clips: &[&str], all: &Abilities, mirrored: bool) -> Vec<String> {
    let named = clip_names(clips);
    let alone = if unused_s < LITTLE_WALKING_S { "" } else { "build them alone, or " };
    let way = format!(
        "{unused_s:.0} s of walking lead to nothing else and are not used ({named}): {alone}add clips that go from \
         them to the others and back"
    );
    std::iter::once(way).chain(all.missing(mirrored)).collect()
}

/// Names of a few clips.
fn clip_names(clips: &[&str]) -> String {
    let more = if clips.len() > MAX_NAMED_CLIPS { ", ..." } else { "" };
    clips.iter().take(MAX_NAMED_CLIPS).map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ") + more
}

/// Measures planted heels and toes in the clips, and the distances of standing feet from the ground.
fn source_feet(tables: &Bundle) -> SourceFeet {
    let (clips, made, dt_s) = (tables.clips(), made_frames(tables), 1.0 / tables.meta().rate_hz as f32);
    let mut all = SlipMeter::new(1, tables.skeleton());
    let mut each = vec![(0.0, 0u64); clips.len()];
    let mut far: Vec<Vec<f32>> = vec![Vec::new(); clips.len()];
    for run in runs(tables) {
        let clip = clips.partition_point(|c| c.first_frame <= run.start).saturating_sub(1);
        if clips[clip].mirrored != 0 || made[run.start as usize..run.end as usize].contains(&true) {
            continue;
        }
        let mut one = SlipMeter::new(1, tables.skeleton());
        all.forget_step();
        let mut at = Vec::new();
        for f in run {
            let joints = clip_joints(tables, f);
            at.push(stance::FEET.map(|j| joints[j.index()].0));
            for meter in [&mut all, &mut one] {
                meter.observe_joints(0, dt_s, tables.contacts()[f as usize], |j| joints[j.index()]);
            }
        }
        let (sum, samples) = &mut each[clip];
        *sum += one.mean_mps() * one.samples() as f64;
        *samples += one.samples();
        let stands = stance::lowest_feet(at.into_iter(), tables.skeleton(), tables.meta().rate_hz);
        far[clip].extend(stance::standing_distances(&stands, tables.meta().rate_hz));
    }
    let measured = each.iter().zip(&tables.meta().clips).filter(|(e, _)| e.1 > 0);
    let mut of_clips: Vec<(String, f64)> =
        measured.map(|(&(sum, samples), meta)| (meta.name.clone(), sum / samples as f64)).collect();
    of_clips.sort_by(|a, b| b.1.total_cmp(&a.1));
    let names = tables.meta().clips.iter().map(|c| c.name.clone());
    let mut stances: Vec<(String, StanceReport)> = names
        .zip(&far)
        .filter(|(_, f)| !f.is_empty())
        .map(|(n, f)| (n, StanceReport::from_distances(f.clone())))
        .collect();
    stances.sort_by(|a, b| b.1.p95_cm.total_cmp(&a.1.p95_cm));
    // A config that keeps heights as captured implies terrain.
    let config = BuildConfig::parse(&tables.meta().config, "bundle".as_ref());
    let stance = config.is_ok_and(|c| c.retarget.align_ground).then(|| StanceReport::from_distances(far.concat()));
    SourceFeet { mean_mps: all.mean_mps(), p95_mps: all.p95_mps(), of_clips, stance, stances }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walking_that_is_not_used_is_named_with_what_all_clips_lack() {
        let all = Abilities { walking_s: 7.0, stops: 2, turn_left_deg_per_s: 12.0, ..Default::default() };
        let advice = advice_on_unused(7.0, &["a", "b", "c", "d", "e"], &all, false);
        assert!(advice[0].starts_with("7 s of walking lead to nothing else") && advice[0].contains("`d`, ..."));
        assert!(!advice[0].contains("alone"), "so little makes no set of its own: {}", advice[0]);
        for (advice, what) in advice[1..].iter().zip(["only 7 s of walking", "no start", "turns left", "turns right"]) {
            assert!(advice.starts_with(what), "{advice}");
        }
        let enough = Abilities { walking_s: 70.0, starts: 2, turn_left_deg_per_s: 90.0, ..all };
        let advice = advice_on_unused(65.0, &["a"], &enough, true);
        assert!(advice[0].contains("build them alone") && advice[1].contains("make up for it"), "{advice:?}");
        assert_eq!(advice.len(), 2);
    }
}
