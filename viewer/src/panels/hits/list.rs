//! The hits as a list.

use super::collection::{Collection, Entry, Field, joint_name};
use crate::bundle::OpenBundle;
use crate::panels::paint::{Cell, Click, Column, Sort, Table};
use eframe::egui::Ui;

const COLUMNS: [Column<'static>; 7] = [
    Column::text("moment", "Clip and time", 110.0, 1.0),
    Column::text("kind", "Kind of blow, or name of the tag", 48.0, 0.0).spare(2),
    Column::text("limb", "What strikes", 76.0, 0.0),
    Column::number("force", "Speed over that of the fastest hit of its kind", 50.0),
    Column::number("angle", "From straight ahead to the left [rad]", 48.0).spare(1),
    Column::number("dist.", "Distance over ground [m]", 44.0),
    Column::number("height", "Above the ground [m]", 50.0),
];

/// Actions of the user in the list.
pub struct Listed {
    /// Hit that was clicked.
    pub chosen: Option<usize>,
    /// Hit whose row is under the pointer.
    pub hovered: Option<usize>,
}

/// Shows the selected hits.
///
/// - `selected`: number of the hit that stands out; `scrolls` brings it into sight.
pub fn show(
    ui: &mut Ui,
    (bundle, hits): (&OpenBundle, &Collection),
    shown: &[usize],
    sort: &mut Sort,
    (selected, scrolls): (Option<usize>, bool),
) -> Listed {
    let table = Table {
        click: Click::Does("Show"),
        sort: Some(*sort),
        selected: selected.and_then(|s| shown.iter().position(|&i| i == s)),
        scroll_to_selected: scrolls,
        ..Table::new("hits", &COLUMNS, shown.len())
    };
    let response = table.show(ui, |row, column| cell(bundle, hits, &hits.entries[shown[row]], Field::ALL[column]));
    *sort = response.sort.unwrap_or(*sort);
    let of_row = |row: usize| shown.get(row).copied();
    Listed { chosen: response.chosen.and_then(of_row), hovered: response.hovered.and_then(|(row, _)| of_row(row)) }
}

fn cell(bundle: &OpenBundle, hits: &Collection, e: &Entry, field: Field) -> Cell {
    match field {
        Field::Moment => Cell::new(moment(bundle, e)).ending(),
        Field::Kind => Cell::new(hits.kind(e.kind)),
        Field::Limb => Cell::new(joint_name(e.joint)),
        Field::Force => Cell::new(format!("{:.2}", e.force)).bar(e.force),
        Field::Angle => Cell::new(format!("{:.2}", e.angle())),
        Field::Distance => Cell::new(format!("{:.2}", e.distance())),
        Field::Height => Cell::new(format!("{:.2}", e.position.y)),
    }
}

/// Clip and time of a hit.
pub fn moment(bundle: &OpenBundle, e: &Entry) -> String {
    format!("{} {:.2} s", bundle.clip_name(e.clip), e.frame as f32 / bundle.rate_hz())
}
