//! What a bundle is worth, in words: how many targets characters reach, what keeps them from it, and what would mend it.

use crate::abilities::{Abilities, LITTLE_WALKING_S, unused_clips};
use crate::matching::runs;
use crate::quality::clip_joints;
use crate::slip::{Feet, SlipMeter};
use crate::trial::{self, Share, TrialConfig, TrialReport};
use serde::Serialize;
use throng_bake::config::BuildConfig;
use throng_bake::policy::BehaviourKind;
use throng_motion::error::BuildError;
use throng_runtime::Bundle;
use throng_runtime::characters::CharactersConfig;

/// Reached by as many, targets are well within reach.
const GOOD: f64 = 0.95;
/// Reached by fewer, they are not.
const FAIR: f64 = 0.8;
/// A group of targets that falls behind the mean by this is named.
const BEHIND: f64 = 0.1;
/// Groups of fewer characters say little.
const FEW: usize = 10;
/// Who stands for more of its way is held up by others.
const STOPPED: f64 = 0.25;
/// A character that chooses no oftener is deaf (s).
const DEAF_S: f64 = 4.0;
/// Feet that slip so many times as fast as those of the clips are worth a word.
const SLIPPERY: f64 = 1.5;
/// Unused clips that are named.
const NAMED: usize = 4;
/// Characters of the short trial that a build ends with.
const CHARACTERS: usize = 200;

/// A verdict on a trial.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Verdict {
    /// `good`, `fair` or `poor`, by the share of the targets that are reached.
    pub word: &'static str,
    /// The verdict and its reasons, one sentence each.
    pub sentences: Vec<String>,
    /// What would mend it.
    pub advice: Vec<String>,
    /// What the motion shows that actions play.
    pub motion: Abilities,
    /// Walking that no action plays, as it does not hang together with the rest (s).
    pub walking_unused_s: f64,
    /// Mean speed of planted heels and toes in the clips themselves (m/s).
    pub source_slip_mean_mps: f64,
}

/// Tries the first behaviour of a bundle for a moment, and judges it.
///
/// - returns nothing for a bundle whose first behaviour goes to no target.
///
/// # Errors
/// As [`trial::run`].
pub fn try_out(tables: &Bundle) -> Result<Option<(TrialReport, Verdict)>, BuildError> {
    let is_approach = |c: BuildConfig| c.behaviours.first().is_some_and(|b| b.kind == BehaviourKind::Approach);
    let config = BuildConfig::parse(&tables.meta().config, "bundle".as_ref());
    if tables.policies().is_empty() || !config.is_ok_and(is_approach) {
        return Ok(None);
    }
    // What the motion can do shows where nobody is in the way.
    let motion = CharactersConfig::default();
    let config = TrialConfig {
        characters: CHARACTERS,
        seconds: 15.0,
        step_hz: 30.0,
        recorded: None,
        motion,
        ..TrialConfig::default()
    };
    let (report, _) = trial::run(tables, &config)?;
    let verdict = Verdict::new(tables, &report);
    Ok(Some((report, verdict)))
}

impl Verdict {
    /// Judges a trial of a bundle.
    pub fn new(tables: &Bundle, trial: &TrialReport) -> Self {
        let mirrored = tables.clips().iter().any(|c| c.mirrored != 0);
        let (motion, all) = (Abilities::of_played(tables), Abilities::of_bundle(tables));
        let unused_s = all.walking_s - motion.walking_s;
        let mut verdict = Self { walking_unused_s: unused_s, ..Self::of(trial, motion, mirrored, source_slip(tables)) };
        if trial.reached_fraction < GOOD && unused_s > verdict.motion.walking_s {
            verdict.advice = of_unused(unused_s, &unused_clips(tables), &all, mirrored);
        }
        verdict
    }

    fn of(trial: &TrialReport, motion: Abilities, mirrored: bool, source_slip_mean_mps: f64) -> Self {
        let (reached, percent) = (trial.reached_fraction, |share: f64| format!("{:.0} %", 100.0 * share));
        let word = match reached {
            GOOD.. => "good",
            FAIR.. => "fair",
            _ => "poor",
        };
        let after = trial.mean_arrival_s.map_or(String::new(), |s| format!(", {s:.1} s on average"));
        let mut sentences = vec![format!(
            "{word}: {} of the targets were reached within {:.0} s{after}",
            percent(reached),
            trial.simulated_s
        )];
        for shares in [&trial.reached_by_direction, &trial.reached_by_distance] {
            if let Some(s) = worst(shares).filter(|s| s.reached_fraction < reached - BEHIND) {
                sentences.push(format!("of those {}: {}", s.targets, percent(s.reached_fraction)));
            }
        }
        let standing = trial.standing_fraction;
        if trial.stayed_fraction * trial.characters as f64 >= FEW as f64 {
            sentences.push(match standing {
                0.5.. => format!("{} of those who stayed there stand still", percent(standing)),
                _ => {
                    format!("only {} of those who stayed there stand still; the others go on moving", percent(standing))
                }
            });
        }
        if trial.stopped_share > STOPPED {
            let share = percent(trial.stopped_share);
            sentences.push(format!("on their way they stand for {share} of the time, as others are in it"));
        }
        let wait = trial.longest_wait_s;
        sentences.push(format!("a character waits {wait:.1} s for its next choice at the longest"));
        let ratio = trial.foot_slip_mean_mps / source_slip_mean_mps.max(1e-6);
        if source_slip_mean_mps > 0.0 {
            let [here, there] = [trial.foot_slip_mean_mps, source_slip_mean_mps].map(|mps| 1000.0 * mps);
            sentences.push(format!(
                "planted feet slip {here:.0} mm/s, {ratio:.1} times as fast as in the clips ({there:.0})"
            ));
        }
        let mut advice = Vec::new();
        if reached < GOOD || standing < 0.5 {
            advice.extend(motion.missing(mirrored));
        }
        if wait > DEAF_S {
            let out = "add clips of walking that are short, or that begin and end as the others do";
            advice.push(format!("for {wait:.0} s a character heeds nothing: {out}"));
        }
        if ratio > SLIPPERY && source_slip_mean_mps > 0.0 {
            let out = "add clips that lie between the poses of the others, so that nearer ones can follow each other";
            advice.push(format!("feet slip where clips are joined: {out}"));
        }
        if reached < GOOD && advice.is_empty() {
            let out = "add clips that walk, turn and stop in one take, so that all of them hang together";
            advice.push(format!("the motion shows all that is needed, in clips that do not lead to each other: {out}"));
        }
        Self { word, sentences, advice, motion, walking_unused_s: 0.0, source_slip_mean_mps }
    }
}

/// What would mend a set most of whose walking no action plays, for that leads to nothing else.
///
/// - `all`: what its clips show together: what they lack, the unused ones do not mend.
fn of_unused(unused_s: f64, clips: &[&str], all: &Abilities, mirrored: bool) -> Vec<String> {
    let more = if clips.len() > NAMED { ", ..." } else { "" };
    let named = clips.iter().take(NAMED).map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ");
    let alone = if unused_s < LITTLE_WALKING_S { "" } else { "build them alone, or " };
    let way = format!(
        "{unused_s:.0} s of walking lead to nothing else and are not used ({named}{more}): {alone}add clips that go from \
         them to the others and back"
    );
    std::iter::once(way).chain(all.missing(mirrored)).collect()
}

/// The group whose targets are reached least.
fn worst(shares: &[Share]) -> Option<&Share> {
    let enough = shares.iter().filter(|s| s.characters >= FEW);
    enough.min_by(|a, b| a.reached_fraction.total_cmp(&b.reached_fraction))
}

/// Mean speed of planted heels and toes in the clips (m/s).
fn source_slip(tables: &Bundle) -> f64 {
    let clips = tables.clips();
    let mut slip = SlipMeter::new(1);
    for run in runs(tables) {
        if clips[clips.partition_point(|c| c.first_frame <= run.start).saturating_sub(1)].mirrored != 0 {
            continue;
        }
        slip.forget_step();
        for f in run {
            let joints = clip_joints(tables, f);
            let feet = Feet::joints(|j| joints[j.index()].0);
            slip.observe(0, 1.0 / tables.meta().rate_hz as f32, tables.contacts()[f as usize], feet);
        }
    }
    slip.mean_mps()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn share(targets: &str, reached_fraction: f64) -> Share {
        Share { targets: targets.into(), characters: 50, reached_fraction }
    }

    #[test]
    fn walking_that_is_not_used_is_named_with_what_all_clips_lack() {
        let all = Abilities { walking_s: 7.0, stops: 2, turn_left_deg_per_s: 12.0, ..Default::default() };
        let advice = of_unused(7.0, &["a", "b", "c", "d", "e"], &all, false);
        assert!(advice[0].starts_with("7 s of walking lead to nothing else") && advice[0].contains("`d`, ..."));
        assert!(!advice[0].contains("alone"), "so little makes no set of its own: {}", advice[0]);
        for (advice, what) in advice[1..].iter().zip(["only 7 s of walking", "no start", "turns left", "turns right"]) {
            assert!(advice.starts_with(what), "{advice}");
        }
        let enough = Abilities { walking_s: 70.0, starts: 2, turn_left_deg_per_s: 90.0, ..all };
        let advice = of_unused(65.0, &["a"], &enough, true);
        assert!(advice[0].contains("build them alone") && advice[1].contains("make up for it"), "{advice:?}");
        assert_eq!(advice.len(), 2);
    }

    #[test]
    fn a_poor_trial_says_where_and_why_and_what_would_mend_it() {
        let motion =
            Abilities { walking_s: 60.0, turn_left_deg_per_s: 90.0, turn_right_deg_per_s: 90.0, ..Default::default() };
        let trial = TrialReport {
            simulated_s: 15.0,
            reached_fraction: 0.6,
            stayed_fraction: 0.5,
            standing_fraction: 0.1,
            longest_wait_s: 8.2,
            foot_slip_mean_mps: 0.3,
            reached_by_direction: vec![share("ahead", 0.9), share("behind", 0.3)],
            reached_by_distance: vec![share("2 to 3 m", 0.55)],
            ..TrialReport::default()
        };
        let verdict = Verdict::of(&trial, motion.clone(), false, 0.1);
        assert_eq!(verdict.word, "poor");
        let (told, advice) = (verdict.sentences.join("\n"), verdict.advice.join("\n"));
        assert!(told.contains("poor: 60 % of the targets were reached within 15 s"), "{told}");
        assert!(told.contains("of those behind: 30 %") && !told.contains("2 to 3 m"), "{told}");
        assert!(told.contains("3.0 times as fast as in the clips (100)"), "{told}");
        for part in ["no stop", "for 8 s a character heeds nothing", "feet slip where clips are joined"] {
            assert!(advice.contains(part), "{advice}");
        }
        let able = Abilities { stops: 3, starts: 3, ..motion };
        let whole = Verdict::of(&TrialReport { longest_wait_s: 1.0, ..trial }, able.clone(), false, 0.3);
        assert!(whole.advice[0].contains("do not lead to each other"), "{whole:?}");
        let good = TrialReport { reached_fraction: 0.99, standing_fraction: 0.9, ..TrialReport::default() };
        let good = Verdict::of(&good, able, false, 0.3);
        assert!(good.word == "good" && good.advice.is_empty(), "{good:?}");
    }
}
