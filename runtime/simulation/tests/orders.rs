//! Promise: an application orders people alike, whatever moves them; they do that until another order, and snapshots keep it.

use crate::snapshot::scenes::{PATCHES, TRAVELLERS, boxing, compile};
use glam::{Vec2, Vec3};
use throng_base::Error;
use throng_simulation::{CharacterEvent, Order, Simulation};

const AGENTS: &str = r#"
[[environment.obstacles]]
wall = { points = [[0.0, -2.0], [0.0, 6.0]], radius_m = 0.1 }

[[groups]]
name = "bodies"
motion = "blend"
bundle = "GOLDEN"
spaces = ["walks"]
count = 2
place = { block = { from = [-6.0, -1.0], to = [-3.0, 3.0] } }
goal = { shift = { by = [0.0, 0.5] } }

[[groups]]
name = "discs"
motion = "none"
count = 2
place = { block = { from = [-6.0, 8.0], to = [-3.0, 10.0] } }
goal = { shift = { by = [0.0, 0.5] } }

[values]
courage = { start = [0.2, 0.2] }

[[events]]
name = "bell"

[[rules]]
name = "dare"
on = "courage > 0.5"
do = [{ go = [-12.0, -9.0] }, { stay = 100.0 }]
[[rules]]
name = "listen"
on = "bell"
do = [{ go = [-14.0, 12.0] }, { stay = 100.0 }]
"#;

fn simulation(scene: &str) -> Simulation {
    Simulation::new(&compile(scene, &boxing(0.0))).unwrap()
}

fn at(sim: &Simulation, who: usize) -> Vec2 {
    let root = sim.root(who).unwrap();
    Vec2::new(root.x, root.z)
}

/// Steps for some seconds; the people who arrive.
fn step(sim: &mut Simulation, seconds: f64) -> Vec<usize> {
    let mut arrived = Vec::new();
    for _ in 0..(seconds * 30.0) as usize {
        sim.step(1.0 / 30.0).unwrap();
        arrived.extend(sim.events().iter().filter(|e| e.kind == CharacterEvent::Arrived).map(|e| e.who));
    }
    arrived
}

#[test]
fn agents_go_round_walls_face_as_told_stop_and_turn() {
    let mut sim = simulation(AGENTS);
    step(&mut sim, 2.0);
    let goals = [Vec2::new(4.0, 2.0), Vec2::new(4.0, -4.0), Vec2::new(5.0, 9.0)];
    for (who, goal) in goals.into_iter().enumerate() {
        sim.order(who, Order::go(Vec3::new(goal.x, 0.0, goal.y)).at_speed(1.5).arrive_facing(2.0)).unwrap();
    }
    let arrived = step(&mut sim, 20.0);
    for (who, goal) in goals.into_iter().enumerate() {
        assert!(arrived.contains(&who) && at(&sim, who).distance(goal) < 0.8, "{who} is at {}", at(&sim, who));
    }
    for who in [0, 1] {
        let off = (sim.root(who).unwrap().heading - 2.0).rem_euclid(std::f32::consts::TAU);
        assert!(off.min(std::f32::consts::TAU - off) < 0.3, "{who} faces {:?}", sim.root(who));
    }
    sim.order(0, Order::go(Vec3::new(4.0, 0.0, -20.0))).unwrap();
    step(&mut sim, 3.0);
    sim.order(0, Order::turn_to(0.0)).unwrap();
    let from = at(&sim, 0);
    step(&mut sim, 4.0);
    assert!(at(&sim, 0).distance(from) < 1.0 && sim.root(0).unwrap().heading.abs() < 0.3, "{:?}", sim.root(0));
    let stands = at(&sim, 0);
    step(&mut sim, 3.0);
    assert!(at(&sim, 0).distance(stands) < 0.1);
}

#[test]
fn agents_follow_and_are_steered() {
    let mut sim = simulation(AGENTS);
    sim.order(2, Order::go(Vec3::new(15.0, 0.0, 9.0))).unwrap();
    sim.order(0, Order::follow(2).keeping(2.0)).unwrap();
    step(&mut sim, 30.0);
    assert!(at(&sim, 2).x > 14.0, "{}", at(&sim, 2));
    let far = at(&sim, 0).distance(at(&sim, 2));
    assert!((1.0..3.0).contains(&far), "{far} m");
    let from = at(&sim, 3);
    sim.order(3, Order::steer(Vec2::new(1.0, 0.0))).unwrap();
    step(&mut sim, 3.0);
    let by = at(&sim, 3) - from;
    assert!((1.8..3.3).contains(&by.x) && by.y.abs() < 0.5, "{by}");
    // A wall is in the way: it stops there.
    sim.order(1, Order::steer(Vec2::new(2.0, 0.0))).unwrap();
    step(&mut sim, 6.0);
    let stands = at(&sim, 1);
    assert!((-1.5..0.0).contains(&stands.x), "{stands}");
    sim.order(1, Order::steer(Vec2::new(2.0, 0.0))).unwrap();
    step(&mut sim, 2.0);
    assert!(at(&sim, 1).distance(stands) < 0.3, "a wall at hand is no error, and nobody goes through it");
    sim.order(3, Order::steer(Vec2::ZERO)).unwrap();
    step(&mut sim, 2.0);
    let stands = at(&sim, 3);
    step(&mut sim, 2.0);
    assert!(at(&sim, 3).distance(stands) < 0.05);
    // Speeds of steering end with it.
    for slowly in [0.0, 0.2] {
        sim.order(3, Order::steer(Vec2::new(slowly, 0.0))).unwrap();
        step(&mut sim, 1.0);
        let goal = at(&sim, 3) + Vec2::new(0.0, -6.0);
        sim.order(3, Order::go(Vec3::new(goal.x, 0.0, goal.y))).unwrap();
        step(&mut sim, 9.0);
        assert!(at(&sim, 3).distance(goal) < 0.8, "after {slowly} m/s it is {} m off", at(&sim, 3).distance(goal));
    }
    // What is refused changes nothing.
    let before = sim.snapshot();
    let told = sim.order(3, Order::go(Vec3::new(0.0, 0.0, 0.0))).unwrap_err();
    assert!(matches!(told, Error::NoPath { .. }) && sim.snapshot() == before, "{told}");
    let told = sim.order(3, Order::steer(Vec2::new(200.0, 0.0))).unwrap_err().to_string();
    assert!(told.contains("velocity") && told.contains("200"), "{told}");
}

#[test]
fn a_rule_acts_on_one_agent_alone() {
    let mut sim = simulation(AGENTS);
    step(&mut sim, 1.0);
    sim.order(1, Order::go(Vec3::new(9.0, 0.0, -9.0))).unwrap();
    sim.set_value(1, "courage", 0.9).unwrap();
    sim.raise_event_for(2, "bell").unwrap();
    let others = [0, 3].map(|who| at(&sim, who));
    step(&mut sim, 25.0);
    assert!(at(&sim, 1).distance(Vec2::new(-12.0, -9.0)) < 1.0, "a rule takes the place of the order");
    assert!(at(&sim, 2).distance(Vec2::new(-14.0, 12.0)) < 1.0);
    assert!([0, 3].iter().zip(others).all(|(who, before)| at(&sim, *who).distance(before) < 1.0), "others stay");
    // A rule takes the place of an order whose goal moves, too.
    sim.order(2, Order::go(Vec3::new(8.0, 0.0, 12.0))).unwrap();
    sim.order(3, Order::follow(2)).unwrap();
    step(&mut sim, 2.0);
    sim.raise_event_for(3, "bell").unwrap();
    step(&mut sim, 20.0);
    assert!(at(&sim, 3).distance(Vec2::new(-14.0, 12.0)) < 1.0, "{} follows on", at(&sim, 3));
    let courage = |who| sim.explain(who).unwrap().values.into_iter().find(|v| v.name == "courage").unwrap().value;
    assert_eq!([0, 1].map(courage), [0.2, 0.9]);
    let fails = [
        (sim.set_value(0, "faith", 0.5), "courage"),
        (sim.set_value(0, "courage", f32::NAN), "finite"),
        (sim.raise_event_for(0, "gong"), "bell"),
        (sim.raise_event_for(9, "bell"), "there are 4"),
        (sim.order(9, Order::stop()), "there are 4"),
        (sim.order(0, Order::follow(0)), "somebody else"),
        (sim.order(0, Order::follow(4)), "there are 4"),
        (sim.order(0, Order::go(Vec3::NAN)), "finite"),
        (sim.order(0, Order::steer(Vec2::new(0.0, 200.0))), "100 m/s"),
        (sim.order(0, Order::go(Vec3::ZERO).at_speed(-1.0)), "0.01 to 100"),
        (sim.order(0, Order::turn_to(f32::INFINITY)), "finite"),
        (sim.order(0, Order::go(Vec3::new(0.0, 0.0, 2.0))), "no way"),
    ];
    for (result, part) in fails {
        let told = result.unwrap_err().to_string();
        assert!(told.contains(part), "{told}");
    }
    let mut patches = simulation(PATCHES);
    let told = patches.order(0, Order::stop()).unwrap_err().to_string();
    assert!(told.contains("scene.toml") && told.contains("take no orders"), "{told}");
}

#[test]
fn snapshots_keep_orders() {
    for scene in [AGENTS, TRAVELLERS] {
        let mut sim = simulation(scene);
        step(&mut sim, 1.0);
        sim.order(0, Order::follow(2)).unwrap();
        sim.order(1, Order::turn_to(1.0)).unwrap();
        sim.order(2, Order::go(Vec3::new(-8.0, 0.0, 55.0)).arrive_facing(1.0)).unwrap();
        step(&mut sim, 4.3);
        let kept = sim.snapshot();
        let mut other = simulation(scene);
        other.order(3, Order::go(Vec3::new(-9.0, 0.0, 50.0))).unwrap();
        step(&mut other, 2.0);
        other.restore(&kept).unwrap();
        for _ in 0..300 {
            for sim in [&mut sim, &mut other] {
                sim.step(1.0 / 30.0).unwrap();
            }
            assert_eq!(sim.hash(), other.hash(), "at {} s", sim.time_s());
        }
        assert_eq!(sim.snapshot(), other.snapshot());
    }
}
