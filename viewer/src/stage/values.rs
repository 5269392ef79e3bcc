//! Values of a policy's cells, drawn around the selected character.

use super::{StageLayout, StagePalette};
use crate::model::Model;
use crate::render::{Rgba, ShapeList};
use crate::run::PolicyChooser;
use crate::theme::viridis;
use crate::volume::Volume;
use glam::Vec3;
use throng_core::Planar;
use throng_core::policy::PolicyTable;

/// Cells that are drawn at most; of finer grids every second, third and so on is.
const MAX_CELLS: usize = 6000;
/// Height at which cells without heights lie (m).
const ON_GROUND_M: f32 = 0.02;

/// A cell that is drawn, to be pointed at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValueCell {
    /// Position in the world (m).
    pub place: Vec3,
    /// Number of the cell in the grid of the state.
    pub cell: usize,
}

/// Draws the cells of the selected policy, for the selected state, where the character stood when it
/// chose in that state, else where it stands.
pub(super) fn lay_out(out: &mut StageLayout, model: &Model, chooser: &PolicyChooser<'_>, palette: &StagePalette) {
    let (characters, c) = (chooser.characters, chooser.number);
    let Some(state) = model.inspected_state() else { return };
    let Some(policy) = chooser.bundle.motion_set.policy(model.selection.policy) else { return };
    if state as usize >= policy.actions().num_states() {
        return;
    }
    let choice = characters.last_choice(c).filter(|choice| choice.state == state);
    let root = choice.map_or(characters.root(c), |choice| choice.root);
    let values = policy.values_of(state);
    let range = values.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[a, b], &v| [a.min(v), b.max(v)]);
    let cells = shown_cells(model, policy, state);
    let stride = cells.len().div_ceil(MAX_CELLS).max(1);
    let radius = radius(policy, state);
    for cell in cells.step_by(stride) {
        let place = place(policy, root, policy.cell_target(state, cell));
        let ratio = viridis::ratio(values[cell], range);
        let [r, g, b, _] = viridis::map(ratio).to_array();
        // Low values are more transparent, so that high values are visible through them.
        let colour = Rgba([r, g, b, 255]).alpha(0.3 + 0.6 * ratio);
        let size = radius * (0.55 + 0.45 * ratio);
        if policy.grid().record().num_heights == 1 {
            out.shapes.disc(place, 1.6 * size, colour);
        } else {
            out.shapes.sphere(place, size, colour);
        }
        out.cells.push(ValueCell { place, cell });
    }
    if let Some(volume) = Volume::of_region(policy.region()) {
        outline(&mut out.shapes, policy, root, &volume, palette.middle.alpha(0.8));
    }
}

/// All cells, or in a space-time grid those of the shown time.
fn shown_cells(model: &Model, policy: &PolicyTable, state: u32) -> std::ops::Range<usize> {
    let grid = policy.grid_of(state);
    if !policy.grid().is_space_time() {
        return 0..grid.num_cells();
    }
    let plane = grid.num_plane_cells();
    let slice = model.selection.slice.min(grid.record().num_heights - 1) as usize;
    slice * plane..(slice + 1) * plane
}

/// Position of a target in the world: at its height, on the ground for a grid without heights, and in a space-time
/// grid at the height of blows (m).
fn place(policy: &PolicyTable, root: Planar, target: Vec3) -> Vec3 {
    let height = match () {
        () if policy.grid().is_space_time() => policy.reward().record().height,
        () if policy.grid().record().num_heights == 1 => ON_GROUND_M,
        () => target.y,
    };
    root.translation() + root.rotation() * target.with_y(height)
}

/// Radius that leaves neighbouring cells apart (m).
fn radius(policy: &PolicyTable, state: u32) -> f32 {
    let grid = policy.grid_of(state);
    let r = grid.record();
    let across = r.angle_spacing * 0.5 * (r.ring_start + grid.radius());
    let up = if r.num_heights > 1 && !grid.is_space_time() { r.height_spacing } else { f32::INFINITY };
    (0.3 * r.ring_spacing.min(across).min(up)).clamp(0.008, 0.08)
}

/// Edges of the volume in which the behaviour is active.
fn outline(shapes: &mut ShapeList, policy: &PolicyTable, root: Planar, volume: &Volume, colour: Rgba) {
    let over_ground = volume.over_ground();
    let at = |i: usize, height: f32| {
        let p = over_ground[i % over_ground.len()];
        place(policy, root, Vec3::new(p.x, height, p.y))
    };
    let [low, high] = volume.height;
    let has_heights = policy.grid().record().num_heights > 1 && !policy.grid().is_space_time();
    let heights: &[f32] = if has_heights { &[low, high] } else { &[low] };
    for &height in heights {
        (0..over_ground.len()).for_each(|i| shapes.line(at(i, height), at(i + 1, height), 1.6, colour));
    }
    if has_heights {
        // The four upright edges of a sector: at the ends of its two arcs.
        let half = over_ground.len() / 2;
        for i in [0, half - 1, half, over_ground.len() - 1] {
            shapes.line(at(i, low), at(i, high), 1.6, colour);
        }
    }
}
