//! A table of rows that can be clicked as a whole.

use eframe::egui::{
    Align2, Color32, CursorIcon, FontId, Pos2, Rect, Response, Role, Sense, Shape, Stroke, TextStyle, Ui, Vec2,
    WidgetInfo,
};

/// Space between columns, and at both ends. [Unit: points]
const GAP: f32 = 6.0;

/// A column.
#[derive(Clone, Copy, Debug)]
pub struct Column {
    /// What stands above it.
    pub title: &'static str,
    /// What it means, in a sentence.
    pub hint: &'static str,
    /// Width. [Unit: points]
    pub width: f32,
    /// Numbers stand at the right.
    pub is_number: bool,
    /// Where a text is too long, its end is kept, not its beginning.
    pub keeps_end: bool,
}

/// By which column rows are ordered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Order {
    /// The column.
    pub column: usize,
    /// The largest comes first.
    pub descending: bool,
}

impl Order {
    /// Orders by a column; by the same one again the other way round.
    pub fn by(&mut self, column: usize) {
        let descending = self.column == column && !self.descending;
        *self = Self { column, descending };
    }
}

/// What a cell shows.
#[derive(Clone, Debug, Default)]
pub struct Cell {
    /// Its text; what does not fit is left out.
    pub text: String,
    /// A bar behind the text. [Limit: 0 to 1]
    pub bar: Option<f32>,
}

impl Cell {
    /// A text.
    pub fn text(text: impl Into<String>) -> Self {
        Self { text: text.into(), bar: None }
    }
}

/// Width of a table. [Unit: points]
pub fn width(columns: &[Column]) -> f32 {
    GAP + columns.iter().map(|c| c.width + GAP).sum::<f32>()
}

/// Height of a row. [Unit: points]
pub fn row_height(ui: &Ui) -> f32 {
    ui.text_style_height(&TextStyle::Body) + 4.0
}

/// The titles. Where there is an order, a click on one changes it.
pub fn header(ui: &mut Ui, columns: &[Column], mut order: Option<&mut Order>) {
    let (all, _) = ui.allocate_exact_size(Vec2::new(width(columns), row_height(ui)), Sense::hover());
    for (i, (column, rect)) in columns.iter().zip(rects(columns, all)).enumerate() {
        let id = ui.unique_id().with(("title", column.title, i));
        let sense = if order.is_some() { Sense::click() } else { Sense::hover() };
        let response = ui.interact(rect.expand2(Vec2::new(GAP * 0.5, 0.0)), id, sense);
        if let Some(o) = &order
            && o.column == i
        {
            order_mark(ui, rect, column.is_number, o.descending);
        }
        if let Some(order) = &mut order {
            response.widget_info(|| WidgetInfo::labeled(Role::Button, true, format!("Order by {}", column.title)));
            if response.clicked() {
                order.by(i);
            }
        }
        let colour = if response.hovered() { ui.visuals().strong_text_color() } else { ui.visuals().weak_text_color() };
        text(ui, rect, column.title, column, colour);
        response.on_hover_text(column.hint);
    }
}

/// A triangle under the title, or above it where the largest comes first.
fn order_mark(ui: &Ui, rect: Rect, right: bool, descending: bool) {
    let x = if right { rect.right() - 5.0 } else { rect.left() + 5.0 };
    let (base, tip) = if descending { (rect.top(), 3.0) } else { (rect.bottom(), -3.0) };
    let corners = vec![Pos2::new(x - 4.0, base), Pos2::new(x + 4.0, base), Pos2::new(x, base + tip)];
    ui.painter().add(Shape::convex_polygon(corners, ui.visuals().strong_text_color(), Stroke::NONE));
}

/// A row; `label` is what it does when it is clicked.
pub fn row(ui: &mut Ui, columns: &[Column], label: &str, marked: bool, cells: &[Cell]) -> Response {
    let size = Vec2::new(width(columns), row_height(ui));
    let (all, response) = ui.allocate_exact_size(size, Sense::click());
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, marked, label));
    let visuals = ui.visuals();
    let fill = match (marked, response.hovered()) {
        (true, _) => visuals.selection.bg_fill.gamma_multiply(0.55),
        (_, true) => visuals.widgets.hovered.weak_bg_fill,
        _ => Color32::TRANSPARENT,
    };
    let colour = if marked || response.hovered() { visuals.strong_text_color() } else { visuals.text_color() };
    let bar = visuals.selection.bg_fill.gamma_multiply(0.45);
    ui.painter().rect_filled(all, 2.0, fill);
    for ((cell, column), rect) in cells.iter().zip(columns).zip(rects(columns, all)) {
        if let Some(ratio) = cell.bar {
            let full = Rect::from_min_size(rect.min, Vec2::new(rect.width() * ratio.clamp(0.0, 1.0), rect.height()));
            ui.painter().rect_filled(full.shrink2(Vec2::new(0.0, 3.0)), 1.0, bar);
        }
        text(ui, rect, &cell.text, column, colour);
    }
    response.on_hover_cursor(CursorIcon::PointingHand)
}

/// Places of a row's cells.
fn rects(columns: &[Column], row: Rect) -> impl Iterator<Item = Rect> {
    columns.iter().scan(row.left() + GAP, move |x, c| {
        let rect = Rect::from_min_size(Pos2::new(*x, row.top()), Vec2::new(c.width, row.height()));
        *x += c.width + GAP;
        Some(rect)
    })
}

fn text(ui: &Ui, rect: Rect, text: &str, column: &Column, colour: Color32) {
    let font: FontId = TextStyle::Body.resolve(ui.style());
    let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
    let width = |text: &str| painter.layout_no_wrap(text.to_owned(), font.clone(), colour).size().x;
    let text = fitted(text, column.keeps_end, |t| width(t) <= rect.width());
    let (pos, align) = if column.is_number {
        (rect.right_center(), Align2::RIGHT_CENTER)
    } else {
        (rect.left_center(), Align2::LEFT_CENTER)
    };
    painter.text(pos, align, text, font, colour);
}

/// The text, or as much of its beginning or end as fits, with an ellipsis.
fn fitted(text: &str, keeps_end: bool, fits: impl Fn(&str) -> bool) -> String {
    if fits(text) {
        return text.to_owned();
    }
    let chars: Vec<char> = text.chars().collect();
    let part = |n: usize| -> String {
        if keeps_end {
            std::iter::once('…').chain(chars[chars.len() - n..].iter().copied()).collect()
        } else {
            chars[..n].iter().copied().chain(std::iter::once('…')).collect()
        }
    };
    // The longest part that fits, by halves.
    let (mut low, mut high) = (0, chars.len());
    while low + 1 < high {
        let middle = (low + high) / 2;
        if fits(&part(middle)) { low = middle } else { high = middle }
    }
    part(low)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_lie_side_by_side_within_the_row() {
        let column = Column { title: "", hint: "", width: 30.0, is_number: false, keeps_end: false };
        let columns = [column, Column { width: 50.0, ..column }, column];
        let row = Rect::from_min_size(Pos2::new(5.0, 5.0), Vec2::new(width(&columns), 20.0));
        let cells: Vec<Rect> = rects(&columns, row).collect();
        assert!(cells.windows(2).all(|w| w[1].left() >= w[0].right()));
        assert!(cells.iter().all(|c| row.contains_rect(*c)));
        assert_eq!(cells.len(), 3);
    }

    #[test]
    fn the_most_that_fits_of_a_text_is_kept() {
        let fits = |n: usize| move |t: &str| t.chars().count() <= n;
        assert_eq!(fitted("walk_left 12–30", true, fits(20)), "walk_left 12–30");
        assert_eq!(fitted("walk_left 12–30", true, fits(8)), "…t 12–30");
        assert_eq!(fitted("walk_left 12–30", false, fits(5)), "walk…");
        assert_eq!(fitted("", false, fits(0)), "");
    }

    #[test]
    fn the_same_column_again_turns_the_order_round() {
        let mut order = Order::default();
        order.by(2);
        assert_eq!(order, Order { column: 2, descending: false });
        order.by(2);
        assert!(order.descending);
        order.by(1);
        assert_eq!(order, Order { column: 1, descending: false });
    }
}
