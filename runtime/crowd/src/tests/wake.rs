//! Agents that are woken before their plans end.

use super::drive::{Drive, Shares, Threads, along, crossing, drive, to};
use crate::events::engine::Engine;
use crate::*;
use glam::{Vec2, Vec3};

/// Agents in each other's way that are fast and brake slowly, so that the motion of others matters.
fn packed<V: Space>(num: usize) -> CrowdSetup<V> {
    let mut setup = crossing(num, 1.3);
    setup.config.largest_speed_mps = 2.0;
    setup.agents.iter_mut().for_each(|a| (a.acceleration, a.speed) = (0.6, 1.9));
    setup
}

/// Sends some agents elsewhere and wakes them, wherever they are in their plans.
fn disturb<V: Space>(crowd: &mut Engine<V>, shares: &mut Shares) {
    let ids: Vec<Id> = crowd.ids().collect();
    for _ in 0..(shares.next() * 20.0) as usize {
        let id = ids[(shares.next() * ids.len() as f32) as usize];
        let goal = V::from_coordinates([(); 3].map(|()| (shares.next() - 0.5) * 20.0));
        crowd.order(id, &along(to(goal), 1.0 + shares.next())).unwrap();
        crowd.wake(id).unwrap();
    }
}

/// All plans keep the safety rule to their ends, as others that chose theirs with them in view rely on. Returns how
/// many woken agents found no other plan.
fn promises_are_kept<V: Space>(seed: u64) -> usize {
    let mut crowd = Engine::new(packed::<V>(150)).unwrap();
    let mut other = crowd.clone();
    let mut shares = Shares(seed);
    let (mut early, mut kept) = (0, 0);
    while crowd.now < 9.0 {
        let woken: Vec<_> = crowd.ids().filter(|id| crowd.states[id.index()].is_woken).collect();
        let due: Vec<f64> = woken.iter().map(|&id| crowd.next_event(id).unwrap()).collect();
        crowd.advance(crowd.now + 0.01 + 0.05 * f64::from(shares.next()), &mut |_| {}).unwrap();
        for (&id, due) in woken.iter().zip(due).filter(|(_, due)| *due <= crowd.now) {
            assert!(!crowd.states[id.index()].is_woken, "it acts when it is due");
            let acted = crowd.last_event(id).unwrap() >= due;
            (early, kept) = (early + usize::from(acted), kept + usize::from(!acted));
        }
        disturb(&mut crowd, &mut shares);
        other.load(&crowd.bytes()).unwrap_or_else(|e| panic!("seed {seed}, {} s: {e}", crowd.now));
    }
    assert!(early > 500, "{early} took another plan: too few to prove anything");
    kept
}

#[test]
fn discs_that_are_woken_keep_what_they_promised() {
    let kept: usize = (0..5).map(promises_are_kept::<Vec2>).sum();
    assert!(kept > 5, "{kept} had to keep their plans: too few to prove anything");
}

#[test]
fn balls_that_are_woken_keep_what_they_promised() {
    (0..5).for_each(|seed| _ = promises_are_kept::<Vec3>(seed));
}

#[test]
fn threads_and_snapshots_do_not_change_who_is_woken() {
    let run = |threads: usize, is_restored: bool| {
        let mut crowd = Engine::new(packed::<Vec2>(400)).unwrap();
        let (mut shares, mut events, mut num_woken, mut num_kept) = (Shares(7), Vec::new(), 0, 0);
        for _ in 0..200 {
            let until = crowd.now + 0.01 + 0.05 * f64::from(shares.next());
            let step = |e: &mut Engine<Vec2>| match threads {
                0 => e.run(until),
                _ => e.run_parallel(until, &Threads(threads)),
            };
            drive(&mut crowd, &mut |e| events.push(*e), step).unwrap();
            (0..3).for_each(|_| disturb(&mut crowd, &mut shares));
            num_woken += crowd.states.iter().filter(|s| s.is_woken).count();
            num_kept += crowd.states.iter().filter(|s| s.goes_on).count();
            if is_restored {
                let bytes = crowd.bytes();
                crowd = Engine::new(packed(400)).unwrap();
                crowd.load(&bytes).unwrap();
            }
        }
        assert!(
            num_woken > 500 && num_kept > 5,
            "{num_woken} were woken, {num_kept} went on: too few to prove anything"
        );
        (events, crowd.bytes(), crowd.hash())
    };
    let alone = run(0, false);
    for (threads, is_restored) in [(0, true), (1, false), (3, false), (3, true)] {
        assert!(run(threads, is_restored) == alone, "{threads} threads, restored: {is_restored}");
    }
}

#[test]
fn who_is_woken_all_the_time_goes_on_in_peace() {
    let mut crowd = Engine::new(packed::<Vec2>(150)).unwrap();
    let ids: Vec<Id> = crowd.ids().collect();
    let mut num_kept = 0;
    for _ in 0..900 {
        crowd.advance(crowd.now + 0.01, &mut |_| {}).unwrap();
        for &id in &ids {
            let before = crowd.next_event(id);
            crowd.wake(id).unwrap();
            if crowd.states[id.index()].goes_on {
                num_kept += 1;
                assert_eq!((before, crowd.next_event(id)), (Some(crowd.cells.plan(id.index).end), before));
            }
        }
    }
    assert!(num_kept > 20, "{num_kept} are too few to prove anything");
}

#[test]
fn an_agent_in_the_open_acts_as_soon_as_it_may() {
    let mut crowd = Engine::new(packed::<Vec2>(1)).unwrap();
    let id = crowd.ids().next().unwrap();
    crowd.advance(3.0, &mut |_| {}).unwrap();
    let interval = f64::from(crowd.scenery.interval);
    for k in 0..50 {
        let now = crowd.now + 0.013 * f64::from(k % 11);
        crowd.advance(now, &mut |_| {}).unwrap();
        let (last, next) = (crowd.last_event(id).unwrap(), crowd.next_event(id).unwrap());
        crowd.order(id, &along(to(Vec2::from_angle(k as f32) * 50.0), 1.3)).unwrap();
        crowd.wake(id).unwrap();
        let due = crowd.next_event(id).unwrap();
        let soonest = now.max(last + interval);
        assert!(due == soonest || (due == next && next - soonest <= interval), "{due} is late");
        crowd.wake(id).unwrap();
        assert_eq!(crowd.next_event(id), Some(due), "to wake it twice changes nothing");
        crowd.advance(due, &mut |_| {}).unwrap();
        assert_eq!(crowd.last_event(id), Some(due));
    }
}

#[test]
fn who_cannot_have_been_woken_is_refused() {
    let mut crowd = Engine::new(packed::<Vec2>(100)).unwrap();
    crowd.advance(3.0, &mut |_| {}).unwrap();
    let mut num = [0; 2];
    for id in crowd.ids() {
        let mut forged = crowd.clone();
        forged.states[id.index()].is_woken = true;
        let may_be = crowd.woken_at(&crowd.plan(id).unwrap(), crowd.now).is_some();
        assert_eq!(crowd.clone().load(&forged.bytes()).is_ok(), may_be, "{id:?}");
        num[usize::from(may_be)] += 1;
    }
    assert!(num.iter().all(|&n| n > 5), "{num:?} are too few to prove anything");
}
