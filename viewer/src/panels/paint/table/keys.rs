//! A table driven by keys while it has the focus.

use super::{RowClick, RowTable, TableMemory};
use eframe::egui::{EventFilter, Id, Key, Modifiers, Ui};

/// Moves on to another row by keys.
///
/// - `page`: rows that are seen at once.
/// - returns the row to bring into sight.
pub(super) fn pressed(ui: &Ui, id: Id, table: &RowTable<'_>, page: usize, memory: &mut TableMemory) -> Option<usize> {
    if table.num_rows == 0 || !ui.memory(|m| m.has_focus(id)) {
        return None;
    }
    let filter = EventFilter { vertical_arrows: true, ..EventFilter::default() };
    ui.memory_mut(|m| m.set_focus_lock_filter(id, filter));
    let page = page.saturating_sub(1).max(1) as isize;
    let moves = [
        (Key::ArrowUp, -1),
        (Key::ArrowDown, 1),
        (Key::PageUp, -page),
        (Key::PageDown, page),
        (Key::Home, isize::MIN),
        (Key::End, isize::MAX),
    ];
    let mut to = None;
    let mut at = if table.click == RowClick::Selects { table.selected } else { memory.cursor };
    for (key, by) in moves {
        if ui.input_mut(|i| i.consume_key(Modifiers::NONE, key)) {
            at = Some(at.map_or(0, |row| row.saturating_add_signed(by)).min(table.num_rows - 1));
            to = at;
        }
    }
    memory.cursor = at;
    to
}
