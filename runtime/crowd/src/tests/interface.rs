//! The crowd as an application uses it.

use crate::*;
use glam::Vec3;
use throng_base::{Error, Inline};

fn ground(x: f32, z: f32) -> Vec3 {
    Vec3::new(x, 0.0, z)
}

/// A block, and streets round it.
fn streets() -> Streets {
    let block = Obstacle::Box { min: Vec3::new(-2.0, 0.0, -3.0), max: Vec3::new(2.0, 3.0, 3.0) };
    Streets::new(&[block], 0.4).unwrap()
}

fn other(e: CrowdError) -> Error {
    e.into()
}

#[test]
fn orders_lead_round_corners_and_stay_until_changed() {
    let mut crowd = Crowd::on_ground(CrowdSetup::in_streets(&streets(), 4)).unwrap();
    let id = crowd.spawn(Agent::standing_at(ground(-5.0, 0.0))).unwrap();
    crowd.advance(2.0, &mut |_| {}).unwrap();
    assert_eq!(crowd.status(id).unwrap(), AgentStatus::Arrived, "it has no order yet");
    assert!(crowd.position(id, 2.0).unwrap().distance(ground(-5.0, 0.0)) < 0.1);
    crowd.order(id, AgentOrder::to_goal(ground(5.0, 0.0))).unwrap();
    let left = crowd.distance_left(id).unwrap();
    assert!(
        left > 11.0 && crowd.status(id).unwrap() == AgentStatus::Going { left_m: left },
        "{left} m round the block"
    );
    crowd.advance(20.0, &mut |_| {}).unwrap();
    assert_eq!(crowd.status(id).unwrap(), AgentStatus::Arrived);
    crowd.order(id, AgentOrder::to_goal(ground(-5.0, 0.0)).then_at_end(AtEnd::Leave).at_speed(2.0)).unwrap();
    crowd.advance(40.0, &mut |_| {}).unwrap();
    assert!(matches!(other(crowd.status(id).unwrap_err()), Error::Gone(gone) if gone == id));
}

#[test]
fn impossible_orders_are_refused_and_change_nothing() {
    let mut crowd = Crowd::on_ground(CrowdSetup::in_streets(&streets(), 4)).unwrap();
    let id = crowd.spawn(Agent::standing_at(ground(-5.0, 0.0))).unwrap();
    let hash = crowd.hash();
    let unreachable = other(crowd.order(id, AgentOrder::to_goal(ground(0.0, 0.0))).unwrap_err());
    assert!(matches!(unreachable, Error::NoPath { who: Some(who), .. } if who == id));
    let fast = crowd.order(id, AgentOrder::to_goal(ground(5.0, 0.0)).at_speed(9.0)).unwrap_err();
    assert!(matches!(other(fast), Error::Value { what: "speed", who: Some(who), .. } if who == id));
    let route = crowd.order(id, AgentOrder::on_route(7)).unwrap_err();
    assert!(matches!(other(route), Error::Index { what: "route", got: 7, .. }));
    assert!(crowd.order(id, AgentOrder::along_subgoals(vec![ground(0.0, 1.0)])).is_err(), "in the block");
    let lost = crowd.spawn(Agent { route: Some(1), ..Agent::standing_at(ground(-9.0, 0.0)) }).unwrap_err();
    assert!(matches!(other(lost), Error::Index { what: "route", got: 1, .. }));
    assert_eq!(crowd.hash(), hash);
}

#[test]
fn placed_agents_go_on_with_their_order_from_there() {
    let mut crowd = Crowd::on_ground(CrowdSetup::in_streets(&streets(), 4)).unwrap();
    let [a, b] = [-5.0, -8.0].map(|x| crowd.spawn(Agent::standing_at(ground(x, 0.0))).unwrap());
    crowd.order(a, AgentOrder::to_goal(ground(5.0, 0.0))).unwrap();
    crowd.advance(1.0, &mut |_| {}).unwrap();
    let hash = crowd.hash();
    assert!(matches!(other(crowd.place(a, ground(-8.2, 0.0)).unwrap_err()), Error::Occupied { who, .. } if who == a));
    assert!(crowd.place(a, Vec3::ZERO).is_err() && crowd.hash() == hash, "in the block");
    crowd.place(a, ground(0.0, 9.0)).unwrap();
    assert_eq!(crowd.position(a, 1.0), Some(ground(0.0, 9.0)));
    crowd.advance(15.0, &mut |_| {}).unwrap();
    assert_eq!([crowd.status(a).unwrap(), crowd.status(b).unwrap()], [AgentStatus::Arrived; 2]);
}

#[test]
fn who_is_there_stays_where_it_is_put() {
    let mut crowd = Crowd::on_ground(CrowdSetup::in_streets(&streets(), 4)).unwrap();
    let [idle, there] = [-5.0, -8.0].map(|x| crowd.spawn(Agent::standing_at(ground(x, 0.0))).unwrap());
    crowd.order(there, AgentOrder::to_goal(ground(-8.0, 2.0))).unwrap();
    crowd.advance(5.0, &mut |_| {}).unwrap();
    for (id, x) in [(idle, 5.0), (there, 8.0)] {
        crowd.place(id, ground(x, 0.0)).unwrap();
        assert_eq!(crowd.status(id).unwrap(), AgentStatus::Arrived);
    }
    crowd.advance(15.0, &mut |_| {}).unwrap();
    for (id, x) in [(idle, 5.0), (there, 8.0)] {
        assert!(crowd.position(id, 15.0).unwrap().distance(ground(x, 0.0)) < 0.1);
    }
}

#[test]
fn blocked_agents_name_who_is_in_front() {
    let mut setup = CrowdSetup::default();
    setup.config.capacity = 2;
    (setup.config.largest_radius_m, setup.config.largest_speed_mps) = (0.3, 1.3);
    for z in [-0.4, 0.4] {
        setup.obstacles.push(Obstacle::Wall { from: ground(-20.0, z), to: ground(20.0, z), radius: 0.0 });
    }
    setup.obstacles.push(Obstacle::Wall { from: ground(3.5, -0.4), to: ground(3.5, 0.4), radius: 0.0 });
    let mut crowd = Crowd::on_ground(setup).unwrap();
    let [a, b] = [0.0, 3.0].map(|x| crowd.spawn(Agent::standing_at(ground(x, 0.0))).unwrap());
    // Too narrow to pass, and the other one cannot go on.
    crowd.order(a, AgentOrder::to_goal(ground(9.0, 0.0))).unwrap();
    crowd.order(b, AgentOrder::to_goal(ground(3.0, 0.0)).with_arrival(0.01).at_speed(0.0)).unwrap();
    crowd.advance(30.0, &mut |_| {}).unwrap();
    assert_eq!(crowd.status(a).unwrap(), AgentStatus::Blocked { by: Some(b) });
}

#[test]
fn air_and_ground_have_the_same_interface() {
    for (in_air, goal) in [(false, Vec3::new(4.0, 0.0, 3.0)), (true, Vec3::new(4.0, 5.0, 3.0))] {
        let mut setup = CrowdSetup { fields: vec![ForceField::COMMUTER, ForceField::BIRD], ..CrowdSetup::default() };
        setup.agents.push(Agent { field: usize::from(in_air), ..Agent::standing_at(Vec3::new(0.0, 0.0, 0.0)) });
        let mut crowd = if in_air { Crowd::in_air(setup) } else { Crowd::on_ground(setup) }.unwrap();
        let id = crowd.ids().next().unwrap();
        crowd.order(id, AgentOrder::to_goal(goal)).unwrap();
        crowd.par_advance(15.0, &Inline, &mut |_| {}).unwrap();
        assert!(crowd.position(id, 15.0).unwrap().distance(goal) < 0.5);
        assert!(crowd.forces(id).is_some() && crowd.bound(id, 15.0).is_some());
    }
}

#[test]
fn every_flipped_bit_of_a_snapshot_is_refused() {
    let mut setup = CrowdSetup::in_streets(&streets(), 3);
    setup.agents.push(Agent::standing_at(ground(-5.0, 0.0)));
    let mut crowd = Crowd::on_ground(setup.clone()).unwrap();
    let id = crowd.ids().next().unwrap();
    crowd.order(id, AgentOrder::to_goal(ground(5.0, 0.0))).unwrap();
    crowd.advance(3.0, &mut |_| {}).unwrap();
    let mut kept = Vec::new();
    crowd.save(&mut kept);
    let hash = crowd.hash();
    let mut again = Crowd::on_ground(setup.clone()).unwrap();
    for at in 0..kept.len() {
        for bit in 0..8 {
            kept[at] ^= 1 << bit;
            assert!(matches!(other(again.load(&kept).unwrap_err()), Error::Snapshot { .. }), "bit {bit} of byte {at}");
            kept[at] ^= 1 << bit;
        }
    }
    again.load(&kept).unwrap();
    assert_eq!(again.hash(), hash);
    setup.config.steering.clear_s = 0.5;
    assert!(Crowd::on_ground(setup.clone()).unwrap().load(&kept).is_err(), "of another setup");
    assert!(Crowd::in_air(setup).unwrap().load(&kept).is_err(), "of another space");
}

#[test]
fn doors_open_and_close_and_never_on_anybody() {
    let wall = |from: [f32; 2], to: [f32; 2]| Obstacle::Wall {
        from: Vec3::new(from[0], 0.0, from[1]),
        to: Vec3::new(to[0], 0.0, to[1]),
        radius: 0.1,
    };
    // A room of 8 m by 6 m, with a door on its right side.
    let obstacles = vec![
        wall([-4.0, -3.0], [4.0, -3.0]),
        wall([-4.0, 3.0], [4.0, 3.0]),
        wall([-4.0, -3.0], [-4.0, 3.0]),
        wall([4.0, -3.0], [4.0, -0.7]),
        wall([4.0, 0.7], [4.0, 3.0]),
        wall([4.0, -0.7], [4.0, 0.7]),
    ];
    let agents =
        (0..6).map(|i| Agent::standing_at(Vec3::new(-2.0 + (i / 3) as f32, 0.0, (i % 3) as f32 - 1.0))).collect();
    let mut crowd = Crowd::on_ground(CrowdSetup { agents, obstacles, ..CrowdSetup::default() }).unwrap();
    let ids: Vec<Id> = crowd.ids().collect();
    for &id in &ids {
        crowd.order(id, AgentOrder::to_goal(Vec3::new(9.0, 0.0, 0.0)).with_arrival(3.0)).unwrap();
    }
    crowd.advance(15.0, &mut |_| {}).unwrap();
    let inside = |crowd: &Crowd| ids.iter().filter(|&&id| crowd.position(id, crowd.time_s()).unwrap().x < 3.9).count();
    assert_eq!(inside(&crowd), 6, "nobody goes through a closed door");
    crowd.set_open(5, true).unwrap();
    let mut refused = 0;
    let mut bytes = Vec::new();
    while inside(&crowd) > 3 {
        crowd.advance(crowd.time_s() + 0.1, &mut |_| {}).unwrap();
        crowd.save(&mut bytes);
        refused += usize::from(matches!(crowd.set_open(5, false), Err(CrowdError::Inside { obstacle: 5, .. })));
        crowd.set_open(5, true).unwrap();
        // A snapshot holds what was open.
        crowd.load(&bytes).unwrap();
        bytes.clear();
    }
    assert!(refused > 0, "somebody stood in it");
    while crowd.set_open(5, false).is_err() {
        crowd.advance(crowd.time_s() + 0.1, &mut |_| {}).unwrap();
    }
    let left = inside(&crowd);
    crowd.advance(crowd.time_s() + 10.0, &mut |_| {}).unwrap();
    assert_eq!(inside(&crowd), left);
    assert!(crowd.set_open(6, true).is_err());
}

#[test]
fn who_comes_to_its_goal_stops_there_and_does_not_walk_back() {
    for (far_m, speed) in [(0.7, 1.3), (0.9, 1.3), (1.2, 1.0), (2.0, 1.5), (3.3, 1.3), (6.0, 1.8)] {
        let mut crowd = Crowd::on_ground(CrowdSetup::in_streets(&Streets::new(&[], 0.4).unwrap(), 1)).unwrap();
        let id = crowd.spawn(Agent::standing_at(ground(0.0, 0.0))).unwrap();
        crowd.order(id, AgentOrder::to_goal(ground(50.0, 0.0)).at_speed(speed)).unwrap();
        crowd.advance(3.0, &mut |_| {}).unwrap();
        let goal = crowd.position(id, 3.0).unwrap() + ground(far_m, 0.0);
        crowd.order(id, AgentOrder::to_goal(goal).with_arrival(0.3)).unwrap();
        crowd.wake(id).unwrap();
        let mut beyond_m = 0.0f32;
        for step in 1..=300 {
            let time_s = 3.0 + f64::from(step) / 30.0;
            crowd.advance(time_s, &mut |_| {}).unwrap();
            beyond_m = beyond_m.max((crowd.position(id, time_s).unwrap() - goal).x);
        }
        assert!(beyond_m < 0.05, "{beyond_m} m beyond a goal in {far_m} m at {speed} m/s");
        assert!(crowd.position(id, 13.0).unwrap().distance(goal) < 0.3);
    }
}

#[test]
fn who_cannot_get_nearer_to_a_common_goal_stands_around_it() {
    for (num, seconds, seed) in [(2, 30.0, 1), (8, 40.0, 2), (8, 40.0, 3), (30, 60.0, 4)] {
        let mut shares = super::Shares(seed);
        let mut crowd = Crowd::on_ground(CrowdSetup::in_streets(&streets(), num)).unwrap();
        let ids: Vec<Id> = (0..num)
            .map(|k| {
                let at = [1.5 * (k / 6) as f32 + shares.next(), 1.5 * (k % 6) as f32 + shares.next()];
                crowd.spawn(Agent::standing_at(ground(-20.0 + at[0], 4.0 + at[1]))).unwrap()
            })
            .collect();
        let goal = ground(-9.0, 12.0);
        ids.iter().for_each(|&id| crowd.order(id, AgentOrder::to_goal(goal)).unwrap());
        crowd.advance(seconds, &mut |_| {}).unwrap();
        let places = |crowd: &Crowd, at: f64| ids.iter().map(|&id| crowd.position(id, at).unwrap()).collect::<Vec<_>>();
        let before = places(&crowd, seconds);
        let num_there = ids.iter().filter(|&&id| crowd.status(id).unwrap() == AgentStatus::Arrived).count();
        assert_eq!(num_there, num, "seed {seed}: so many of {num} have arrived");
        let farthest = before.iter().map(|p| p.distance(goal)).fold(0.0, f32::max);
        assert!(farthest < 1.0 + 0.6 * (num as f32).sqrt(), "seed {seed}: {farthest} m from the goal");
        for step in 1..=100 {
            crowd.advance(seconds + 0.1 * f64::from(step), &mut |_| {}).unwrap();
        }
        let moved = before.iter().zip(places(&crowd, seconds + 10.0)).map(|(a, b)| a.distance(b)).fold(0.0, f32::max);
        assert!(moved < 0.05, "seed {seed}: one of {num} moves by {moved} m");
    }
}

#[test]
fn runners_pass_their_points_and_stop_at_their_goal_whatever_they_weigh() {
    let corners = [[40.0, 0.0], [52.0, 12.0], [40.0, 24.0], [-10.0, 24.0], [-22.0, 12.0], [-10.0, 0.0], [-3.0, 0.0]];
    let mut faults = Vec::new();
    // Faster ones need more room than there is between these points.
    let pairs = [2.0, 3.0, 3.5, 4.0, 4.5, 5.0].into_iter().flat_map(|v| [3.0, 4.0, 5.0, 8.0].map(|a| (v, a)));
    for (speed, acceleration) in pairs {
        let runner = Agent { speed, acceleration, ..Agent::standing_at(Vec3::ZERO) };
        let mut setup = CrowdSetup { agents: vec![runner], ..CrowdSetup::default() };
        setup.config.largest_speed_mps = speed;
        let mut crowd = Crowd::on_ground(setup).unwrap();
        let id = crowd.ids().next().unwrap();
        let points = corners.map(|[x, z]| Vec3::new(x, 0.0, z)).to_vec();
        crowd.order(id, AgentOrder::along_subgoals(points).with_arrival(1.0)).unwrap();
        let (mut way_m, mut before) = (0.0, Vec3::ZERO);
        while crowd.time_s() < 240.0 && crowd.status(id).unwrap() != AgentStatus::Arrived {
            crowd.advance(crowd.time_s() + 0.1, &mut |_| {}).unwrap();
            let at = crowd.position(id, crowd.time_s()).unwrap();
            (way_m, before) = (way_m + at.distance(before), at);
        }
        let took_s = crowd.time_s();
        crowd.advance(took_s + 5.0, &mut |_| {}).unwrap();
        let stands = crowd.velocity(id, crowd.time_s()).unwrap().length() < 0.1;
        if way_m > 215.0 || took_s > 240.0 || !stands {
            faults.push(format!("{speed} m/s, {acceleration} m/s2: {way_m:.1} m in {took_s:.1} s, stands: {stands}"));
        }
    }
    assert!(faults.is_empty(), "174 m along the points: {faults:#?}");
}
