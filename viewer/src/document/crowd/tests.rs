//! A crowd against itself: played, rewound, branched.

use super::*;
use crate::document::SceneDocument;
use crate::fixtures::golden;
use crate::run::{RunInput, SceneChoice, explain_choice, target_home};
use glam::Vec3;
use throng_core::Mat3x4;

/// Steps of the minute that is recorded.
const MINUTE: u32 = 3600;

fn crowd(characters: usize, seed: u64) -> SceneDocument {
    let choice = SceneChoice { characters, seed, ..SceneChoice::default() };
    SceneDocument::crowd_of(&Arc::new(golden()), choice).unwrap()
}

fn poses(run: &SceneRun) -> Vec<Mat3x4> {
    run.simulation().poses().flatten().flatten().copied().collect()
}

fn home(run: &SceneRun, who: usize) -> Vec3 {
    target_home(run.simulation(), who).unwrap()
}

fn steps(run: &mut SceneRun, count: u32) {
    (0..count).for_each(|_| run.step().unwrap());
}

#[test]
fn every_recorded_step_looks_as_it_did() {
    let mut run = crowd(20, 1).run;
    let mut seen = vec![poses(&run)];
    for step in 1..200 {
        if step == 70 {
            run.input(RunInput::Target { character: None, to: Vec3::new(3.0, 0.0, -4.0) }).unwrap();
        }
        if step == 120 {
            run.input(RunInput::Play { character: 3, segment: 1 }).unwrap();
        }
        run.step().unwrap();
        assert_eq!(run.head.shown_step(), step);
        seen.push(poses(&run));
    }
    for step in [199, 0, 60, 59, 61, 120, 119, 121, 70, 69, 3, 180] {
        run.seek(step).unwrap();
        assert_eq!(run.head.shown_step(), step);
        assert!(poses(&run) == seen[step as usize], "step {step}");
    }
}

#[test]
fn the_same_seed_gives_the_same_run() {
    let run = |seed| {
        let mut run = crowd(20, seed).run;
        steps(&mut run, 150);
        poses(&run)
    };
    assert!(run(1) == run(1));
    assert!(run(1) != run(2));
}

#[test]
fn a_target_moves_on_when_it_is_reached() {
    let mut run = crowd(20, 1).run;
    let mut moved = 0;
    for _ in 0..600 {
        let moved_before = moved;
        let before: Vec<Vec3> = (0..20).map(|who| home(&run, who)).collect();
        run.step().unwrap();
        for (who, before) in before.into_iter().enumerate() {
            let by = home(&run, who).distance(before);
            let root = run.simulation().root(who).unwrap().translation();
            assert_eq!(by > 0.0, root.distance(before) < 0.5, "character {who}, {by} m");
            assert!(by == 0.0 || (2.0..6.001).contains(&by), "{by} m");
            moved += usize::from(by > 0.0);
        }
        // The figures are those of the step, before any target moved on.
        assert_eq!(run.figures().at_target, Some(moved - moved_before));
    }
    assert!(moved > 20, "{moved} targets moved on");
}

#[test]
fn an_input_in_the_past_replaces_what_followed() {
    let mut run = crowd(20, 1).run;
    steps(&mut run, 150);
    run.seek(40).unwrap();
    let to = Vec3::new(9.0, 0.0, 9.0);
    run.input(RunInput::Target { character: Some(2), to }).unwrap();
    assert_eq!(run.head.recorded(), 0..=40);
    assert!(run.head.is_live());
    run.step().unwrap();
    assert_eq!((run.head.shown_step(), home(&run, 2)), (41, to));
}

#[test]
fn the_last_minute_is_recorded_and_no_more() {
    let mut document = crowd(2, 1);
    let run = &mut document.run;
    run.input(RunInput::Weights { member: 0, weights: vec![0.5] }).unwrap();
    steps(run, MINUTE + 500);
    let kept = run.head.recorded().end() - run.head.recorded().start();
    assert!((MINUTE..MINUTE + 120).contains(&kept), "{kept}");
    run.seek(0).unwrap();
    assert_eq!(run.head.shown_step(), *run.head.recorded().start());
    assert_eq!(document.weights(0).unwrap().1, [0.5]);
}

#[test]
fn the_reasons_of_a_choice_name_the_action_that_is_played() {
    for seed in 0..20 {
        // Nobody else is there to make way for, so that nobody takes another than the best.
        let mut document = crowd(1, seed);
        steps(&mut document.run, 90);
        // While it answers to a target that has moved on, it plays what it did not choose.
        let has_chosen = |document: &SceneDocument| explain_choice(&document.chooser(0).unwrap()).is_some();
        for _ in 0..240 {
            if has_chosen(&document) {
                break;
            }
            document.run.step().unwrap();
        }
        let chooser = document.chooser(0).unwrap();
        let why = explain_choice(&chooser).unwrap();
        // Without chance, the best candidate is taken.
        assert_eq!(why.chosen, 0);
        assert_eq!(why.candidates[0].segment, chooser.characters.segment(0).0);
        assert!(why.step <= document.run.head.shown_step());
        assert!(why.candidates.is_sorted_by(|a, b| a.score >= b.score));
    }
}
