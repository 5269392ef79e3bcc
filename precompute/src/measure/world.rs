//! What a world costs: stitching it, changing it, planning in it, living in it.

mod paths;

use crate::environment::Environment;
use crate::error::BuildError;
use crate::progress::Silent;
use crate::scene::world::{SharedWish, WishConfig, WorldScene};
use crate::stitch::{Editor, Kit, WorldSource};
pub use paths::PathFigures;
use serde::Serialize;
use std::path::Path;
use std::time::Instant;
use throng_runtime::Tables;
use throng_runtime::patch::Placement;
use throng_runtime::troupe::Repertoire;
use throng_runtime::world::WorldGraph;

/// Moves of a unit that are timed, and how far each goes. [Unit: m]
const EDITS: usize = 5;
const EDIT_M: f32 = 0.03;
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
    /// Name of the unit that was moved.
    pub edited_unit: String,
    /// Moving it a few centimetres, the median of some moves; none where every move was refused. [Unit: s]
    pub edit_seconds: Option<f64>,
    /// Moving it over stitching anew.
    pub edit_over_stitch: Option<f64>,
    /// Paths between places drawn at random.
    pub paths: PathFigures,
    /// The same paths, planned by who cannot wait.
    pub paths_soon: PathFigures,
    /// Characters who walked about, as many as there was room for up to a thousand.
    pub characters: usize,
    /// Steps of all of them a second on one thread: control and poses.
    pub steps_per_second: f64,
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
    let mut editor = Editor::new(tables.patches(), kit.library(tables), environment.clone(), &source.stitch, &Silent)?;
    let stitch_seconds = begin.elapsed().as_secs_f64();
    let report = editor.report().clone();
    let moved = chosen(&kit, &environment);
    let edit_seconds = edit(&mut editor, moved, environment.units[moved].placement);
    let (data, _) = editor.into_world();
    let graph = WorldGraph::new(tables.patches(), data.view()).map_err(|e| fail(e.to_string()))?;
    // First, for the time that the first planner of a world takes.
    let (paths, paths_soon) = paths::measure(&graph, tables.meta().rate_hz);
    let (characters, steps_per_second) = life(source, tables, &graph)?;
    Ok(WorldFigures {
        world: source.name.clone(),
        instances: report.instances,
        cells: report.cells,
        transitions: report.transitions,
        stitch_seconds,
        peak_bytes: report.peak_bytes,
        edited_unit: kit.units.units[environment.units[moved].unit].name.clone(),
        edit_seconds,
        edit_over_stitch: edit_seconds.map(|s| s / stitch_seconds),
        paths,
        paths_soon,
        characters,
        steps_per_second,
    })
}

fn fail(message: String) -> BuildError {
    BuildError::Stage { stage: "bench", message, help: "Stitch the world with `throng stitch` first".into() }
}

/// The last unit that is not walked on, else the last one.
fn chosen(kit: &Kit, environment: &Environment) -> usize {
    let furniture = environment.units.iter().rposition(|u| !kit.units.units[u.unit].floor);
    furniture.unwrap_or(environment.units.len() - 1)
}

/// Median time to move a unit; a move that is refused counts for nothing.
fn edit(editor: &mut Editor<'_>, unit: usize, from: Placement) -> Option<f64> {
    let mut seconds = Vec::new();
    for k in 1..=EDITS {
        let begin = Instant::now();
        let to = Placement { x: from.x + k as f32 * EDIT_M, ..from };
        if editor.drag(unit, to).is_ok() {
            seconds.push(begin.elapsed().as_secs_f64());
        }
    }
    seconds.sort_by(f64::total_cmp);
    seconds.get(seconds.len() / 2).copied()
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
