//! A table of which only the visible rows are laid out.

use eframe::egui::text::{LayoutJob, TextWrapping};
use eframe::egui::{
    Align, Align2, Color32, CursorIcon, EventFilter, FontId, Id, Key, Modifiers, Rect, Response, Role, ScrollArea,
    Sense, Shape, Stroke, TextStyle, Ui, Vec2, WidgetInfo, pos2, vec2,
};
use std::ops::Range;

/// Space between the edge of a cell and its text. [Unit: points]
const PAD: f32 = 5.0;

/// A column.
#[derive(Clone, Copy, Debug)]
pub struct Column {
    /// What stands above it.
    pub title: &'static str,
    /// What it means.
    pub hint: &'static str,
    /// Least width. [Unit: points]
    pub width: f32,
    /// Share of the width that is left over.
    pub grows: f32,
    /// Numbers stand at the right.
    pub is_number: bool,
}

/// By which column rows are sorted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sort {
    /// Number of the column.
    pub column: usize,
    /// The largest first.
    pub descending: bool,
}

/// What stands in a cell.
#[derive(Clone, Debug, Default)]
pub struct Cell {
    /// The text.
    pub text: String,
    /// It matters less.
    pub weak: bool,
    /// Where there is no room for all of it, its end is shown instead of its beginning.
    pub ending: bool,
}

impl Cell {
    /// A text.
    pub fn new(text: impl Into<String>) -> Self {
        Self { text: text.into(), ..Self::default() }
    }

    /// A text that matters less.
    pub fn weak(text: impl Into<String>) -> Self {
        Self { text: text.into(), weak: true, ..Self::default() }
    }

    /// The same, of which the end tells more than the beginning.
    pub fn ending(self) -> Self {
        Self { ending: true, ..self }
    }
}

/// What the user did to a table.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TableResponse {
    /// Row that was clicked, or moved to by keys.
    pub chosen: Option<usize>,
    /// Row that is pointed at.
    pub hovered: Option<usize>,
    /// Another order was asked for.
    pub sort: Option<Sort>,
}

/// A table of many rows. One of them may be selected; the arrow keys move on from it while the table has the focus.
#[derive(Debug)]
pub struct Table<'a> {
    /// Tells it from others in the same place.
    pub id: &'a str,
    /// Its columns.
    pub columns: &'a [Column],
    /// Number of rows.
    pub num_rows: usize,
    /// The selected row.
    pub selected: Option<usize>,
    /// The order; none where rows cannot be sorted.
    pub sort: Option<Sort>,
    /// Bring the selected row into sight.
    pub scroll_to_selected: bool,
}

impl Table<'_> {
    /// Shows the table in all the room there is.
    pub fn show(&self, ui: &mut Ui, mut cell: impl FnMut(usize, usize) -> Cell) -> TableResponse {
        let mut out = TableResponse::default();
        let id = ui.scope_id().with(self.id);
        let row_height = ui.text_style_height(&TextStyle::Body) + 4.0;
        let bar = ui.spacing().scroll.allocated_width().max(ui.spacing().scroll.bar_width);
        let width = (ui.available_width() - bar).max(1.0);
        let places = places(self.columns, width);
        ui.spacing_mut().item_spacing.y = 0.0;
        self.header(ui, width, &places, row_height, &mut out);
        let body = ui.available_rect_before_wrap();
        ui.interact(body, id, Sense::focusable_noninteractive());
        if self.num_rows > 0 {
            self.keys(ui, id, (body.height() / row_height) as usize, &mut out);
        }
        let mut area = ScrollArea::vertical().id_salt(self.id).auto_shrink([false, false]);
        if let Some(row) = out.chosen.or(self.selected.filter(|_| self.scroll_to_selected)) {
            let shown = shown_offset(ui, id, row, row_height, body.height());
            if let Some(offset) = shown {
                area = area.vertical_scroll_offset(offset);
            }
        }
        let scrolled = area.show_rows(ui, row_height, self.num_rows, |ui, rows| {
            for row in rows {
                let response = self.row(ui, row, vec2(width, row_height), &places, &mut cell);
                if response.clicked() {
                    out.chosen = Some(row);
                    ui.memory_mut(|m| m.request_focus(id));
                }
                if response.hovered() {
                    out.hovered = Some(row);
                }
            }
        });
        ui.data_mut(|d| d.insert_temp(id, scrolled.state.clamped_offset().y));
        out
    }

    fn header(&self, ui: &mut Ui, width: f32, places: &[Range<f32>], height: f32, out: &mut TableResponse) {
        let (_, space) = ui.allocate_space(vec2(width, height));
        let visuals = ui.visuals().clone();
        for (i, (column, place)) in self.columns.iter().zip(places).enumerate() {
            let rect = cell_rect(space, place);
            let sense = if self.sort.is_some() { Sense::click() } else { Sense::hover() };
            let response = ui.interact(rect, ui.scope_id().with((self.id, "header", i)), sense);
            response.widget_info(|| WidgetInfo::labeled(Role::Button, true, format!("Sort by {}", column.title)));
            let sorted = self.sort.filter(|s| s.column == i);
            let colour = if response.hovered() && self.sort.is_some() || sorted.is_some() {
                visuals.strong_text_color()
            } else {
                visuals.weak_text_color()
            };
            if let Some(sort) = sorted {
                sort_mark(ui, rect, sort.descending, colour);
            }
            text(ui, rect, column.is_number, column.title, FontId::proportional(11.5), colour);
            if response.clicked() {
                out.sort = Some(Sort { column: i, descending: sorted.is_some_and(|s| !s.descending) });
            }
            let response =
                if self.sort.is_some() { response.on_hover_cursor(CursorIcon::PointingHand) } else { response };
            response.on_hover_text(column.hint);
        }
        ui.painter().hline(space.x_range(), space.bottom(), visuals.widgets.noninteractive.bg_stroke);
    }

    fn row(
        &self,
        ui: &mut Ui,
        row: usize,
        size: Vec2,
        places: &[Range<f32>],
        cell: &mut impl FnMut(usize, usize) -> Cell,
    ) -> Response {
        let (rect, response) = ui.allocate_exact_size(size, Sense::CLICK);
        let selected = self.selected == Some(row);
        let visuals = ui.visuals().clone();
        let cells: Vec<Cell> = (0..places.len()).map(|c| cell(row, c)).collect();
        response.widget_info(|| {
            let name = cells.first().map_or("", |c| c.text.as_str());
            WidgetInfo::selected(Role::Row, true, selected, name)
        });
        if selected {
            ui.painter().rect_filled(rect, 3.0, visuals.selection.bg_fill);
        } else if response.hovered() {
            ui.painter().rect_filled(rect, 3.0, visuals.widgets.hovered.weak_bg_fill);
        } else if row % 2 == 1 {
            ui.painter().rect_filled(rect, 0.0, visuals.faint_bg_color);
        }
        let font = TextStyle::Body.resolve(ui.style());
        for ((cell, place), column) in cells.iter().zip(places).zip(self.columns) {
            let colour = match (selected, cell.weak) {
                (true, _) => visuals.selection.stroke.color,
                (false, true) => visuals.weak_text_color(),
                (false, false) => visuals.text_color(),
            };
            let rect = cell_rect(rect, place);
            if cell.ending {
                let ending = shortened(ui, &cell.text, &font, rect.width());
                text(ui, rect, column.is_number, &ending, font.clone(), colour);
            } else {
                text(ui, rect, column.is_number, &cell.text, font.clone(), colour);
            }
        }
        response
    }

    /// Moves the selection by keys.
    fn keys(&self, ui: &Ui, id: Id, page: usize, out: &mut TableResponse) {
        if !ui.memory(|m| m.has_focus(id)) {
            return;
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
        for (key, by) in moves {
            if ui.input_mut(|i| i.consume_key(Modifiers::NONE, key)) {
                let to = self.selected.map_or(0, |s| s.saturating_add_signed(by));
                out.chosen = Some(to.min(self.num_rows - 1));
            }
        }
    }
}

/// A small triangle above a title: its broad side is where the largest rows are.
fn sort_mark(ui: &Ui, title: Rect, descending: bool, colour: Color32) {
    let (tip, base) = if descending { (3.0, -1.0) } else { (-1.0, 3.0) };
    let at = title.center_top() + vec2(0.0, 1.0);
    let points = vec![at + vec2(-3.5, base), at + vec2(3.5, base), at + vec2(0.0, tip)];
    ui.painter().add(Shape::convex_polygon(points, colour, Stroke::NONE));
}

/// Where to scroll so that a row is seen; none where it is seen already.
fn shown_offset(ui: &Ui, id: Id, row: usize, row_height: f32, height: f32) -> Option<f32> {
    let now = ui.data(|d| d.get_temp::<f32>(id)).unwrap_or(0.0);
    let (top, bottom) = (row as f32 * row_height, (row + 1) as f32 * row_height);
    if top < now {
        Some(top)
    } else if bottom > now + height {
        Some((bottom - height).max(0.0))
    } else {
        None
    }
}

/// Where columns begin and end, from the left edge of a row on.
fn places(columns: &[Column], width: f32) -> Vec<Range<f32>> {
    let least: f32 = columns.iter().map(|c| c.width).sum();
    let shares: f32 = columns.iter().map(|c| c.grows).sum();
    let rest = if shares > 0.0 { (width - least).max(0.0) / shares } else { 0.0 };
    let mut x = 0.0;
    columns
        .iter()
        .map(|c| {
            let from = x;
            x += c.width + c.grows * rest;
            from..x
        })
        .collect()
}

fn cell_rect(row: Rect, place: &Range<f32>) -> Rect {
    let from = row.left() + place.start;
    Rect::from_min_max(pos2(from, row.top()), pos2(row.left() + place.end, row.bottom()))
}

/// One line; what does not fit ends in dots.
fn text(ui: &Ui, rect: Rect, is_number: bool, text: &str, font: FontId, colour: Color32) {
    if text.is_empty() {
        return;
    }
    let room = (rect.width() - 2.0 * PAD).max(1.0);
    let mut job = LayoutJob::simple_singleline(text.to_owned(), font, colour);
    job.wrap = TextWrapping::truncate_at_width(room);
    let galley = ui.painter().layout_job(job);
    let align = if is_number { Align2([Align::Max, Align::Center]) } else { Align2([Align::Min, Align::Center]) };
    let place = align.align_size_within_rect(galley.size(), rect.shrink2(vec2(PAD, 0.0)));
    ui.painter().with_clip_rect(rect.intersect(ui.clip_rect())).galley(place.min, galley, colour);
}

/// The end of a text that is wider than a cell, after dots.
fn shortened(ui: &Ui, text: &str, font: &FontId, width: f32) -> String {
    let lay_out = |text: &str| ui.painter().layout_no_wrap(text.to_owned(), font.clone(), Color32::PLACEHOLDER);
    let (whole, room) = (lay_out(text), width - 2.0 * PAD);
    if whole.size().x <= room {
        return text.to_owned();
    }
    let least = whole.size().x + lay_out("…").size().x + 1.0 - room;
    let places = whole.rows.iter().flat_map(|r| r.glyphs.iter().map(|g| g.pos.x));
    let dropped = places.take_while(|x| *x < least).count();
    std::iter::once('…').chain(text.chars().skip(dropped)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_share_what_is_left_over_and_keep_their_least_width() {
        let column = |width, grows| Column { title: "", hint: "", width, grows, is_number: false };
        let columns = [column(50.0, 1.0), column(30.0, 0.0), column(20.0, 3.0)];
        assert_eq!(places(&columns, 140.0), [0.0..60.0, 60.0..90.0, 90.0..140.0]);
        assert_eq!(places(&columns, 10.0), [0.0..50.0, 50.0..80.0, 80.0..100.0]);
    }

    #[test]
    fn only_rows_in_sight_are_laid_out_and_the_selected_one_is_brought_there() {
        let columns = [Column { title: "Row", hint: "", width: 80.0, grows: 1.0, is_number: false }];
        let mut asked = Vec::new();
        let mut harness = egui_kittest::Harness::builder().with_size(vec2(200.0, 300.0)).build_ui(|ui| {
            let table = Table {
                id: "rows",
                columns: &columns,
                num_rows: 100_000,
                selected: Some(70_000),
                sort: None,
                scroll_to_selected: true,
            };
            asked.clear();
            table.show(ui, |row, _| {
                asked.push(row);
                Cell::new(row.to_string())
            });
        });
        harness.run_steps(3);
        drop(harness);
        assert!(asked.contains(&70_000) && asked.len() < 40, "{asked:?}");
    }
}
