//! Carries out the commands about a world.

use super::Model;
use crate::command::WorldCommand;
use crate::document::world::{EditStatus, EditorOrder};
use crate::document::{OpenDocument, WorldDocument};
use throng_core::patch::Placement;
use throng_precompute::environment::UnitObject;

/// Start of the message about an edit that was refused.
const UNCHANGED: &str = "The world is unchanged: ";

impl Model {
    /// The world with the shown inhabitants; none while a clip is shown.
    pub fn shown_world(&self) -> Option<&WorldDocument> {
        self.document.world().filter(|_| !self.shows_clip())
    }

    /// Instance inspected by panels: the selected one, that of the selected unit, or that of the selected character.
    pub fn inspected_instance(&self) -> Option<u32> {
        let world = self.document.world()?;
        let options = &self.selection.world;
        let of_unit = || options.place.map(|p| world.instances_of(p).first().copied());
        let of_character = || {
            let c = self.selection.character?;
            Some(world.run.reel.moment().states.get(c)?.node.instance)
        };
        let found = options.instance.or_else(|| of_unit().unwrap_or_else(of_character));
        found.filter(|&i| (i as usize) < world.graph().num_instances())
    }

    pub(super) fn apply_to_world(&mut self, command: WorldCommand) {
        if matches!(command, WorldCommand::SelectPlace(_)) {
            self.forget_refused();
        }
        let OpenDocument::World(world) = &mut self.document else { return };
        let options = &mut self.selection.world;
        match command {
            WorldCommand::Tool(tool) => (options.tool, options.draft) = (tool, None),
            WorldCommand::SelectPlace(place) => {
                (options.place, options.instance, options.link) =
                    (place.filter(|&p| p < world.placed().len()), None, None);
            }
            WorldCommand::SelectInstance(instance) => (options.instance, options.link) = (instance, None),
            WorldCommand::SelectLink(link) => options.link = link,
            WorldCommand::ShowLinks(on) => options.hides_links = !on,
            WorldCommand::Draft(draft) => options.draft = draft,
            WorldCommand::Edit(change) => self.edit(EditorOrder::Change(change)),
            WorldCommand::Undo => self.edit(EditorOrder::Undo),
            WorldCommand::Redo => self.edit(EditorOrder::Redo),
            WorldCommand::Save(path) => {
                let saved = world.save(&path).map(|()| path.display().to_string());
                self.tell_saved(saved);
            }
        }
    }

    /// Closes the message about the last edit, and takes away the unit that it marks.
    fn forget_refused(&mut self) {
        if let OpenDocument::World(world) = &mut self.document {
            world.refused = None;
            self.messages.retain(|m| !m.text.starts_with(UNCHANGED));
        }
    }

    fn tell_refused(&mut self) {
        if let Some(refused) = self.document.world().and_then(|w| w.refused.as_ref()) {
            self.complain(format!("{UNCHANGED}{}", refused.reason));
        }
    }

    fn edit(&mut self, order: EditorOrder) {
        self.forget_refused();
        let waits = self.is_unhurried;
        let OpenDocument::World(world) = &mut self.document else { return };
        self.selection.world.draft = None;
        if let Err(why) = world.order(order) {
            return self.say(format!("No change: {why}"));
        }
        self.tell_refused();
        self.adopt_edit(waits);
    }

    /// Takes in a world that has been stitched meanwhile.
    pub(super) fn adopt_edit(&mut self, waits: bool) {
        let OpenDocument::World(world) = &mut self.document else { return };
        let taken = world.adopt_edit(waits);
        if let Some(EditStatus::Changed(place)) = taken {
            let options = &mut self.selection.world;
            (options.place, options.instance, options.link) = (place, None, None);
        }
        if taken.is_some() {
            self.tell_refused();
            self.limit_selected();
        }
    }
}

/// A placement near `to` that is aligned with units of its kind: panels side by side, anything else on a fine grid.
///
/// - `others`: placements of other units of the kind.
pub fn snapped(unit: &UnitObject, others: impl Iterator<Item = Placement>, to: Placement) -> Placement {
    let far = |p: &Placement| p.translation().distance_squared(to.translation());
    let steps = unit.tile.as_ref().map_or(&[][..], |t| &t.steps);
    let nearest = others.min_by(|a, b| far(a).total_cmp(&far(b)));
    // The neighbours of the nearest one, as it stands.
    let beside = nearest.iter().flat_map(move |near| {
        let both_ways = steps.iter().flat_map(|step| [-1.0, 1.0].map(|side| side * glam::Vec3::from(*step)));
        both_ways.map(move |step| near.compose(Placement::new(step.x, step.y, step.z, 0.0)))
    });
    let best = beside.min_by(|a, b| far(a).total_cmp(&far(b)));
    if let Some(best) = best.filter(|p| far(p) < SNAP_M * SNAP_M) {
        return Placement { heading: to.heading, ..best };
    }
    let fine = |v: f32| (v / GRID_M).round() * GRID_M;
    Placement { x: fine(to.x), z: fine(to.z), ..to }
}

/// Distance within which a dragged panel snaps beside another (m).
const SNAP_M: f32 = 0.9;
/// Everything else stands on a grid (m).
const GRID_M: f32 = 0.05;

#[cfg(test)]
mod tests {
    use super::*;
    use throng_precompute::environment::TileEdges;

    fn unit(steps: Vec<[f32; 3]>) -> UnitObject {
        let tile = TileEdges { widths: vec![2.0; steps.len()], steps, centre: [0.0; 3] };
        let tile = Some(tile).filter(|t| !t.steps.is_empty());
        UnitObject { name: "u".into(), shapes: Vec::new(), region: None, symmetry: 1, tile, floor: true }
    }

    #[test]
    fn panels_are_placed_beside_others_and_anything_else_on_a_grid() {
        let panel = unit(vec![[2.8, 0.0, 0.0], [0.0, 0.0, 2.8]]);
        let others = [Placement::new(10.0, 0.0, 5.0, 0.0), Placement::new(99.0, 0.0, 0.0, 0.0)];
        let near = |x, z| snapped(&panel, others.iter().copied(), Placement::new(x, 0.0, z, 0.5));
        assert_eq!(near(12.5, 5.3), Placement::new(12.8, 0.0, 5.0, 0.5));
        assert_eq!(near(10.2, 2.0), Placement::new(10.0, 0.0, 2.2, 0.5));
        let free = near(30.02, 7.0);
        assert!((free.x - 30.0).abs() < 1e-4 && (free.z - 7.0).abs() < 1e-4, "{free:?}");
        let desk = snapped(&unit(Vec::new()), others.iter().copied(), Placement::new(12.61, 0.3, 5.0, 0.5));
        assert!((desk.x - 12.6).abs() < 1e-4 && desk.y == 0.3, "{desk:?}");
    }
}
