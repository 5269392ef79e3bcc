//! The disabled links of an instance, as a list.

use super::facts::{InstanceFacts, reason_text};
use crate::command::{Commands, ViewerCommand, WorldCommand};
use crate::document::WorldDocument;
use crate::model::Model;
use crate::panels::clip_frame;
use crate::panels::paint::{RowClick, RowTable, TableCell, TableColumn};
use eframe::egui::{CollapsingHeader, Ui, vec2};
use throng_core::patch::LinkRecord;

const COLUMNS: [TableColumn<'static>; 4] = [
    TableColumn::number("link", "Number within the patch", 44.0),
    TableColumn::text("clip and time", "Motion it plays", 110.0, 1.0),
    TableColumn::number("frames", "Frames it plays", 48.0),
    TableColumn::text("taken out", "In a word; click for the whole reason", 120.0, 1.0),
];
/// Height of the list (points).
const HEIGHT: f32 = 170.0;

/// Shows the list; a click selects a link.
pub fn show(ui: &mut Ui, model: &Model, world: &WorldDocument, facts: &InstanceFacts, commands: &mut Commands) {
    let (graph, selected) = (world.graph(), model.selection.world.link);
    let out: Vec<usize> = (0..facts.links.len()).filter(|&l| facts.links[l].is_some()).collect();
    if out.is_empty() {
        return;
    }
    CollapsingHeader::new(format!("{} links taken out", out.len())).default_open(true).show(ui, |ui| {
        let size = vec2(ui.available_width(), HEIGHT);
        ui.allocate_ui(size, |ui| {
            ui.set_min_size(size);
            let table = RowTable {
                click: RowClick::Does("Show"),
                selected: selected.and_then(|s| out.iter().position(|&l| l == s as usize)),
                ..RowTable::new("links taken out", &COLUMNS, out.len())
            };
            let response = table.show(ui, |row, column| {
                let (number, link) = (out[row], &graph.links(facts.instance)[out[row]]);
                match column {
                    0 => TableCell::new(number.to_string()),
                    1 => TableCell::new(motion(world, link)).ending(),
                    2 => TableCell::new(link.num_frames.to_string()),
                    _ => TableCell::new(facts.links[number].map_or("", reason_text)),
                }
            });
            if let Some(&link) = response.chosen.and_then(|row| out.get(row)) {
                commands.push(ViewerCommand::World(WorldCommand::SelectLink(Some(link as u32))));
            }
        });
    });
}

/// Clip and time that a link begins at.
fn motion(world: &WorldDocument, link: &LinkRecord) -> String {
    let bundle = world.bundle();
    let (clip, frame) = clip_frame(bundle, link.frame);
    format!("{} {:.2} s", bundle.clip_name(clip), frame as f32 / bundle.rate_hz())
}
