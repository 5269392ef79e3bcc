//! A world: its units, its inhabitants, and the selected patch.

use super::{StageLayout, StagePalette, cues};
use crate::render::{CharacterInstance, Rgba, SolidInstance};
use crate::{command::Tool, document::WorldDocument, model::Model, settings::Colouring};
use glam::Vec3;
use throng_core::patch::{CellRecord, KIND_TILE, Placement};
use throng_geometry::BoundingBox;
use throng_precompute::environment::PlacedUnit;
use throng_world::{WorldNode, WorldStep, inhabitants::InhabitantActivity};

/// Length of trails (s).
const TRAIL_S: f32 = 6.0;
/// Approximate limit of drawn links of an instance, spread over all of them.
const MAX_LINKS: usize = 160;
/// Height of lines above the ground (m).
const ABOVE: f32 = 0.02;

/// Colour of enabled links.
pub const ENABLED: Rgba = Rgba::hex(0x2fb39b);
/// Colour of disabled links.
pub const DISABLED: Rgba = Rgba::hex(0xe0564f);
/// Colour of planned paths.
pub const PLANNED: Rgba = Rgba::hex(0xf2b134);

/// Activities of characters, with their names and colours.
pub const KINDS: [(InhabitantActivity, &str, Rgba); 9] = [
    (InhabitantActivity::Roaming, "roams", Rgba::hex(0xb9c0c9)),
    (InhabitantActivity::Walking, "on its way", Rgba::hex(0xe8743b)),
    (InhabitantActivity::Waiting, "waits", Rgba::hex(0xe0457b)),
    (InhabitantActivity::Detour, "makes way", Rgba::hex(0xf2b134)),
    (InhabitantActivity::Meeting, "waits for a partner", Rgba::hex(0x4f9fd6)),
    (InhabitantActivity::Performing, "performs", Rgba::hex(0x8f6fd6)),
    (InhabitantActivity::Arrived, "is there", Rgba::hex(0x2fb39b)),
    (InhabitantActivity::Unreachable, "finds no path", Rgba::hex(0x9c2f2f)),
    (InhabitantActivity::Blocked, "its place is taken", Rgba::hex(0xd98f8f)),
];

/// Name and colour of an activity; planning a path is part of the way.
pub fn kind_of(doing: InhabitantActivity) -> (&'static str, Rgba) {
    let (_, name, colour) = KINDS.into_iter().find(|kind| kind.0 == doing).unwrap_or(KINDS[1]);
    (name, colour)
}

pub(super) fn lay_out(out: &mut StageLayout, model: &Model, world: &WorldDocument, palette: &StagePalette, dark: bool) {
    units(out, model, world, palette, dark);
    inhabitants(out, model, world, palette);
    if let Some(c) = model.selection.character.filter(|&c| c < world.run.num_characters()) {
        cues_of(out, model, world, c, palette);
    }
    if let Some(instance) = model.inspected_instance() {
        patch(out, model, world, instance, palette);
    }
}

fn units(out: &mut StageLayout, model: &Model, world: &WorldDocument, palette: &StagePalette, dark: bool) {
    let options = &model.selection.world;
    let dragged = options.place.filter(|_| options.draft.is_some() && options.tool == Tool::Move);
    let moved = dragged.or(world.working.as_ref().and_then(|w| w.place()));
    let placed = world.placed().iter().enumerate();
    out.solids.instances.extend(placed.map(|(i, p)| {
        let unit = world.unit(p.unit);
        let colour = colour_of_unit(&unit.name, unit.floor, p.placement, dark);
        let colour = if moved == Some(i) { colour.alpha(0.25) } else { colour };
        SolidInstance::upright(p.unit as u32, p.placement, colour)
    }));
    if let Some(p) = options.place.and_then(|p| world.placed().get(p)) {
        outline(out, world.kit.geometries[p.unit].bounds, p.placement, palette.selected);
    }
    let draft = options.draft.map(|d| PlacedUnit { unit: d.unit, placement: d.at });
    if let Some(draft) = draft.as_ref().or(world.working.as_ref().and_then(|w| w.at.as_ref())) {
        ghost(out, world, draft, palette.selected);
    } else if let Some(refused) = world.refused.as_ref().and_then(|r| r.at.as_ref()) {
        ghost(out, world, refused, DISABLED);
    }
}

/// A unit that is not placed yet, with its heading.
fn ghost(out: &mut StageLayout, world: &WorldDocument, unit: &PlacedUnit, colour: Rgba) {
    let Some(geometry) = world.kit.geometries.get(unit.unit) else { return };
    let at = unit.placement;
    out.solids.instances.push(SolidInstance::upright(unit.unit as u32, at, colour.alpha(0.6)));
    outline(out, geometry.bounds, at, colour);
    let (from, ahead) = (at.translation().with_y(at.y + ABOVE), at.planar().rotation() * Vec3::Z);
    out.shapes.on_top(true).arrow(from, from + ahead * 0.8, 0.03, colour);
    out.shapes.on_top(false);
}

/// Colour of a unit, the same for the same name; floor panels form a chequered pattern that shows each of them.
pub(super) fn colour_of_unit(name: &str, floor: bool, at: Placement, dark: bool) -> Rgba {
    let hash = name.bytes().fold(0x811c_9dc5_u32, |h, b| (h ^ u32::from(b)).wrapping_mul(0x0100_0193));
    const HUES: [u32; 6] = [0x8a7458, 0x5f7a94, 0x8a6070, 0x6c8560, 0x7a6a94, 0x9a8a50];
    let hue = Rgba::hex(HUES[(hash >> 8) as usize % HUES.len()]);
    if !floor {
        return if dark { hue } else { hue.mix(Rgba::WHITE, 0.25) };
    }
    let base = if dark { Rgba::hex(0x4a4f57) } else { Rgba::hex(0xc4c6c8) };
    let is_odd = ((at.x / 1.4).round() + (at.z / 1.4).round()).rem_euclid(4.0) < 1.0;
    let ink = if dark { Rgba::WHITE } else { Rgba::hex(0) };
    // Decks stand out from the ground below them.
    let raised = (at.y / 12.0).clamp(0.0, 1.0).sqrt() * 0.3;
    base.mix(hue, 0.18).mix(ink, if is_odd { 0.07 } else { 0.0 } + raised)
}

/// The edges of a box, seen through everything.
fn outline(out: &mut StageLayout, bounds: BoundingBox, at: Placement, colour: Rgba) {
    if bounds.is_empty() {
        return;
    }
    out.shapes.on_top(true);
    let edges = cues::box_edges(bounds.corners().map(|c| at.transform_point(c)));
    edges.for_each(|[a, b]| out.shapes.line(a, b, 2.0, colour));
    out.shapes.on_top(false);
}

fn inhabitants(out: &mut StageLayout, model: &Model, world: &WorldDocument, palette: &StagePalette) {
    let moment = world.run.reel.moment();
    let selected = model.selection.character;
    let colour = |c: usize| match model.settings.colouring {
        Colouring::Target => kind_of(moment.states[c].activity).1,
        Colouring::Clip => cues::category(moment.states[c].node.instance as usize),
        Colouring::Speed | Colouring::Made | Colouring::Plain => palette.plain,
    };
    out.instances.extend(moment.roots.iter().enumerate().map(|(c, &root)| {
        let is_selected = selected == Some(c);
        CharacterInstance { root, colour: colour(c), is_selected, look: 0 }
    }));
}

/// Cues of the selected character: past positions, path, and reservations.
fn cues_of(out: &mut StageLayout, model: &Model, world: &WorldDocument, c: usize, palette: &StagePalette) {
    let run = &world.run;
    let o = model.settings.overlays;
    if o.trails {
        let points: Vec<Vec3> = run.trail(c, TRAIL_S).map(|p| p - Vec3::Y * 0.9).collect();
        out.shapes.polyline(&points, 2.0, palette.selected.alpha(0.7));
    }
    if o.joint_axes {
        let pose = &run.reel.moment().poses[c * throng_core::NUM_JOINTS..][..throng_core::NUM_JOINTS];
        cues::joint_axes(&mut out.shapes, run.reel.moment().roots[c], pose);
    }
    if !run.reel.head.is_live() {
        return;
    }
    let inhabitants = &run.inhabitants;
    let id = run.id(c);
    for unit in inhabitants.units_of(id).into_iter().flatten() {
        if let Some(p) = world.placed().get(unit as usize) {
            let bounds = world.kit.geometries[p.unit].bounds;
            outline(out, bounds, p.placement, palette.selected.alpha(0.35));
        }
    }
    let path = inhabitants.path_steps(id).unwrap_or_default();
    draw_path(out, world, inhabitants.reserved_steps(id).unwrap_or_default(), palette.slow);
    draw_path(out, world, path, PLANNED);
    if let Some(last) = path.last() {
        out.shapes.sphere(world.graph().place(last.to).translation(), 0.08, PLANNED);
    }
}

/// Steps of a path as a line over the ground they are walked on.
fn draw_path(out: &mut StageLayout, world: &WorldDocument, steps: &[WorldStep], colour: Rgba) {
    let mut points: Vec<Vec3> = Vec::new();
    for step in steps {
        if let Some(link) = world.graph().link(step) {
            let frames = step.from_offset..=step.to_offset;
            points.extend(world.link_path(step.instance, link, frames, 2.0 * ABOVE));
        }
    }
    out.shapes.polyline(&points, 3.5, colour);
}

/// The selected patch: links, entries and exits.
fn patch(out: &mut StageLayout, model: &Model, world: &WorldDocument, instance: u32, palette: &StagePalette) {
    let (graph, options) = (world.graph(), &model.selection.world);
    if !options.hides_links {
        let links = graph.links(instance);
        for (l, link) in links.iter().enumerate().step_by(links.len() / MAX_LINKS + 1) {
            let is_left = graph.is_link_enabled(instance, l as u32);
            let colour = if is_left { ENABLED.alpha(0.45) } else { DISABLED.alpha(0.25) };
            out.shapes.polyline(&world.link_path(instance, link, 0..=link.num_frames, ABOVE), 1.0, colour);
        }
    }
    let is_tile = graph.patches().patches[graph.instance(instance).patch as usize].kind == KIND_TILE;
    for (c, cell) in graph.cells(instance).iter().enumerate() {
        let node = WorldNode { instance, cell: c as u32 };
        let place = graph.place(node);
        let is_left = graph.is_enabled(node);
        let ground = place.translation().with_y(ground_of(world, instance, c as u32));
        let ahead = place.planar().rotation() * Vec3::Z * 0.18;
        if is_tile && cell.edge != throng_core::patch::NONE {
            let colour = if cell.has_flags(CellRecord::IS_EXIT) { palette.fast } else { palette.slow };
            let colour = if is_left { colour } else { colour.alpha(0.25) };
            out.shapes.arrow(ground - ahead * 0.5, ground + ahead * 0.5, 0.008, colour);
        } else if cell.has_flags(CellRecord::IS_REST) && is_left {
            out.shapes.disc(ground, 0.04, ENABLED);
        }
    }
    if let Some(link) = options.link.and_then(|l| graph.links(instance).get(l as usize)) {
        let points = world.link_path(instance, link, 0..=link.num_frames, 2.0 * ABOVE);
        out.shapes.on_top(true).polyline(&points, 4.0, palette.selected);
        if let [.., a, b] = points[..] {
            out.shapes.arrow(b + (a - b).normalize_or_zero() * 0.2, b, 0.02, palette.selected);
        }
        out.shapes.on_top(false);
    }
}

/// Height of the ground at a cell: where a link begins there (m).
fn ground_of(world: &WorldDocument, instance: u32, cell: u32) -> f32 {
    let (graph, record) = (world.graph(), world.graph().instance(instance));
    let (cells, links) = (graph.cells(instance), graph.links(instance));
    let begin = |c: &CellRecord| links.get(c.first_link as usize).filter(|_| c.num_links > 0).map(|l| l.start.y);
    let here = &cells[cell as usize];
    let across = || {
        // No link begins at an exit, but one does at the entry of the neighbour, which may stand higher.
        let entry = cells.get(here.twin as usize).filter(|_| here.has_flags(CellRecord::IS_EXIT))?;
        let edge = graph.patches().edges_of(record.patch as usize).get(here.edge as usize)?;
        Some(begin(entry)? + edge.step[1])
    };
    record.placement.y + begin(here).or_else(across).unwrap_or(0.0) + ABOVE
}
