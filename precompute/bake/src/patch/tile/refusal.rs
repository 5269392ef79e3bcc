//! Reasons why a tile cannot be made, and the way out.

use super::{PatchInputs, TileCell, TileConfig, TileGraph, TileLayout, TileOutline, TileSource, UnprunedTile};
use crate::{environment::UnitObject, patch::is_ground, stages::stage_error};
use throng_motion::error::BuildError;

/// Error for a missing unit.
pub(super) fn missing_unit_error(given: &PatchInputs, config: &TileConfig) -> BuildError {
    let names: Vec<_> = given.units.units.iter().map(|u| format!("`{}`", u.name)).collect();
    let why = format!("expected a unit ({}), found `{}`. Correct the config.", names.join(", "), config.unit);
    BuildError::key("unit", why)
}

/// Error for a unit without edges.
pub(super) fn missing_edges_error(unit: &UnitObject) -> BuildError {
    let why = format!(
        "the unit `{}` has no edges. Give it `tile = {{ steps = [[...]], widths = [...] }}` in the unit \
         file, or take it out of the tiles.",
        unit.name
    );
    BuildError::key("unit", why)
}

/// Error for a tile without clips.
pub(super) fn missing_clips_error(unit: &UnitObject, config: &TileConfig) -> BuildError {
    let wanted = match (is_ground(unit), config.clips.is_empty()) {
        (true, true) => "a clip captured in no environment".to_owned(),
        (true, false) => format!("a clip whose name matches {}", config.clips.join(", ")),
        (false, _) => format!("a clip captured in an environment that holds `{}`", unit.name),
    };
    BuildError::key("clips", format!("`{}`: expected {wanted}, found none. Correct the config.", unit.name))
}

/// Error for a tile of which pruning left nothing.
pub(super) fn empty_tile_error(tile: &UnprunedTile, source: &TileSource) -> BuildError {
    let UnprunedTile { unit, region, graph, .. } = tile;
    let (message, help) = first_unmet(source, region, graph).unwrap_or_else(|| {
        let help = format!(
            "Add walks of {:.1} m in the same few poses, straight and with turns to all sides, and stops: what the fewest \
             entries can do is missing most. Or allow more editing (edit_m_per_m, edit_deg_per_m), or take more pose groups \
             at the edges (edge_groups)",
            region.size
        );
        (format!("no entries meet all conditions together: {}", count_met(region, graph)), help)
    });
    let (name, minutes) = (&unit.name, source.minutes());
    let further = if graph.must_rest { ", and further tiles do not make up for it" } else { "" };
    let message = format!("the tile `{name}` cannot be made from {minutes:.1} min of motion: {message}{further}");
    stage_error("patch", message, help)
}

/// How many of the entries across the first edge meet each condition, in words.
fn count_met(region: &TileOutline, graph: &TileGraph) -> String {
    let entries: Vec<u32> =
        (0..graph.cells.len() as u32).filter(|&i| graph.cells[i as usize] == TileCell::Entry(0)).collect();
    let leads = |from: u32, fits: &dyn Fn(TileCell) -> bool| {
        graph.links.iter().any(|&(f, to)| f == from && fits(graph.cells[to as usize]))
    };
    let count = |fits: &dyn Fn(TileCell) -> bool| entries.iter().filter(|&&e| leads(e, fits)).count();
    let leaving = |&way: &u32| {
        let n = count(&|c| matches!(c, TileCell::Exit(e, _) if e == way));
        format!("{n} can leave {}", TileLayout::direction(region, 0, way))
    };
    let mut out: Vec<String> = graph.exit_edges[0].iter().map(leaving).collect();
    if graph.must_rest {
        out.push(format!("{} can come to rest", count(&|c| c == TileCell::Rest)));
    }
    format!("of {} entries across an edge, {}", entries.len(), out.join(", "))
}

/// First condition that no entry meets, and the motion that would help.
fn first_unmet(source: &TileSource, region: &TileOutline, graph: &TileGraph) -> Option<(String, String)> {
    const EDIT: &str = "or allow more editing (edit_m_per_m, edit_deg_per_m)";
    let enters = |from: u32| if let TileCell::Entry(edge) = graph.cells[from as usize] { Some(edge) } else { None };
    if !graph.cells.iter().any(|c| matches!(c, TileCell::Entry(_))) {
        return Some((
            "no pose is common where its edges are crossed".to_owned(),
            "Add motion that crosses it, or check where the environment places it".to_owned(),
        ));
    }
    // A slide is not entered from below.
    let entered = |edge: usize| graph.cells.contains(&TileCell::Entry(edge as u32));
    for (edge, paths) in graph.exit_edges.iter().enumerate().filter(|(e, _)| entered(*e)) {
        let leaves = |way: u32| {
            let mut links = graph.links.iter().filter(|l| enters(l.0) == Some(edge as u32));
            links.any(|l| matches!(graph.cells[l.1 as usize], TileCell::Exit(e, _) if e == way))
        };
        if let Some(&way) = paths.iter().find(|&&w| !leaves(w)) {
            let direction = TileLayout::direction(region, edge as u32, way);
            let walk = match direction {
                "straight ahead" => "walks straight on",
                "back across the same edge" => "walks that turn round",
                "to the left" => "walks that turn left by 90 degrees",
                _ => "walks that turn right by 90 degrees",
            };
            let help = format!("Add {walk} within {:.1} m, {EDIT}", region.size);
            return Some((format!("no entry can leave {direction}"), help));
        }
    }
    let rests = |l: &&(u32, u32)| enters(l.0).is_some() && graph.cells[l.1 as usize] == TileCell::Rest;
    if graph.must_rest && !graph.links.iter().any(|l| rests(&l)) {
        let (why, also) = match source.stops() {
            0 => ("there is no walking that stops".to_owned(), " and then stand for a second"),
            n => {
                let why = format!("none of {n} stops ends a walk of the kind that enters, in a pose of rest");
                (why, ", take more poses of rest (rest_groups)")
            }
        };
        let help = format!("Add walks that come to a stop within {:.1} m{also}, {EDIT}", region.size);
        return Some((format!("no entry can come to rest: {why}"), help));
    }
    let sets_out = |l: &(u32, u32)| {
        graph.cells[l.0 as usize] == TileCell::Rest && matches!(graph.cells[l.1 as usize], TileCell::Exit(..))
    };
    if graph.must_rest && !graph.links.iter().any(sets_out) {
        return Some((
            "no way leads out of a rest: there is no motion that starts walking from standing".to_owned(),
            format!("Add walks that begin at rest, take more poses of rest (rest_groups), {EDIT}"),
        ));
    }
    None
}
