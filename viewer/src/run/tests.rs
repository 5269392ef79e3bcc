//! A run against itself: played, rewound, branched.

use super::*;
use crate::fixtures::golden as bundle;
use throng_core::Mat3x4;

fn config() -> CrowdRunConfig {
    CrowdRunConfig { characters: 20, temperature: 0.2, ..CrowdRunConfig::default() }
}

fn poses(run: &CrowdRun) -> Vec<Mat3x4> {
    run.characters().model_matrices().to_vec()
}

#[test]
fn every_recorded_step_looks_as_it_did() {
    let b = bundle();
    let mut run = CrowdRun::new(&b, config(), &[]).unwrap();
    let mut seen = vec![poses(&run)];
    for step in 1..200 {
        if step == 70 {
            run.input(RunInput::Target { character: None, to: Vec3::new(3.0, 0.0, -4.0) });
        }
        if step == 120 {
            run.input(RunInput::Play { character: 3, segment: 1 });
        }
        run.step(&b).unwrap();
        assert_eq!(run.shown_step(), step);
        seen.push(poses(&run));
    }
    for step in [199, 0, 60, 59, 61, 120, 119, 121, 70, 69, 3, 180] {
        run.seek(&b, step).unwrap();
        assert_eq!(run.shown_step(), step);
        assert!(poses(&run) == seen[step as usize], "step {step}");
    }
}

#[test]
fn the_same_seed_gives_the_same_run() {
    let b = bundle();
    let run = |seed| {
        let mut run = CrowdRun::new(&b, CrowdRunConfig { seed, ..config() }, &[]).unwrap();
        (0..150).for_each(|_| run.step(&b).unwrap());
        poses(&run)
    };
    assert!(run(1) == run(1));
    assert!(run(1) != run(2));
}

#[test]
fn an_input_in_the_past_replaces_what_followed() {
    let b = bundle();
    let mut run = CrowdRun::new(&b, config(), &[]).unwrap();
    (0..150).for_each(|_| run.step(&b).unwrap());
    run.seek(&b, 40).unwrap();
    let to = Vec3::new(9.0, 0.0, 9.0);
    run.input(RunInput::Target { character: Some(2), to });
    assert_eq!(run.head.recorded(), 0..=40);
    assert!(run.head.is_live());
    run.step(&b).unwrap();
    assert_eq!((run.shown_step(), run.targets()[2]), (41, to));
}

#[test]
fn the_last_minute_is_recorded_and_no_more() {
    let b = bundle();
    let mut run = CrowdRun::new(&b, CrowdRunConfig { characters: 2, ..config() }, &[]).unwrap();
    run.input(RunInput::Weights { member: 0, weights: vec![0.5] });
    (0..RECORDED_STEPS + 500).for_each(|_| run.step(&b).unwrap());
    let kept = run.head.recorded().end() - run.head.recorded().start();
    assert!((RECORDED_STEPS..RECORDED_STEPS + 120).contains(&kept), "{kept}");
    run.seek(&b, 0).unwrap();
    assert_eq!(run.shown_step(), *run.head.recorded().start());
    assert_eq!(run.weights(), [0.5]);
}

#[test]
fn the_reasons_of_a_choice_name_the_action_that_is_played() {
    let b = bundle();
    // Nobody makes way, so that nobody takes another than the best.
    let mut run = CrowdRun::new(&b, CrowdRunConfig { temperature: 0.0, avoid: false, ..config() }, &[]).unwrap();
    (0..90).for_each(|_| run.step(&b).unwrap());
    for c in 0..20 {
        let why = explain_choice(&run.chooser(&b, c).unwrap()).unwrap();
        // Without chance, the best candidate is taken.
        assert_eq!(why.chosen, 0);
        assert_eq!(why.candidates[0].segment, run.characters().segment(c).0);
        assert!(why.step <= run.shown_step());
        assert!(why.candidates.is_sorted_by(|a, b| a.score >= b.score));
    }
}
