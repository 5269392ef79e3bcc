//! What a world costs: stitching it, changing it, planning in it, living in it.

mod paths;

pub use paths::PathFigures;
use serde::Serialize;
use std::path::Path;
use std::time::Instant;
use throng_bake::stitch::{Editor, Kit, WorldSource};
use throng_motion::error::BuildError;
use throng_motion::progress::Silent;
use throng_runtime::format::AlignedBytes;
use throng_runtime::patch::Placement;
use throng_runtime::world::inhabitants::{Inhabitants, InhabitantsConfig, scatter};
use throng_runtime::world::{PathCosts, World, WorldData, WorldGraph};
use throng_runtime::{Bundle, Cast, Error, Inline};

/// Moves of a unit that are timed, and how far each goes on from the one before (m).
const EDITS: usize = 7;
const EDIT_M: f32 = 0.03;
/// Units that are tried where the middle one cannot be moved so little, and places for each.
const UNITS: usize = 8;
const PLACES: usize = 20;
/// Characters that walk about, where there is room, and for how long (s).
const CHARACTERS: usize = 1000;
const LIFE_S: f32 = 4.0;
const STEP_HZ: f32 = 60.0;

/// Figures of a world.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct WorldFigures {
    /// The world's name.
    pub world: String,
    /// Patches that were fitted.
    pub instances: usize,
    /// Cells that are left.
    pub cells: u64,
    /// Transitions that are left.
    pub transitions: u64,
    /// Stitching it, on all threads (s).
    pub stitch_seconds: f64,
    /// Working out its path costs and writing the file, on all threads (s).
    pub bake_seconds: f64,
    /// Most memory until then, where the system tells (bytes).
    pub peak_bytes: u64,
    /// Moving a unit of every kind that is placed, in the order of the bundle's.
    pub edits: Vec<EditFigures>,
    /// Paths between places drawn at random.
    pub paths: PathFigures,
    /// The same paths, planned for a quick answer.
    pub paths_soon: PathFigures,
    /// Characters that walked about, as many as there was room for up to a thousand.
    pub characters: usize,
    /// Steps of all of them a second on one thread: control and poses.
    pub steps_per_second: f64,
}

/// Figures of moving a unit a few centimetres, and a few more, as in dragging. What only fits a raster, as tiles do,
/// is moved by its own length, from the rim of what is placed to free places beside others of its kind.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct EditFigures {
    /// Name of the unit.
    pub unit: String,
    /// How many are placed.
    pub placed: usize,
    /// The place that was moved: of all of that kind the middle one, or the first that there is a free place for.
    pub place: usize,
    /// How far each move went (m).
    pub step_m: f64,
    /// Moves that were done; others were refused: the unit does not fit there, or it or others could not be reached.
    pub done: usize,
    /// Time for one, on all threads, the median; none where every move was refused (s).
    pub seconds: Option<f64>,
    /// That time over stitching anew.
    pub over_stitch: Option<f64>,
}

/// Measures a world.
///
/// - `path`: of the world file, for messages.
///
/// # Errors
/// As [`Kit::new`], [`Editor::new`] and [`Inhabitants::new`].
pub fn world(tables: &Bundle, source: &WorldSource, path: &Path) -> Result<WorldFigures, BuildError> {
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
    let begin = Instant::now();
    let file = baked(&data, tables).map_err(|e| fail(e.to_string()))?;
    let bake_seconds = begin.elapsed().as_secs_f64();
    let begin = Instant::now();
    let world = World::from_bytes(file, tables).map_err(|e| fail(e.to_string()))?;
    let open_seconds = begin.elapsed().as_secs_f64();
    let (paths, paths_soon) = paths::measure(world.graph(), tables.meta().rate_hz, open_seconds);
    let (characters, steps_per_second) = life(&world)?;
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
fn baked(data: &WorldData, tables: &Bundle) -> Result<AlignedBytes, Box<dyn std::error::Error>> {
    let costs = PathCosts::bake(&WorldGraph::new(tables.patches(), &data.view())?)?;
    let mut bytes = Vec::new();
    data.write(&costs, &mut bytes)?;
    Ok(AlignedBytes::from_slice(&bytes))
}

fn fail(message: String) -> BuildError {
    BuildError::Stage { stage: "bench", message, help: "Stitch the world with `throng stitch` first".into() }
}

/// Moves one of all units of a kind, and back again; none where there is none.
fn edit(
    editor: &mut Editor<'_>,
    kit: &Kit,
    kind: usize,
    stitch_seconds: f64,
) -> Result<Option<EditFigures>, BuildError> {
    let units = &editor.environment().units;
    let places: Vec<usize> = (0..units.len()).filter(|&u| units[u].unit == kind).collect();
    let Some(&middle) = places.get(places.len() / 2) else { return Ok(None) };
    let home = units[middle].placement;
    let nudges = (1..=EDITS).map(|k| home.compose(Placement::new(k as f32 * EDIT_M, 0.0, 0.0, 0.0)));
    let mut moved = (middle, EDIT_M, timed(editor, middle, nudges)?);
    if moved.2.is_empty() {
        let extent = kit.geometries[kind].bounds.max - kit.geometries[kind].bounds.min;
        let length = extent.x.max(extent.z);
        let free = free_places(editor, &places, length);
        // What stands in the middle of others is missed there: those on the rim are placed first or last.
        for &place in places.iter().step_by(places.len().div_ceil(UNITS)) {
            if moved.2.is_empty() {
                moved = (place, length, timed(editor, place, free.iter().copied())?);
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

/// The times of moves that were not refused, at most [`EDITS`]; then the unit is where it was (s).
fn timed(editor: &mut Editor<'_>, place: usize, ways: impl Iterator<Item = Placement>) -> Result<Vec<f64>, BuildError> {
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

/// Where nothing of a kind stands, but something a length away: those beside the last of the kind first.
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

/// How fast people walk about.
fn life(world: &World) -> Result<(usize, f64), BuildError> {
    let starts = scatter(world.graph(), CHARACTERS, 1);
    let wrong = |e: Error| fail(e.to_string());
    let mut people = Inhabitants::new(world, starts.len(), InhabitantsConfig::default()).map_err(wrong)?;
    starts.iter().try_for_each(|&start| people.spawn(start).map(|_| ())).map_err(wrong)?;
    let steps = (LIFE_S * STEP_HZ) as usize;
    let begin = Instant::now();
    for _ in 0..steps {
        people.step(1.0 / STEP_HZ, &Inline).map_err(wrong)?;
    }
    Ok((starts.len(), steps as f64 / begin.elapsed().as_secs_f64()))
}
