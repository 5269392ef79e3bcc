//! A crowd that several ranks move, against one that one process moves.

use super::drive::{Drive, Shares, crossing};
use crate::events::engine::Engine;
use crate::events::shared::SharedEngine;
use crate::*;
use glam::{Vec2, Vec3};
use proptest::prelude::*;
use throng_base::{Comm, LocalComm, SingleRank};

/// State after some time, and how many agents were handed over and overlapped.
fn shared<V: Space>(setup: &CrowdSetup<V>, num_ranks: usize, times: &[f64]) -> (Vec<u8>, u64, u64) {
    let mut all = LocalComm::run(num_ranks, |comm| {
        let mut part = SharedEngine::new(Engine::new(setup.clone()).unwrap(), comm).unwrap();
        let mut overlaps = 0;
        for &time in times {
            part.advance(time, comm).unwrap();
            overlaps += part.num_overlapping();
            let all = comm.sum(part.num_own() as u64).unwrap();
            assert!(all <= setup.agents.len() as u64, "everybody is one rank's");
        }
        let handed_over = part.handed_over;
        (part.gather_crowd(comm).unwrap().map(|engine| engine.bytes()), handed_over, overlaps)
    });
    let handed_over = all.iter().map(|a| a.1).sum();
    let overlaps = all.iter().map(|a| a.2).sum();
    assert!(all[1..].iter().all(|a| a.0.is_none()));
    (all.swap_remove(0).0.unwrap(), handed_over, overlaps)
}

/// All saved state of a crowd is the same at every number of ranks; returns how many agents were handed over.
fn equals_one_process<V: Space>(setup: &CrowdSetup<V>, num_ranks: &[usize], times: &[f64]) -> u64 {
    let mut alone = Engine::new(setup.clone()).unwrap();
    times.iter().for_each(|&time| alone.advance(time, &mut |_| {}).unwrap());
    let mut handed_over = 0;
    for &num in num_ranks {
        let got = shared(setup, num, times);
        assert!(got.0 == alone.bytes(), "{num} ranks end in another state");
        assert_eq!(got.2, 0, "overlaps");
        assert!(num > 1 || got.1 == 0);
        handed_over += got.1;
    }
    handed_over
}

#[test]
fn crossing_crowd_is_that_of_one_process() {
    let times = [0.3, 5.0, 5.01, 20.0, 60.0];
    assert!(equals_one_process(&crossing::<Vec2>(150, 1.0), &[1, 2, 3, 4, 8], &times) > 100);
    assert!(equals_one_process(&crossing::<Vec3>(120, 1.1), &[2, 4], &[10.0]) > 10);
}

#[test]
fn agents_that_leave_and_obstacles_are_those_of_one_process() {
    let mut setup = crossing::<Vec2>(200, 1.2);
    setup.routes.iter_mut().for_each(|r| r.at_end = AtEnd::Leave);
    setup.obstacles.push(Obstacle::Ball { centre: Vec2::new(40.0, 0.0), radius: 3.0 });
    let path = vec![(0.0, Vec2::new(-30.0, 0.0)), (20.0, Vec2::new(30.0, 1.0)), (40.0, Vec2::new(-30.0, 0.0))];
    setup.obstacles.push(Obstacle::Mover { path, radius: 0.5 });
    assert!(equals_one_process(&setup, &[2, 3, 5], &[40.0]) > 20);
}

/// Agents that are woken before ranks share a crowd, and agents that still are when the ranks join it again.
#[test]
fn agents_that_are_woken_act_as_in_one_process() {
    let mut alone = Engine::new(crossing::<Vec2>(150, 1.0)).unwrap();
    alone.advance(1.0, &mut |_| {}).unwrap();
    for id in alone.ids().collect::<Vec<_>>() {
        alone.wake(id).unwrap();
    }
    let start = alone.clone();
    for until in [1.03, 5.0] {
        alone.advance(until, &mut |_| {}).unwrap();
        let all = LocalComm::run(4, |comm| {
            let mut part = SharedEngine::new(start.clone(), comm).unwrap();
            part.advance(until, comm).unwrap();
            let mut whole = part.gather_crowd(comm).unwrap()?;
            let bytes = whole.bytes();
            whole.advance(6.0, &mut |_| {}).unwrap();
            Some((bytes, whole.bytes()))
        });
        let mut later = alone.clone();
        later.advance(6.0, &mut |_| {}).unwrap();
        assert!(all[0] == Some((alone.bytes(), later.bytes())), "until {until} s");
        let num_woken = alone.states.iter().filter(|s| s.is_woken).count();
        assert_eq!(num_woken > 5, until < 2.0, "{num_woken} wait to act");
    }
}

#[test]
fn ties_between_agents_are_refused() {
    let mut engine = Engine::new(crossing::<Vec2>(9, 3.0)).unwrap();
    let ids: Vec<Id> = engine.ids().take(2).collect();
    engine.set_companions(&ids).unwrap();
    let error = SharedEngine::new(engine, &SingleRank).unwrap_err();
    assert!(error.to_string().contains("companions"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn any_crowd_is_that_of_one_process(
        seed in 0u64..1000, num in 2usize..120, spacing in 0.8f32..4.0, num_ranks in 2usize..7, goal in 0.0f32..1.0,
    ) {
        let mut setup = crossing::<Vec2>(num, spacing);
        let mut shares = Shares(seed);
        for route in &mut setup.routes {
            let aside = Vec2::new(shares.next() - 0.5, shares.next() - 0.5) * 40.0;
            route.subgoals[0] = route.subgoals[0] * (1.0 - goal) + aside * goal;
            if shares.next() < 0.3 {
                route.at_end = AtEnd::Leave;
            }
        }
        equals_one_process(&setup, &[num_ranks], &[2.0, 12.0]);
    }
}
