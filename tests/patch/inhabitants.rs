//! Characters in made-up worlds: nobody enters what others hold, and everybody keeps arriving.

use crate::made_up_world::{self, SIDE, SIT};
use throng_runtime::NUM_JOINTS;
use throng_runtime::characters::CharactersConfig;
use throng_runtime::patch::Placement;
use throng_runtime::world::inhabitants::{Doing, Inhabitants, InhabitantsConfig, InhabitantsError, Wish, scatter};
use throng_runtime::world::{Node, World};

const DT: f32 = 1.0 / 30.0;
const PLAIN: [&str; 5] = ["#####"; 5];

/// See [`made_up_world::world`].
pub fn open(rows: &[&str]) -> World {
    let tables = made_up_world::tables();
    World::from_data(&made_up_world::world(&tables, rows), &tables).expect("a world")
}

/// The tile that stands at a column and row.
fn tile(world: &World, x: i32, z: i32) -> u32 {
    let at = |p: Placement| p.x == x as f32 * SIDE && p.z == z as f32 * SIDE;
    world.view().instances.iter().position(|i| at(i.placement)).expect("a tile there") as u32
}

/// Everyone whose root is well inside a tile holds it, and every unit's holder knows of it.
fn nobody_is_where_others_hold(world: &World, people: &Inhabitants) {
    for c in 0..people.num_characters() {
        let root = people.characters().root(c);
        for (unit, u) in world.view().units.iter().enumerate().filter(|(_, u)| u.unit == made_up_world::FLOOR) {
            let inside = |a: f32, b: f32| (a - b).abs() < SIDE * 0.5 - 0.1;
            if inside(root.x, u.placement.x) && inside(root.z, u.placement.z) {
                assert_eq!(people.holder(unit as u32), Some(c as u32), "character {c} is in unit {unit}");
            }
        }
        assert!(people.held(c).all(|u| people.holder(u) == Some(c as u32)));
        assert!(people.held(c).count() > 0);
    }
}

#[test]
fn nobody_enters_a_held_unit_and_motion_ends_where_its_node_is() {
    let world = open(&PLAIN);
    let graph = world.graph();
    let starts = scatter(graph, 12, 3);
    assert_eq!(starts.len(), 12);
    let mut people = Inhabitants::new(&world, InhabitantsConfig::default(), &starts).unwrap();
    let mut been = std::collections::BTreeSet::new();
    for _ in 0..3000 {
        people.step(DT).unwrap();
        nobody_is_where_others_hold(&world, &people);
        for c in 0..12 {
            let status = people.status(c);
            been.insert(status.node.instance);
            let (end, node) = (people.characters().scheduled_end(world.motion_set(), c), graph.place(status.node));
            let away = (end.x - node.x).hypot(end.z - node.z);
            let turned = throng_runtime::planar::wrap_angle(end.heading - node.heading);
            assert!(away < 1e-4 && turned.abs() < 1e-4, "{end:?} {node:?}");
        }
    }
    assert_eq!(been.len(), 25, "they roam everywhere");
}

#[test]
fn nothing_jumps() {
    let world = open(&["###", "#b#", "###"]);
    let graph = world.graph();
    let mut people = Inhabitants::new(&world, InhabitantsConfig::default(), &scatter(graph, 3, 1)).unwrap();
    people.set_wish(0, Wish::Perform { tag: SIT, seconds: 3.0 }).unwrap();
    let dt = 1.0 / 120.0;
    people.step(0.0).unwrap();
    let mut before: Vec<_> = (0..3).map(|c| people.characters().joint_positions(c)).collect();
    for step in 0..4000 {
        people.step(dt).unwrap();
        for c in 0..3 {
            let now = people.characters().joint_positions(c);
            for j in 0..NUM_JOINTS {
                let speed = (now[j] - before[c][j]).length() / dt;
                assert!(speed < 8.0, "step {step}, character {c}, joint {j}: {speed} m/s");
            }
            before[c] = now;
        }
    }
    assert_eq!(people.status(0).num_fulfilled, 1);
}

/// Lets everyone walk to and fro between two places, and returns how often each arrived in each part of the time.
fn commute(world: &World, ends: &[[u32; 2]], seconds: f32, parts: usize, check: bool) -> Vec<Vec<u32>> {
    let graph = world.graph();
    let starts: Vec<Node> =
        ends.iter().map(|[from, _]| graph.rest_cells(*from).next().expect("a place to stand")).collect();
    let mut people = Inhabitants::new(world, InhabitantsConfig::default(), &starts).unwrap();
    let mut seen = vec![0; ends.len()];
    for (c, [_, to]) in ends.iter().enumerate() {
        people.set_wish(c, Wish::GoTo { instance: *to }).unwrap();
    }
    let steps = (seconds / DT) as usize;
    let mut out = vec![vec![0; parts]; ends.len()];
    for step in 0..steps {
        people.step(DT).unwrap();
        if check && step % 10 == 0 {
            nobody_is_where_others_hold(world, &people);
        }
        for c in 0..ends.len() {
            let status = people.status(c);
            if status.num_fulfilled > seen[c] {
                seen[c] = status.num_fulfilled;
                out[c][step * parts / steps] += 1;
                let to = ends[c][seen[c].is_multiple_of(2) as usize];
                people.set_wish(c, Wish::GoTo { instance: to }).unwrap();
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

#[test]
fn a_bench_is_sat_on_by_one_after_the_other() {
    let world = open(&["####", "#b##", "####"]);
    let graph = world.graph();
    let mut people = Inhabitants::new(&world, InhabitantsConfig::default(), &scatter(graph, 3, 8)).unwrap();
    let bench = graph.num_instances() as u32 - 1;
    for c in 0..3 {
        people.set_wish(c, Wish::Perform { tag: SIT, seconds: 5.0 }).unwrap();
    }
    let (mut sat, mut seated) = ([0.0f32; 3], 0);
    for _ in 0..9000 {
        people.step(DT).unwrap();
        for c in 0..3 {
            let status = people.status(c);
            if status.doing == Doing::Performing {
                assert_eq!(status.node.instance, bench);
                sat[c] += DT;
            }
            if status.doing == Doing::Arrived && status.wish != Wish::Roam {
                seated += 1;
                people.set_wish(c, Wish::Roam).unwrap();
            }
        }
    }
    assert_eq!(seated, 3, "{sat:?}");
    assert!(sat.iter().all(|s| (4.9..9.0).contains(s)), "{sat:?}");
}

/// The bench that somebody sits down on who comes when another one sits on the near one, for so long.
fn seat_beside_one_taken_for(seconds: f32) -> usize {
    let world = open(&["############", "b##########b", "############"]);
    let graph = world.graph();
    let starts = [[1, 1], [3, 2]].map(|[x, z]| graph.rest_cells(tile(&world, x, z)).next().unwrap());
    let mut people = Inhabitants::new(&world, InhabitantsConfig::default(), &starts).unwrap();
    people.set_wish(0, Wish::Perform { tag: SIT, seconds }).unwrap();
    let mut has_asked = false;
    for _ in 0..9000 {
        people.step(DT).unwrap();
        let doing = [0, 1].map(|c| people.status(c).doing);
        if doing[0] == Doing::Performing && !has_asked {
            people.set_wish(1, Wish::Perform { tag: SIT, seconds: 1.0 }).unwrap();
            has_asked = true;
        }
        if doing[0] == Doing::Arrived {
            people.set_wish(0, Wish::Roam).unwrap();
        }
        if doing[1] == Doing::Performing {
            let bench = people.status(1).node.instance as usize;
            return bench + 2 - graph.num_instances();
        }
    }
    panic!("nobody sat down");
}

#[test]
fn a_seat_that_is_soon_free_is_waited_for_and_another_one_gone_to_otherwise() {
    assert_eq!([3.0, 100.0].map(seat_beside_one_taken_for), [0, 1]);
}

#[test]
fn cells_that_are_come_to_are_those_at_which_steps_end() {
    let world = open(&["####", "#bb#", "####"]);
    let graph = world.graph();
    let all = |i: u32| (0..graph.cells(i).len() as u32).map(move |cell| Node { instance: i, cell });
    let nodes = || (0..graph.num_instances() as u32).flat_map(all).filter(|n| graph.is_node(*n));
    let mut ends = std::collections::BTreeSet::new();
    nodes().for_each(|n| graph.for_each_step(n, |step| _ = ends.insert(step.to)));
    for n in nodes() {
        let is_come_to = graph.come_to(n.instance)[n.cell as usize];
        let expected = graph.is_tile(n.instance) || ends.contains(&n);
        assert_eq!(is_come_to, expected, "{n:?}");
    }
}

#[test]
fn the_nearest_place_to_a_point_is_gone_to() {
    let world = open(&PLAIN);
    let graph = world.graph();
    let from = graph.rest_cells(tile(&world, 0, 0)).next().unwrap();
    let mut people = Inhabitants::new(&world, InhabitantsConfig::default(), &[from]).unwrap();
    let place = glam::Vec3::new(3.2 * SIDE, 0.0, 4.4 * SIDE);
    people.set_wish(0, Wish::GoToPlace { place }).unwrap();
    people.step(DT).unwrap();
    let plan = *people.plan(0).expect("a plan");
    assert_eq!(people.path(0).len(), plan.num_stored);
    assert!(plan.length_m > 4.0 * SIDE && plan.opened_nodes > 0);
    // Nothing but open ground: the upper layer has nothing to do.
    assert_eq!(plan.opened_instances, 0);
    let mut steps = 0;
    while people.status(0).doing != Doing::Arrived {
        people.step(DT).unwrap();
        steps += 1;
        assert!(steps < 3000);
    }
    assert_eq!(people.status(0).node.instance, tile(&world, 3, 4));
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let rows = vec!["####################"; 20];
    let world = open(&rows);
    let graph = world.graph();
    let starts = scatter(graph, 200, 5);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut people = Inhabitants::new(&world, InhabitantsConfig::default(), &starts).unwrap();
            for c in 0..50 {
                people.set_wish(c, Wish::GoTo { instance: (c * 7 % 400) as u32 }).unwrap();
            }
            for _ in 0..300 {
                people.step_on(DT, &throng_runtime::Rayon).unwrap();
            }
            let nodes: Vec<_> = (0..200).map(|c| people.status(c).node).collect();
            (nodes, people.characters().model_matrices().to_vec())
        })
    };
    let one = on(1);
    assert!(on(2) == one && on(8) == one);
}

#[test]
fn starts_and_wishes_that_cannot_be_are_refused() {
    let world = open(&["###", "#b#", "###"]);
    let graph = world.graph();
    let new = |starts: &[Node]| Inhabitants::new(&world, InhabitantsConfig::default(), starts);
    let rest = graph.rest_cells(4).next().unwrap();
    let entry = Node { instance: 4, cell: 0 };
    assert_eq!(new(&[entry]).unwrap_err(), InhabitantsError::Start { character: 0, node: entry });
    assert!(matches!(new(&[rest, rest]), Err(InhabitantsError::Held { character: 1, other: 0, .. })));
    assert!(matches!(new(&[Node { instance: 99, cell: 0 }]), Err(InhabitantsError::Index { .. })));
    let config = InhabitantsConfig { patience_s: f32::NAN, ..InhabitantsConfig::default() };
    assert!(Inhabitants::new(&world, config, &[rest]).is_err());
    let characters = CharactersConfig { half_life_s: 0.0, ..CharactersConfig::default() };
    let config = InhabitantsConfig { characters, ..InhabitantsConfig::default() };
    assert!(matches!(Inhabitants::new(&world, config, &[rest]), Err(InhabitantsError::Characters(_))));
    let mut people = new(&[rest]).unwrap();
    assert!(matches!(people.set_wish(1, Wish::Roam), Err(InhabitantsError::Index { .. })));
    assert!(matches!(people.set_wish(0, Wish::GoTo { instance: 50 }), Err(InhabitantsError::Index { .. })));
    let chat = Wish::Perform { tag: made_up_world::CHAT, seconds: 1.0 };
    assert_eq!(people.set_wish(0, chat), Err(InhabitantsError::NoTag { tag: made_up_world::CHAT }));
    let nowhere = Wish::GoToPlace { place: glam::Vec3::NAN };
    assert!(matches!(people.set_wish(0, nowhere), Err(InhabitantsError::Value { .. })));
    assert!(matches!(people.step(2.0), Err(InhabitantsError::Value { .. })));
}
