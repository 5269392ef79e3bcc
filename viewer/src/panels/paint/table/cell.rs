//! Content of a cell: a text, and a bar behind it.

use eframe::egui::text::LayoutJob;
use eframe::egui::{Align, Align2, Color32, FontId, Galley, Rect, TextStyle, Ui, vec2};
use std::sync::Arc;

/// Space between the edge of a cell and its text (points).
const PAD: f32 = 5.0;

/// Content of a cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TableCell {
    /// The text.
    pub text: String,
    /// Shown in a weak colour.
    pub weak: bool,
    /// A text that is too long keeps its end instead of its beginning.
    pub ending: bool,
    /// Length of a bar behind the text (0 to 1).
    pub bar: Option<f32>,
}

impl TableCell {
    /// A text.
    pub fn new(text: impl Into<String>) -> Self {
        Self { text: text.into(), ..Self::default() }
    }

    /// A text that matters less.
    pub fn weak(text: impl Into<String>) -> Self {
        Self { text: text.into(), weak: true, ..Self::default() }
    }

    /// This cell, keeping its end if it is too long.
    pub fn ending(self) -> Self {
        Self { ending: true, ..self }
    }

    /// This cell with a bar behind the text (0 to 1).
    pub fn bar(self, length: f32) -> Self {
        Self { bar: Some(length), ..self }
    }

    /// Paints it.
    pub(super) fn paint(&self, ui: &Ui, rect: Rect, is_number: bool, selected: bool) {
        let visuals = ui.visuals();
        if let Some(length) = self.bar {
            let back = if selected { visuals.selection.stroke.color } else { visuals.selection.bg_fill };
            let full = rect.shrink2(vec2(0.5 * PAD, 3.0));
            let bar = full.with_max_x(full.left() + full.width() * length.clamp(0.0, 1.0));
            let strength = if selected { 0.25 } else { 0.45 };
            ui.painter_at(rect).rect_filled(bar, 1.0, back.gamma_multiply(strength));
        }
        let colour = match (selected, self.weak) {
            (true, _) => visuals.selection.stroke.color,
            (false, true) => visuals.weak_text_color(),
            (false, false) => visuals.text_color(),
        };
        paint_text(ui, rect, is_number, self, TextStyle::Body.resolve(ui.style()), colour);
    }
}

/// Paints the text of a cell; one that is too long loses its end or, with [`TableCell::ending`], its beginning.
pub(super) fn paint_text(ui: &Ui, rect: Rect, is_number: bool, cell: &TableCell, font: FontId, colour: Color32) {
    if cell.text.is_empty() {
        return;
    }
    let lay_out = |text: &str| -> Arc<Galley> {
        ui.painter().layout_job(LayoutJob::simple_singleline(text.to_owned(), font.clone(), colour))
    };
    let room = (rect.width() - 2.0 * PAD).max(1.0);
    let galley = lay_out(&fitted(&cell.text, cell.ending, |t| lay_out(t).size().x <= room));
    let align = if is_number { Align2([Align::Max, Align::Center]) } else { Align2([Align::Min, Align::Center]) };
    let place = align.align_size_within_rect(galley.size(), rect.shrink2(vec2(PAD, 0.0)));
    ui.painter_at(rect).galley(place.min, galley, colour);
}

/// The text, or the part of its beginning or end that fits, with an ellipsis.
fn fitted(text: &str, ending: bool, fits: impl Fn(&str) -> bool) -> String {
    if fits(text) {
        return text.to_owned();
    }
    let chars: Vec<char> = text.chars().collect();
    let part = |n: usize| -> String {
        if ending {
            std::iter::once('…').chain(chars[chars.len() - n..].iter().copied()).collect()
        } else {
            chars[..n].iter().copied().chain(std::iter::once('…')).collect()
        }
    };
    let lengths: Vec<usize> = (1..chars.len()).collect();
    part(lengths.partition_point(|&n| fits(&part(n))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_that_fits_of_a_text_is_kept() {
        let fits = |n: usize| move |t: &str| t.chars().count() <= n;
        assert_eq!(fitted("walk_left 12–30", true, fits(20)), "walk_left 12–30");
        assert_eq!(fitted("walk_left 12–30", true, fits(8)), "…t 12–30");
        assert_eq!(fitted("walk_left 12–30", false, fits(5)), "walk…");
        assert_eq!(fitted("", false, fits(0)), "");
    }
}
