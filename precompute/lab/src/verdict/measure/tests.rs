//! Each measure by itself, and all of them together.

use super::super::Verdict;
use super::*;
use crate::quality::MotionQuality;

fn share(targets: &str, reached_fraction: f64) -> ReachShare {
    ReachShare { targets: targets.into(), characters: 50, reached_fraction }
}

/// Motion that lacks nothing.
fn able() -> Abilities {
    let [turn_left_deg_per_s, turn_right_deg_per_s] = [90.0; 2];
    Abilities {
        walking_s: 60.0,
        stops: 3,
        starts: 3,
        turn_left_deg_per_s,
        turn_right_deg_per_s,
        ..Abilities::default()
    }
}

/// A trial in which all is well.
fn fine() -> TrialReport {
    TrialReport {
        characters: 200,
        simulated_s: 15.0,
        reached_fraction: 0.99,
        stayed_fraction: 0.98,
        standing_fraction: 0.9,
        longest_wait_s: 1.0,
        foot_slip_mean_mps: 0.02,
        ..TrialReport::default()
    }
}

/// The verdict on a fine trial of able motion, but for what `edit` makes of it.
fn verdict(edit: impl FnOnce(&mut TrialReport, &mut Abilities, &mut Rest)) -> Verdict {
    let (mut trial, mut motion, mut rest) = (fine(), able(), Rest { source_slip_mps: 0.03, ..Rest::default() });
    edit(&mut trial, &mut motion, &mut rest);
    let of_clips = vec![("slider".to_owned(), 0.5), ("walker".to_owned(), 0.01)];
    let promises = rest.promises.iter().map(|(name, p)| (*name, p.clone(), "set more rings".to_owned())).collect();
    Verdict::from_inputs(&VerdictInputs {
        trial: &trial,
        motion: &motion,
        mirrored: false,
        source: SourceFeet {
            mean_mps: rest.source_slip_mps,
            p95_mps: rest.source_slip_p95_mps,
            of_clips,
            stance: Some(StanceReport::from_distances(vec![rest.far_m; 20])),
            stances: vec![("floater".to_owned(), StanceReport::from_distances(vec![rest.far_m; 20]))],
        },
        longest: Some(LongestAction { clip: "long".into(), seconds: 8.0, is_alone: rest.is_alone }),
        promises,
        blends: &rest.blends,
    })
}

/// What else is known.
#[derive(Default)]
struct Rest {
    source_slip_mps: f64,
    source_slip_p95_mps: f64,
    far_m: f32,
    is_alone: bool,
    promises: Vec<(&'static str, Promise)>,
    blends: Vec<BlendReport>,
}

#[test]
fn a_poor_trial_says_where_and_why_and_what_would_mend_it() {
    let verdict = verdict(|trial, motion, rest| {
        trial.reached_fraction = 0.6;
        trial.standing_fraction = 0.1;
        trial.longest_wait_s = 8.2;
        trial.foot_slip_mean_mps = 0.3;
        trial.reached_by_direction = vec![share("ahead", 0.9), share("behind", 0.3)];
        trial.reached_by_distance = vec![share("2 to 3 m", 0.55)];
        (motion.stops, motion.starts, rest.source_slip_mps) = (0, 0, 0.1);
    });
    assert_eq!((verdict.word, verdict.worst), ("poor", "targets reached"));
    let (sentence, advice) = (verdict.sentences.join("\n"), verdict.advice.join("\n"));
    assert!(sentence.starts_with("poor: 60 % of the targets were reached within 15 s"), "{sentence}");
    assert!(sentence.contains("of those behind: 30 % (poor)") && !sentence.contains("2 to 3 m"), "{sentence}");
    assert!(sentence.contains("3.0 times as fast as in the clips (100) (poor)"), "{sentence}");
    for part in ["no stop", "for 8 s a character makes no choice", "feet slip where clips are joined"] {
        assert!(advice.contains(part), "{advice}");
    }
}

#[test]
fn a_good_trial_is_good_and_needs_no_advice() {
    let good = verdict(|_, _, _| {});
    assert!((good.word, good.worst) == ("good", "") && good.advice.is_empty(), "{good:?}");
    assert!(good.sentences[0].starts_with("good: 99 % of the targets"), "{good:?}");
    // Slow feet are still, however still those of the clips are.
    assert_eq!(verdict(|t, _, r| (t.foot_slip_mean_mps, r.source_slip_mps) = (0.029, 0.002)).word, "good");
}

/// Each measure by itself makes the verdict, is named by it, comes first, and has advice where there is any.
#[test]
fn the_verdict_is_that_of_the_worst_measure() {
    let promise = |kept, kept_p05| Promise { kept: Some(kept), kept_p05: Some(kept_p05), ..Promise::default() };
    let seam = |closing_m, closing_deg: f64| {
        let e = ExampleReport {
            name: "trot".into(),
            closing_m,
            closing_rad: closing_deg.to_radians(),
            ..Default::default()
        };
        vec![BlendReport { name: "ahead".into(), examples: vec![ExampleReport::default(), e], ..Default::default() }]
    };
    let toes =
        |mps| MotionQuality { toe_speed_low_p95_mps: mps, source_toe_speed_low_p95_mps: 0.1, ..Default::default() };
    let check = |v: Verdict, word: &str, worst: &str, sentence: &str, advice: &str| {
        assert_eq!((v.word, v.worst), (word, worst), "{v:?}");
        let first = &v.sentences[0];
        assert!(first.starts_with(&format!("{word}: ")) && first.contains(sentence), "{first}");
        assert!(advice.is_empty() || v.advice.iter().any(|a| a.contains(advice)), "{:?}", v.advice);
        assert!(v.sentences.iter().any(|s| s.contains("% of the targets were")), "{v:?}");
    };
    check(verdict(|t, _, _| t.reached_fraction = 0.85), "fair", "targets reached", "85 %", "lead to each other");
    let back = |t: &mut TrialReport, share| t.quality.apart.backwards_share = share;
    check(verdict(|t, _, _| back(t, 0.47)), "poor", "going backwards", "47 %", "costs.backwards");
    check(verdict(|t, _, _| back(t, 0.1)), "fair", "going backwards", "10 %", "costs.backwards");
    let moody = |t: &mut TrialReport| t.quality.apart.manner_changes_per_min = 18.0;
    check(verdict(|t, _, _| moody(t)), "poor", "changes of manner (1/min)", "18.0 times", "manner_change_s");
    let crowd = |t: &mut TrialReport| (t.avoiding, t.reached_fraction) = (true, 0.85);
    check(verdict(|t, _, _| crowd(t)), "fair", "targets reached", "15 s", "others were in the way");
    let behind = |t: &mut TrialReport| t.reached_by_direction = vec![share("behind", 0.4)];
    check(verdict(|t, _, _| behind(t)), "poor", "targets of the worst direction", "behind: 40 %", "");
    check(verdict(|t, _, _| t.standing_fraction = 0.0), "fair", "standing at targets", "only 0 %", "come to stand");
    check(
        verdict(|t, _, _| t.stayed_fraction = 0.01),
        "poor",
        "staying at targets",
        "only 1 % of those who came",
        "stand",
    );
    let back = |m: &mut Abilities| m.backwards_s = 50.0;
    check(verdict(|_, m, _| back(m)), "poor", "walking backwards", "83 % of the walking", "`import.forward`");
    check(verdict(|t, _, _| t.stopped_share = 0.5), "fair", "standing on the way", "50 % of the time", "");
    let wait = "longest wait for a choice (s)";
    check(verdict(|t, _, _| t.longest_wait_s = 9.0), "poor", wait, "waits 9.0 s", "8.0 s of `long`: lower `graph.max");
    // The longest action takes 8 s: whoever waits for 12 is held up.
    let held_up = |t: &mut TrialReport, s| (t.avoiding, t.longest_wait_s) = (true, s);
    check(verdict(|t, _, _| held_up(t, 9.0)), "poor", wait, "waits 9.0 s", "8.0 s of `long`: lower `graph.max");
    check(verdict(|t, _, _| held_up(t, 12.0)), "poor", wait, "waits 12.0 s", "others hold it up");
    check(verdict(|t, _, _| t.foot_slip_mean_mps = 0.06), "fair", "foot slip (m/s)", "2.0 times", "between the poses");
    let source = "foot slip in the clips (m/s)";
    check(verdict(|_, _, r| r.source_slip_mps = 0.7), "poor", source, "700 mm/s", "`slider` 500, `walker` 10 mm/s");
    let far = "feet from the ground (cm)";
    check(verdict(|_, _, r| r.far_m = 0.04), "fair", far, "up to 4.0 cm", "farthest in `floater` 4 cm");
    check(verdict(|_, _, r| r.far_m = 0.12), "poor", far, "12.0 cm at worst", "level the floor");
    let low = "low toes, 95th percentile (m/s)";
    check(verdict(|t, _, _| t.quality = toes(1.2)), "fair", low, "up to 1.20 m/s (0.10", "alike");
    let kept = |p| verdict(|_, _, r| r.promises = vec![("ok", promise(1.0, 0.9)), ("punch", p)]);
    check(kept(promise(0.3, 0.2)), "poor", "promises kept", "`punch` collects 30 %", "`punch`: set more rings");
    let p05 = "promises kept, 5th percentile";
    check(kept(promise(1.2, 0.02)), "fair", p05, "`punch` collects 2 %", "`punch`: set more rings");
    assert_eq!(kept(promise(1.2, 0.2)).word, "good");
    let widest = "widest seam of a blend";
    let of = |blends| verdict(|_, _, r| r.blends = blends);
    check(of(seam(0.17, 1.0)), "fair", widest, "`trot` in blend space `ahead` is 17 cm", "other `frames` of `trot`");
    check(of(seam(0.01, 20.0)), "poor", widest, "20 deg", "leave it out");
    assert_eq!(of(seam(0.09, 5.0)).word, "good");
}

#[test]
fn motion_that_skates_is_told_however_little_it_gets_worse() {
    let skates = verdict(|t, _, r| (t.foot_slip_mean_mps, r.source_slip_mps) = (0.15, 0.15));
    let word = |name: &str| skates.measures.iter().find(|m| m.name == name).unwrap().word;
    assert_eq!((word("foot slip (m/s)"), word("foot slip in the clips (m/s)")), ("fair", "fair"), "{skates:?}");
    let skates = verdict(|_, _, r| r.source_slip_p95_mps = 0.236);
    assert_eq!((skates.word, skates.worst), ("fair", "foot slip in the clips, 95th percentile (m/s)"));
    assert!(skates.sentences[0].contains("slips 236 mm/s or more") && !skates.advice.is_empty(), "{skates:?}");
}

#[test]
fn one_bad_clip_of_many_does_not_make_a_library_poor() {
    assert!(are_few(1, 4) && are_few(2, 20) && !are_few(1, 2) && !are_few(3, 20));
    let alone = verdict(|t, _, r| (t.longest_wait_s, r.is_alone) = (9.0, true));
    assert_eq!((alone.word, alone.worst), ("fair", "longest wait for a choice (s)"));
    assert!(alone.advice[0].contains("8.0 s of `long`"), "{:?}", alone.advice);
}

#[test]
fn others_are_blamed_only_where_the_motion_lacks_nothing() {
    let crowd =
        |stops| verdict(|t, m, _| (t.avoiding, t.reached_fraction, m.stops) = (true, 0.85, stops)).advice.join("\n");
    assert!(crowd(3).contains("others were in the way"));
    assert!(crowd(0).contains("no stop") && !crowd(0).contains("others"), "{}", crowd(0));
}
