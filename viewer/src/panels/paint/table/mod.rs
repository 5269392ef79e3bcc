//! A table of which only the visible rows are laid out; its rows are clicked as a whole.

mod cell;
mod column;
#[cfg(test)]
mod tests;

pub use cell::TableCell;
pub use column::{TableColumn, TableSort, least_width};

use column::{ColumnPlace, places};
use eframe::egui::{
    CursorIcon, EventFilter, Id, Key, Modifiers, Rect, Response, Role, ScrollArea, Sense, Stroke, StrokeKind,
    TextStyle, Ui, UiBuilder, WidgetInfo, pos2, vec2,
};

/// Effect of a click on a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RowClick<'a> {
    /// Selects the row, as the arrow keys do while the table has the focus. Rows are called by their names.
    #[default]
    Selects,
    /// Performs the action of this name on the row. The arrow keys only move a mark to another row, and the enter key
    /// performs the action. Rows are called by the action and their names.
    Does(&'a str),
}

/// A table of many rows.
#[derive(Clone, Copy, Debug, Default)]
pub struct RowTable<'a> {
    /// Name, unique in the same place.
    pub id: &'a str,
    /// Columns of the table.
    pub columns: &'a [TableColumn<'a>],
    /// Number of rows.
    pub num_rows: usize,
    /// The column that has the names of rows.
    pub named_by: usize,
    /// Effect of a click on a row.
    pub click: RowClick<'a>,
    /// The row that stands out.
    pub selected: Option<usize>,
    /// The order; none if rows cannot be sorted.
    pub sort: Option<TableSort>,
    /// Bring the selected row into sight.
    pub scroll_to_selected: bool,
    /// Most visible rows; none takes all the available room.
    pub most_rows: Option<usize>,
}

/// Actions of the user in a table.
#[derive(Clone, Debug, Default)]
pub struct TableResponse {
    /// Row that was clicked, or chosen by keys.
    pub chosen: Option<usize>,
    /// Row that is pointed at, to tell more of it.
    pub hovered: Option<(usize, Response)>,
    /// Another order was asked for.
    pub sort: Option<TableSort>,
}

/// Content of a cell, by row and column.
type CellContent<'a> = dyn FnMut(usize, usize) -> TableCell + 'a;

/// State of a table between frames.
#[derive(Clone, Copy, Debug, Default)]
struct TableMemory {
    /// Scroll offset (points).
    offset: f32,
    /// Row that the keys have moved to.
    cursor: Option<usize>,
}

impl<'a> RowTable<'a> {
    /// A table in which a click selects a row and the first column has the names.
    pub fn new(id: &'a str, columns: &'a [TableColumn<'a>], num_rows: usize) -> Self {
        Self { id, columns, num_rows, ..Self::default() }
    }

    /// Shows the table; `cell` is called with row and column of each visible cell.
    pub fn show(&self, ui: &mut Ui, mut cell: impl FnMut(usize, usize) -> TableCell) -> TableResponse {
        let row_height = ui.text_style_height(&TextStyle::Body) + 4.0;
        let all = ui.available_rect_before_wrap();
        let height = self.most_rows.map_or(all.height(), |most| row_height * (1 + most.min(self.num_rows)) as f32);
        let rect = Rect::from_min_size(all.min, vec2(all.width(), height));
        let inner = ui.scope_builder(UiBuilder::new().id_salt(self.id).max_rect(rect), |ui| {
            ui.spacing_mut().item_spacing.y = 0.0;
            self.show_in(ui, rect, row_height, &mut cell)
        });
        inner.inner
    }

    fn show_in(&self, ui: &mut Ui, rect: Rect, row_height: f32, cell: &mut CellContent<'_>) -> TableResponse {
        let id = ui.scope_id().with("rows");
        let mut memory: TableMemory = ui.data(|d| d.get_temp(id)).unwrap_or_default();
        memory.cursor = memory.cursor.filter(|c| *c < self.num_rows);
        let body_height = rect.height() - row_height;
        let scrolls = self.num_rows as f32 * row_height > body_height + 0.5;
        let bar = ui.spacing().scroll.allocated_width().max(ui.spacing().scroll.bar_width);
        let width = (rect.width() - if scrolls { bar } else { 0.0 }).max(1.0);
        let places = places(self.columns, width);
        let mut out = TableResponse::default();
        let (_, titles) = ui.allocate_space(vec2(width, row_height));
        out.sort = column::show_titles(ui, self, id, titles, &places);
        let body = rect.with_min_y(titles.bottom());
        ui.interact(body, id, Sense::focusable_noninteractive());
        let page = (body_height / row_height) as usize;
        let focused = ui.memory(|m| m.has_focus(id));
        let moved = pressed_row(ui, id, self, page, &mut memory);
        // A row that is moved to is chosen at once where rows are selected; else the enter key chooses it.
        let enters = || focused && ui.input_mut(|i| i.consume_key(Modifiers::NONE, Key::Enter));
        out.chosen = if self.click == RowClick::Selects { moved } else { memory.cursor.filter(|_| enters()) };
        let mut area = ScrollArea::vertical()
            .id_salt("rows")
            .auto_shrink([false, false])
            .min_scrolled_height(0.0)
            .max_height(body_height);
        let wanted = moved.or(self.selected.filter(|_| self.scroll_to_selected));
        if let Some(offset) = wanted.and_then(|row| shown_offset(memory.offset, row, row_height, body_height)) {
            area = area.vertical_scroll_offset(offset);
        }
        let scrolled = area.show_rows(ui, row_height, self.num_rows, |ui, rows| {
            for row in rows {
                let (_, rect) = ui.allocate_space(vec2(width, row_height));
                // A fixed number keeps the widget's identity, whatever else is shown.
                let response = ui.interact(rect, id.with(row), Sense::CLICK).on_hover_cursor(CursorIcon::PointingHand);
                self.show_row(ui, row, &response, &places, cell);
                if focused && self.click != RowClick::Selects && memory.cursor == Some(row) {
                    let stroke = Stroke::new(1.0, ui.visuals().selection.stroke.color);
                    ui.painter().rect_stroke(rect, 3.0, stroke, StrokeKind::Inside);
                }
                if response.clicked() {
                    out.chosen = Some(row);
                    memory.cursor = Some(row);
                    ui.memory_mut(|m| m.request_focus(id));
                }
                if response.hovered() {
                    out.hovered = Some((row, response));
                }
            }
        });
        memory.offset = scrolled.state.clamped_offset().y;
        ui.data_mut(|d| d.insert_temp(id, memory));
        out
    }

    fn show_row(&self, ui: &Ui, row: usize, response: &Response, places: &[ColumnPlace], cell: &mut CellContent<'_>) {
        let (rect, selected) = (response.rect, self.selected == Some(row));
        let name = cell(row, self.named_by).text;
        response.widget_info(|| match self.click {
            RowClick::Selects => WidgetInfo::selected(Role::Row, true, selected, &name),
            RowClick::Does(what) => WidgetInfo::selected(Role::Button, true, selected, format!("{what} {name}")),
        });
        let visuals = ui.visuals();
        if selected {
            ui.painter().rect_filled(rect, 3.0, visuals.selection.bg_fill);
        } else if response.hovered() {
            ui.painter().rect_filled(rect, 3.0, visuals.widgets.hovered.weak_bg_fill);
        } else if row % 2 == 1 {
            ui.painter().rect_filled(rect, 0.0, visuals.faint_bg_color);
        }
        for place in places {
            let is_number = self.columns[place.column].is_number;
            cell(row, place.column).paint(ui, place_rect(rect, place), is_number, selected);
        }
    }
}

/// Scroll offset that brings a row into view; none if it is visible.
fn shown_offset(now: f32, row: usize, row_height: f32, height: f32) -> Option<f32> {
    let (top, bottom) = (row as f32 * row_height, (row + 1) as f32 * row_height);
    let up = (top < now).then_some(top);
    up.or_else(|| (bottom > now + height).then(|| (bottom - height).max(0.0)))
}

/// The part of a row that a column takes.
fn place_rect(row: Rect, place: &ColumnPlace) -> Rect {
    Rect::from_min_max(pos2(row.left() + place.x.start, row.top()), pos2(row.left() + place.x.end, row.bottom()))
}

/// Moves on to another row by keys.
///
/// - `page`: rows that are seen at once.
/// - returns the row to bring into sight.
fn pressed_row(ui: &Ui, id: Id, table: &RowTable<'_>, page: usize, memory: &mut TableMemory) -> Option<usize> {
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
