//! Doors: paths lead through open ones and round closed ones, for those on their way too.

use crate::*;
use glam::Vec3;

fn ground(x: f32, z: f32) -> Vec3 {
    Vec3::new(x, 0.0, z)
}

fn wall(from: [f32; 2], to: [f32; 2]) -> Obstacle {
    Obstacle::Wall { from: ground(from[0], from[1]), to: ground(to[0], to[1]), radius: 0.05 }
}

/// Number of the door between two rooms.
const DOOR: usize = 5;

/// Two rooms with a door of 1.4 m between them; the wall reaches from one end to the other, or leaves a path round.
fn rooms(is_closed_off: bool) -> Crowd {
    let end = if is_closed_off { 6.0 } else { 4.0 };
    let walls = vec![
        wall([-8.0, -6.0], [8.0, -6.0]),
        wall([-8.0, 6.0], [8.0, 6.0]),
        wall([-8.0, -6.0], [-8.0, 6.0]),
        wall([8.0, -6.0], [8.0, 6.0]),
        wall([0.0, -6.0], [0.0, -1.7]),
        wall([0.0, -1.7], [0.0, -0.3]),
        wall([0.0, -0.3], [0.0, end]),
    ];
    let streets = Streets::new(&walls, 0.4).unwrap();
    Crowd::on_ground(CrowdSetup::in_streets(&streets, 12)).unwrap()
}

fn enter(crowd: &mut Crowd, num: usize) -> Vec<Id> {
    let at = |i: usize| ground(-6.0 + 1.2 * (i / 4) as f32, -4.0 + 1.2 * (i % 4) as f32);
    (0..num).map(|i| crowd.spawn(Agent::standing_at(at(i))).unwrap()).collect()
}

fn goal(i: usize) -> Vec3 {
    ground(3.0 + 1.2 * (i / 4) as f32, -4.0 + 1.2 * (i % 4) as f32)
}

fn at(crowd: &Crowd, id: Id) -> Vec3 {
    crowd.position(id, crowd.time_s()).unwrap()
}

fn run(crowd: &mut Crowd, seconds: f64) {
    crowd.advance(crowd.time_s() + seconds, &mut |_| {}).unwrap();
}

#[test]
fn those_on_their_way_turn_round_when_a_door_closes_and_back_when_it_opens() {
    let mut crowd = rooms(false);
    let id = enter(&mut crowd, 1)[0];
    crowd.set_open(DOOR, true).unwrap();
    crowd.order(id, AgentOrder::to_goal(ground(3.0, -1.0))).unwrap();
    let short = crowd.distance_left(id).unwrap();
    run(&mut crowd, 2.0);
    crowd.set_open(DOOR, false).unwrap();
    run(&mut crowd, 1.0);
    let round = crowd.distance_left(id).unwrap();
    assert!(short < 10.5 && round > 10.5, "{short} m through the door, {round} m round the wall");
    assert!(crowd.desired_direction(id).unwrap().z > 0.7, "round the end of the wall");
    crowd.set_open(DOOR, true).unwrap();
    run(&mut crowd, 1.0);
    assert!(crowd.distance_left(id).unwrap() < 8.0);
    run(&mut crowd, 8.0);
    assert_eq!(crowd.status(id).unwrap(), AgentStatus::Arrived);
}

#[test]
fn all_wait_before_a_closed_door_that_is_the_only_way_and_go_on_when_it_opens() {
    let mut crowd = rooms(true);
    let ids = enter(&mut crowd, 12);
    let lost = crowd.order(ids[0], AgentOrder::to_goal(goal(0)));
    assert!(matches!(lost.unwrap_err().into(), throng_base::Error::NoPath { .. }), "a wall for all that it knows");
    crowd.set_open(DOOR, true).unwrap();
    crowd.set_open(DOOR, false).unwrap();
    for (i, &id) in ids.iter().enumerate() {
        crowd.order(id, AgentOrder::to_goal(goal(i))).unwrap();
    }
    run(&mut crowd, 12.0);
    let near = |&&id: &&Id| at(&crowd, id).distance(ground(0.0, -1.0)) < 5.5;
    assert_eq!(ids.iter().filter(near).count(), 12, "they wait before it");
    assert!(ids.iter().all(|&id| at(&crowd, id).x < -0.3), "nobody went through");
    assert!(ids.iter().all(|&id| crowd.distance_left(id).unwrap() < 30.0), "a closed door is no way");
    crowd.set_open(DOOR, true).unwrap();
    run(&mut crowd, 20.0);
    assert!(ids.iter().all(|&id| crowd.status(id).unwrap() == AgentStatus::Arrived));
}

/// Doors that open and close all the time, while agents go to and fro.
fn busy(crowd: &mut Crowd, ids: &[Id], round: usize) {
    let _ = crowd.set_open(DOOR, !round.is_multiple_of(3));
    for (i, &id) in ids.iter().enumerate() {
        let there = goal((i + round) % 12);
        let to = if (i + round / 6).is_multiple_of(2) { there } else { ground(-there.x, there.z) };
        let _ = crowd.order(id, AgentOrder::to_goal(to).at_speed(1.0 + 0.05 * i as f32));
    }
    run(crowd, 0.9);
}

#[test]
fn snapshots_go_on_the_same_with_the_doors_of_then() {
    let mut crowd = rooms(true);
    let ids = enter(&mut crowd, 12);
    let mut kept = Vec::new();
    let mut hashes = Vec::new();
    for round in 0..30 {
        let mut bytes = Vec::new();
        crowd.save(&mut bytes);
        kept.push(bytes);
        busy(&mut crowd, &ids, round);
        hashes.push(crowd.hash());
    }
    // In a crowd whose doors were never opened, and in one whose doors were.
    for (mut other, first) in [(rooms(true), 7), (rooms(true), 0), (crowd, 13)] {
        other.load(&kept[first]).unwrap();
        for round in first..30 {
            busy(&mut other, &ids, round);
            assert_eq!(other.hash(), hashes[round], "round {round} from {first} on");
        }
    }
}

#[test]
fn moving_obstacles_are_no_doors() {
    let obstacles = vec![Obstacle::Mover { path: vec![(0.0, Vec3::ZERO)], radius: 1.0 }];
    let mut crowd = Crowd::on_ground(CrowdSetup { obstacles, ..CrowdSetup::default() }).unwrap();
    assert!(crowd.set_open(0, true).is_err());
}

/// Time at which the last of two crowds of twelve that meet at a door of twice their width is through; in the other's
/// room (s).
fn through_a_door(shift: f32) -> f64 {
    let walls = vec![wall([0.0, -12.0], [0.0, -0.65]), wall([0.0, 0.65], [0.0, 12.0])];
    let streets = Streets::with_limits(&walls, None, 0.45, 0.3).unwrap();
    let mut crowd = Crowd::on_ground(CrowdSetup::in_streets(&streets, 24)).unwrap();
    for side in [-1.0, 1.0] {
        for i in 0..12 {
            let at = ground(side * (1.5 + shift + 1.1 * (i / 4) as f32), -1.8 + shift + 1.1 * (i % 4) as f32);
            let id = crowd.spawn(Agent { radius: 0.3, ..Agent::standing_at(at) }).unwrap();
            crowd.order(id, AgentOrder::to_goal(ground(-side * 8.0, at.z)).then_at_end(AtEnd::Leave)).unwrap();
        }
    }
    while crowd.num_agents() > 0 && crowd.time_s() < 300.0 {
        run(&mut crowd, 1.0);
    }
    crowd.time_s()
}

#[test]
fn two_crowds_at_a_narrow_door_take_turns() {
    let times = [0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35].map(through_a_door);
    assert!(times.iter().sum::<f64>() < 8.0 * 66.0, "the last one is through after {times:?} s");
}

/// Twelve in a room of a shape with a closed door to the next one, who want to go there; after some seconds, the farthest that one
/// moves in the ten seconds after (m), and the places then.
fn wait_before(crowd: &mut Crowd, ids: &[Id], seconds: f64) -> (f32, Vec<Vec3>) {
    run(crowd, seconds);
    let before: Vec<Vec3> = ids.iter().map(|&id| at(crowd, id)).collect();
    let mut farthest = 0.0f32;
    for _ in 0..100 {
        run(crowd, 0.1);
        farthest = ids.iter().zip(&before).map(|(&id, place)| at(crowd, id).distance(*place)).fold(farthest, f32::max);
    }
    (farthest, before)
}

#[test]
fn who_waits_before_a_closed_door_stands_at_ease_beside_the_doorway() {
    for seed in 1..17 {
        let mut shares = super::Shares(seed);
        let mut crowd = rooms(true);
        let ids = enter(&mut crowd, 12);
        crowd.set_open(DOOR, true).unwrap();
        crowd.set_open(DOOR, false).unwrap();
        for (i, &id) in ids.iter().enumerate() {
            let goal = goal(i) + ground(shares.next(), shares.next()) - ground(0.5, 0.5);
            crowd.order(id, AgentOrder::to_goal(goal).at_speed(1.0 + 0.5 * shares.next())).unwrap();
        }
        let (farthest, places) = wait_before(&mut crowd, &ids, 20.0);
        assert!(farthest < 0.05, "seed {seed}: one walks about by {farthest} m");
        let near = places.iter().filter(|p| p.distance(ground(0.0, -1.0)) < 5.5).count();
        let in_lane = places.iter().filter(|p| (p.z + 1.0).abs() < 0.6 && p.x > -3.0).count();
        assert!(near == 12 && in_lane == 0, "seed {seed}: {near} wait near the door, {in_lane} before it: {places:?}");
        assert!(ids.iter().all(|&id| matches!(crowd.status(id).unwrap(), AgentStatus::Going { .. })), "seed {seed}");
        crowd.set_open(DOOR, true).unwrap();
        run(&mut crowd, 30.0);
        let arrived = ids.iter().filter(|&&id| crowd.status(id).unwrap() == AgentStatus::Arrived).count();
        assert_eq!(arrived, 12, "seed {seed}");
    }
}

#[test]
fn who_waits_before_a_lift_lets_people_out_first() {
    for (seed, width) in (1..9).map(|seed| (seed, if seed % 2 == 0 { 1.0 } else { 1.6 })) {
        let mut shares = super::Shares(seed);
        let half = 0.5 * width;
        let walls = vec![
            wall([-half, 0.0], [half, 0.0]),
            wall([-6.0, 0.0], [-half, 0.0]),
            wall([half, 0.0], [6.0, 0.0]),
            wall([-1.1, 0.0], [-1.1, 2.0]),
            wall([-1.1, 2.0], [1.1, 2.0]),
            wall([1.1, 2.0], [1.1, 0.0]),
        ];
        let streets = Streets::with_limits(&walls, None, 0.4, 0.25).unwrap();
        let mut setup = CrowdSetup::in_streets(&streets, 9);
        setup.doors.push(0);
        let mut crowd = Crowd::on_ground(setup).unwrap();
        crowd.set_open(0, false).unwrap();
        let mut person = |from: Vec3, to: Vec3| {
            let off = ground(shares.next() - 0.5, shares.next() - 0.5) * 0.2;
            let id = crowd.spawn(Agent { radius: 0.22, ..Agent::standing_at(from + off) }).unwrap();
            crowd.order(id, AgentOrder::to_goal(to)).unwrap();
            id
        };
        let inside: Vec<Id> = (0..4)
            .map(|i| {
                person(ground(0.9 * (i % 2) as f32 - 0.45, 0.6 + 0.8 * (i / 2) as f32), ground(i as f32 - 1.5, -9.0))
            })
            .collect();
        let outside: Vec<Id> = (0..4)
            .map(|i| {
                person(ground(i as f32 - 1.5, -4.0), ground(1.2 * (i % 2) as f32 - 0.6, 0.55 + 0.9 * (i / 2) as f32))
            })
            .collect();
        run(&mut crowd, 15.0);
        crowd.set_open(0, true).unwrap();
        let [mut last_out, mut first_in] = [0.0, f64::INFINITY];
        for _ in 0..400 {
            run(&mut crowd, 0.1);
            if inside.iter().any(|&id| at(&crowd, id).z > 0.0) {
                last_out = crowd.time_s();
            }
            if outside.iter().any(|&id| at(&crowd, id).z > 0.0) {
                first_in = first_in.min(crowd.time_s());
            }
        }
        assert!(
            last_out < 30.0 && last_out < first_in,
            "seed {seed}: in at {first_in} s, the last one out at {last_out} s"
        );
    }
}
