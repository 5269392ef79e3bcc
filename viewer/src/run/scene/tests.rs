//! A scene against itself: played, rewound, told something, saved.

use super::*;
use crate::document::SceneDocument;
use crate::fixtures::boxing::Boxing;
use crate::fixtures::market::Market;
use crate::fixtures::meeting::Meeting;
use crate::fixtures::paces::Paces;
use crate::fixtures::quietly;
use crate::run::agents::EventFilter;
use crate::run::{BlowResult, explain_choice};
use std::path::Path;
use throng_core::NUM_JOINTS;

fn open(path: &Path) -> SceneDocument {
    quietly(|with| SceneDocument::open(path, with)).unwrap()
}

fn steps(run: &mut SceneRun, count: u32) {
    (0..count).for_each(|_| run.step().unwrap());
}

/// Places of all characters and joints, as bits.
fn poses(run: &SceneRun) -> Vec<u32> {
    let simulation = run.simulation();
    let joints = |who| simulation.joint_positions(who).into_iter().flatten();
    let points = (0..simulation.num_characters()).flat_map(|who| run.place(who).into_iter().chain(joints(who)));
    points.flat_map(|p| p.to_array()).map(f32::to_bits).collect()
}

fn targets(run: &SceneRun) -> Vec<Option<Vec3>> {
    (0..run.simulation().num_characters()).map(|who| run.simulation().target(who)).collect()
}

fn home(run: &SceneRun) -> Vec3 {
    let AnyCharacterGroup::Policy(practice) = &run.simulation().character_groups()[0] else { panic!("no targets") };
    practice.practice().targets()[0].home
}

#[test]
fn a_recorded_bout_looks_and_counts_as_it_did() {
    let boxing = Boxing::new();
    let mut document = open(&boxing.pairs(4));
    let run = &mut document.run;
    let marks = |run: &SceneRun| run.blow_marks(2.0).copied().collect::<Vec<_>>();
    let state = |run: &SceneRun| {
        let f = run.figures();
        (poses(run), marks(run), f.bout, f.slip, targets(run))
    };
    let mut seen = vec![state(run)];
    for step in 1..=600 {
        if step == 130 {
            run.input(RunInput::Weights { member: 2, weights: vec![1.0, 0.5, 0.0] }).unwrap();
        }
        if step == 200 {
            run.input(RunInput::Play { character: 1, segment: 2 }).unwrap();
        }
        run.step().unwrap();
        seen.push(state(run));
    }
    let bout = run.figures().bout.unwrap();
    assert!(bout.blows.thrown > 0 && bout.penetration_m.is_some(), "{bout:?}");
    assert_eq!(bout.blows.thrown, bout.blows.landed + bout.blows.blocked + bout.blows.missed);
    for step in [600, 0, 61, 60, 131, 130, 201, 599, 300] {
        run.seek(step).unwrap();
        assert!(state(run) == seen[step as usize], "step {step}");
    }
    // Opponents' heads stay where they are.
    run.input(RunInput::Target { character: Some(0), to: Vec3::ZERO }).unwrap();
    assert!(targets(run) == seen[300].4);
    assert_eq!(run.head.recorded(), 0..=300);
}

#[test]
fn marks_show_the_result_of_every_blow() {
    let boxing = Boxing::new();
    let mut document = open(&boxing.pairs(6));
    let run = &mut document.run;
    steps(run, 900);
    let blows = run.figures().bout.unwrap().blows;
    let all: Vec<BlowMark> = run.blow_marks(60.0).copied().collect();
    let count = |is: fn(BlowResult) -> bool| all.iter().filter(|m| is(m.result)).count() as u32;
    assert_eq!(all.len() as u32, blows.thrown);
    assert_eq!(count(|m| matches!(m, BlowResult::Body(_))), blows.landed + blows.blocked);
    assert_eq!(count(|m| m == BlowResult::Nothing), blows.missed);
    assert!(all.is_sorted_by(|a, b| a.step >= b.step));
}

#[test]
fn a_target_gives_way_comes_back_and_hangs_where_it_is_put() {
    let boxing = Boxing::new();
    let mut document = open(&boxing.targets(1));
    let run = &mut document.run;
    let at_rest = home(run);
    let mut furthest = 0.0f32;
    for _ in 0..1800 {
        run.step().unwrap();
        assert_eq!(home(run), at_rest);
        furthest = furthest.max(targets(run)[0].unwrap().distance(at_rest));
    }
    assert!(run.figures().bout.unwrap().blows.landed > 0, "{:?}", run.figures().bout);
    assert!(furthest > 0.05, "{furthest}");
    let struck = run.blow_marks(30.0).find(|m| m.result == BlowResult::Target).unwrap().step;
    run.seek(struck.saturating_add(10).min(1800)).unwrap();
    run.seek(struck).unwrap();
    let there = at_rest + Vec3::new(0.4, 0.1, 0.3);
    run.input(RunInput::Target { character: Some(0), to: there }).unwrap();
    assert_eq!(home(run), there);
    run.step().unwrap();
    assert_eq!((home(run), run.head.shown_step()), (there, struck + 1));
    // Going back before the input and on again repeats it.
    run.seek(struck.saturating_sub(1)).unwrap();
    assert_eq!(home(run), at_rest);
    run.seek(struck + 1).unwrap();
    assert_eq!(home(run), there);
}

#[test]
fn the_reasons_of_a_boxer_name_what_it_does_and_which_behaviours_did_not_count() {
    let boxing = Boxing::new();
    let mut document = open(&boxing.pairs(8));
    let (mut inactive, mut best_taken, mut not_chosen) = (0, 0, 0);
    for step in 0..300 {
        document.run.step().unwrap();
        if step % 30 != 0 {
            continue;
        }
        for c in 0..8 {
            let chooser = document.chooser(c).unwrap();
            // Who is struck may step away by a segment that it did not choose.
            let Some(why) = explain_choice(&chooser) else {
                not_chosen += 1;
                continue;
            };
            assert_eq!(why.behaviours.len(), 3);
            assert_eq!(why.candidates[why.chosen].segment, chooser.characters.segment(c).0);
            let best = why.candidates[0].score;
            // What would lead into the opponent is not taken.
            let is_best = best - why.candidates[why.chosen].score < 1e-4;
            best_taken += u32::from(is_best);
            let opponent = chooser.characters.root(c ^ 1);
            let apart = (opponent.x - why.root.x).hypot(opponent.z - why.root.z);
            assert!(is_best || apart < 1.5, "character {c} at {step}: {apart} m");
            for s in &why.behaviours {
                let policy = chooser.bundle.motion_set.policy(s.policy).unwrap();
                assert_eq!(s.is_active, policy.region().contains(s.target));
                inactive += u32::from(!s.is_active);
            }
        }
    }
    assert!(inactive > 0, "no target was ever out of reach");
    assert!(best_taken > 40 && not_chosen <= 4, "{best_taken} and {not_chosen} of 80");
    assert_eq!(document.weights(3).unwrap().0, ["approach", "throw-punches", "evade"]);
}

#[test]
fn people_on_their_way_are_played_with_their_walls() {
    let boxing = Boxing::new();
    let mut document = open(&boxing.travellers(4));
    assert_eq!(document.surroundings.obstacles.len(), 1);
    let run = &mut document.run;
    steps(run, 60);
    let seen = poses(run);
    run.seek(10).unwrap();
    assert!(poses(run) != seen);
    run.seek(60).unwrap();
    assert!(poses(run) == seen && document.chooser(2).is_none());
}

#[test]
fn walkers_on_hills_are_played_and_rewound() {
    let paces = Paces::new();
    let mut document = open(&paces.scene(7, 0.5));
    assert!(document.surroundings.has_hills && document.surroundings.meshes.len() == 3);
    let run = &mut document.run;
    steps(run, 90);
    let seen = poses(run);
    assert!(seen.len() == 7 * 3 * (NUM_JOINTS + 1));
    run.seek(10).unwrap();
    assert!(poses(run) != seen);
    run.seek(90).unwrap();
    assert!(poses(run) == seen && run.trail(2, 1.0).count() > 8);
}

#[test]
fn agents_are_measured_and_their_events_logged() {
    let meeting = Meeting::new();
    let mut document = open(&meeting.scene(12));
    let run = &mut document.run;
    run.log.watch(Some(3));
    steps(run, 240);
    let figures = run.figures().agents.unwrap();
    assert!(figures.present == 24 && figures.overlaps == 0 && figures.progress_mps > 0.3, "{figures:?}");
    let all = EventFilter::of_kinds([true; AgentEventKind::COUNT]);
    let log = &run.log;
    let of_one = log.last_of_watched(&all, 9.0, 999);
    assert!(!of_one.is_empty() && of_one.iter().all(|h| h.is_about(3)));
    assert!(log.last(&all, 2.0, 99).iter().all(|h| h.time_s <= 2.0 && h.at.is_finite()));
    assert!(log.rates.totals(9.0).iter().sum::<u64>() > 100);
    // What is told in the past drops what came after it.
    run.seek(120).unwrap();
    run.input(RunInput::Target { character: None, to: Vec3::ZERO }).unwrap();
    assert!(run.log.last(&all, 9.0, 99).iter().all(|h| h.time_s <= 2.0));
    steps(run, 10);
    assert_eq!(run.head.recorded(), 0..=130);
}

/// What agents came to, and who knows what, in words.
fn brains_of(run: &SceneRun) -> String {
    let brains = run.simulation().brains().unwrap();
    let of = |agent: usize| (brains.states_of(agent), [0, 1, 2].map(|level| run.entry(agent, level)));
    let known = |e| run.spread.times(e).iter().filter(|t| **t <= run.simulation().time_s()).count();
    let all: Vec<_> = (0..brains.len()).map(of).collect();
    format!("{all:?} {:?}", [0, 1].map(known))
}

#[test]
fn what_agents_came_to_is_the_same_whichever_way_a_moment_is_shown() {
    let market = Market::new();
    let mut document = open(&market.scene(24));
    let run = &mut document.run;
    let mut seen = vec![brains_of(run)];
    for _ in 0..360 {
        run.step().unwrap();
        seen.push(brains_of(run));
    }
    for step in [200, 30, 359, 0, 61, 360] {
        run.seek(step).unwrap();
        assert!(brains_of(run) == seen[step as usize], "step {step}");
    }
    let brains = run.simulation().brains().unwrap();
    let sale = brains.event_names().iter().position(|e| e == "sale").unwrap();
    let times = run.spread.times(sale);
    assert!(times.len() > 2 && times.is_sorted() && times[..2] == [1.0, 1.0], "{times:?}");
    assert_eq!(times.len(), brains.event_spreads()[sale].informed);
    // Whoever shops came there by the first edge, and all below is gone; who strolls, by none or the one back.
    let now = |agent: usize| brains.states_of(agent)[0].unwrap().state;
    let shopping = (0..24).find(|a| now(*a) == "shop").expect("somebody shops");
    let entry = run.entry(shopping, 0).unwrap();
    let (edge, at_s) = entry.edge.unwrap();
    assert!(edge == 0 && entry.since_s == Some(at_s) && at_s >= 1.0, "{entry:?}");
    assert_eq!(brains.states_of(shopping)[1], None);
    // What is listed is what is known.
    let kinds = AgentEventKind::all().map(|what| what == AgentEventKind::Learnt);
    let listed = run.log.last(&EventFilter { message: Some(sale), ..EventFilter::of_kinds(kinds) }, 9.0, 999);
    assert_eq!(listed.len(), times.len());
    assert!(
        listed
            .iter()
            .any(|h| matches!(h.other_party, OtherParty::Message("passed_on", Some(_))) && h.other_at.is_some())
    );
}

#[test]
fn an_event_in_the_past_changes_what_spreads_from_there_on() {
    let market = Market::new();
    let mut document = open(&market.scene(12));
    let run = &mut document.run;
    steps(run, 240);
    let later = run.spread.times(1).len();
    run.seek(30).unwrap();
    run.input(RunInput::Event("sale".into())).unwrap();
    assert_eq!(run.spread.times(1), [0.5, 0.5]);
    let all = EventFilter::of_kinds([true; AgentEventKind::COUNT]);
    assert!(run.log.last(&all, 9.0, 999).iter().any(|h| h.kind == AgentEventKind::Learnt && h.message == Some(1)));
    let now = brains_of(run);
    steps(run, 100);
    assert!(later >= 2 && run.spread.times(1).len() >= 2);
    run.seek(30).unwrap();
    assert!(brains_of(run) == now, "the input is repeated");
}

#[test]
fn a_saved_scene_goes_on_as_before() {
    let (meeting, boxing) = (Meeting::new(), Boxing::new());
    for path in [meeting.scene(6), meeting.flock(6), boxing.pairs(2), boxing.targets(2)] {
        let mut document = open(&path);
        steps(&mut document.run, 97);
        let bytes = document.run.simulation().snapshot();
        let compiled = document.run.simulation().compiled().clone();
        steps(&mut document.run, 50);
        let mut again = SceneRun::new(&compiled, Some(&bytes), false).unwrap();
        assert_eq!(again.head.recorded(), 97..=97);
        steps(&mut again, 50);
        assert!(poses(&again) == poses(&document.run), "{}", path.display());
        again.seek(97).unwrap();
        again.seek(147).unwrap();
        assert!(poses(&again) == poses(&document.run), "{}", path.display());
    }
}
