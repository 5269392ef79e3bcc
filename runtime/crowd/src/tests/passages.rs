//! Narrow places: they are found from what stands, and two streams take turns there.

use super::{Drive, Shares};
use crate::events::engine::Engine;
use crate::routes::passages::Passages;
use crate::*;
use glam::{Vec2, Vec3};

fn wall(from: [f32; 2], to: [f32; 2]) -> Obstacle {
    let at = |[x, z]: [f32; 2]| Vec3::new(x, 0.0, z);
    Obstacle::Wall { from: at(from), to: at(to), radius: 0.1 }
}

/// Walls along the points, and the same mirrored at x = 0.
fn mirrored(points: &[[f32; 2]]) -> Vec<Obstacle> {
    let mirror = |[x, z]: [f32; 2], side: f32| [side * x, z];
    let wall = |w: &[[f32; 2]]| [1.0, -1.0].map(|side| wall(mirror(w[0], side), mirror(w[1], side)));
    points.windows(2).flat_map(wall).collect()
}

/// A wall with a passage of a width and length along z (m).
fn passage(width: f32, length: f32) -> Vec<Obstacle> {
    let (x, z) = (0.5 * width + 0.1, 0.5 * length - 0.1);
    mirrored(&[[20.0, -z], [x, -z], [x, z], [20.0, z]])
}

fn found(walls: &[Obstacle]) -> usize {
    Passages::find(&Streets::new(walls, 0.45).unwrap(), 0.3).len()
}

#[test]
fn narrow_places_are_found_from_what_stands() {
    for length in [0.2, 0.9, 3.0, 12.0] {
        assert_eq!(found(&passage(1.0, length)), 1, "{length} m long");
        assert_eq!(found(&passage(2.0, length)), 0, "{length} m long and wide");
        assert_eq!(found(&passage(0.5, length)), 0, "{length} m long, and nobody fits in");
    }
    let door = |x: f32, z: f32| [wall([x - 9.0, z], [x - 0.6, z]), wall([x + 0.6, z], [x + 9.0, z])];
    assert_eq!(found(&[door(0.0, 0.0), door(0.0, 9.0)].concat()), 2, "two doors");
    let sides = [-1.6f32, 1.6].map(|x| wall([x, 0.0], [x, 1.0]));
    assert_eq!(found(&[&door(0.0, 0.0)[..], &door(0.0, 1.0), &sides].concat()), 1, "nobody can wait between them");
    let posts = [-0.6f32, 0.6].map(|x| Obstacle::Ball { centre: Vec3::X * x, radius: 0.1 });
    assert_eq!(found(&posts), 1, "between two posts");
    // A corridor of 1 m round a corner, with a dead end of the same width beside it.
    let bent = [
        wall([-0.6, -6.0], [-0.6, 0.6]),
        wall([-0.6, 0.6], [6.0, 0.6]),
        wall([0.6, -6.0], [0.6, -0.6]),
        wall([0.6, -0.6], [6.0, -0.6]),
    ];
    assert_eq!(found(&bent), 1, "round a corner");
    let dead = [wall([0.0, 0.0], [0.0, 5.0]), wall([1.2, 0.0], [1.2, 5.0]), wall([0.0, 5.0], [1.2, 5.0])];
    assert_eq!(found(&dead), 0, "a dead end");
    assert_eq!(found(&[]), 0);
}

/// So many people on each side of a passage that want to the other side; they leave there. Number that is not through
/// after a time, and the deepest overlap (m).
fn left_over(walls: &[Obstacle], num: usize, seconds: usize, seed: u64) -> (usize, f32) {
    let mut shares = Shares(seed);
    let far = walls.iter().fold(0.0f32, |far, w| if let Obstacle::Wall { to, .. } = w { far.max(to.z) } else { far });
    let mut setup = CrowdSetup::default();
    for side in [-1.0f32, 1.0] {
        for i in 0..num {
            let jitter = (Vec2::new(shares.next(), shares.next()) - 0.5) * 0.3;
            let at = Vec2::new((i % 8) as f32 - 3.5, side * (far + 2.0 + (i / 8) as f32)) + jitter;
            setup.agents.push(Agent { position: at, route: Some(setup.routes.len()), ..Agent::default() });
            let to = Vec2::new(at.x, -side * (far + 9.0));
            setup.routes.push(Route { subgoals: vec![to], arrival_radius: 1.0, at_end: AtEnd::Leave });
        }
    }
    setup.obstacles = walls.iter().map(|o| o.clone().map(Vec2::from_world)).collect();
    setup.streets = Some(Streets::new(walls, 0.45).unwrap());
    let mut crowd = Engine::new(setup).unwrap();
    let mut deepest = f32::NEG_INFINITY;
    for tenth in 1..=10 * seconds {
        crowd.advance(0.1 * tenth as f64, &mut |_| {}).unwrap();
        let here: Vec<Vec2> = crowd.ids().filter_map(|id| crowd.agent(id)).map(|m| m.position).collect();
        for (i, a) in here.iter().enumerate() {
            deepest = here[..i].iter().map(|b| 0.6 - a.distance(*b)).fold(deepest, f32::max);
        }
    }
    (crowd.num_agents(), deepest)
}

#[test]
fn two_streams_take_turns_at_a_passage() {
    for length in [0.2, 1.0, 2.0, 3.0, 6.0] {
        let (left, deepest) = left_over(&passage(1.0, length), 40, 180, 3);
        assert!(left == 0 && deepest < 0.0, "{length} m: {left} of 80 are left, {deepest} m deep");
    }
}

#[test]
fn two_streams_take_turns_where_two_barely_pass() {
    for (width, length) in [(1.35, 0.2), (1.4, 2.0), (1.5, 2.0)] {
        let (left, deepest) = left_over(&passage(width, length), 40, 180, 11);
        assert!(left == 0 && deepest < 0.0, "{width} m wide, {length} m long: {left} of 80 are left, {deepest} m deep");
    }
}

#[test]
fn three_meet_three_in_a_passage() {
    for seed in 1..6 {
        let (left, deepest) = left_over(&passage(1.0, 6.0), 3, 60, seed);
        assert!(left == 0 && deepest < 0.0, "{left} of 6 are left");
    }
}

#[test]
fn stairs_and_a_narrow_bridge_between_them_are_one_passage() {
    // Stairs 2 m wide, of 6 m each, a bridge of 8 m between them, and a wall on the ground below it.
    let narrow = stairs_and_bridge(1.2);
    assert_eq!(narrow.len(), 1);
    let is_inside = |at: Vec3| {
        let found = narrow.find_use(Vec2::new(at.x, at.z), Vec2::new(30.0, 0.0), at.y);
        found.is_some_and(|found| found.is_inside)
    };
    let places = [[-8.0, 1.0, 0.0], [-4.0, 3.0, 0.0], [0.0, 3.0, 0.0], [7.0, 1.5, 0.5]];
    assert_eq!(places.map(|at| is_inside(Vec3::from(at))), [true; 4]);
    assert!(!is_inside(Vec3::ZERO), "below the bridge");
    assert_eq!(stairs_and_bridge(2.0).len(), 0, "two meet on stairs as wide as these");
}

/// Passages of stairs with a bridge of a width (m) between them.
fn stairs_and_bridge(width: f32) -> Passages {
    let mut walls = vec![([Vec3::new(-4.0, 0.0, -1.0), Vec3::new(-4.0, 0.0, 1.0)], [0.0, 0.0])];
    for side in [-1.0f32, 1.0] {
        let mut add = |[from, to]: [[f32; 3]; 2]| {
            for x in [-1.0, 1.0] {
                let at = |[along, y, z]: [f32; 3]| Vec3::new(x * along, y, side * z);
                walls.push(([at(from), at(to)], [from[1].min(to[1]), from[1].max(to[1])]));
            }
        };
        let half = 0.5 * width;
        add([[0.0, 3.0, half], [4.0, 3.0, half]]);
        add([[4.0, 3.0, half], [4.0, 3.0, 1.0]]);
        for k in 0..6 {
            let (x, y) = (4.0 + k as f32, 3.0 - 0.5 * k as f32);
            add([[x, y, 1.0], [x + 1.0, y - 0.5, 1.0]]);
        }
    }
    let solid: Vec<Obstacle> =
        walls.iter().map(|([from, to], _)| Obstacle::Wall { from: *from, to: *to, radius: 0.0 }).collect();
    let streets = Streets::of_level(&solid, walls.iter().map(|(_, floor)| *floor).collect(), 0.4).unwrap();
    Passages::find_below(&streets, 0.4, &[1.76], 3.5)
}
