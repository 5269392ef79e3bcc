//! Small painters that panels share: a time axis with its ruler, legends, tables of many rows.

mod axis;
mod hatch;
mod legend;
mod plot;
mod ruler;
mod table;

pub use axis::{FrameAxis, FrameSpan};
pub use hatch::hatch;
pub use legend::legend;
pub use plot::fixed_plot;
pub use ruler::{RULER_HEIGHT, ruler};
pub use table::{RowClick, RowTable, TableCell, TableColumn, TableResponse, TableSort, least_width};

use crate::document::OpenDocument;
use eframe::egui::{Align, Layout, RichText, Ui};

/// Shows a title and a hint in the middle of an empty panel.
pub fn empty(ui: &mut Ui, title: &str, hint: &str) {
    ui.with_layout(Layout::top_down(Align::Center), |ui| {
        ui.add_space((0.5 * ui.available_height() - 30.0).max(8.0));
        ui.label(RichText::new(title).strong());
        ui.label(RichText::new(hint).weak());
    });
}

/// Hint of panels about bundles for a document without one.
pub fn no_bundle(ui: &mut Ui, document: &OpenDocument) {
    match document {
        OpenDocument::Task(_) => empty(ui, "A task has no bundle", "The panel Plan (F11) shows what is to do."),
        OpenDocument::Scene(_) => empty(ui, "This scene has no bundle", "The panel Control (F1) shows its groups."),
        _ => nothing_open(ui),
    }
}

/// Hint of panels if no document is open.
pub fn nothing_open(ui: &mut Ui) {
    empty(ui, "Nothing is open", "Open a bundle or a motion file: drop it here or use File > Open.");
}

/// A length of time as people read it, such as `3.20 s` or `2:05 min` (s).
pub fn time_text(seconds: f64) -> String {
    if seconds < 60.0 {
        format!("{seconds:.2} s")
    } else {
        let whole = seconds.round() as u64;
        format!("{}:{:02} min", whole / 60, whole % 60)
    }
}

#[cfg(test)]
mod tests {
    use super::time_text;

    #[test]
    fn times_are_short() {
        assert_eq!(time_text(3.2), "3.20 s");
        assert_eq!(time_text(125.4), "2:05 min");
        assert_eq!(time_text(59.999), "60.00 s");
    }
}
