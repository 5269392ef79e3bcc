//! Tests of small crowds that would jam if all agents just pressed on.

use super::{Drive, Shares};
use crate::events::engine::Engine;
use crate::*;
use glam::Vec2;

/// An agent that goes from a place through some others, and leaves at the last one.
fn add(setup: &mut CrowdSetup<Vec2>, from: Vec2, through: &[Vec2]) {
    setup.agents.push(Agent { position: from, route: Some(setup.routes.len()), ..Agent::default() });
    setup.routes.push(Route { subgoals: through.to_vec(), arrival_radius: 1.0, at_end: AtEnd::Leave });
}

fn wall(from: [f32; 2], to: [f32; 2], radius: f32) -> Obstacle<Vec2> {
    Obstacle::Wall { from: Vec2::from_array(from), to: Vec2::from_array(to), radius }
}

/// Record of a run, ten times a second.
#[derive(Default)]
struct JamRecord {
    /// Agents that are not gone at the end.
    left_over: usize,
    /// Deepest overlap (m).
    deepest: f32,
    /// Seconds spent by agents that turned back and forth more than twice a second and did not move on.
    trembling: f32,
}

fn run(setup: CrowdSetup<Vec2>, seconds: usize) -> JamRecord {
    let mut crowd = Engine::new(setup).unwrap();
    let mut report = JamRecord { deepest: f32::NEG_INFINITY, ..JamRecord::default() };
    for second in 0..seconds {
        let ids: Vec<Id> = crowd.ids().collect();
        let start: Vec<Vec2> = ids.iter().map(|&id| crowd.position(id, crowd.now).unwrap()).collect();
        let mut turns = vec![0; ids.len()];
        let mut before = vec![Vec2::ZERO; ids.len()];
        for tenth in 1..=10 {
            crowd.advance(second as f64 + 0.1 * f64::from(tenth), &mut |_| {}).unwrap();
            let here: Vec<(Vec2, f32)> =
                crowd.ids().filter_map(|id| crowd.agent(id)).map(|m| (m.position, m.radius)).collect();
            for (i, (a, r)) in here.iter().enumerate() {
                let depth = here[..i].iter().map(|(b, s)| r + s - a.distance(*b));
                report.deepest = depth.fold(report.deepest, f32::max);
            }
            for (i, &id) in ids.iter().enumerate() {
                let velocity = crowd.velocity(id, crowd.now).unwrap_or_default();
                if velocity.length() > 0.05 {
                    turns[i] += usize::from(velocity.dot(before[i]) < 0.0);
                    before[i] = velocity;
                }
            }
        }
        let trembles = |i: &usize| {
            let stays = crowd.position(ids[*i], crowd.now).is_some_and(|x| x.distance(start[*i]) < 0.2);
            stays && turns[*i] > 2
        };
        report.trembling += (0..ids.len()).filter(trembles).count() as f32;
    }
    report.left_over = crowd.num_agents();
    report
}

/// Walls along X, longer than any agent walks.
fn corridor(sides: [f32; 2]) -> Vec<Obstacle<Vec2>> {
    sides.map(|y| wall([-120.0, y], [120.0, y], 0.0)).to_vec()
}

#[test]
fn two_groups_pass_in_a_narrow_corridor() {
    let mut setup = CrowdSetup::default();
    let mut shares = Shares(5);
    for side in [-1.0f32, 1.0] {
        for i in 0..20 {
            let jitter = Vec2::new(shares.next(), shares.next()) * 0.2;
            let from = Vec2::new(side * (2.5 + (i / 4) as f32), (i % 4) as f32 - 1.6) + jitter;
            add(&mut setup, from, &[from - Vec2::X * (side * 25.0)]);
        }
    }
    setup.obstacles = corridor([-2.0, 2.0]);
    let report = run(setup, 45);
    assert_eq!(report.left_over, 0);
    assert!(report.deepest < 0.0 && report.trembling < 20.0, "{} m, {} s", report.deepest, report.trembling);
}

#[test]
fn smaller_group_steps_back_in_a_corridor() {
    let mut left_over = 0;
    for seed in 100..112 {
        let mut setup = CrowdSetup::default();
        let mut shares = Shares(seed);
        for (side, num) in [(-1.0f32, 8), (1.0, 30)] {
            for i in 0..num {
                let jitter = Vec2::new(shares.next(), shares.next()) * 0.1;
                let from = Vec2::new(side * (1.5 + (i / 3) as f32 * 0.75), (i % 3) as f32 * 0.75 - 0.85) + jitter;
                add(&mut setup, from, &[from - Vec2::X * (side * 25.0)]);
            }
        }
        setup.obstacles = corridor([-1.2, 1.2]);
        left_over += run(setup, 65).left_over;
    }
    // If none did, more than a third of all 456 would be there still.
    assert!(left_over < 50, "{left_over}");
}

#[test]
fn two_crowds_pass_in_narrow_corridors() {
    // Width, agents of either crowd, and how far the corridor is to the side of where cells are parted. The last ones are
    // there after 110 s.
    for (width, num, aside) in [(2.2f32, 40, 0.0), (2.8, 60, 0.0), (3.3, 50, 0.0), (3.3, 50, 0.9), (4.4, 100, 0.0)] {
        let mut setup = CrowdSetup::default();
        let mut shares = Shares(7);
        let columns = width as usize;
        let apart = (width - 0.7) / (columns - 1) as f32;
        for side in [-1.0f32, 1.0] {
            for i in 0..num {
                let (row, column) = ((i / columns) as f32, (i % columns) as f32);
                let jitter = (Vec2::new(shares.next(), shares.next()) - 0.5) * 0.05;
                let from = Vec2::new(side * (2.0 + row), column * apart - 0.5 * (width - 0.7) + aside) + jitter;
                add(&mut setup, from, &[from - Vec2::X * (side * (4.0 + 2.0 * (num / columns) as f32))]);
            }
        }
        setup.obstacles = corridor([aside - 0.5 * width, aside + 0.5 * width]);
        let report = run(setup, 110);
        assert_eq!(report.left_over, 0, "{width} m wide");
        assert!(report.deepest < 0.0, "{width} m wide: {} m", report.deepest);
    }
}

/// Agents of a row, each `apart` from the next, in rows as far apart; wanted along X, `far`.
fn rows(setup: &mut CrowdSetup<Vec2>, num: usize, (width, apart): (f32, f32), (side, begin, far): (f32, f32, f32)) {
    let mut shares = Shares(11);
    let columns = (width / apart) as usize;
    for i in 0..num {
        let (row, column) = ((i / columns) as f32, (i % columns) as f32 + 0.5);
        let jitter = (Vec2::new(shares.next(), shares.next()) - 0.5) * (0.8 * (apart - 0.602));
        let from = Vec2::new(side * (begin + row * apart), column * apart - 0.5 * width) + jitter;
        add(setup, from, &[from - Vec2::X * (side * far)]);
    }
}

/// Mean progress of all agents that are still there, from the start on (m/s).
fn progress(setup: CrowdSetup<Vec2>, seconds: f64) -> f32 {
    let mut crowd = Engine::new(setup).unwrap();
    let before: Vec<f32> = crowd.ids().map(|id| crowd.distance_left(id).unwrap()).collect();
    crowd.advance(seconds, &mut |_| {}).unwrap();
    let gained: f32 = crowd.ids().map(|id| before[id.index()] - crowd.distance_left(id).unwrap()).sum();
    gained / crowd.num_agents() as f32 / seconds as f32
}

#[test]
fn one_way_crowd_keeps_its_speed() {
    // Three on two square metres, from rest.
    let mut setup = CrowdSetup::default();
    rows(&mut setup, 300, (6.0, 0.816), (1.0, 0.0, 100.0));
    setup.obstacles = corridor([-3.3, 3.3]);
    // If all turned to where the way is free longest, 0.95 m/s.
    let got = progress(setup, 12.0);
    assert!(got > 1.02, "{got} m/s");
}

#[test]
fn two_crowds_pass_side_by_side_in_a_street() {
    let mut setup = CrowdSetup::default();
    for side in [-1.0f32, 1.0] {
        rows(&mut setup, 240, (10.0, 1.0), (side, 2.0, 60.0));
    }
    setup.obstacles = corridor([-5.2, 5.2]);
    // If all turned to where the way is free longest, and kept less to the right, 0.73 m/s.
    let got = progress(setup, 20.0);
    assert!(got > 0.79, "{got} m/s");
}

#[test]
fn rows_before_a_gap_go_through() {
    let mut setup = CrowdSetup::default();
    for (x, y) in [(-3.0, -0.3), (-3.0, 0.301), (-3.55, -0.6), (-3.55, 0.001), (-3.55, 0.602)] {
        add(&mut setup, Vec2::new(x, y), &[Vec2::new(-1.0, 0.0), Vec2::new(1.0, 0.0), Vec2::new(8.0, 0.0)]);
    }
    setup.obstacles = vec![wall([0.0, 1.2], [0.0, 500.0], 0.2), wall([0.0, -1.2], [0.0, -500.0], 0.2)];
    assert_eq!(run(setup, 20).left_over, 0);
}

#[test]
fn dense_packing_of_two_crowds_dissolves() {
    let mut setup = CrowdSetup::default();
    for i in 0..48 {
        let (row, column) = (i / 8, i % 8);
        let from = Vec2::new(column as f32 + 0.5 * (row % 2) as f32, row as f32 * 0.8661) * 0.6005;
        let side = if column < 4 { 1.0 } else { -1.0 };
        add(&mut setup, from, &[from + Vec2::X * (side * 20.0)]);
    }
    let report = run(setup, 45);
    assert_eq!(report.left_over, 0);
    assert!(report.deepest < 0.0 && report.trembling < 30.0, "{} m, {} s", report.deepest, report.trembling);
}

#[test]
fn agent_touching_long_wall_walks_on() {
    for x in [17.92, 111.3, -203.7] {
        let mut setup = CrowdSetup::default();
        let from = Vec2::new(x, 0.000_15);
        add(&mut setup, from, &[from + Vec2::new(-10.0, 0.3)]);
        setup.obstacles = vec![wall([-500.0, -0.3], [500.0, -0.3], 0.0)];
        assert_eq!(run(setup, 12).left_over, 0, "at {x}");
    }
}

#[test]
fn agents_at_their_goals_make_way() {
    let mut setup = CrowdSetup::default();
    // A ring of goals with gaps of 0.3 m; the last agent has to get in between standing ones.
    for i in 0..12 {
        let goal = Vec2::from_angle(i as f32 * std::f32::consts::TAU / 12.0) * 1.75;
        let from = if i == 0 { Vec2::new(-6.0, 0.1) } else { goal };
        setup.agents.push(Agent { position: from, route: Some(i), ..Agent::default() });
        setup.routes.push(Route { subgoals: vec![goal], arrival_radius: 0.5, at_end: AtEnd::Stay });
    }
    let mut crowd = Engine::new(setup).unwrap();
    let mut arrived = [false; 12];
    let mut note = |e: &CrowdEvent| arrived[e.agent.index()] |= e.kind == CrowdEventKind::Arrived;
    crowd.advance(25.0, &mut note).unwrap();
    assert_eq!(arrived, [true; 12]);
    let left = crowd.ids().map(|id| crowd.distance_left(id).unwrap()).fold(0.0, f32::max);
    assert!(left < 0.5, "all are at their places: {left} m");
}

#[test]
fn nobody_circles_where_a_route_turns_back() {
    let mut left_over = 0;
    for i in 0..60 {
        let [begin, corner] = [Vec2::new(0.0, -13.0), Vec2::ZERO];
        let [tip, end] = [Vec2::new(1.9, 13.0 + 0.05 * i as f32), Vec2::new(0.0, -18.0)];
        // Tied to the way near its corners, as scenes do.
        let tie = |from: Vec2, to: Vec2| from + (to - from).normalize() * 1.016;
        let through = [begin, tie(corner, begin), corner, tie(corner, tip), tie(tip, corner), tip, tie(tip, end), end];
        let mut setup = CrowdSetup::default();
        add(&mut setup, begin, &through);
        setup.agents[0].radius = 0.508;
        left_over += run(setup, 58).left_over;
    }
    assert_eq!(left_over, 0);
}

/// Two crowds head-on in a corridor of 10 m; each agent has so many points on its route. Mean progress of all (m/s).
fn with_points(num: usize) -> f32 {
    let mut setup = CrowdSetup::default();
    for side in [-1.0f32, 1.0] {
        rows(&mut setup, 150, (10.0, 1.0), (side, 2.0, 40.0));
    }
    for (route, agent) in setup.routes.iter_mut().zip(&setup.agents) {
        let goal = route.subgoals[0];
        let point = |i: usize| agent.position + (goal - agent.position) * (i as f32 / (num - 1) as f32);
        if num > 1 {
            route.subgoals = (0..num).map(point).collect();
        }
    }
    setup.obstacles = corridor([-5.2, 5.2]);
    progress(setup, 20.0)
}

#[test]
fn routes_of_one_two_or_many_points_are_walked_alike() {
    let one = with_points(1);
    for num in [2, 3, 20] {
        let many = with_points(num);
        assert!((many - one).abs() < 0.05 * one, "{num} points: {many} m/s, one: {one} m/s");
    }
}

/// Two streams through a bend of 90 degrees, 8 m wide: all get through, and the outer half is used.
#[test]
fn two_ways_use_the_width_of_a_bend() {
    let obstacles = vec![
        wall([-60.0, -4.0], [4.0, -4.0], 0.0),
        wall([4.0, -4.0], [4.0, 60.0], 0.0),
        wall([-60.0, 4.0], [-4.0, 4.0], 0.0),
        wall([-4.0, 4.0], [-4.0, 60.0], 0.0),
    ];
    let mut setup = CrowdSetup { obstacles, ..CrowdSetup::default() };
    let mut shares = Shares(5);
    for i in 0..240 {
        let (row, column) = ((i / 2 / 6) as f32, (i / 2 % 6) as f32);
        let jitter = (Vec2::new(shares.next(), shares.next()) - 0.5) * 0.4;
        let from = Vec2::new(-7.0 - 1.2 * row, 1.2 * (column - 2.5)) + jitter;
        let to = Vec2::new(3.0 * (2.0 * shares.next() - 1.0), 16.0 + 8.0 * shares.next());
        // The other way is the same, mirrored at the diagonal of the corner.
        let mirror = |p: Vec2| Vec2::new(-p.y, -p.x);
        if i % 2 == 0 { add(&mut setup, from, &[to]) } else { add(&mut setup, mirror(from), &[mirror(to)]) }
    }
    let world = setup.obstacles.iter().map(|o| o.clone().map(|p: Vec2| p.to_world())).collect::<Vec<_>>();
    setup.streets = Some(Streets::new(&world, 0.45).unwrap());
    let mut crowd = Engine::new(setup).unwrap();
    let mut outer = 0;
    for second in 1..=100 {
        crowd.advance(f64::from(second), &mut |_| {}).unwrap();
        let here = crowd.ids().filter_map(|id| crowd.agent(id));
        // In the corner, and farther from the inner corner than the middle of the way.
        outer += here
            .filter(|a| a.position.x.abs() < 4.0 && a.position.y.abs() < 4.0 && a.position.x > a.position.y)
            .count();
    }
    assert_eq!(crowd.num_agents(), 0, "all are through");
    assert!(outer > 30, "{outer} looks at agents in the outer half");
}
