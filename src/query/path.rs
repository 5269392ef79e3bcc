//! A path through a world.

use crate::args::{CacheArgs, CommandResult, parse_point};
use crate::{keys, output, stitch};
use schemars::JsonSchema;
use serde::Serialize;
use std::{path::PathBuf, time::Instant};
use throng_core::base::error::ensure;
use throng_precompute::stitch::WorldSource;
use throng_world::plan::{PlanTarget, WorldPlanner};
use throng_world::{WorldGraph, WorldNode, WorldStep};

/// Most steps of a path: half an hour of walking.
const MAX_STEPS: usize = 4096;

/// Greatest distance of a point from a place where a character can stay; farther ones lie outside of the world (m).
const NEAR_M: f32 = 3.0;

/// Plan a path through a world, between the places nearest to two points.
#[derive(clap::Args)]
#[command(after_long_help = keys::json_keys::<PathQueryReport<'static>>())]
pub struct Args {
    /// World file (`.toml`), which is stitched if that has not been done.
    #[arg(value_name = "WORLD")]
    file: PathBuf,
    /// Start of the path, in metres.
    #[arg(long, value_name = "X,Z", allow_hyphen_values = true, value_parser = parse_point)]
    from: [f32; 2],
    /// End of the path, in metres.
    #[arg(long, value_name = "X,Z", allow_hyphen_values = true, value_parser = parse_point)]
    to: [f32; 2],
    #[command(flatten)]
    cache: CacheArgs,
    /// Print one JSON object; `throng help keys` lists its keys.
    #[arg(long)]
    json: bool,
}

/// Printed report.
#[derive(Serialize, JsonSchema)]
struct PathQueryReport<'a> {
    /// Name of the world.
    world: &'a str,
    /// Nearest place to the start where a character can stay (m).
    from_m: [f32; 3],
    /// Nearest place to the end where a character can stay (m).
    to_m: [f32; 3],
    /// Length of the path (m).
    length_m: f32,
    /// Time that the path takes (s).
    duration_s: f64,
    /// Steps of the path.
    transitions: usize,
    /// States of instances that the upper layer opened.
    opened_instances: usize,
    /// Nodes that the lower layer opened.
    opened_nodes: usize,
    /// Wall time of planning (s).
    seconds: f64,
    /// Places along the path: x, y, z (m).
    path_m: Vec<[f32; 3]>,
}

/// Plans from the place nearest to one point to that nearest to another.
pub fn run(args: &Args) -> CommandResult {
    let source = WorldSource::load(&args.file)?;
    let tables = stitch::world_bundle(&source, &args.cache)?;
    let world = stitch::open_world(&source, &args.file, &tables)?;
    let graph = world.graph();
    let nearest = |key: &str, [x, z]: [f32; 2]| {
        let none = || format!("{}: there is no place in this world where a character can stay", args.file.display());
        let (node, away_m) = nearest_rest_place(graph, [x, z]).ok_or_else(none)?;
        let at = graph.place(node);
        let expected = format!("a point within {NEAR_M} m of a place where a character can stay");
        let fault = || format!("{key} {x},{z}: expected {expected}; the nearest one is at {:.1},{:.1}", at.x, at.z);
        ensure(away_m <= NEAR_M, fault).map(|()| node)
    };
    let [start, end] = [nearest("--from", args.from)?, nearest("--to", args.to)?];
    let mut planner = WorldPlanner::new(graph);
    let mut steps = vec![WorldStep::NONE; MAX_STEPS];
    let begin = Instant::now();
    let plan = planner.plan(graph, start, PlanTarget::Node(end), &mut steps);
    let none = || format!("{}: no way leads from {:?} to {:?}", args.file.display(), args.from, args.to);
    let plan = plan.ok_or_else(none)?;
    let seconds = begin.elapsed().as_secs_f64();
    let at = |node: WorldNode| graph.place(node).translation().to_array();
    let report = PathQueryReport {
        world: &source.name,
        from_m: at(start),
        to_m: at(end),
        length_m: plan.length_m,
        duration_s: f64::from(plan.num_frames) / tables.meta().rate_hz,
        transitions: plan.num_steps,
        opened_instances: plan.opened_instances,
        opened_nodes: plan.opened_nodes,
        seconds,
        path_m: steps[..plan.num_stored].iter().map(|s| at(s.to)).collect(),
    };
    output::report(&report, args.json, print)
}

/// Nearest place to a point of the ground plane where a character can stay, and its distance (m).
fn nearest_rest_place(graph: &WorldGraph, [x, z]: [f32; 2]) -> Option<(WorldNode, f32)> {
    let away = |n: WorldNode| {
        let p = graph.place(n);
        (n, (p.x - x).hypot(p.z - z))
    };
    let all = (0..graph.num_instances() as u32).flat_map(|i| graph.rest_cells(i));
    all.map(away).min_by(|a, b| a.1.total_cmp(&b.1))
}

fn print(r: &PathQueryReport<'_>) -> CommandResult {
    let place = |p: [f32; 3]| format!("{:.1}, {:.1}, {:.1}", p[0], p[1], p[2]);
    let opened = format!("{} states of instances and {} nodes opened", r.opened_instances, r.opened_nodes);
    output::table(&[
        ("path", format!("from ({}) to ({}) in {}", place(r.from_m), place(r.to_m), r.world)),
        ("length", format!("{:.1} m, {:.1} s, {} transitions", r.length_m, r.duration_s, r.transitions)),
        ("planning", format!("{:.2} ms; {opened}", 1e3 * r.seconds)),
    ])
}
