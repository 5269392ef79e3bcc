//! Relationships of single agents: interests of their own, and companions.

use super::drive::{Drive, Shares, crossing};
use crate::events::engine::Engine;
use crate::*;
use glam::{Vec2, Vec3};

fn ground(x: f32, z: f32) -> Vec3 {
    Vec3::new(x, 0.0, z)
}

fn at(crowd: &Crowd, id: Id) -> Vec3 {
    crowd.position(id, crowd.time_s()).unwrap()
}

fn crowd(agents: Vec<Agent>, obstacles: Vec<Obstacle>) -> (Crowd, Vec<Id>) {
    let streets = Some(Streets::new(&obstacles, 0.4).unwrap());
    let crowd = Crowd::on_ground(CrowdSetup { agents, obstacles, streets, ..CrowdSetup::default() }).unwrap();
    let ids = crowd.ids().collect();
    (crowd, ids)
}

#[test]
fn interests_of_one_agent_draw_it_alone() {
    let (mut crowd, ids) =
        crowd(vec![Agent::standing_at(ground(0.0, 0.0)), Agent::standing_at(ground(0.0, 8.0))], Vec::new());
    for (k, &id) in ids.iter().enumerate() {
        crowd.order(id, AgentOrder::to_goal(ground(30.0, 8.0 * k as f32))).unwrap();
    }
    let window = PersonalInterest { at: InterestLocation::Place(ground(10.0, 5.0)), strength: 2.0, reach: 8.0 };
    crowd.set_interest(ids[0], 0, Some(window)).unwrap();
    crowd.advance(7.0, &mut |_| {}).unwrap();
    let [drawn, other] = [0, 1].map(|k| at(&crowd, ids[k]).z - 8.0 * k as f32);
    assert!(drawn > 0.15 && other.abs() < 0.05, "{drawn} {other}");
    crowd.set_interest(ids[0], 0, None).unwrap();
    let bad = |strength, reach, other| PersonalInterest { at: InterestLocation::Agent(other), strength, reach };
    assert!(crowd.set_interest(ids[0], 4, Some(window)).is_err());
    for interest in [bad(f32::NAN, 1.0, ids[1]), bad(1.0, 0.0, ids[1]), bad(1.0, 1.0, ids[0])] {
        assert!(crowd.set_interest(ids[0], 1, Some(interest)).is_err(), "{interest:?}");
    }
    let gone = Id { index: 1, generation: 7 };
    assert!(crowd.set_interest(ids[0], 1, Some(bad(1.0, 1.0, gone))).is_err());
}

/// What is twice as strong, and half way to its end, draws as much.
#[test]
fn interests_of_one_agent_fade_with_distance() {
    let mut relationships = crate::steering::relationships::RelationshipTable::<Vec2>::new(1);
    let id = Id { index: 0, generation: 0 };
    for (strength, distance) in [(2.0, 0.0), (2.0, 2.0), (2.0, 6.0), (2.0, 8.0), (2.0, 9.0)] {
        let at = InterestLocation::Place(Vec2::new(distance, 0.0));
        relationships.set_interest(id, 1, Some(PersonalInterest { at, strength, reach: 8.0 })).unwrap();
        let pull = relationships.interest_acceleration(0, Vec2::ZERO, |_| None);
        let want = if distance > 0.0 { strength * (1.0 - distance / 8.0f32).max(0.0) } else { 0.0 };
        assert!(pull.distance(Vec2::new(want, 0.0)) < 1e-6, "at {distance} m: {pull}");
    }
}

#[test]
fn an_agent_follows_one_that_draws_it_until_that_one_leaves() {
    let (mut crowd, ids) =
        crowd(vec![Agent::standing_at(ground(0.0, 0.0)), Agent::standing_at(ground(4.0, 0.0))], Vec::new());
    crowd.order(ids[1], AgentOrder::to_goal(ground(30.0, 0.0)).at_speed(0.7)).unwrap();
    crowd
        .set_interest(
            ids[0],
            2,
            Some(PersonalInterest { at: InterestLocation::Agent(ids[1]), strength: 9.0, reach: 20.0 }),
        )
        .unwrap();
    crowd.advance(10.0, &mut |_| {}).unwrap();
    let moved = at(&crowd, ids[0]).x;
    assert!(moved > 0.3, "{moved}");
    crowd.despawn(ids[1]).unwrap();
    crowd.advance(30.0, &mut |_| {}).unwrap();
    assert!(at(&crowd, ids[0]).x < 0.1, "back at its place");
}

/// Whether groups stay together, and how fast their members come on.
#[derive(Debug)]
struct Together {
    /// Share of time that they are within 2.5 m of the middle of their group.
    share: f32,
    /// Time until nine in ten have crossed x = 0 or left (s).
    through: f32,
    /// Mean speed along x of all (m/s).
    speed: f32,
    /// Mean angle between the lines through two members and the way: 0 one after the other, 1 abreast.
    abreast: f32,
}

/// Sends agents along x, each as far as ordered, and records them ten times a second.
fn walk(crowd: &mut Crowd, ids: &[Id], size: usize, far: f32, seconds: usize, grouped: bool) -> Together {
    let starts: Vec<Vec3> = ids.iter().map(|&id| at(crowd, id)).collect();
    for (group, from) in ids.chunks(size).zip(starts.chunks(size)) {
        let to = if from[0].x < 0.0 { far } else { -far };
        for (&id, from) in group.iter().zip(from) {
            crowd
                .order(id, AgentOrder::to_goal(ground(to, from.z)).with_arrival(2.0).then_at_end(AtEnd::Leave))
                .unwrap();
        }
        if grouped {
            crowd.set_companions(group).unwrap();
        }
    }
    let (mut near, mut whole, mut all, mut distance, mut abreast, mut pairs) = (0, 0, 0, 0.0, 0.0, 0);
    let mut through = 0.0;
    let signs: Vec<f32> = starts.iter().map(|s| s.x.signum()).collect();
    let mut before = starts;
    for tick in 1..=10 * seconds {
        crowd.advance(0.1 * tick as f64, &mut |_| {}).unwrap();
        let crossed = |c: &(&Id, &f32)| crowd.position(*c.0, crowd.time_s()).is_none_or(|p| p.x * c.1 < 0.0);
        if ids.iter().zip(&signs).filter(crossed).count() * 10 < ids.len() * 9 {
            through = 0.1 * tick as f32;
        }
        for (g, group) in ids.chunks(size).enumerate() {
            let there: Vec<Vec3> = group.iter().filter_map(|&id| crowd.position(id, crowd.time_s())).collect();
            for (m, &id) in group.iter().enumerate() {
                if let Some(now) = crowd.position(id, crowd.time_s()) {
                    distance += (now.x - before[g * size + m].x).abs();
                    before[g * size + m] = now;
                    all += 1;
                }
            }
            if there.len() < size {
                continue;
            }
            whole += size;
            let middle = there.iter().sum::<Vec3>() / size as f32;
            near += there.iter().filter(|p| p.distance(middle) < 2.5).count();
            for (k, a) in there.iter().enumerate() {
                for b in &there[..k] {
                    abreast += ((a.z - b.z).abs() / a.distance(*b)).min(1.0);
                    pairs += 1;
                }
            }
        }
    }
    Together {
        share: near as f32 / whole as f32,
        through,
        speed: distance / (0.1 * all as f32),
        abreast: abreast / pairs.max(1) as f32,
    }
}

fn wall(z: f32) -> Obstacle {
    Obstacle::Wall { from: ground(-60.0, z), to: ground(60.0, z), radius: 0.1 }
}

/// A group in a way of some width, in the open if that is not finite.
fn group(size: usize, width: f32, grouped: bool) -> Together {
    let start = |k: usize| {
        let z = if width.is_finite() { 0.2 * (k % 2) as f32 } else { 1.2 * k as f32 };
        Agent { speed: 1.1 + 0.1 * k as f32, ..Agent::standing_at(ground(-20.0 - 1.0 * k as f32, z)) }
    };
    let walls = if width.is_finite() { vec![wall(-0.5 * width - 0.1), wall(0.5 * width + 0.1)] } else { Vec::new() };
    let (mut crowd, ids) = crowd((0..size).map(start).collect(), walls);
    walk(&mut crowd, &ids, size, 30.0, 35, grouped)
}

/// Two crowds head-on between walls, in groups.
fn head_on(size: usize, num: usize, grouped: bool) -> Together {
    let mut shares = Shares(7);
    let agents = (0..2 * num).map(|i| {
        let (side, i) = (if i < num { -1.0 } else { 1.0 }, i % num);
        let x = 6.0 + 1.3 * (i / 5) as f32 + 0.2 * shares.next();
        let z = -3.0 + 1.3 * (i % 5) as f32 + 0.2 * shares.next();
        Agent::standing_at(ground(side * x, z))
    });
    let (mut crowd, ids) = crowd(agents.collect(), vec![wall(-4.1), wall(4.1)]);
    walk(&mut crowd, &ids, size, 30.0, 60, grouped)
}

/// Two crowds through a door, one after the other or head-on.
fn door(size: usize, num: usize, width: f32, grouped: bool, seed: u64) -> Together {
    let mut shares = Shares(seed);
    let agents = (0..num).map(|i| {
        let (x, z) = (3.0 + 1.2 * (i / 6) as f32 + 0.2 * shares.next(), -3.0 + 1.2 * (i % 6) as f32);
        Agent::standing_at(ground(-x, z))
    });
    let jamb = |z: f32, to: f32| Obstacle::Wall { from: ground(0.0, z), to: ground(0.0, to), radius: 0.05 };
    let half = 0.5 * width + 0.05;
    let (mut crowd, ids) = crowd(agents.collect(), vec![wall(-5.1), wall(5.1), jamb(half, 5.0), jamb(-half, -5.0)]);
    walk(&mut crowd, &ids, size, 12.0, 90, grouped)
}

#[test]
fn groups_walk_abreast_in_the_open_and_one_after_the_other_where_it_is_narrow() {
    for size in 2..=4 {
        let in_the_open = group(size, f32::INFINITY, true);
        assert!(in_the_open.share > 0.98 && in_the_open.abreast > 0.95, "{size}: {in_the_open:?}");
        // At the speed of the slowest, or nearly so.
        assert!(in_the_open.speed > 1.05 && in_the_open.through < 21.0, "{size}: {in_the_open:?}");
        let narrow = group(size, 1.2, true);
        assert!(narrow.share > 0.98 && narrow.abreast < 0.1 && narrow.speed > 1.05, "{size} in 1.2 m: {narrow:?}");
        let wider = group(size, 2.0, true);
        assert!(wider.share > 0.98 && wider.speed > 1.0, "{size} in 2 m: {wider:?}");
        assert!((size == 2) == (wider.abreast > 0.9), "two have room beside each other in 2 m: {wider:?}");
        let alone = group(size, f32::INFINITY, false);
        assert!(in_the_open.share >= alone.share && in_the_open.abreast > alone.abreast, "{size}: {alone:?}");
    }
}

#[test]
fn groups_stay_together_against_a_crowd_that_comes_and_do_not_slow_it() {
    for size in 2..=4 {
        let (together, alone) = (head_on(size, 60, true), head_on(size, 60, false));
        assert!(together.share > 0.97 && together.share > alone.share, "{size}: {together:?} {alone:?}");
        assert!(together.speed > 0.95 * alone.speed, "{size}: {together:?} {alone:?}");
        assert!(together.through < 1.05 * alone.through, "{size}: {together:?} {alone:?}");
    }
}

#[test]
fn groups_hardly_lessen_the_flow_through_a_door() {
    let through = |size, grouped| (1..=4).map(|seed| door(size, 60, 2.0, grouped, seed).through).sum::<f32>();
    let alone = through(2, false);
    for size in 2..=4 {
        let together = through(size, true);
        assert!(together < 1.1 * alone, "{size}: {together} s for four crowds, {alone} s of single ones");
    }
}

#[test]
fn companions_are_named_until_they_part_or_leave() {
    let agents = (0..5).map(|k| Agent::standing_at(ground(k as f32, 0.0))).collect();
    let (mut crowd, ids) = crowd(agents, Vec::new());
    let of = |crowd: &Crowd, n: usize| crowd.companions(ids[n]).map(Id::index).collect::<Vec<_>>();
    assert!(of(&crowd, 0).is_empty());
    crowd.set_companions(&ids[..4]).unwrap();
    assert_eq!((of(&crowd, 1), of(&crowd, 3)), (vec![0, 2, 3], vec![0, 1, 2]));
    crowd.set_companions(&[ids[3], ids[4]]).unwrap();
    assert_eq!((of(&crowd, 0), of(&crowd, 4)), (vec![1, 2], vec![3]));
    crowd.despawn(ids[2]).unwrap();
    crowd.set_companions(&ids[4..]).unwrap();
    assert_eq!((of(&crowd, 0), of(&crowd, 2), of(&crowd, 3)), (vec![1], vec![], vec![]));
    for wrong in [&[][..], &ids[1..3], &[ids[0], ids[0]], &[0, 1, 3, 4, 0].map(|k| ids[k])] {
        assert!(crowd.set_companions(wrong).is_err(), "{wrong:?}");
    }
}

/// A crowd in groups of three, some of which look at others far away.
fn bound(num: usize) -> Engine<Vec2> {
    let mut crowd = Engine::new(crossing::<Vec2>(num, 1.3)).unwrap();
    let ids: Vec<Id> = crowd.ids().collect();
    ids.chunks(3).for_each(|group| crowd.set_companions(group).unwrap());
    for (k, &id) in ids.iter().enumerate().filter(|(k, _)| k % 5 == 0) {
        let at = InterestLocation::Agent(ids[(k + num / 2) % num]);
        crowd.set_interest(id, k % 4, Some(PersonalInterest { at, strength: 0.8, reach: 60.0 })).unwrap();
    }
    crowd
}

#[test]
fn bonds_do_not_depend_on_threads_nor_on_snapshots() {
    let (mut alone, mut threads) = (bound(700), bound(700));
    for second in 1..=6 {
        alone.advance(f64::from(second), &mut |_| {}).unwrap();
        threads.par_advance(f64::from(second), &mut |_| {}).unwrap();
        assert_eq!(alone.hash(), threads.hash(), "after {second} s");
    }
    let mut other = Engine::new(crossing::<Vec2>(700, 1.3)).unwrap();
    other.load(&alone.bytes()).unwrap();
    assert_eq!(other.hash(), alone.hash());
    [&mut other, &mut alone].into_iter().for_each(|crowd| crowd.advance(8.0, &mut |_| {}).unwrap());
    assert_eq!(other.hash(), alone.hash());
    // Relationships are a part of the state.
    other.set_companions(&alone.ids().take(2).collect::<Vec<_>>()).unwrap();
    assert_ne!(other.hash(), alone.hash());
}
