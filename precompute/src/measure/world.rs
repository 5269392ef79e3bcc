//! What a world costs: stitching it, changing it, planning in it, living in it.

use crate::error::BuildError;
use crate::progress::Silent;
use crate::scene::world::{SharedWish, WishConfig, WorldScene};
use crate::stitch::{Editor, Kit, WorldSource};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::Serialize;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::path::Path;
use std::time::Instant;
use throng_runtime::Tables;
use throng_runtime::patch::Placement;
use throng_runtime::troupe::Repertoire;
use throng_runtime::world::plan::{Planner, Target};
use throng_runtime::world::{Node, Step, WorldGraph};

/// Moves of a unit that are timed, and how far each goes on from the one before. [Unit: m]
const EDITS: usize = 7;
const EDIT_M: f32 = 0.03;
/// Paths that are planned, and those of them that are compared with a plain search.
const PATHS: usize = 40;
const COMPARED: usize = 8;
/// Larger worlds are not searched through. [Unit: nodes]
const MAX_SEARCHED: usize = 1_000_000;
/// Steps of a path that are kept.
const MAX_STEPS: usize = 4096;
/// Characters that walk about, where there is room, and for how long. [Unit: s]
const CHARACTERS: usize = 1000;
const LIFE_S: f32 = 4.0;
const STEP_HZ: f32 = 60.0;

/// Figures of a world.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct WorldFigures {
    /// The world's name.
    pub world: String,
    /// Patches that were fitted.
    pub instances: usize,
    /// Cells that are left.
    pub cells: u64,
    /// Transitions that are left.
    pub transitions: u64,
    /// Stitching it, on all threads. [Unit: s]
    pub stitch_seconds: f64,
    /// Most memory until then, where the system tells. [Unit: bytes]
    pub peak_bytes: u64,
    /// Moving a unit of every kind that is placed, in the order of the bundle's.
    pub edits: Vec<EditFigures>,
    /// Paths between places drawn at random.
    pub paths: PathFigures,
    /// Characters who walked about, as many as there was room for up to a thousand.
    pub characters: usize,
    /// Steps of all of them a second on one thread: control and poses.
    pub steps_per_second: f64,
}

/// Figures of moving a unit a few centimetres, and a few more, as who drags it does.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct EditFigures {
    /// Name of the unit.
    pub unit: String,
    /// How many are placed.
    pub placed: usize,
    /// The place that was moved: of all of that kind the middle one.
    pub place: usize,
    /// Moves that were done; others were refused: nothing fits the unit there, or nobody gets to it or to others.
    pub done: usize,
    /// Time for one, on all threads, the median; none where every move was refused. [Unit: s]
    pub seconds: Option<f64>,
    /// That time over stitching anew.
    pub over_stitch: Option<f64>,
}

/// Figures of path planning.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PathFigures {
    /// Paths that were found.
    pub found: usize,
    /// Time to plan one, on average. [Unit: s]
    pub seconds_mean: f64,
    /// Time to plan one, at most. [Unit: s]
    pub seconds_max: f64,
    /// Length of the paths, on average. [Unit: m]
    pub length_mean_m: f64,
    /// Length of the longest. [Unit: m]
    pub length_max_m: f64,
    /// Time they take to walk, on average. [Unit: s]
    pub duration_mean_s: f64,
    /// States of instances opened in the upper layer, on average.
    pub opened_instances_mean: f64,
    /// Nodes opened in the lower layer, on average.
    pub opened_nodes_mean: f64,
    /// Paths that were compared with Dijkstra's over the whole world.
    pub compared: usize,
    /// Time to walk over that of Dijkstra's, on average and at most; none in worlds too large to search through.
    pub over_dijkstra_mean: Option<f64>,
    /// See `over_dijkstra_mean`.
    pub over_dijkstra_max: Option<f64>,
}

/// Measures a world.
///
/// - `path`: of the world file, for messages.
///
/// # Errors
/// As [`Kit::new`], [`Editor::new`] and [`WorldScene::live`].
pub fn world(tables: &Tables, source: &WorldSource, path: &Path) -> Result<WorldFigures, BuildError> {
    let kit = Kit::new(tables, &source.bundle)?;
    let environment = source.environment(&kit.units, path)?;
    let begin = Instant::now();
    let mut editor = Editor::new(tables.patches(), kit.library(tables), environment, &source.stitch, &Silent)?;
    let stitch_seconds = begin.elapsed().as_secs_f64();
    let report = editor.report().clone();
    let kinds = 0..kit.units.units.len();
    let edits = kinds.filter_map(|kind| edit(&mut editor, &kit, kind, stitch_seconds).transpose());
    let edits = edits.collect::<Result<_, _>>()?;
    let (data, _) = editor.into_world();
    let graph = WorldGraph::new(tables.patches(), data.view()).map_err(|e| fail(e.to_string()))?;
    let (characters, steps_per_second) = life(source, tables, &graph)?;
    Ok(WorldFigures {
        world: source.name.clone(),
        instances: report.instances,
        cells: report.cells,
        transitions: report.transitions,
        stitch_seconds,
        peak_bytes: report.peak_bytes,
        edits,
        paths: paths(&graph, tables.meta().rate_hz),
        characters,
        steps_per_second,
    })
}

fn fail(message: String) -> BuildError {
    BuildError::Stage { stage: "bench", message, help: "Stitch the world with `throng stitch` first".into() }
}

/// Moves the middle one of all units of a kind, and back again; none where there is none.
fn edit(
    editor: &mut Editor<'_>,
    kit: &Kit,
    kind: usize,
    stitch_seconds: f64,
) -> Result<Option<EditFigures>, BuildError> {
    let units = &editor.environment().units;
    let places: Vec<usize> = (0..units.len()).filter(|&u| units[u].unit == kind).collect();
    let Some(&place) = places.get(places.len() / 2) else { return Ok(None) };
    let home = units[place].placement;
    let mut seconds = Vec::new();
    for k in 1..=EDITS {
        let to = home.compose(Placement::new(k as f32 * EDIT_M, 0.0, 0.0, 0.0));
        let begin = Instant::now();
        if editor.drag(place, to).is_ok() {
            seconds.push(begin.elapsed().as_secs_f64());
        }
    }
    editor.drag(place, home)?;
    seconds.sort_by(f64::total_cmp);
    let median = seconds.get(seconds.len() / 2).copied();
    Ok(Some(EditFigures {
        unit: kit.units.units[kind].name.clone(),
        placed: places.len(),
        place,
        done: seconds.len(),
        seconds: median,
        over_stitch: median.map(|s| s / stitch_seconds),
    }))
}

/// How fast people walk about.
fn life(source: &WorldSource, tables: &Tables, graph: &WorldGraph<'_>) -> Result<(usize, f64), BuildError> {
    let room = throng_runtime::world::inhabitants::scatter(graph, CHARACTERS, 1).len();
    let roam = SharedWish { share: 1.0, wish: WishConfig::Roam { seconds: [1e3, 1e3] } };
    let scene = WorldScene {
        name: source.name.clone(),
        world: Default::default(),
        characters: room.max(1),
        seed: 1,
        wishes: vec![roam],
        picture: Default::default(),
    };
    let repertoire = Repertoire::new(tables);
    let mut life = scene.live(tables, &repertoire, graph)?;
    let steps = (LIFE_S * STEP_HZ) as usize;
    let begin = Instant::now();
    for _ in 0..steps {
        life.step(&repertoire, graph, 1.0 / STEP_HZ).map_err(|e| fail(e.to_string()))?;
    }
    Ok((scene.characters, steps as f64 / begin.elapsed().as_secs_f64()))
}

fn paths(graph: &WorldGraph<'_>, rate_hz: f64) -> PathFigures {
    let rests: Vec<Node> = (0..graph.num_instances() as u32).filter_map(|i| graph.rest_cells(i).next()).collect();
    let (mut rng, mut planner) = (Pcg64Mcg::seed_from_u64(1), Planner::new(graph));
    let mut steps = vec![Step::NONE; MAX_STEPS];
    let (mut out, mut ratios) = (PathFigures::default(), Vec::new());
    for k in 0..PATHS {
        let mut draw = || rests[rng.random_range(0..rests.len())];
        let (from, to) = (draw(), draw());
        let begin = Instant::now();
        let Some(plan) = planner.plan(graph, from, Target::Node(to), &mut steps) else { continue };
        let seconds = begin.elapsed().as_secs_f64();
        out.found += 1;
        out.seconds_mean += seconds;
        out.seconds_max = out.seconds_max.max(seconds);
        out.length_mean_m += f64::from(plan.length_m);
        out.length_max_m = out.length_max_m.max(f64::from(plan.length_m));
        out.duration_mean_s += f64::from(plan.num_frames) / rate_hz;
        out.opened_instances_mean += plan.opened_instances as f64;
        out.opened_nodes_mean += plan.opened_nodes as f64;
        if k < COMPARED && graph.num_nodes() <= MAX_SEARCHED && from != to {
            ratios.extend(dijkstra(graph, from, to).map(|best| f64::from(plan.num_frames) / f64::from(best)));
        }
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
    out.over_dijkstra_mean = (!ratios.is_empty()).then(|| ratios.iter().sum::<f64>() / ratios.len() as f64);
    out.over_dijkstra_max = ratios.into_iter().reduce(f64::max);
    out
}

/// Frames of the shortest way between two nodes, over the whole world.
fn dijkstra(graph: &WorldGraph<'_>, from: Node, to: Node) -> Option<u32> {
    let mut best = std::collections::HashMap::from([(from, 0u32)]);
    let mut open = BinaryHeap::from([Reverse((0u32, from))]);
    while let Some(Reverse((frames, node))) = open.pop() {
        if node == to {
            return Some(frames);
        }
        if best[&node] < frames {
            continue;
        }
        graph.for_each_step(node, |step| {
            let then = frames + step.num_frames();
            if best.get(&step.to).is_none_or(|&b| then < b) {
                best.insert(step.to, then);
                open.push(Reverse((then, step.to)));
            }
        });
    }
    None
}
