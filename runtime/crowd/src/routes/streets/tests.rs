//! Paths over the ground.

use super::*;
use crate::routes::streets::search::path_length;
use proptest::prelude::*;
use std::collections::BinaryHeap;
use std::f32::consts::{FRAC_PI_2, SQRT_2};

fn ground([x, z]: [f32; 2]) -> Vec3 {
    Vec3::new(x, 0.0, z)
}

fn wall(from: [f32; 2], to: [f32; 2]) -> Obstacle {
    Obstacle::Wall { from: ground(from), to: ground(to), radius: 0.0 }
}

fn streets(obstacles: Vec<Obstacle>, clearance: f32, nearest: f32) -> Streets {
    Streets::with_limits(&obstacles, None, clearance, nearest).unwrap()
}

/// Length of the shortest path over a fine grid whose steps keep the clearance: brute force.
fn over_grid(map: &Streets, from: Vec2, to: Vec2, half: f32, step: f32) -> Option<f32> {
    let n = (2.0 * half / step) as i32 + 1;
    let at = |i: i32| Vec2::new((i % n) as f32, (i / n) as f32) * step - half;
    let index = |p: Vec2| {
        let c = ((p + half) / step).round();
        c.y as i32 * n + c.x as i32
    };
    // Sixteen directions: paths over a grid are at most 3 % longer than straight ones.
    let mut moves = Vec::new();
    for dx in -2i32..=2 {
        for dz in -2i32..=2 {
            let is_primitive = (dx.abs(), dz.abs()) != (2, 2) && (dx, dz) != (0, 0) && dx.abs() + dz.abs() != 2
                || (dx.abs(), dz.abs()) == (1, 1);
            if is_primitive {
                moves.push((dx, dz));
            }
        }
    }
    let mut best = vec![f32::INFINITY; (n * n) as usize];
    let mut open = BinaryHeap::from([(std::cmp::Reverse(0u64), index(from))]);
    best[index(from) as usize] = 0.0;
    while let Some((_, i)) = open.pop() {
        if i == index(to) {
            return Some(best[i as usize]);
        }
        for (dx, dz) in &moves {
            let (x, z) = (i % n + dx, i / n + dz);
            if x < 0 || z < 0 || x >= n || z >= n {
                continue;
            }
            let j = z * n + x;
            let then = best[i as usize] + at(i).distance(at(j));
            if then < best[j as usize] - 1e-5 && map.is_clear(at(i), at(j), map.clearance) {
                best[j as usize] = then;
                open.push((std::cmp::Reverse((then * 1e4) as u64), j));
            }
        }
    }
    None
}

#[test]
fn ways_are_as_short_as_over_a_grid_and_keep_the_clearance() {
    let scenes = [
        vec![wall([0.0, -3.0], [0.0, 2.0])],
        vec![wall([-1.0, -9.0], [-1.0, 2.0]), wall([1.5, -2.0], [1.5, 9.0])],
        vec![
            Obstacle::Polygon {
                corners: [[-1.0, -2.0], [1.0, -2.5], [2.0, 2.0], [0.0, 0.5], [-2.0, 3.0]].map(ground).to_vec(),
            },
            Obstacle::Ball { centre: ground([0.0, 4.5]), radius: 0.8 },
        ],
    ];
    for (s, solids) in scenes.into_iter().enumerate() {
        let map = streets(solids, 0.4, 0.3);
        for (from, to) in [([-4.0, 0.0], [4.0, 0.0]), ([-4.0, -4.0], [4.0, 3.0]), ([-4.0, 2.0], [3.0, -1.0])] {
            let (from, to) = (Vec2::from(from), Vec2::from(to));
            let path = map.flat_corners(from, to).unwrap();
            assert_eq!((path[0], path[path.len() - 1]), (from, to));
            for leg in path.windows(2) {
                assert!(map.is_clear(leg[0], leg[1], 0.399), "scene {s}: {leg:?}");
            }
            let brute = over_grid(&map, from, to, 6.0, 0.1).expect("a way over the grid");
            assert!(path_length(&path) <= 1.01 * brute, "scene {s}: {} against {brute}", path_length(&path));
            assert!(path_length(&path) >= 0.95 * brute, "scene {s}: {} against {brute}", path_length(&path));
        }
    }
}

/// Around the end of a wall: a tangent, an arc, a tangent.
#[test]
fn way_round_a_wall_end_is_nearly_shortest() {
    let map = streets(vec![wall([0.0, -50.0], [0.0, 0.0])], 1.0, 1.0);
    let reach = SQRT_2;
    let path = map.flat_corners(Vec2::new(-reach, 0.0), Vec2::new(reach, 0.0)).unwrap();
    let exact = 2.0 * 1.0 + FRAC_PI_2;
    assert!(path_length(&path) >= exact && path_length(&path) < 1.05 * exact, "{} against {exact}", path_length(&path));
}

#[test]
fn way_to_a_visible_goal_is_straight() {
    let map = streets(vec![wall([0.0, -3.0], [0.0, -1.0])], 0.4, 0.4);
    let ends = [Vec2::new(-2.0, 0.0), Vec2::new(2.0, 0.0)];
    assert_eq!(map.flat_corners(ends[0], ends[1]), Ok(ends.to_vec()));
}

#[test]
fn narrow_gaps_and_goals_in_walls_are_refused() {
    let gap = |half: f32| vec![wall([0.0, -9.0], [0.0, -half]), wall([0.0, half], [0.0, 9.0])];
    let room = [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0], [-9.0, -9.0]];
    let around = || room.windows(2).map(|w| wall(w[0], w[1]));
    let (from, to) = (Vec2::new(-3.0, 4.0), Vec2::new(3.0, 1.0));
    let wide = streets(gap(0.6).into_iter().chain(around()).collect(), 0.5, 0.4).flat_corners(from, to);
    assert!(wide.unwrap().len() > 2);
    let narrow = streets(gap(0.4).into_iter().chain(around()).collect(), 0.5, 0.4).flat_corners(from, to);
    assert_eq!(narrow, Err(NoPath::Separated));
    let block = Obstacle::Polygon { corners: [[2.0, 0.0], [4.0, 0.0], [4.0, 2.0], [2.0, 2.0]].map(ground).to_vec() };
    let map = streets(vec![block], 0.5, 0.3);
    assert_eq!(map.flat_corners(from, to), Err(NoPath::Goal(0)));
    assert_eq!(map.flat_corners(to, from), Err(NoPath::Start(0)));
    assert_eq!(map.flat_corners(from, Vec2::new(4.2, 1.0)), Err(NoPath::Goal(0)), "too near");
    assert!(map.flat_corners(from, Vec2::new(4.4, 1.0)).is_ok(), "nearer than the clearance, but not too near");
    assert!(map.flat_corners(Vec2::new(4.2, 1.0), from).is_ok(), "an agent at the wall gets away from it");
}

#[test]
fn routes_turn_at_corners_and_are_refused_through_blocks() {
    let block = Obstacle::Box { min: ground([-1.0, -4.0]), max: ground([1.0, 4.0]) };
    let streets = Streets::new(&[block], 0.4).unwrap();
    let (from, to) = (ground([-5.0, 0.0]), ground([5.0, 0.0]));
    let route = streets.route(from, to).unwrap();
    assert!(route.subgoals.len() > 2 && route.subgoals.iter().any(|p| p.z.abs() > 4.3), "{route:?}");
    assert_eq!(streets.route(from, from + Vec3::Z).unwrap().subgoals, [from + Vec3::Z], "nothing is in the way");
    let inside = streets.route(from, Vec3::ZERO).unwrap_err();
    assert!(matches!(inside, Error::NoPath { to: Vec3::ZERO, .. }), "{inside}");
    assert!(matches!(Streets::new(&[], 0.0), Err(Error::Value { what: "clearance_m", .. })));
}

#[test]
fn more_corners_than_a_graph_has_room_for_are_refused() {
    let balls = |num: usize| vec![Obstacle::Ball { centre: ground([3.0, 0.0]), radius: 1.0 }; num];
    let e = Streets::new(&balls(4001), 0.4).unwrap_err().to_string();
    assert!(e.contains("corners") && e.contains("4001") && e.contains("at most 4000"), "{e}");
    let boxes: Vec<_> = (0..400).map(|n| ([(n % 20) as f32 * 9.0, (n / 20) as f32 * 9.0], 6.0)).collect();
    let block =
        |&([x, z], size): &([f32; 2], f32)| Obstacle::Box { min: ground([x, z]), max: ground([x + size, z + size]) };
    let map = Streets::new(&boxes.iter().map(block).collect::<Vec<_>>(), 0.4).unwrap();
    let path = map.corners(ground([-2.0, -2.0]), ground([180.0, 180.0])).unwrap();
    let flat: Vec<Vec2> = path.iter().map(|p| p.xz()).collect();
    assert!(path_length(&flat) < 182.0 * 2.0 && path_length(&flat) > 182.0 * SQRT_2, "{}", path_length(&flat));
}

/// Two rooms with a door between them, and a path round the wall or none.
fn rooms(far: f32) -> Vec<Obstacle> {
    vec![wall([0.0, -far], [0.0, -0.6]), wall([0.0, 0.6], [0.0, far + 1.0]), wall([0.0, -0.6], [0.0, 0.6])]
}

#[test]
fn ways_lead_through_open_doors_and_round_closed_ones() {
    let mut map = streets(rooms(8.0), 0.4, 0.3);
    let (from, to) = (Vec2::new(-3.0, 4.0), Vec2::new(3.0, 1.0));
    let closed = map.flat_corners(from, to).unwrap();
    map.set_open(2, true).unwrap();
    let open = map.flat_corners(from, to).unwrap();
    // As if the door were not there.
    let without = streets(rooms(8.0)[..2].to_vec(), 0.4, 0.3).flat_corners(from, to).unwrap();
    assert!((path_length(&open) - path_length(&without)).abs() < 1e-3, "{open:?} {without:?}");
    assert!(path_length(&open) < 0.7 * path_length(&closed));
    map.set_open(2, false).unwrap();
    let again = map.flat_corners(from, to).unwrap();
    assert!((path_length(&again) - path_length(&closed)).abs() < 1e-3, "{again:?} {closed:?}");
    assert!(map.set_open(3, true).is_err());
}

#[test]
fn ways_lead_to_a_closed_door_where_no_other_leads_on() {
    let room = [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0], [-9.0, -9.0]];
    let around = room.windows(2).map(|w| wall(w[0], w[1]));
    let mut map = streets(rooms(9.0).into_iter().chain(around).collect(), 0.4, 0.3);
    let (from, to) = (Vec2::new(-3.0, 4.0), Vec2::new(3.0, 1.0));
    assert_eq!(map.flat_corners(from, to), Err(NoPath::Separated));
    map.set_open(2, true).unwrap();
    let open = map.flat_corners(from, to).unwrap();
    map.set_open(2, false).unwrap();
    assert_eq!(map.flat_corners(from, to), Ok(open), "it was a door once");
    // Two doors beside each other, one closed.
    let doors = [wall([0.0, -5.0], [0.0, -3.8])];
    let mut walls = vec![wall([0.0, -9.0], [0.0, -5.0]), wall([0.0, -3.8], [0.0, -0.6])];
    walls.extend(rooms(9.0)[1..].iter().cloned().chain(doors));
    walls.extend(room.windows(2).map(|w| wall(w[0], w[1])));
    let mut map = streets(walls, 0.4, 0.3);
    for (first, second) in [(3, 4), (4, 3)] {
        map.set_open(second, false).unwrap();
        map.set_open(first, true).unwrap();
        let path = map.flat_corners(from, to).unwrap();
        let (z, half) = if first == 3 { (0.0, 0.6) } else { (-4.4, 0.6) };
        let at = |w: &[Vec2]| w[0].lerp(w[1], w[0].x / (w[0].x - w[1].x)).y;
        let crosses = path.windows(2).find(|w| w[0].x <= 0.0 && w[1].x > 0.0).map(at).unwrap();
        assert!((crosses - z).abs() < half, "door {first}: {path:?}");
    }
}

#[test]
fn ways_in_the_air_pass_above_what_is_low_and_rise_evenly() {
    let column = |x: f32, high: f32| Obstacle::Wall { from: Vec3::X * x, to: Vec3::new(x, high, 0.0), radius: 1.0 };
    let streets = Streets::with_limits(&[column(5.0, 3.0), column(0.0, 30.0)], Some([5.0, 20.0]), 1.5, 1.0).unwrap();
    let (from, to) = (Vec3::new(-9.0, 6.0, 0.0), Vec3::new(9.0, 16.0, 0.0));
    let path = streets.corners(from, to).unwrap();
    assert!(path.len() > 2 && path[0] == from && path[path.len() - 1] == to, "{path:?}");
    assert!(path.windows(2).all(|w| w[0].y < w[1].y), "{path:?}");
    assert_eq!(streets.corners(from, Vec3::new(0.0, 9.0, 0.5)), Err(NoPath::Goal(1)));
}

fn many_outlines() -> impl Strategy<Value = Vec<Obstacle>> {
    let place = || [-50.0f32..50.0, -20.0f32..20.0];
    let one = prop_oneof![
        (place(), place()).prop_map(|(a, b)| wall(a, b)),
        (place(), 0.1f32..3.0).prop_map(|(c, radius)| Obstacle::Ball { centre: ground(c), radius }),
        (place(), [0.1f32..9.0, 0.1f32..9.0])
            .prop_map(|(a, size)| Obstacle::Box { min: ground(a), max: ground([a[0] + size[0], a[1] + size[1]]) }),
        (place(), prop::collection::vec(0.5f32..8.0, 3..9)).prop_map(|(c, reach)| {
            let turn = std::f32::consts::TAU / reach.len() as f32;
            let corner = |(i, r): (usize, &f32)| (Vec2::from(c) + Vec2::from_angle(turn * i as f32) * *r).to_array();
            Obstacle::Polygon { corners: reach.iter().enumerate().map(corner).map(ground).collect() }
        }),
    ];
    prop::collection::vec(one, 0..60)
}

proptest! {
    #[test]
    fn lines_come_near_to_what_they_come_near_to_one_by_one(
        obstacles in many_outlines(),
        lines in prop::collection::vec(([-70.0f32..70.0, -40.0f32..40.0], [-70.0f32..70.0, -40.0f32..40.0], 0..5), 40),
        clearance in prop_oneof![Just(0.0f32), 0.01f32..3.0],
    ) {
        let map = streets(obstacles, 0.4, 0.2);
        for (from, to, kind) in lines {
            let from = Vec2::from(from);
            // Points, and lines along an axis, too.
            let to = match kind {
                0 => from,
                1 => Vec2::new(from.x, to[1]),
                2 => Vec2::new(to[0], from.y),
                _ => Vec2::from(to),
            };
            let mut found = vec![false; map.outlines.len()];
            map.edges.find_near(&map.outlines, [from, to], clearance, |n| {
                found[n] = true;
                true
            });
            let near: Vec<bool> = map.outlines.iter().map(|o| o.distance_of_line(from, to) < clearance).collect();
            prop_assert_eq!(&found, &near, "{} {}", from, to);
            let is_free = map.edges.find_near(&map.outlines, [from, to], clearance, |_| false);
            prop_assert_eq!(is_free, !near.contains(&true));
        }
    }
}
