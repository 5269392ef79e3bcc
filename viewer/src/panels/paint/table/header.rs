//! The titles of a table, and by which of them rows are sorted.

use super::cell::{TableCell, paint_text};
use super::column::ColumnPlace;
use super::{RowTable, place_rect};
use crate::panels::paint::PanelWidget;
use eframe::egui::{Color32, CursorIcon, FontId, Id, Rect, Role, Sense, Shape, Stroke, Ui, vec2};
use std::cmp::Ordering;

/// By which column rows are sorted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TableSort {
    /// Number of the column.
    pub column: usize,
    /// The largest first.
    pub descending: bool,
}

impl Default for TableSort {
    /// Rows stay in their order.
    fn default() -> Self {
        Self { column: usize::MAX, descending: false }
    }
}

impl TableSort {
    /// Sorts numbers of items.
    ///
    /// - `orders`: ascending order of each column.
    pub fn sort<T>(self, rows: &mut [usize], orders: &[fn(&T, &T) -> Ordering], items: &[T]) {
        if let Some(order) = orders.get(self.column) {
            rows.sort_by(|&a, &b| self.directed(order(&items[a], &items[b])));
        }
    }

    /// Order of two rows whose values in the column have the order `ascending`.
    pub fn directed(self, ascending: Ordering) -> Ordering {
        if self.descending { ascending.reverse() } else { ascending }
    }

    /// Sorted by a column; by the same column again in reverse.
    pub fn toggled(self, column: usize) -> Self {
        Self { column, descending: self.column == column && !self.descending }
    }
}

/// Shows the titles.
///
/// - returns the order that was asked for.
pub(super) fn show(ui: &mut Ui, table: &RowTable<'_>, id: Id, row: Rect, places: &[ColumnPlace]) -> Option<TableSort> {
    let mut asked = None;
    let visuals = ui.visuals().clone();
    for place in places {
        let column = &table.columns[place.column];
        let rect = place_rect(row, place);
        let sense = if table.sort.is_some() { Sense::click() } else { Sense::hover() };
        let response = ui.interact(rect, id.with(("title", place.column)), sense);
        let sorted = table.sort.filter(|s| s.column == place.column);
        let stands_out = sorted.is_some() || table.sort.is_some() && response.hovered();
        let colour = if stands_out { visuals.strong_text_color() } else { visuals.weak_text_color() };
        if let Some(sort) = sorted {
            paint_sort_mark(ui, rect, sort.descending, colour);
        }
        let title = TableCell::new(column.title);
        paint_text(ui, rect, column.is_number, &title, FontId::proportional(11.5), colour);
        let response = match table.sort {
            Some(sort) => {
                asked = asked.or(response.clicked().then(|| sort.toggled(place.column)));
                let name = format!("Sort by {}", column.title);
                response.named(Role::Button, name).on_hover_cursor(CursorIcon::PointingHand)
            }
            None => response.named(Role::ColumnHeader, column.title),
        };
        if !column.hint.is_empty() {
            response.on_hover_text(column.hint);
        }
    }
    ui.painter().hline(row.x_range(), row.bottom(), visuals.widgets.noninteractive.bg_stroke);
    asked
}

/// A small triangle above a title: its broad side is where the largest rows are.
fn paint_sort_mark(ui: &Ui, title: Rect, descending: bool, colour: Color32) {
    let (tip, base) = if descending { (3.0, -1.0) } else { (-1.0, 3.0) };
    let at = title.center_top() + vec2(0.0, 1.0);
    let points = vec![at + vec2(-3.5, base), at + vec2(3.5, base), at + vec2(0.0, tip)];
    ui.painter().add(Shape::convex_polygon(points, colour, Stroke::NONE));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_click_on_a_column_reverses_the_order() {
        let sort = TableSort::default().toggled(2);
        assert_eq!(sort, TableSort { column: 2, descending: false });
        assert!(sort.toggled(2).descending);
        assert_eq!(sort.toggled(2).toggled(2), sort);
        assert_eq!(sort.toggled(2).toggled(1), TableSort { column: 1, descending: false });
    }
}
