//! Tables driven as a user would.

use super::*;
use eframe::egui::Key;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

const COLUMNS: [TableColumn<'static>; 2] =
    [TableColumn::text("Row", "", 80.0, 1.0), TableColumn::number("Twice", "", 60.0).spare(1)];

fn cell(row: usize, column: usize) -> TableCell {
    TableCell::new(((column + 1) * row).to_string())
}

/// A table in a window, and the rows that were chosen.
fn window(width: f32, table: RowTable<'static>) -> Harness<'static, Vec<usize>> {
    let show = move |ui: &mut Ui, chosen: &mut Vec<usize>| {
        let selected = chosen.last().copied().filter(|_| table.click == RowClick::Selects);
        chosen.extend(RowTable { selected, ..table }.show(ui, cell).chosen);
    };
    Harness::builder().with_size(vec2(width, 300.0)).build_ui_state(show, Vec::new())
}

#[test]
fn only_rows_in_sight_are_laid_out_and_the_selected_one_is_brought_there() {
    let mut asked = Vec::new();
    let mut harness = Harness::builder().with_size(vec2(200.0, 300.0)).build_ui(|ui| {
        let table =
            RowTable { selected: Some(70_000), scroll_to_selected: true, ..RowTable::new("rows", &COLUMNS, 100_000) };
        asked.clear();
        table.show(ui, |row, column| {
            asked.push(row);
            cell(row, column)
        });
    });
    harness.run_steps(3);
    drop(harness);
    asked.dedup();
    assert!(asked.contains(&70_000) && asked.len() < 40, "{asked:?}");
}

#[test]
fn keys_select_other_rows_at_once() {
    let mut h = window(200.0, RowTable::new("rows", &COLUMNS, 1000));
    h.get_by_label("3").click();
    h.run();
    h.key_press(Key::ArrowDown);
    h.run();
    h.key_press(Key::End);
    h.run();
    assert_eq!(h.state()[..], [3, 4, 999]);
    h.get_by_label("999");
}

#[test]
fn only_a_click_or_enter_activates_a_row() {
    let mut h = window(200.0, RowTable { click: RowClick::Does("Play"), ..RowTable::new("rows", &COLUMNS, 1000) });
    h.get_by_label("Play 3").click();
    h.run();
    for _ in 0..2 {
        h.key_press(Key::ArrowDown);
        h.run();
    }
    assert_eq!(h.state()[..], [3]);
    h.key_press(Key::Enter);
    h.run();
    assert_eq!(h.state()[..], [3, 5]);
}

#[test]
fn spare_columns_are_shown_where_there_is_room() {
    let titles = |width| {
        let h = window(width, RowTable::new("rows", &COLUMNS, 3));
        ["Row", "Twice"].map(|t| h.query_by_label(t).is_some())
    };
    assert_eq!(titles(300.0), [true, true]);
    assert_eq!(titles(130.0), [true, false]);
}

#[test]
fn a_table_of_few_rows_is_as_high_as_they_are() {
    let below = |num_rows: usize| {
        let height = std::rc::Rc::new(std::cell::Cell::new(0.0));
        let out = height.clone();
        let mut h = Harness::builder().with_size(vec2(200.0, 400.0)).build_ui(move |ui| {
            let top = ui.cursor().top();
            let _ = RowTable { most_rows: Some(9), ..RowTable::new("rows", &COLUMNS, num_rows) }.show(ui, cell);
            out.set(ui.cursor().top() - ui.spacing().item_spacing.y - top);
            ui.label("below");
        });
        h.run_steps(2);
        height.get()
    };
    let row = below(3) - below(2);
    assert!(row > 10.0);
    assert!((below(20) - 10.0 * row).abs() < 1.5, "{} {row}", below(20));
    assert!((below(3) - 4.0 * row).abs() < 1.5);
}
