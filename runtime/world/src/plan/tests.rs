//! Paths over made-up floors against plain Dijkstra.

use super::*;
use crate::made_up::{costs_to, nodes, places, tiles};
use proptest::prelude::*;

/// Checks that the steps follow each other from a node to another one, and take as long as the plan says.
fn check_path(graph: &WorldGraph, from: WorldNode, to: WorldNode, plan: &WorldPlan, steps: &[WorldStep]) {
    assert_eq!(plan.num_stored, plan.num_steps);
    let mut at = from;
    for step in &steps[..plan.num_stored] {
        let mut leads = false;
        graph.for_each_step(at, |s| leads |= s == *step);
        assert!(leads, "no {step:?} from {at:?}");
        at = step.to;
    }
    assert_eq!(at, to);
    assert_eq!(steps[..plan.num_stored].iter().map(WorldStep::num_frames).sum::<u32>(), plan.num_frames);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn paths_that_are_found_soon_lead_there_and_none_is_shorter_than_the_bounds(
        tile in tiles(),
        depths in prop::array::uniform3(0i32..5),
        pairs in prop::collection::vec((any::<prop::sample::Index>(), any::<prop::sample::Index>()), 6),
    ) {
        let world = tile.floor(&places(depths));
        let graph = WorldGraph::new(&tile.patches(), &world.tables()).unwrap();
        let (nodes, mut planner) = (nodes(&graph), WorldPlanner::new(&graph));
        let (mut steps, mut soon_steps) = (vec![WorldStep::NONE; 400], vec![WorldStep::NONE; 400]);
        for (from, to) in pairs {
            let (from, to) = (*from.get(&nodes), *to.get(&nodes));
            let best = costs_to(&graph, to).get(&from).copied();
            let plan = planner.plan(&graph, from, PlanTarget::Node(to), &mut steps);
            let soon = planner.plan_soon(&graph, from, PlanTarget::Node(to), &mut soon_steps);
            prop_assert_eq!([plan.is_some(), soon.is_some()], [best.is_some(); 2], "{:?} {:?}", from, to);
            let (Some(best), Some(plan), Some(soon)) = (best, plan, soon) else { continue };
            check_path(&graph, from, to, &plan, &steps);
            check_path(&graph, from, to, &soon, &soon_steps);
            prop_assert!(plan.least_frames.max(soon.least_frames) <= best, "{:?} {:?} {}", plan, soon, best);
            prop_assert!(plan.num_frames as f32 <= best as f32 * WORST + 1e-2, "{:?} {}", plan, best);
            prop_assert!(plan.least_frames <= soon.num_frames, "{:?} {:?}", plan, soon);
            prop_assert!(plan.num_frames <= soon.num_frames, "{:?} {:?}", plan, soon);
        }
    }
}
