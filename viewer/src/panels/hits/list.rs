//! The hits as a list.

use super::HitsInput;
use super::collection::{HitCollection, HitEntry, joint_name};
use crate::bundle::OpenBundle;
use crate::panels::moment;
use crate::panels::paint::{RowClick, RowTable, TableCell, TableColumn, TableResponse, TableSort};
use eframe::egui::Ui;

const COLUMNS: [TableColumn<'static>; 7] = [
    TableColumn::text("moment", "Clip and time", 110.0, 1.0),
    TableColumn::text("kind", "Kind of blow, or name of the tag", 48.0, 0.0).spare(2),
    TableColumn::text("limb", "What strikes", 76.0, 0.0),
    TableColumn::number("force", "Speed over that of the fastest hit of its kind", 50.0),
    TableColumn::number("angle", "From straight ahead to the left [rad]", 48.0).spare(1),
    TableColumn::number("dist.", "Distance over ground [m]", 44.0),
    TableColumn::number("height", "Above the ground [m]", 50.0),
];

/// Shows the selected hits.
///
/// - `scrolls`: brings the hit that stands out into sight.
pub fn show(ui: &mut Ui, input: &HitsInput<'_>, sort: &mut TableSort, scrolls: bool) -> TableResponse {
    let &HitsInput { bundle, hits, shown, .. } = input;
    let table = RowTable {
        click: RowClick::Does("Show"),
        sort: Some(*sort),
        selected: input.standing_out.and_then(|s| shown.iter().position(|&i| i == s)),
        scroll_to_selected: scrolls,
        ..RowTable::new("hits", &COLUMNS, shown.len())
    };
    let response = table.show(ui, |row, column| cell(bundle, hits, &hits.entries[shown[row]], column));
    *sort = response.sort.unwrap_or(*sort);
    response
}

/// A hit in a column, which [`COLUMNS`] numbers.
fn cell(bundle: &OpenBundle, hits: &HitCollection, e: &HitEntry, column: usize) -> TableCell {
    match column {
        0 => TableCell::new(moment(bundle, e.row)).ending(),
        1 => TableCell::new(hits.kind(e.kind)),
        2 => TableCell::new(joint_name(e.joint)),
        3 => TableCell::new(format!("{:.2}", e.force)).bar(e.force),
        4 => TableCell::new(format!("{:.2}", e.angle())),
        5 => TableCell::new(format!("{:.2}", e.distance())),
        _ => TableCell::new(format!("{:.2}", e.position.y)),
    }
}
