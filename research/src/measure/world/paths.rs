//! Cost of path planning, and length of the planned paths relative to the best ones.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::Serialize;
use std::time::Instant;
use throng_world::plan::{PlanTarget, WorldPlan, WorldPlanner};
use throng_world::{WorldGraph, WorldNode, WorldStep};

/// Number of planned paths, and how many of them are compared with a plain search.
const PATHS: usize = 40;
const COMPARED: usize = 24;
/// Largest world for the plain search (nodes).
const MAX_SEARCHED: usize = 2_500_000;
/// Most steps of a path.
const MAX_STEPS: usize = 4096;

/// Figures of path planning.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct PlannedPathFigures {
    /// Paths that were found.
    pub found: usize,
    /// Time to open the world's file and make a planner (s).
    pub first_seconds: f64,
    /// Time to plan a path, on average (s).
    pub seconds_mean: f64,
    /// Time to plan a path, at most (s).
    pub seconds_max: f64,
    /// First and last instance of the path that took longest to plan.
    pub slowest: [u32; 2],
    /// Length of the paths, on average (m).
    pub length_mean_m: f64,
    /// Length of the longest path (m).
    pub length_max_m: f64,
    /// Time to walk the paths, on average (s).
    pub duration_mean_s: f64,
    /// Instance states that the upper layer opened, on average.
    pub opened_instances_mean: f64,
    /// Nodes opened in the lower layer, on average.
    pub opened_nodes_mean: f64,
    /// Time to walk a path over the lower bound of any path, at most.
    pub over_bound_max: f64,
    /// Paths that were compared with Dijkstra's algorithm over the whole world.
    pub compared: usize,
    /// Time to walk over that of the shortest path, mean; none in worlds too large for the search.
    pub over_dijkstra_mean: Option<f64>,
    /// Time to walk over that of the shortest path, at most.
    pub over_dijkstra_max: Option<f64>,
    /// First and last instance of the worst of those paths.
    pub worst: Option<[u32; 2]>,
}

/// Plans paths between random places: within the bound of the default planner, and for a quick answer.
pub(super) fn measure(graph: &WorldGraph, rate_hz: f64, open_seconds: f64) -> (PlannedPathFigures, PlannedPathFigures) {
    let rests: Vec<WorldNode> = (0..graph.num_instances() as u32).filter_map(|i| graph.rest_cells(i).next()).collect();
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    let pairs: Vec<[WorldNode; 2]> =
        (0..PATHS).map(|_| [0; 2].map(|_| rests[rng.random_range(0..rests.len())])).collect();
    let searched = graph.num_nodes() <= MAX_SEARCHED;
    let best = |(k, &[from, to]): (usize, &[WorldNode; 2])| {
        (searched && k < COMPARED && from != to).then(|| dijkstra(graph, from, to)).flatten()
    };
    let best: Vec<Option<u32>> = pairs.iter().enumerate().map(best).collect();
    let begin = Instant::now();
    let mut planner = WorldPlanner::new(graph);
    let first_seconds = open_seconds + begin.elapsed().as_secs_f64();
    let mut steps = vec![WorldStep::NONE; MAX_STEPS];
    let promised = path_figures(&pairs, &best, rate_hz, |from, to| planner.plan(graph, from, to, &mut steps));
    let soon = path_figures(&pairs, &best, rate_hz, |from, to| planner.plan_soon(graph, from, to, &mut steps));
    (PlannedPathFigures { first_seconds, ..promised }, PlannedPathFigures { first_seconds, ..soon })
}

/// Figures of one planning method.
fn path_figures(
    pairs: &[[WorldNode; 2]],
    best: &[Option<u32>],
    rate_hz: f64,
    mut plan: impl FnMut(WorldNode, PlanTarget) -> Option<WorldPlan>,
) -> PlannedPathFigures {
    let (mut out, mut ratios) = (PlannedPathFigures::default(), Vec::new());
    for (&[from, to], best) in pairs.iter().zip(best) {
        let begin = Instant::now();
        let Some(plan) = plan(from, PlanTarget::Node(to)) else { continue };
        let seconds = begin.elapsed().as_secs_f64();
        let ends = [from.instance, to.instance];
        out.found += 1;
        out.seconds_mean += seconds;
        out.slowest = if seconds > out.seconds_max { ends } else { out.slowest };
        out.seconds_max = out.seconds_max.max(seconds);
        out.length_mean_m += f64::from(plan.length_m);
        out.length_max_m = out.length_max_m.max(f64::from(plan.length_m));
        out.duration_mean_s += f64::from(plan.num_frames) / rate_hz;
        out.opened_instances_mean += plan.opened_instances as f64;
        out.opened_nodes_mean += plan.opened_nodes as f64;
        out.over_bound_max = out.over_bound_max.max(f64::from(plan.num_frames) / f64::from(plan.least_frames.max(1)));
        ratios.extend(best.map(|best| (f64::from(plan.num_frames) / f64::from(best), ends)));
    }
    let n = out.found.max(1) as f64;
    for mean in [
        &mut out.seconds_mean,
        &mut out.length_mean_m,
        &mut out.duration_mean_s,
        &mut out.opened_instances_mean,
        &mut out.opened_nodes_mean,
    ] {
        *mean /= n;
    }
    out.compared = ratios.len();
    let sum: f64 = ratios.iter().map(|r| r.0).sum();
    out.over_dijkstra_mean = (!ratios.is_empty()).then(|| sum / ratios.len() as f64);
    let worst = ratios.into_iter().max_by(|a, b| a.0.total_cmp(&b.0));
    (out.over_dijkstra_max, out.worst) = worst.unzip();
    out
}

/// Frames of the shortest path between two nodes over the whole world: Dijkstra with buckets of whole frames (Dial 1969).
fn dijkstra(graph: &WorldGraph, from: WorldNode, to: WorldNode) -> Option<u32> {
    let mut first = vec![0];
    (0..graph.num_instances() as u32).for_each(|i| first.push(first[i as usize] + graph.cells(i).len()));
    let number = |n: WorldNode| first[n.instance as usize] + n.cell as usize;
    let mut best = vec![u32::MAX; graph.num_nodes()];
    // No step takes longer than its offsets can represent.
    let mut buckets = vec![Vec::new(); usize::from(u16::MAX) + 1];
    let (mut open, mut frames) = (1, 0u32);
    best[number(from)] = 0;
    buckets[0].push(from);
    while open > 0 {
        let Some(node) = buckets[frames as usize % (usize::from(u16::MAX) + 1)].pop() else {
            frames += 1;
            continue;
        };
        open -= 1;
        if best[number(node)] < frames {
            continue;
        }
        if node == to {
            return Some(frames);
        }
        graph.for_each_step(node, |step| {
            let then = frames + step.num_frames();
            if then < best[number(step.to)] {
                best[number(step.to)] = then;
                buckets[then as usize % (usize::from(u16::MAX) + 1)].push(step.to);
                open += 1;
            }
        });
    }
    None
}
