//! Cost of a world: stitching, editing, path planning, and inhabitants.

mod paths;

pub use paths::PlannedPathFigures;
use serde::Serialize;
use std::path::Path;
use std::time::Instant;
use throng_bake::stitch::{Editor, StitchKit, WorldSource};
use throng_core::format::AlignedBytes;
use throng_core::patch::Placement;
use throng_core::{Bundle, CharacterGroup, Error, Inline};
use throng_motion::error::BuildError;
use throng_motion::progress::Silent;
use throng_world::inhabitants::{Inhabitants, InhabitantsConfig, scatter_rest_nodes};
use throng_world::{PathCosts, World, WorldData, WorldGraph};

/// Number of timed moves of a unit, and distance of each from the one before (m).
const EDITS: usize = 7;
const EDIT_M: f32 = 0.03;
/// Number of units to try if the middle one cannot be moved so little, and of places for each.
const UNITS: usize = 8;
const PLACES: usize = 20;
/// Number of inhabitants if there is room, and for how long they walk about (s).
const CHARACTERS: usize = 1000;
const INHABITED_S: f32 = 4.0;
const STEP_HZ: f32 = 60.0;

/// Figures of a world.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct WorldFigures {
    /// The world's name.
    pub world: String,
    /// Patches that were fitted.
    pub instances: usize,
    /// Cells that remain after stitching.
    pub cells: u64,
    /// Transitions that remain after stitching.
    pub transitions: u64,
    /// Time to stitch it, on all threads (s).
    pub stitch_seconds: f64,
    /// Time to compute its path costs and write the file, on all threads (s).
    pub bake_seconds: f64,
    /// Peak memory until then, where the system reports it (bytes).
    pub peak_bytes: u64,
    /// Figures of moving a unit of every kind that is placed, in the order of the bundle's.
    pub edits: Vec<EditFigures>,
    /// Paths between places drawn at random.
    pub paths: PlannedPathFigures,
    /// Figures of the same paths, planned for a quick answer.
    pub paths_soon: PlannedPathFigures,
    /// Number of inhabitants: as many as there was room for, up to a thousand.
    pub characters: usize,
    /// Steps of all of them a second on one thread: control and poses.
    pub steps_per_second: f64,
}

/// Figures of moving a unit by a few centimetres at a time, as in dragging. Units that only fit a raster, such as tiles,
/// are moved by their own length, from the rim of the placed ones to free places beside others of their kind.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct EditFigures {
    /// Name of the unit.
    pub unit: String,
    /// Number of placed units of this kind.
    pub placed: usize,
    /// Place that was moved: the middle one of that kind, or the first that has a free place.
    pub place: usize,
    /// Distance of each move (m).
    pub step_m: f64,
    /// Moves that were accepted; others were refused, as the unit does not fit there or a unit could not be reached any more.
    pub done: usize,
    /// Median time of a move, on all threads; none where every move was refused (s).
    pub seconds: Option<f64>,
    /// That time over the time to stitch anew.
    pub over_stitch: Option<f64>,
}

/// Measures a world.
///
/// - `path`: of the world file, for messages.
///
/// # Errors
/// As [`StitchKit::new`], [`Editor::new`] and [`Inhabitants::new`].
pub fn world(tables: &Bundle, source: &WorldSource, path: &Path) -> Result<WorldFigures, BuildError> {
    let kit = StitchKit::new(tables, &source.bundle)?;
    let environment = source.environment(&kit.units, path)?;
    let begin = Instant::now();
    let mut editor = Editor::new(tables.patches(), kit.library(tables), environment, &source.stitch, &Silent)?;
    let stitch_seconds = begin.elapsed().as_secs_f64();
    let report = editor.report().clone();
    let kinds = 0..kit.units.units.len();
    let edits = kinds.filter_map(|kind| measure_edit(&mut editor, &kit, kind, stitch_seconds).transpose());
    let edits = edits.collect::<Result<_, _>>()?;
    let (data, _) = editor.into_world();
    let begin = Instant::now();
    let file = bake_world(&data, tables).map_err(|e| fail(e.to_string()))?;
    let bake_seconds = begin.elapsed().as_secs_f64();
    let begin = Instant::now();
    let world = World::from_bytes(file, tables).map_err(|e| fail(e.to_string()))?;
    let open_seconds = begin.elapsed().as_secs_f64();
    let (paths, paths_soon) = paths::measure(world.graph(), tables.meta().rate_hz, open_seconds);
    let (characters, steps_per_second) = measure_inhabitants(&world)?;
    Ok(WorldFigures {
        world: source.name.clone(),
        instances: report.instances,
        cells: report.cells,
        transitions: report.transitions,
        stitch_seconds,
        bake_seconds,
        peak_bytes: report.peak_bytes,
        edits,
        paths,
        paths_soon,
        characters,
        steps_per_second,
    })
}

/// The bytes of the world's file.
fn bake_world(data: &WorldData, tables: &Bundle) -> Result<AlignedBytes, Box<dyn std::error::Error>> {
    let costs = PathCosts::bake(&WorldGraph::new(tables.patches(), &data.tables())?)?;
    let mut bytes = Vec::new();
    data.write(&costs, &mut bytes)?;
    Ok(AlignedBytes::from_slice(&bytes))
}

fn fail(message: String) -> BuildError {
    BuildError::Stage { stage: "bench", message, help: "Stitch the world with `throng stitch` first".into() }
}

/// Moves one unit of a kind, and back again; none without units of that kind.
fn measure_edit(
    editor: &mut Editor<'_>,
    kit: &StitchKit,
    kind: usize,
    stitch_seconds: f64,
) -> Result<Option<EditFigures>, BuildError> {
    let units = &editor.environment().units;
    let places: Vec<usize> = (0..units.len()).filter(|&u| units[u].unit == kind).collect();
    let Some(&middle) = places.get(places.len() / 2) else { return Ok(None) };
    let home = units[middle].placement;
    let nudges = (1..=EDITS).map(|k| home.compose(Placement::new(k as f32 * EDIT_M, 0.0, 0.0, 0.0)));
    let mut moved = (middle, EDIT_M, time_moves(editor, middle, nudges)?);
    if moved.2.is_empty() {
        let extent = kit.geometries[kind].bounds.max - kit.geometries[kind].bounds.min;
        let length = extent.x.max(extent.z);
        let free = free_places(editor, &places, length);
        // Removing a unit from the middle cuts its neighbours off; units on the rim are first or last in the list.
        for &place in places.iter().step_by(places.len().div_ceil(UNITS)) {
            if moved.2.is_empty() {
                moved = (place, length, time_moves(editor, place, free.iter().copied())?);
            }
        }
    }
    let (place, step_m, mut seconds) = moved;
    seconds.sort_by(f64::total_cmp);
    let median = seconds.get(seconds.len() / 2).copied();
    Ok(Some(EditFigures {
        unit: kit.units.units[kind].name.clone(),
        placed: places.len(),
        place,
        step_m: f64::from(step_m),
        done: seconds.len(),
        seconds: median,
        over_stitch: median.map(|s| s / stitch_seconds),
    }))
}

/// Times of accepted moves, at most [`EDITS`]; the unit ends where it began (s).
fn time_moves(
    editor: &mut Editor<'_>,
    place: usize,
    ways: impl Iterator<Item = Placement>,
) -> Result<Vec<f64>, BuildError> {
    let home = editor.environment().units[place].placement;
    let mut seconds = Vec::new();
    for to in ways {
        let begin = Instant::now();
        if editor.drag(place, to).is_ok() {
            seconds.push(begin.elapsed().as_secs_f64());
        }
        if seconds.len() == EDITS {
            break;
        }
    }
    if !seconds.is_empty() {
        editor.drag(place, home)?;
    }
    Ok(seconds)
}

/// Free places one length away from a unit of a kind, beginning beside the last of the kind.
fn free_places(editor: &Editor<'_>, places: &[usize], length: f32) -> Vec<Placement> {
    let at = |&p: &usize| editor.environment().units[p].placement;
    let sides = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
    let beside = places
        .iter()
        .rev()
        .map(at)
        .flat_map(|p| sides.map(|[x, z]| p.compose(Placement::new(x * length, 0.0, z * length, 0.0))));
    let is_free = |to: &Placement| {
        let apart = |p: Placement| (p.translation() - to.translation()).length();
        places.iter().map(at).all(|p| apart(p) > 0.5 * length)
    };
    beside.filter(is_free).take(PLACES).collect()
}

/// Number of inhabitants, and their steps a second.
fn measure_inhabitants(world: &World) -> Result<(usize, f64), BuildError> {
    let starts = scatter_rest_nodes(world.graph(), CHARACTERS, 1);
    let wrong = |e: Error| fail(e.to_string());
    let mut people = Inhabitants::new(world, starts.len(), InhabitantsConfig::default()).map_err(wrong)?;
    starts.iter().try_for_each(|&start| people.spawn(start).map(|_| ())).map_err(wrong)?;
    let steps = (INHABITED_S * STEP_HZ) as usize;
    let begin = Instant::now();
    for _ in 0..steps {
        people.step(1.0 / STEP_HZ, &Inline).map_err(wrong)?;
    }
    Ok((starts.len(), steps as f64 / begin.elapsed().as_secs_f64()))
}
