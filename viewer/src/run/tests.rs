//! A run against itself: played, rewound, branched.

use super::*;
use crate::bundle::OpenBundle;
use crate::fixtures::boxing::Boxing;
use crate::fixtures::golden as bundle;
use throng_runtime::Mat3x4;

fn config() -> RunConfig {
    RunConfig { characters: 20, temperature: 0.2, ..RunConfig::default() }
}

fn poses(run: &Run) -> Vec<Mat3x4> {
    run.characters().model_matrices().to_vec()
}

#[test]
fn every_recorded_step_looks_as_it_did() {
    let b = bundle();
    let mut run = Run::new(&b, config(), &[]).unwrap();
    let mut seen = vec![poses(&run)];
    for step in 1..200 {
        if step == 70 {
            run.input(Input::Target { character: None, to: Vec3::new(3.0, 0.0, -4.0) });
        }
        if step == 120 {
            run.input(Input::Play { character: 3, segment: 1 });
        }
        run.step(&b).unwrap();
        assert_eq!(run.now(), step);
        seen.push(poses(&run));
    }
    for step in [199, 0, 60, 59, 61, 120, 119, 121, 70, 69, 3, 180] {
        run.seek(&b, step).unwrap();
        assert_eq!(run.now(), step);
        assert!(poses(&run) == seen[step as usize], "step {step}");
    }
}

#[test]
fn the_same_seed_gives_the_same_run() {
    let b = bundle();
    let run = |seed| {
        let mut run = Run::new(&b, RunConfig { seed, ..config() }, &[]).unwrap();
        (0..150).for_each(|_| run.step(&b).unwrap());
        poses(&run)
    };
    assert!(run(1) == run(1));
    assert!(run(1) != run(2));
}

#[test]
fn an_input_in_the_past_replaces_what_followed() {
    let b = bundle();
    let mut run = Run::new(&b, config(), &[]).unwrap();
    (0..150).for_each(|_| run.step(&b).unwrap());
    run.seek(&b, 40).unwrap();
    let to = Vec3::new(9.0, 0.0, 9.0);
    run.input(Input::Target { character: Some(2), to });
    assert_eq!(run.head.recorded(), 0..=40);
    assert!(run.head.is_live());
    run.step(&b).unwrap();
    assert_eq!((run.now(), run.targets()[2]), (41, to));
}

#[test]
fn the_last_minute_is_recorded_and_no_more() {
    let b = bundle();
    let mut run = Run::new(&b, RunConfig { characters: 2, ..config() }, &[]).unwrap();
    run.input(Input::Weights(vec![0.5]));
    (0..RECORDED_STEPS + 500).for_each(|_| run.step(&b).unwrap());
    let kept = run.head.recorded().end() - run.head.recorded().start();
    assert!((RECORDED_STEPS..RECORDED_STEPS + 120).contains(&kept), "{kept}");
    run.seek(&b, 0).unwrap();
    assert_eq!(run.now(), *run.head.recorded().start());
    assert_eq!(run.weights(), [0.5]);
}

#[test]
fn the_reasons_of_a_choice_name_the_action_that_is_played() {
    let b = bundle();
    let mut run = Run::new(&b, RunConfig { temperature: 0.0, ..config() }, &[]).unwrap();
    (0..90).for_each(|_| run.step(&b).unwrap());
    for c in 0..20 {
        let why = run.why(&b, c).unwrap();
        // Without chance, the best candidate is taken.
        assert_eq!(why.chosen, 0);
        assert_eq!(why.candidates[0].segment, run.characters().segment(c).0);
        assert!(why.step <= run.now());
        assert!(why.candidates.is_sorted_by(|a, b| a.score >= b.score));
    }
}

fn scene(path: &std::path::Path) -> (OpenBundle, Run) {
    let scene = Scene::load(path).unwrap();
    let bundle = OpenBundle::open(&scene.bundle).unwrap();
    let run = Run::of_scene(&bundle, &scene).unwrap();
    (bundle, run)
}

fn marks(run: &Run) -> Vec<Mark> {
    run.marks(2.0).copied().collect()
}

#[test]
fn a_recorded_bout_looks_and_counts_as_it_did() {
    let boxing = Boxing::new();
    let (b, mut run) = scene(&boxing.pairs(4));
    let state = |run: &Run| (poses(run), marks(run), run.figures().bout, run.targets().to_vec());
    let mut seen = vec![state(&run)];
    for step in 1..=600 {
        if step == 130 {
            run.input(Input::Weights(vec![1.0, 0.5, 0.0]));
        }
        if step == 200 {
            run.input(Input::Play { character: 1, segment: 2 });
        }
        run.step(&b).unwrap();
        seen.push(state(&run));
    }
    let bout = run.figures().bout.unwrap();
    assert!(bout.blows.thrown > 0 && bout.penetration_m.is_some(), "{bout:?}");
    assert_eq!(bout.blows.thrown, bout.blows.landed + bout.blows.blocked + bout.blows.missed);
    for step in [600, 0, 61, 60, 131, 130, 129, 201, 199, 599, 300] {
        run.seek(&b, step).unwrap();
        assert!(state(&run) == seen[step as usize], "step {step}");
    }
    // Opponents' heads stay where they are.
    run.input(Input::Target { character: Some(0), to: Vec3::ZERO });
    assert_eq!(run.targets(), seen[300].3);
    assert_eq!(run.head.recorded(), 0..=600);
}

#[test]
fn marks_show_the_result_of_every_blow() {
    let boxing = Boxing::new();
    let (b, mut run) = scene(&boxing.pairs(6));
    (0..900).for_each(|_| run.step(&b).unwrap());
    let blows = run.figures().bout.unwrap().blows;
    let all: Vec<Mark> = run.marks(60.0).copied().collect();
    let count = |is: fn(Met) -> bool| all.iter().filter(|m| is(m.met)).count() as u32;
    let is_blocked = |m: Met| m == Met::Body(throng_runtime::sparring::Part::Arm);
    assert_eq!(all.len() as u32, blows.thrown);
    assert_eq!(count(is_blocked), blows.blocked);
    assert_eq!(count(|m| m == Met::Nothing), blows.missed);
    assert!(all.is_sorted_by_key(|m| m.step));
}

#[test]
fn a_target_gives_way_comes_back_and_hangs_where_it_is_put() {
    let boxing = Boxing::new();
    let (b, mut run) = scene(&boxing.targets(1));
    let home = run.home(0).unwrap();
    let mut furthest = 0.0f32;
    for _ in 0..1800 {
        run.step(&b).unwrap();
        assert_eq!(run.home(0), Some(home));
        furthest = furthest.max(run.targets()[0].distance(home));
    }
    assert!(run.figures().bout.unwrap().blows.landed > 0, "{:?}", run.figures().bout);
    assert!(furthest > 0.05, "{furthest}");
    let struck = run.marks(30.0).find(|m| m.met == Met::Target).unwrap().step;
    let out = |run: &mut Run, step| {
        run.seek(&b, step).unwrap();
        run.targets()[0].distance(home)
    };
    assert!(out(&mut run, struck + 10) > 0.02);
    let there = home + Vec3::new(0.4, 0.1, 0.3);
    run.seek(&b, struck).unwrap();
    run.input(Input::Target { character: Some(0), to: there });
    assert_eq!(run.home(0), Some(there));
    run.step(&b).unwrap();
    assert_eq!((run.home(0), run.now()), (Some(there), struck + 1));
}

#[test]
fn the_reasons_of_a_boxer_name_what_it_does_and_which_behaviours_did_not_count() {
    let boxing = Boxing::new();
    let (b, mut run) = scene(&boxing.pairs(8));
    let mut inactive = 0;
    for step in 0..300 {
        run.step(&b).unwrap();
        if step % 30 != 0 {
            continue;
        }
        for c in 0..8 {
            let why = run.why(&b, c).unwrap();
            assert_eq!(why.behaviours.len(), 3);
            assert_eq!(why.candidates[why.chosen].segment, run.characters().segment(c).0);
            let best = why.candidates[0].score;
            assert!(best - why.candidates[why.chosen].score < 1e-4, "character {c} at {step}");
            for s in &why.behaviours {
                let policy = b.motion_set().policy(s.policy).unwrap();
                assert_eq!(s.is_active, policy.region().contains(s.target));
                inactive += u32::from(!s.is_active);
            }
        }
    }
    assert!(inactive > 0, "nobody was ever out of reach");
}
