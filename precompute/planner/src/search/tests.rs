use super::tree::{MetricWeights, SearchNode, SearchTree};
use super::*;
use crate::collide::Checker;
use crate::linkage::{LIMB_JOINTS, LimbPose};
use crate::problem::LimbState;
use crate::testing::{TestCharacter, stuck};
use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const WEIGHTS: MetricWeights = MetricWeights { time: 0.3, place: 1.0 };

fn node(rng: &mut Pcg64Mcg) -> SearchNode {
    let ends = std::array::from_fn(|_| DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0))));
    SearchNode { state: LimbState { pose: LimbPose::REST, time_s: rng.random_range(0.0..2.0) }, ends, parent: 0 }
}

#[test]
fn the_nearest_node_is_that_of_brute_force() {
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    for from_goal in [false, true] {
        let mut tree = SearchTree::default();
        let mut root = node(&mut rng);
        root.state.time_s = if from_goal { 2.0 } else { 0.0 };
        tree.reset(root, from_goal);
        for _ in 0..200 {
            let at = node(&mut rng);
            let metric = |n: &SearchNode| {
                let apart = (0..LIMB_JOINTS).map(|i| (n.ends[i] - at.ends[i]).length()).fold(0.0, f64::max);
                0.3 * (n.state.time_s - at.state.time_s).abs() + apart
            };
            let before = |n: &SearchNode| {
                if from_goal { n.state.time_s >= at.state.time_s } else { n.state.time_s <= at.state.time_s }
            };
            let all = tree.nodes.iter().enumerate().filter(|(_, n)| before(n));
            let best = all.min_by(|a, b| metric(a.1).total_cmp(&metric(b.1))).map(|(i, _)| i);
            assert_eq!(Some(tree.nearest_node(&at, &WEIGHTS)), best);
            tree.add(at);
        }
    }
}

#[test]
fn trees_grow_by_free_steps_of_epsilon_forwards_and_backwards_in_time() {
    let s = TestCharacter::standing();
    // The trees grow and never meet.
    let problem = stuck(&s);
    let config = SearchConfig::default();
    let grid = TimeGrid::new(0.0, 1.5, 30.0);
    let mut search = TreeSearch::default();
    let mut checker = Checker::default();
    let quest = SearchRequest { problem: &problem, config: &config, grid, draws: 1500, warm: false };
    let found = search.run(quest, &mut checker, &mut Pcg64Mcg::seed_from_u64(4), || None);
    assert_eq!((found, search.draws), (SearchOutcome::NoPath, 1500));
    let apart = |a: &LimbState, b: &LimbState| {
        let [a, b] = [a, b].map(|s| problem.chain.segment_ends(&problem.place_chain(s)));
        (0..3).map(|i| a[i].distance(b[i])).fold(0.0, f64::max)
    };
    for (k, tree) in search.trees().into_iter().enumerate() {
        let nodes: Vec<(LimbState, usize)> = tree.map(|(s, parent)| (*s, parent)).collect();
        assert!(nodes.len() > [1, 20][k], "{k}: {}", nodes.len());
        for (state, parent) in &nodes[1..] {
            let from = &nodes[*parent].0;
            let (a, b) = if k == 0 { (from, state) } else { (state, from) };
            assert!(a.time_s <= b.time_s && checker.is_free(&problem, state));
            assert!(checker.is_edge_free(&problem, a, b));
            // Even turns of joints are not even motion of places: about epsilon.
            assert!(apart(a, b) < 2.0 * config.epsilon_m, "{}", apart(a, b));
            assert!((grid.time_at(grid.nearest_frame(state.time_s)) - state.time_s).abs() < 1e-12);
        }
    }
}
