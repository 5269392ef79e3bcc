//! The walking body, and its companion.

use super::slider;
use crate::run::{BlendCompanions, Blending, LEGS, SIZES};
use eframe::egui::{Grid, Ui};

/// Shows size, legs, retargeting and the companion.
pub fn show(ui: &mut Ui, wanted: &mut Blending) {
    Grid::new("body").num_columns(2).spacing([8.0, 3.0]).show(ui, |ui| {
        for (name, tip, value, range) in [
            ("size", "Size of the walking body; the examples have 1", &mut wanted.size, SIZES),
            ("legs", "Length of its legs, relative to its size", &mut wanted.legs, LEGS),
        ] {
            ui.label(name).on_hover_text(tip);
            slider(ui, name, value, range, "");
            ui.end_row();
        }
    });
    ui.horizontal_wrapped(|ui| {
        ui.checkbox(&mut wanted.retarget, "retarget").on_hover_text(
            "Planted feet stay, legs and touching arms reach; without it, joint angles are taken as they are blended",
        );
        if (wanted.size, wanted.legs) != (1.0, 1.0) && ui.small_button("size of the examples").clicked() {
            (wanted.size, wanted.legs) = (1.0, 1.0);
        }
    });
    ui.horizontal_wrapped(|ui| {
        ui.label("beside");
        for (beside, name, tip) in [
            (BlendCompanions::None, "nobody", "It walks alone"),
            (
                BlendCompanions::Retargeting,
                if wanted.retarget { "not retargeted" } else { "retargeted" },
                "The same body with the other setting",
            ),
            (BlendCompanions::Sizes, "sizes", "The smallest and the largest body, on the same path"),
        ] {
            ui.selectable_value(&mut wanted.companions, beside, name).on_hover_text(tip);
        }
    });
}
