//! Characters in made-up worlds: none enters reserved units, and all keep arriving.

use super::made_up_world::{self, GIVE, SIDE, SIT};
use glam::Vec3;
use throng_core::body::{ArmLayer, BodyLayers};
use throng_core::characters::CharactersConfig;
use throng_core::patch::Placement;
use throng_core::{CharacterGroup, Error, Id, Inline, Joint, NUM_JOINTS, OrderStatus, Planar, Rayon};
use throng_world::inhabitants::{
    InhabitantActivity, InhabitantEvent, InhabitantGoal, Inhabitants, InhabitantsConfig, scatter_rest_nodes,
};
use throng_world::{RestPlace, World, WorldNode};

const DT: f32 = 1.0 / 30.0;
const PLAIN: [&str; 5] = ["#####"; 5];

/// See [`made_up_world::world`].
pub fn open(rows: &[&str]) -> World {
    let tables = made_up_world::tables();
    World::from_data(&made_up_world::world(&tables, rows), &tables).expect("a world")
}

/// Everybody at rest where they start.
fn people_at(world: &World, starts: &[WorldNode]) -> Inhabitants {
    let mut people = Inhabitants::new(world, starts.len(), InhabitantsConfig::default()).expect("room");
    starts.iter().for_each(|&start| _ = people.spawn(start).expect("a start"));
    people
}

/// The tile that stands at a column and row.
fn tile(world: &World, x: i32, z: i32) -> u32 {
    let at = |p: Placement| p.x == x as f32 * SIDE && p.z == z as f32 * SIDE;
    world.view().instances.iter().position(|i| at(i.placement)).expect("a tile there") as u32
}

/// Everyone whose root is well inside a tile holds it, and every unit's holder knows of it.
fn nobody_is_where_others_hold(world: &World, people: &Inhabitants) {
    for c in 0..people.ids().len() {
        let root = people.characters().root(c);
        for (unit, u) in world.view().units.iter().enumerate().filter(|(_, u)| u.unit == made_up_world::FLOOR) {
            let inside = |a: f32, b: f32| (a - b).abs() < SIDE * 0.5 - 0.1;
            if inside(root.x, u.placement.x) && inside(root.z, u.placement.z) {
                assert_eq!(people.holder(unit as u32), Some(Id::first(c)), "character {c} is in unit {unit}");
            }
        }
        assert!(people.units_of(Id::first(c)).unwrap().all(|u| people.holder(u) == Some(Id::first(c))));
        assert!(people.units_of(Id::first(c)).unwrap().count() > 0);
    }
}

#[test]
fn nobody_enters_a_held_unit_and_motion_ends_where_its_node_is() {
    let world = open(&PLAIN);
    let graph = world.graph();
    let starts = scatter_rest_nodes(graph, 12, 3);
    assert_eq!(starts.len(), 12);
    let mut people = people_at(&world, &starts);
    let mut been = std::collections::BTreeSet::new();
    for _ in 0..3000 {
        people.step(DT, &Inline).unwrap();
        nobody_is_where_others_hold(&world, &people);
        for c in 0..12 {
            let status = people.state(Id::first(c)).unwrap();
            been.insert(status.node.instance);
            let (end, node) = (people.characters().scheduled_end(world.motion_set(), c), graph.place(status.node));
            let away = (end.x - node.x).hypot(end.z - node.z);
            let turned = throng_core::planar::wrap_angle(end.heading - node.heading);
            assert!(away < 1e-4 && turned.abs() < 1e-4, "{end:?} {node:?}");
        }
    }
    assert_eq!(been.len(), 25, "they roam everywhere");
}

/// One of two looks up and waves, and is pushed: the other one's pose stays as it is, and a copy goes on alike.
#[test]
fn inhabitants_look_wave_and_take_pushes() {
    let world = open(&PLAIN);
    let starts = scatter_rest_nodes(world.graph(), 2, 3);
    let [mut plain, mut people] = [(); 2].map(|()| people_at(&world, &starts));
    let layers =
        BodyLayers { look_at: Some(Vec3::new(0.0, 4.0, 0.0)), arms: [None, Some(ArmLayer::Wave)], ..BodyLayers::NONE };
    people.set_layers(Id::first(0), layers).unwrap();
    let (mut moved, mut raised) = (0.0f32, f32::MIN);
    for i in 0..90 {
        if i == 60 {
            people.push(Id::first(0), Joint::UpperChest, Vec3::X * 0.08).unwrap();
        }
        plain.step(DT, &Inline).unwrap();
        people.step(DT, &Inline).unwrap();
        assert_eq!(plain.bodies().model[1], people.bodies().model[1], "step {i}");
        let [was, now] = [&plain, &people].map(|p| p.bodies().model[0].map(|m| m.translation()));
        if i < 60 {
            raised = raised.max(now[Joint::RightHand.index()].y - was[Joint::RightHand.index()].y);
        } else {
            moved = moved.max(now[Joint::UpperChest.index()].distance(was[Joint::UpperChest.index()]));
        }
    }
    assert!(raised > 0.3, "the hand is {raised} m higher");
    assert!(moved > 0.03, "the chest gives way by {moved} m");
    let mut saved = Vec::new();
    people.save(&mut saved);
    let mut copy = people_at(&world, &starts);
    copy.load(&saved).unwrap();
    for p in [&mut people, &mut copy] {
        (0..10).for_each(|_| p.step(DT, &Inline).unwrap());
    }
    assert_eq!(people.bodies().model, copy.bodies().model);
    let bad = BodyLayers { look_at: Some(Vec3::splat(f32::NAN)), ..layers };
    assert!(matches!(people.set_layers(Id::first(0), bad), Err(Error::Value { .. })));
}

/// People of two worlds that are alike do the same where they have the same numbers, and else not.
#[test]
fn who_has_another_number_roams_elsewhere() {
    let world = open(&PLAIN);
    let starts = scatter_rest_nodes(world.graph(), 3, 7);
    let ends = |first_number| {
        let characters = CharactersConfig { first_number, ..CharactersConfig::default() };
        let config = InhabitantsConfig { characters, ..InhabitantsConfig::default() };
        let mut people = Inhabitants::new(&world, starts.len(), config).expect("room");
        starts.iter().for_each(|&start| _ = people.spawn(start).expect("a start"));
        (0..600).for_each(|_| people.step(DT, &Inline).expect("a step"));
        (0..3).map(|c| people.state(Id::first(c)).expect("is there").node).collect::<Vec<_>>()
    };
    assert_eq!(ends(0), ends(0));
    assert_ne!(ends(0), ends(3));
}

#[test]
fn nothing_jumps() {
    let world = open(&["###", "#b#", "###"]);
    let graph = world.graph();
    let mut people = people_at(&world, &scatter_rest_nodes(graph, 3, 1));
    people.order(Id::first(0), InhabitantGoal::Perform { tag: SIT, seconds: 3.0 }).unwrap();
    let dt = 1.0 / 120.0;
    people.step(0.0, &Inline).unwrap();
    let mut before: Vec<_> = (0..3).map(|c| people.characters().joint_positions(c)).collect();
    for step in 0..4000 {
        people.step(dt, &Inline).unwrap();
        for c in 0..3 {
            let now = people.characters().joint_positions(c);
            for j in 0..NUM_JOINTS {
                let speed = (now[j] - before[c][j]).length() / dt;
                assert!(speed < 8.0, "step {step}, character {c}, joint {j}: {speed} m/s");
            }
            before[c] = now;
        }
    }
    assert_eq!(people.state(Id::first(0)).unwrap().num_fulfilled, 1);
}

/// Lets everyone walk to and fro between two places, and returns how often each arrived in each part of the time.
fn commute(world: &World, ends: &[[u32; 2]], seconds: f32, parts: usize, check: bool) -> Vec<Vec<u32>> {
    let graph = world.graph();
    let starts: Vec<WorldNode> =
        ends.iter().map(|[from, _]| graph.rest_cells(*from).next().expect("a place to stand")).collect();
    let mut people = people_at(world, &starts);
    let mut seen = vec![0; ends.len()];
    for (c, [_, to]) in ends.iter().enumerate() {
        people.order(Id::first(c), InhabitantGoal::GoTo { instance: *to }).unwrap();
    }
    let steps = (seconds / DT) as usize;
    let mut out = vec![vec![0; parts]; ends.len()];
    for step in 0..steps {
        people.step(DT, &Inline).unwrap();
        if check && step % 10 == 0 {
            nobody_is_where_others_hold(world, &people);
        }
        for c in 0..ends.len() {
            let status = people.state(Id::first(c)).unwrap();
            if status.num_fulfilled > seen[c] {
                seen[c] = status.num_fulfilled;
                out[c][step * parts / steps] += 1;
                let to = ends[c][seen[c].is_multiple_of(2) as usize];
                people.order(Id::first(c), InhabitantGoal::GoTo { instance: to }).unwrap();
            }
        }
    }
    out
}

#[test]
fn a_crossing_crowd_keeps_arriving_for_ten_minutes() {
    let world = open(&["######"; 6]);
    let mut ends = Vec::new();
    for i in 0..6 {
        if i % 2 == 0 {
            ends.push([tile(&world, i, 0), tile(&world, 5 - i, 5)]);
            ends.push([tile(&world, 0, i), tile(&world, 5, i)]);
        } else {
            ends.push([tile(&world, i, 5), tile(&world, i, 0)]);
            ends.push([tile(&world, 5, i), tile(&world, 0, 5 - i)]);
        }
    }
    ends.sort_unstable();
    ends.dedup_by_key(|e| e[0]);
    let arrivals = commute(&world, &ends, 600.0, 5, true);
    for (c, a) in arrivals.iter().enumerate() {
        assert!(a.iter().all(|n| *n > 0), "character {c} arrived {a:?} times in each two minutes");
    }
}

#[test]
fn a_narrow_passage_that_is_walked_both_ways_does_not_clog() {
    let world = open(&["###...###", "#########", "###...###"]);
    let ends: Vec<_> = [(0, 0, 8, 0), (0, 2, 8, 2), (8, 1, 0, 1), (7, 2, 1, 2)]
        .map(|(ax, az, bx, bz)| [tile(&world, ax, az), tile(&world, bx, bz)])
        .to_vec();
    let arrivals = commute(&world, &ends, 600.0, 3, true);
    for (c, a) in arrivals.iter().enumerate() {
        assert!(a.iter().all(|n| *n > 0), "character {c} arrived {a:?} times in each part: {arrivals:?}");
    }
}

/// How far people get in 10 s, over the length of their way: of all stretches of those who roam for two minutes, the mean.
fn straightness(rows: &[&str], num_people: usize, seed: u64) -> f32 {
    let world = open(rows);
    let mut people = people_at(&world, &scatter_rest_nodes(world.graph(), num_people, seed));
    let at = |people: &Inhabitants| people.bodies().roots.iter().map(|r| r.translation()).collect::<Vec<_>>();
    let (mut far, mut distance) = (0.0, 0.0);
    for _ in 0..12 {
        let begin = at(&people);
        let mut last = begin.clone();
        for _ in 0..300 {
            people.step(DT, &Inline).unwrap();
            let now = at(&people);
            distance += now.iter().zip(&last).map(|(a, b)| a.distance(*b)).sum::<f32>();
            last = now;
        }
        far += last.iter().zip(&begin).map(|(a, b)| a.distance(*b)).sum::<f32>();
    }
    far / distance
}

#[test]
fn who_roams_walks_on_rather_than_round_about() {
    // Straight on, left and right with equal chances: the same number of tiles of a floor without an end.
    let (mut far, mut draw) = (0.0, 0);
    for _ in 0..1000 {
        let (mut x, mut z, mut heading) = (0i32, 0i32, 0usize);
        for _ in 0..6 {
            [x, z] = [x + [0, 1, 0, -1][heading], z + [1, 0, -1, 0][heading]];
            draw += 1;
            heading = (heading + [0, 1, 3][(throng_core::characters::uniform_random(1, 1, draw) * 3.0) as usize]) % 4;
        }
        far += ((x * x + z * z) as f32).sqrt() / 6000.0;
    }
    for seed in 1..4 {
        let found = straightness(&["########################"; 24], 12, seed);
        assert!(found > 1.3 * far, "seed {seed}: {found}, by chance {far}");
    }
    // In corners and among others they go on all the same.
    assert!(straightness(&["#####", "#...#", "#...#", "#####"], 4, 1) > 0.05);
}

#[test]
fn a_bench_is_sat_on_by_one_after_the_other() {
    let world = open(&["####", "#b##", "####"]);
    let graph = world.graph();
    let mut people = people_at(&world, &scatter_rest_nodes(graph, 3, 8));
    let bench = graph.num_instances() as u32 - 1;
    for c in 0..3 {
        people.order(Id::first(c), InhabitantGoal::Perform { tag: SIT, seconds: 5.0 }).unwrap();
    }
    let (mut sat, mut seated) = ([0.0f32; 3], 0);
    for _ in 0..9000 {
        people.step(DT, &Inline).unwrap();
        for c in 0..3 {
            let status = people.state(Id::first(c)).unwrap();
            if status.activity == InhabitantActivity::Performing {
                assert_eq!(status.node.instance, bench);
                sat[c] += DT;
            }
            if status.activity == InhabitantActivity::Arrived && status.goal != InhabitantGoal::Roam {
                seated += 1;
                people.order(Id::first(c), InhabitantGoal::Roam).unwrap();
            }
        }
    }
    assert_eq!(seated, 3, "{sat:?}");
    assert!(sat.iter().all(|s| (4.9..9.0).contains(s)), "{sat:?}");
}

/// The bench that a character chooses while another one sits on the near one for so long.
fn seat_beside_one_taken_for(seconds: f32) -> usize {
    let world = open(&["############", "b##########b", "############"]);
    let graph = world.graph();
    let starts = [[1, 1], [3, 2]].map(|[x, z]| graph.rest_cells(tile(&world, x, z)).next().unwrap());
    let mut people = people_at(&world, &starts);
    people.order(Id::first(0), InhabitantGoal::Perform { tag: SIT, seconds }).unwrap();
    people.order(Id::first(1), InhabitantGoal::GoTo { instance: starts[1].instance }).unwrap();
    let mut has_asked = false;
    for _ in 0..9000 {
        people.step(DT, &Inline).unwrap();
        let doing = [0, 1].map(|c| people.state(Id::first(c)).unwrap().activity);
        if doing[0] == InhabitantActivity::Performing && !has_asked {
            people.order(Id::first(1), InhabitantGoal::Perform { tag: SIT, seconds: 1.0 }).unwrap();
            has_asked = true;
        }
        if doing[0] == InhabitantActivity::Arrived {
            people.order(Id::first(0), InhabitantGoal::Roam).unwrap();
        }
        if doing[1] == InhabitantActivity::Performing {
            let bench = people.state(Id::first(1)).unwrap().node.instance as usize;
            return bench + 2 - graph.num_instances();
        }
    }
    panic!("no character sat down");
}

#[test]
fn who_is_told_at_once_takes_turns_at_several_benches() {
    let world = open(&["############", "b##########b", "############"]);
    let graph = world.graph();
    let starts = [[1, 0], [1, 2], [2, 1], [3, 0], [3, 2], [4, 1]];
    let starts = starts.map(|[x, z]| graph.rest_cells(tile(&world, x, z)).next().unwrap());
    let mut people = people_at(&world, &starts);
    for c in 0..6 {
        people.order(Id::first(c), InhabitantGoal::Perform { tag: SIT, seconds: 3.0 }).unwrap();
    }
    let mut seats = [None; 6];
    for _ in 0..9000 {
        people.step(DT, &Inline).unwrap();
        for c in 0..6 {
            let status = people.state(Id::first(c)).unwrap();
            if status.activity == InhabitantActivity::Performing {
                seats[c] = Some(status.node.instance);
            }
            if status.activity == InhabitantActivity::Arrived && status.goal != InhabitantGoal::Roam {
                people.order(Id::first(c), InhabitantGoal::Roam).unwrap();
            }
        }
    }
    let at_first = seats.iter().filter(|seat| **seat == seats[0]).count();
    assert!(seats.iter().all(Option::is_some) && (2..=4).contains(&at_first), "{seats:?}");
}

#[test]
fn a_seat_that_is_soon_free_is_waited_for_and_another_one_gone_to_otherwise() {
    assert_eq!([3.0, 100.0].map(seat_beside_one_taken_for), [0, 1]);
}

/// If somebody takes the short way round a ring, on which two give each other something for so long; and if it waits.
fn past_a_pair(seconds: f32) -> [bool; 2] {
    let world = open(&["#######", "#.....#", "#######"]);
    let [from, to] = [[0, 0], [6, 0]].map(|[x, z]| tile(&world, x, z));
    let starts = [[2, 0], [3, 0], [0, 0]].map(|[x, z]| world.graph().rest_cells(tile(&world, x, z)).next().unwrap());
    let mut people = people_at(&world, &starts);
    let two = [Id::first(0), Id::first(1)];
    let doing = |people: &Inhabitants, c: usize| people.state(Id::first(c)).unwrap().activity;
    people.order_meeting(two, GIVE, seconds).unwrap();
    people.order(Id::first(2), InhabitantGoal::GoTo { instance: from }).unwrap();
    while doing(&people, 0) != InhabitantActivity::Performing {
        people.step(DT, &Inline).unwrap();
    }
    people.order(Id::first(2), InhabitantGoal::GoTo { instance: to }).unwrap();
    let (mut is_short, mut waits) = (false, false);
    for _ in 0..3000 {
        people.step(DT, &Inline).unwrap();
        let walker = people.ids().iter().position(|id| *id == Id::first(2)).unwrap();
        let root = people.characters().root(walker);
        is_short |= (root.x - 3.0 * SIDE).abs() < 0.5 && root.z < 0.5 * SIDE;
        waits |= doing(&people, 2) == InhabitantActivity::Waiting;
        if people.state(two[0]).is_ok_and(|s| s.activity == InhabitantActivity::Arrived) {
            two.into_iter().for_each(|id| people.despawn(id).unwrap());
        }
        if doing(&people, 2) == InhabitantActivity::Arrived {
            return [is_short, waits];
        }
    }
    panic!("{:?}", people.state(Id::first(2)));
}

#[test]
fn who_performs_is_walked_around_where_waiting_takes_longer() {
    assert_eq!(past_a_pair(1000.0), [false, false]);
    assert_eq!(past_a_pair(2.0), [true, true]);
}

#[test]
fn cells_that_are_come_to_are_those_at_which_steps_end() {
    let world = open(&["####", "#bb#", "####"]);
    let graph = world.graph();
    let all = |i: u32| (0..graph.cells(i).len() as u32).map(move |cell| WorldNode { instance: i, cell });
    let nodes = || (0..graph.num_instances() as u32).flat_map(all).filter(|n| graph.is_node(*n));
    let mut ends = std::collections::BTreeSet::new();
    nodes().for_each(|n| graph.for_each_step(n, |step| _ = ends.insert(step.to)));
    for n in nodes() {
        let is_come_to = graph.node_of_cell(n.instance)[n.cell as usize];
        let expected = graph.is_tile(n.instance) || ends.contains(&n);
        assert_eq!(is_come_to, expected, "{n:?}");
    }
}

#[test]
fn the_nearest_place_to_a_point_is_gone_to() {
    let world = open(&PLAIN);
    let graph = world.graph();
    let from = graph.rest_cells(tile(&world, 0, 0)).next().unwrap();
    let mut people = people_at(&world, &[from]);
    let place = world.nearest_place(Vec3::new(3.2 * SIDE, 0.0, 4.4 * SIDE), 2.0).unwrap();
    people.order(Id::first(0), InhabitantGoal::GoToPlace { place }).unwrap();
    people.step(DT, &Inline).unwrap();
    let plan = *people.last_plan(Id::first(0)).unwrap().expect("a plan");
    assert_eq!(people.path_steps(Id::first(0)).unwrap().len(), plan.num_stored);
    assert!(plan.length_m > 4.0 * SIDE && plan.opened_nodes > 0);
    // Nothing but open ground: the upper layer has nothing to do.
    assert_eq!(plan.opened_instances, 0);
    let mut steps = 0;
    while people.state(Id::first(0)).unwrap().activity != InhabitantActivity::Arrived {
        people.step(DT, &Inline).unwrap();
        steps += 1;
        assert!(steps < 3000);
    }
    assert_eq!(people.state(Id::first(0)).unwrap().node.instance, tile(&world, 3, 4));
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let rows = vec!["####################"; 20];
    let world = open(&rows);
    let graph = world.graph();
    let starts = scatter_rest_nodes(graph, 200, 5);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut people = people_at(&world, &starts);
            for c in 0..50 {
                people.order(Id::first(c), InhabitantGoal::GoTo { instance: (c * 7 % 400) as u32 }).unwrap();
            }
            for _ in 0..300 {
                people.step(DT, &Rayon).unwrap();
            }
            let nodes: Vec<_> = (0..200).map(|c| people.state(Id::first(c)).unwrap().node).collect();
            (nodes, people.characters().model_matrices().to_vec())
        })
    };
    let one = on(1);
    assert!(on(2) == one && on(8) == one);
}

#[test]
fn starts_and_goals_that_cannot_be_are_refused() {
    let world = open(&["###.###", "#b#.###", "###.###"]);
    let graph = world.graph();
    let rest = graph.rest_cells(1).next().unwrap();
    let new = |config| Inhabitants::new(&world, 2, config);
    let mut people = new(InhabitantsConfig::default()).unwrap();
    let [first, next] = [Id::first(0), Id::first(1)];
    assert_eq!(people.spawn(rest).unwrap(), first);
    let mut refuse = |start| people.spawn(start).unwrap_err();
    assert!(matches!(refuse(WorldNode { instance: 1, cell: 0 }), Error::Value { who, .. } if who == Some(next)));
    assert!(matches!(refuse(WorldNode { instance: 99, cell: 0 }), Error::Index { who, .. } if who == Some(next)));
    assert!(matches!(refuse(rest), Error::Occupied { who, by } if who == next && by == "0"));
    assert_eq!(people.spawn(graph.rest_cells(0).next().unwrap()).unwrap(), next);
    assert!(matches!(people.spawn(rest), Err(Error::Full { capacity: 2 })));
    let half_life_s = CharactersConfig { half_life_s: 0.0, ..CharactersConfig::default() };
    for config in [
        InhabitantsConfig { patience_s: f32::NAN, ..InhabitantsConfig::default() },
        InhabitantsConfig { characters: half_life_s, ..InhabitantsConfig::default() },
    ] {
        assert!(matches!(new(config), Err(Error::Value { .. })));
    }
    let before = people.hash();
    let mut refuse = |goal| people.order(first, goal).unwrap_err();
    assert!(matches!(
        refuse(InhabitantGoal::GoTo { instance: 50 }),
        Error::Index { who: Some(Id { index: 0, .. }), .. }
    ));
    let entry = RestPlace { node: WorldNode { instance: 1, cell: 0 }, at: Vec3::ZERO };
    for goal in [
        InhabitantGoal::Perform { tag: made_up_world::CHAT, seconds: 1.0 },
        InhabitantGoal::Perform { tag: SIT, seconds: f32::NAN },
        InhabitantGoal::GoToPlace { place: entry },
        InhabitantGoal::GoNear { place: Vec3::NAN, within_m: 1.0 },
        InhabitantGoal::GoNear { place: Vec3::new(500.0, 0.0, 0.0), within_m: 3.0 },
    ] {
        assert!(matches!(refuse(goal), Error::Value { who: Some(Id { index: 0, .. }), .. }), "{goal:?}");
    }
    // Over there is another room.
    let there = world.nearest_place(Vec3::new(5.0 * SIDE, 1.0, SIDE), 1.0).unwrap();
    for goal in [InhabitantGoal::GoTo { instance: there.node.instance }, InhabitantGoal::GoToPlace { place: there }] {
        let error = refuse(goal);
        assert!(matches!(error, Error::NoPath { who: Some(Id { index: 0, .. }), .. }), "{error}");
    }
    assert!(matches!(people.step(2.0, &Inline), Err(Error::Value { .. })));
    let other = made_up_world::named("another");
    assert!(matches!(people.adopt(&other), Err(Error::OtherBundle { .. })));
    assert!(people.adopt(&made_up_world::tables()).is_ok());
    assert_eq!(people.hash(), before);
    people.despawn(next).unwrap();
    assert!(matches!(people.order(next, InhabitantGoal::Roam), Err(Error::Gone(id)) if id == next));
    assert!(people.status(next).is_err() && people.state(next).is_err() && people.despawn(next).is_err());
}

#[test]
fn who_leaves_makes_room_and_everybody_else_goes_on() {
    let world = open(&PLAIN);
    let starts = scatter_rest_nodes(world.graph(), 12, 4);
    let mut people = people_at(&world, &starts);
    let mut gone = Vec::new();
    for round in 0..60u32 {
        for (k, &id) in people.ids().to_vec().iter().enumerate() {
            if people.state(id).unwrap().activity != InhabitantActivity::Walking {
                people.order(id, InhabitantGoal::GoTo { instance: (k as u32 * 7 + round * 3) % 25 }).unwrap();
            }
        }
        (0..40).for_each(|_| people.step(DT, &Inline).unwrap());
        let leaves = people.ids()[round as usize % people.ids().len()];
        people.despawn(leaves).unwrap();
        gone.push(leaves);
        for (row, &id) in people.ids().iter().enumerate() {
            assert!(people.units_of(id).unwrap().count() > 0);
            assert!(people.units_of(id).unwrap().all(|u| people.holder(u) == Some(id)));
            let (body, root) = (people.bodies().get(id).unwrap(), people.characters().root(row));
            assert_eq!((body.root, body.model[0]), (root, people.characters().pose(row)[0]));
        }
        let held: usize = people.ids().iter().map(|id| people.units_of(*id).unwrap().count()).sum();
        assert_eq!(
            (0..25).filter(|u| people.holder(*u).is_some()).count(),
            held,
            "no reservation of a character that left remains"
        );
        let free = (0..25).find(|u| people.holder(*u).is_none()).expect("a free tile");
        let id = people.spawn(world.graph().rest_cells(free).next().unwrap()).unwrap();
        assert!(!gone.contains(&id), "no id is used twice");
    }
}

#[test]
fn who_is_put_elsewhere_goes_on_from_there() {
    let world = open(&PLAIN);
    let graph = world.graph();
    let starts = [tile(&world, 0, 0), tile(&world, 4, 4)].map(|t| graph.rest_cells(t).next().unwrap());
    let mut people = people_at(&world, &starts);
    let [a, b] = [0, 1].map(Id::first);
    let place = world.nearest_place(Vec3::new(0.0, 1.0, 4.0 * SIDE), 1.0).unwrap();
    people.order(a, InhabitantGoal::GoToPlace { place }).unwrap();
    (0..50).for_each(|_| people.step(DT, &Inline).unwrap());
    people.place(a, Planar::new(3.0 * SIDE + 0.2, 0.3, 1.5)).unwrap();
    let root = people.bodies().get(a).unwrap().root;
    assert!((root.x - 3.0 * SIDE).abs() + root.z.abs() < 1e-3 && (root.heading - 1.57).abs() < 0.1, "{root:?}");
    assert_eq!(people.units_of(a).unwrap().collect::<Vec<_>>(), [tile(&world, 3, 0)]);
    let OrderStatus::Going { left_m } = people.status(a).unwrap() else { panic!("it has an order") };
    assert!((left_m - 5.0 * SIDE).abs() < 0.1, "{left_m}");
    assert!(matches!(people.place(b, root), Err(Error::Occupied { who, by }) if who == b && by == "0"));
    assert!(matches!(people.place(b, Planar::new(-9.0, 0.0, 0.0)), Err(Error::Value { who, .. }) if who == Some(b)));
    let mut steps = 0;
    while people.status(a).unwrap() != OrderStatus::Arrived {
        people.step(DT, &Inline).unwrap();
        steps += 1;
        assert!(steps < 3000);
    }
    assert_eq!(people.events(), [(a, InhabitantEvent::Fulfilled)]);
    assert_eq!(people.state(a).unwrap().node, place.node);
}

/// Ten characters sent to ten points around a centre, a quarter of an hour later.
fn ten_sent(seed: u64, goal: impl Fn(&World, Vec3) -> InhabitantGoal) -> (World, Inhabitants) {
    let world = open(&["#######"; 7]);
    let mut people = people_at(&world, &scatter_rest_nodes(world.graph(), 10, seed));
    for c in 0..10 {
        let at = Vec3::new(2.0 * SIDE + (c % 4) as f32, 1.0, 3.0 * SIDE + (c / 4) as f32);
        let goal = goal(&world, at);
        people.order(Id::first(c), goal).unwrap();
    }
    (0..27000).for_each(|_| people.step(DT, &Inline).unwrap());
    (world, people)
}

#[test]
pub fn ten_sent_to_places_a_metre_apart_stand_or_wait_and_say_for_whom() {
    let to_place = |world: &World, at| InhabitantGoal::GoToPlace { place: world.nearest_place(at, 2.0).unwrap() };
    for seed in [3, 6, 9] {
        stand_or_wait(ten_sent(seed, to_place).1);
    }
}

fn stand_or_wait(mut people: Inhabitants) {
    let ids = people.ids().to_vec();
    let status = |people: &Inhabitants| ids.iter().map(|id| people.status(*id).unwrap()).collect::<Vec<_>>();
    let nodes = |people: &Inhabitants| ids.iter().map(|id| people.state(*id).unwrap().node).collect::<Vec<_>>();
    let (stand, stood) = (status(&people), nodes(&people));
    let mut there = 0;
    for s in &stand {
        match *s {
            OrderStatus::Arrived => there += 1,
            OrderStatus::Blocked { by: Some(by) } => {
                assert!(!matches!(stand[by.index()], OrderStatus::Going { .. }), "{stand:?}")
            }
            s => panic!("{s:?}: {stand:?}"),
        }
    }
    assert!((2..10).contains(&there), "{stand:?}");
    for _ in 0..3600 {
        people.step(DT, &Inline).unwrap();
        assert_eq!(nodes(&people), stood);
    }
    // One goes away: another one takes its place.
    let is_waited_for = |id: &&Id| stand.contains(&OrderStatus::Blocked { by: Some(**id) });
    // Its tile can still be entered.
    let x = |id: &Id| people.bodies().get(*id).unwrap().root.x;
    let left =
        *ids.iter().filter(is_waited_for).min_by(|a, b| x(a).total_cmp(&x(b))).expect("a character that is waited for");
    people.despawn(left).unwrap();
    (0..3600).for_each(|_| people.step(DT, &Inline).unwrap());
    let now = people.ids().iter().filter(|id| people.status(**id).unwrap() == OrderStatus::Arrived).count();
    assert!(now >= there, "{now} of {there}");
}

#[test]
pub fn ten_sent_near_a_place_all_come_near_it() {
    for seed in 1..=6 {
        let (world, people) = ten_sent(seed, |_, at| InhabitantGoal::GoNear { place: at, within_m: 2.5 * SIDE });
        for (c, &id) in people.ids().iter().enumerate() {
            let at = Vec3::new(2.0 * SIDE + (c % 4) as f32, 1.0, 3.0 * SIDE + (c / 4) as f32);
            assert_eq!(people.status(id).unwrap(), OrderStatus::Arrived, "{c} of seed {seed}");
            assert!(world.graph().place(people.state(id).unwrap().node).translation().distance(at) < 2.5 * SIDE);
        }
    }
}
