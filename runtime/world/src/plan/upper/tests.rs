//! Estimates of made-up floors against plain Dijkstra.

use super::*;
use crate::made_up::{Tile, costs_to, nodes, places, tiles};
use proptest::prelude::*;

/// Checks that no estimate is above what paths cost; how many paths on from regions were found dominated.
fn check_estimates(tile: &Tile, depths: [i32; 3], target: usize) -> usize {
    let world = tile.floor(&places(depths));
    let graph = WorldGraph::new(&tile.patches(), &world.tables()).unwrap();
    let (hierarchy, nodes) = (graph.hierarchy(), nodes(&graph));
    let mut upper = UpperSearch::new(&graph, hierarchy);
    let target = nodes[target % nodes.len()];
    let costs = costs_to(&graph, target);
    for from in [nodes[0], nodes[nodes.len() - 1]] {
        let leads = upper.run(&graph, PlanTarget::Node(target), from, f32::INFINITY);
        assert!(leads || !costs.contains_key(&from), "{from:?} {target:?}");
        for (&node, &frames) in &costs {
            let estimate = upper.estimate(hierarchy, node);
            assert!(estimate <= frames as f32 + 1e-2, "{node:?} to {target:?}: {estimate} {frames}");
        }
    }
    let is_dominated = |&entrance: &u32| {
        let s = entrance as usize;
        upper.stamps[s] == upper.stamp
            && upper.next_stamps[s] != upper.stamp
            && hierarchy.leads_from(entrance).is_some()
    };
    (0..hierarchy.entrances.len() as u32).filter(is_dominated).count()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn estimates_are_no_more_than_ways_cost(
        tile in tiles(), depths in prop::array::uniform3(0i32..5), target in 0usize..1000
    ) {
        check_estimates(&tile, depths, target);
    }
}

#[test]
fn ways_into_dead_ends_are_needless_and_nothing_is_lost_with_them() {
    let dominated: usize = (0..160).step_by(7).map(|t| check_estimates(&Tile::crossed_in(20, 16), [4, 3, 4], t)).sum();
    assert!(dominated > 0);
}

#[test]
fn ways_longer_than_can_be_counted_are_ways_still() {
    let tile = Tile::crossed_in(20, 16);
    let world = tile.floor(&places([3, 4, 2]));
    let graph = WorldGraph::new(&tile.patches(), &world.tables()).unwrap();
    let hierarchy = graph.hierarchy();
    let mut upper = UpperSearch::new(&graph, hierarchy);
    upper.begin();
    let (region, entrance) = (0..hierarchy.entrances.len() as u32)
        .filter_map(|e| Some((hierarchy.leads_from(e)?.0, e)))
        .find(|&(region, _)| !hierarchy.region_costs.list(region).is_empty())
        .unwrap();
    upper.reach_region(hierarchy, region, entrance, 3e9);
    let reached = (0..upper.costs.len()).filter(|&s| upper.stamps[s] == upper.stamp);
    assert!(reached.clone().count() > 0 && reached.clone().all(|s| upper.costs[s] >= 3e9));
}
