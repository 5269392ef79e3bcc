//! Bodies that navigation leads, and that something else moves.

use crate::*;
use glam::{Vec2, Vec3};

#[test]
fn bodies_go_straight_through_an_open_door_and_round_a_shut_one() {
    let wall = |from: f32, to: f32| Obstacle::Wall { from: Vec3::X * from, to: Vec3::X * to, radius: 0.1 };
    let mut streets = Streets::new(&[wall(-9.0, -1.0), wall(-1.0, 1.0), wall(1.0, 5.0)], 0.45).unwrap();
    streets.set_open(1, true).unwrap();
    let mut navigation = Navigation::new(&streets, 0.3, 1.3, 1).unwrap();
    let at = Vec2::new(0.0, -0.8);
    let route = Route { subgoals: vec![Vec2::new(0.0, 6.0)], arrival_radius: 0.5, at_end: AtEnd::Stay };
    navigation.add_body(&route, at).unwrap();
    let mut time_s = 0.0;
    for open in [true, false, true] {
        navigation.set_open(1, open).unwrap();
        for _ in 0..12 {
            navigation.update(time_s, |_| Some(NavigatedBody { position: at, velocity: Vec2::ZERO, height_m: 0.0 }));
            time_s += 0.05;
        }
        let NavigationAim { position, velocity, .. } = navigation.aim(0);
        let round = position.x > 5.0 && velocity.x > 0.8;
        let straight = position == Vec2::new(0.0, 6.0) && velocity.y > 1.2;
        assert!(if open { straight } else { round }, "{open}: to {position} at {velocity}");
    }
    assert!(navigation.set_open(3, true).is_err());
}

#[test]
fn a_body_that_stops_short_of_the_end_of_a_round_goes_back() {
    let (from, to) = (Vec2::ZERO, Vec2::new(15.0, 0.0));
    for [off, stops_m] in [[0.0, 0.4], [1.2, 0.4], [-1.2, 0.55], [2.0, 0.1]] {
        let mut navigation = Navigation::new(&Streets::new(&[], 0.3).unwrap(), 0.3, 1.3, 1).unwrap();
        let route = Route { subgoals: vec![from, to, from], arrival_radius: 0.5, at_end: AtEnd::Again };
        navigation.add_body(&route, from).unwrap();
        let (mut at, mut moves, mut ends) = (from, Vec2::ZERO, Vec::new());
        for step in 0..60 * 30 {
            let body = NavigatedBody { position: at, velocity: moves * 30.0, height_m: 0.0 };
            navigation.update(f64::from(step) / 30.0, |_| Some(body));
            let aim = navigation.aim(0);
            let left = aim.position - at;
            let ahead = if left.length() > 0.1 { left } else { moves };
            moves =
                if left.length() + aim.rest_m > stops_m { ahead.normalize_or_zero() * 1.3 / 30.0 } else { Vec2::ZERO };
            // Somebody pushes it aside.
            at += moves + if step == 90 { Vec2::new(0.0, off) } else { Vec2::ZERO };
            let end = if at.x < 1.0 {
                0
            } else if at.x > 14.0 {
                1
            } else {
                continue;
            };
            if ends.last() != Some(&end) {
                ends.push(end);
            }
        }
        assert!(ends.len() >= 5, "{off} {stops_m}: {ends:?}, now at {at}");
    }
}
