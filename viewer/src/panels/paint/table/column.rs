//! Columns of a table: their widths, their titles, and by which of them rows are sorted.

use super::cell::{TableCell, paint_text};
use super::{RowTable, place_rect};
use crate::panels::paint::PanelWidget;
use eframe::egui::{Color32, CursorIcon, FontId, Id, Rect, Role, Sense, Shape, Stroke, Ui, vec2};
use std::{cmp::Ordering, ops::Range};

/// A column.
#[derive(Clone, Copy, Debug)]
pub struct TableColumn<'a> {
    /// Title above the column.
    pub title: &'a str,
    /// Meaning of the column.
    pub hint: &'a str,
    /// Least width (points).
    pub width: f32,
    /// Share of the width that is left over.
    pub grows: f32,
    /// Numbers stand at the right.
    pub is_number: bool,
    /// Rank for leaving columns out: if there is no room for all, the largest rank goes first, and of equal ranks the
    /// last column; columns of rank 0 always stay.
    pub spare: u8,
}

impl<'a> TableColumn<'a> {
    /// A column of texts that takes its share of the width that is left over.
    pub const fn text(title: &'a str, hint: &'a str, width: f32, grows: f32) -> Self {
        Self { title, hint, width, grows, is_number: false, spare: 0 }
    }

    /// A column of numbers.
    pub const fn number(title: &'a str, hint: &'a str, width: f32) -> Self {
        Self { title, hint, width, grows: 0.0, is_number: true, spare: 0 }
    }

    /// This column with a rank for leaving it out; see [`TableColumn::spare`].
    pub const fn spare(self, rank: u8) -> Self {
        Self { spare: rank, ..self }
    }
}

/// Least width of a table that has all of the columns (points).
pub fn least_width(columns: &[TableColumn<'_>]) -> f32 {
    columns.iter().map(|c| c.width).sum()
}

/// A visible column.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ColumnPlace {
    /// Number of the column.
    pub column: usize,
    /// From where to where it goes, from the left edge of a row on (points).
    pub x: Range<f32>,
}

/// Positions of the visible columns.
pub(super) fn places(columns: &[TableColumn<'_>], width: f32) -> Vec<ColumnPlace> {
    let kept = fitting(columns, width);
    let least: f32 = kept.iter().map(|&c| columns[c].width).sum();
    let shares: f32 = kept.iter().map(|&c| columns[c].grows).sum();
    let rest = if shares > 0.0 { (width - least).max(0.0) / shares } else { 0.0 };
    let mut x = 0.0;
    let place = |column: usize| {
        let from = x;
        x += columns[column].width + columns[column].grows * rest;
        ColumnPlace { column, x: from..x }
    };
    kept.into_iter().map(place).collect()
}

/// Numbers of the columns that fit.
fn fitting(columns: &[TableColumn<'_>], width: f32) -> Vec<usize> {
    let mut kept: Vec<usize> = (0..columns.len()).collect();
    while kept.iter().map(|&c| columns[c].width).sum::<f32>() > width {
        let most = kept.iter().map(|&c| columns[c].spare).max().unwrap_or(0);
        let Some(at) = kept.iter().rposition(|&c| most > 0 && columns[c].spare == most) else { break };
        kept.remove(at);
    }
    kept
}

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
pub fn show_titles(ui: &mut Ui, table: &RowTable<'_>, id: Id, row: Rect, places: &[ColumnPlace]) -> Option<TableSort> {
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

    fn column(width: f32, grows: f32) -> TableColumn<'static> {
        TableColumn::text("", "", width, grows)
    }

    fn ranges(columns: &[TableColumn<'_>], width: f32) -> Vec<Range<f32>> {
        places(columns, width).into_iter().map(|p| p.x).collect()
    }

    #[test]
    fn columns_share_what_is_left_over_and_keep_their_least_width() {
        let columns = [column(50.0, 1.0), column(30.0, 0.0), column(20.0, 3.0)];
        assert_eq!(ranges(&columns, 140.0), [0.0..60.0, 60.0..90.0, 90.0..140.0]);
        assert_eq!(ranges(&columns, 10.0), [0.0..50.0, 50.0..80.0, 80.0..100.0]);
    }

    #[test]
    fn columns_lie_side_by_side_within_the_row() {
        let columns = [column(30.0, 0.2), column(50.0, 0.0), column(30.0, 1.7)];
        let found = ranges(&columns, 200.0);
        assert_eq!(found.len(), 3);
        assert!(found.windows(2).all(|w| w[1].start >= w[0].end));
        assert!(found.iter().all(|r| r.start >= 0.0 && r.end <= 200.001 && r.end > r.start));
    }

    #[test]
    fn columns_of_the_highest_rank_are_left_out_first() {
        let columns = [column(50.0, 0.0), column(40.0, 0.0).spare(1), column(30.0, 0.0).spare(2), column(20.0, 0.0)];
        let kept = |width| places(&columns, width).into_iter().map(|p| p.column).collect::<Vec<_>>();
        assert_eq!(kept(140.0), [0, 1, 2, 3]);
        assert_eq!(kept(139.0), [0, 1, 3]);
        assert_eq!(kept(109.0), [0, 3]);
        assert_eq!(kept(10.0), [0, 3]);
        let alike = [column(50.0, 0.0), column(40.0, 0.0).spare(1), column(40.0, 0.0).spare(1)];
        assert_eq!(fitting(&alike, 100.0), [0, 1]);
    }

    #[test]
    fn a_second_click_on_a_column_reverses_the_order() {
        let sort = TableSort::default().toggled(2);
        assert_eq!(sort, TableSort { column: 2, descending: false });
        assert!(sort.toggled(2).descending);
        assert_eq!(sort.toggled(2).toggled(2), sort);
        assert_eq!(sort.toggled(2).toggled(1), TableSort { column: 1, descending: false });
    }
}
