//! Paths in two layers against plain Dijkstra over the whole graph.

use super::made_up_world::{self, FLOOR, SIT};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::collections::{BTreeMap, BTreeSet};
use throng_core::Bundle;
use throng_world::plan::{PlanTarget, WORST, WorldPlan, WorldPlanner};
use throng_world::{WorldData, WorldGraph, WorldNode, WorldStep};

/// Least frames from a node to every other one.
fn dijkstra(graph: &WorldGraph, from: WorldNode) -> BTreeMap<WorldNode, u32> {
    let mut queue = BTreeSet::from([(0, from)]);
    let mut found: BTreeMap<WorldNode, u32> = BTreeMap::new();
    while let Some((frames, node)) = queue.pop_first() {
        if found.contains_key(&node) {
            continue;
        }
        found.insert(node, frames);
        graph.for_each_step(node, |s| {
            queue.insert((frames + s.num_frames(), s.to));
        });
    }
    found
}

/// The steps lead from the node to the target, each one is there to be taken, and the plan says what they are.
fn assert_is_path(graph: &WorldGraph, from: WorldNode, target: PlanTarget, steps: &[WorldStep], plan: &WorldPlan) {
    let mut at = from;
    for s in steps {
        let mut there = false;
        graph.for_each_step(at, |t| there |= t == *s);
        assert!(there, "{s:?} cannot be taken from {at:?}");
        at = s.to;
    }
    assert!(target.is_at(graph, at));
    assert_eq!(plan.num_steps, steps.len());
    assert_eq!(plan.num_frames, steps.iter().map(WorldStep::num_frames).sum::<u32>());
}

/// A floor with holes, and a bench here and there where one can be come to.
fn floor(rng: &mut Pcg64Mcg) -> Vec<String> {
    let mut rows = vec![vec!['#'; 9]; 9];
    for _ in 0..14 {
        rows[rng.random_range(0..9usize)][rng.random_range(0..9usize)] = '.';
    }
    for _ in 0..4 {
        let (z, x) = (rng.random_range(1..8usize), rng.random_range(0..9usize));
        if [z - 1, z, z + 1].iter().all(|&z| rows[z][x] != '.') {
            rows[z][x] = 'b';
        }
    }
    rows.iter().map(|r| r.iter().collect()).collect()
}

#[test]
fn paths_are_as_short_as_the_shortest_within_five_percent() {
    let tables = made_up_world::tables();
    let mut rng = Pcg64Mcg::seed_from_u64(7);
    let (mut paths, mut none) = (0, 0);
    for _ in 0..12 {
        let rows = floor(&mut rng);
        let world = made_up_world::world(&tables, &rows.iter().map(String::as_str).collect::<Vec<_>>());
        let graph = WorldGraph::new(tables.patches(), &world.tables()).unwrap();
        let mut planner = WorldPlanner::new(&graph);
        let mut steps = vec![WorldStep::NONE; 400];
        for _ in 0..25 {
            let instance = rng.random_range(0..graph.num_instances() as u32);
            let cells = graph.cells(instance).len() as u32;
            let from = WorldNode { instance, cell: rng.random_range(0..cells) };
            if !graph.is_node(from) {
                continue;
            }
            let to = rng.random_range(0..graph.num_instances() as u32);
            let target = match rng.random_range(0..3) {
                0 => PlanTarget::Tag { instance: to, tag: SIT },
                _ => PlanTarget::Rest { instance: to },
            };
            let best =
                dijkstra(&graph, from).into_iter().filter(|(n, _)| target.is_at(&graph, *n)).map(|(_, f)| f).min();
            match (planner.plan(&graph, from, target, &mut steps), best) {
                (Some(plan), Some(best)) => {
                    assert_is_path(&graph, from, target, &steps[..plan.num_stored], &plan);
                    assert!(
                        f64::from(plan.num_frames) <= f64::from(WORST) * f64::from(best),
                        "{} frames, {best}",
                        plan.num_frames
                    );
                    assert!(plan.num_frames >= best);
                    paths += 1;
                }
                (None, None) => none += 1,
                (found, best) => panic!("{from:?} {target:?}: {found:?}, Dijkstra {best:?} in {rows:#?}"),
            }
        }
    }
    assert!(paths > 100 && none > 5, "{paths} {none}");
}

#[test]
fn the_first_steps_of_a_long_path_are_kept() {
    let tables = made_up_world::tables();
    let world = made_up_world::world(&tables, &["####################"]);
    let graph = WorldGraph::new(tables.patches(), &world.tables()).unwrap();
    let mut planner = WorldPlanner::new(&graph);
    let from = graph.rest_cells(0).next().unwrap();
    let target = PlanTarget::Rest { instance: 19 };
    let (mut all, mut few) = (vec![WorldStep::NONE; 50], [WorldStep::NONE; 6]);
    let whole = planner.plan(&graph, from, target, &mut all).unwrap();
    let part = planner.plan(&graph, from, target, &mut few).unwrap();
    assert_eq!((whole.num_steps, whole.num_stored), (20, 20));
    assert_eq!((part.num_steps, part.num_stored), (20, 6));
    assert_eq!(all[..6], few);
    // From the middle of the first tile to that of the last one.
    assert!((whole.length_m - 38.0).abs() < 0.5, "{}", whole.length_m);
}

#[test]
fn the_way_of_a_target_that_is_a_node_ends_there() {
    let tables = made_up_world::tables();
    let world = made_up_world::world(&tables, &["####"; 4]);
    let graph = WorldGraph::new(tables.patches(), &world.tables()).unwrap();
    let mut planner = WorldPlanner::new(&graph);
    let from = graph.rest_cells(0).next().unwrap();
    let best = dijkstra(&graph, from);
    let mut steps = [WorldStep::NONE; 60];
    for (&node, &frames) in &best {
        let plan = planner.plan(&graph, from, PlanTarget::Node(node), &mut steps);
        let plan = plan.unwrap_or_else(|| panic!("no way to {node:?}"));
        assert_is_path(&graph, from, PlanTarget::Node(node), &steps[..plan.num_stored], &plan);
        assert!(
            f64::from(plan.num_frames) <= f64::from(WORST) * f64::from(frames),
            "{node:?}: {} {frames}",
            plan.num_frames
        );
    }
}

/// Plans between many nodes of a floor, and compares with Dijkstra; how many paths and how many times none there were.
fn compare(tables: &Bundle, rows: &[&str], rng: &mut Pcg64Mcg, change: impl Fn(&mut WorldData)) -> (usize, usize) {
    let mut world = made_up_world::world(tables, rows);
    change(&mut world);
    world.check(tables.patches()).expect("the changed world is sound");
    let graph = WorldGraph::new(tables.patches(), &world.tables()).unwrap();
    let (mut planner, mut steps) = (WorldPlanner::new(&graph), vec![WorldStep::NONE; 400]);
    let (mut paths, mut none) = (0, 0);
    for _ in 0..25 {
        let mut draw = || {
            let instance = rng.random_range(0..graph.num_instances() as u32);
            WorldNode { instance, cell: rng.random_range(0..graph.cells(instance).len() as u32) }
        };
        let (from, to) = (draw(), draw());
        if !graph.is_node(from) || !graph.is_node(to) {
            continue;
        }
        let best = dijkstra(&graph, from).get(&to).copied();
        let target = PlanTarget::Node(to);
        let plans =
            [planner.plan(&graph, from, target, &mut steps), planner.plan_soon(&graph, from, target, &mut steps)];
        assert_eq!(plans.map(|p| p.is_some()), [best.is_some(); 2], "{from:?} {to:?} in {rows:#?}");
        let (Some(best), [Some(plan), Some(soon)]) = (best, plans) else {
            none += 1;
            continue;
        };
        assert_is_path(&graph, from, target, &steps[..soon.num_stored], &soon);
        assert!(f64::from(plan.num_frames) <= f64::from(WORST) * f64::from(best), "{} {best}", plan.num_frames);
        assert!(plan.least_frames <= best && soon.least_frames <= best, "{plan:?} {soon:?} {best}");
        paths += 1;
    }
    (paths, none)
}

#[test]
fn ways_around_corners_and_through_gateways_are_as_good_as_promised() {
    let tables = made_up_world::tables();
    let mut rng = Pcg64Mcg::seed_from_u64(11);
    let floors: [&[&str]; 4] = [
        &["##########", "##########", "##........", "##........", "##........", "##########", "##########"],
        &["####..####", "####..####", "##########", "#b##..####", "####..####"],
        &["#######", "#.....#", "#.###.#", "#.#.#.#", "#.###.#", "#..#..#", "#######"],
        &["###.###", "###.###", "###.###"],
    ];
    let (mut paths, mut none) = (0, 0);
    for rows in floors {
        for _ in 0..3 {
            let found = compare(&tables, rows, &mut rng, |_| {});
            (paths, none) = (paths + found.0, none + found.1);
        }
    }
    assert!(paths > 60 && none > 5, "{paths} {none}");
}

#[test]
fn ways_over_tiles_that_are_crossed_in_one_direction_are_as_good_as_promised() {
    let tables = made_up_world::tables();
    let links = tables.patches().links_of(FLOOR as usize);
    let mut rng = Pcg64Mcg::seed_from_u64(12);
    let (mut paths, mut none) = (0, 0);
    for _ in 0..6 {
        // Nobody walks back to -x in the first rows.
        let found = compare(&tables, &["########"; 4], &mut rng, |world| {
            let in_rows: Vec<_> = world.instances.iter().filter(|i| i.placement.z < 3.0).copied().collect();
            for i in in_rows {
                for (k, _) in links.iter().enumerate().filter(|(_, l)| l.to == 5) {
                    world.link_words[i.first_link_word as usize + k / 64] &= !(1 << (k % 64));
                }
            }
        });
        (paths, none) = (paths + found.0, none + found.1);
    }
    assert!(paths > 30, "{paths} {none}");
}

#[test]
fn ways_around_obstacles_are_as_good_as_promised() {
    let tables = made_up_world::tables();
    let num_links = tables.patches().links_of(FLOOR as usize).len();
    let mut rng = Pcg64Mcg::seed_from_u64(13);
    let (mut paths, mut none) = (0, 0);
    for _ in 0..8 {
        let seed = rng.random_range(0..1000u64);
        let found =
            compare(&tables, &["########", "##b#####", "########", "#####b##", "########"], &mut rng, |world| {
                let mut obstacles = Pcg64Mcg::seed_from_u64(seed);
                let floor: Vec<_> = world.instances.iter().filter(|i| i.patch == FLOOR).copied().collect();
                for i in floor {
                    for k in (0..num_links).filter(|_| obstacles.random_range(0..5) == 0) {
                        world.link_words[i.first_link_word as usize + k / 64] &= !(1 << (k % 64));
                    }
                }
            });
        (paths, none) = (paths + found.0, none + found.1);
    }
    assert!(paths > 40, "{paths} {none}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn no_floor_breaks_the_promise(seed in 0u64..1_000_000) {
        let tables = made_up_world::tables();
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let rows = floor(&mut rng);
        compare(&tables, &rows.iter().map(String::as_str).collect::<Vec<_>>(), &mut rng, |_| {});
    }
}
