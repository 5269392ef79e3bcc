//! Messages to the user, over the 3-D view.

use super::paint::PanelWidget;
use crate::command::{Commands, ViewerCommand};
use crate::model::Model;
use eframe::egui::{self, Align2, Area, Color32, Frame, Id, Rect, RichText, Ui, vec2};

/// Shows the messages in the upper left corner of a part of the window, the latest at the top.
pub fn show(ui: &Ui, within: Rect, model: &Model, commands: &mut Commands) {
    if model.messages.is_empty() {
        return;
    }
    let at = within.left_top() + vec2(10.0, 10.0);
    let area = Area::new(Id::unique("messages")).fixed_pos(at).pivot(Align2::LEFT_TOP).constrain_to(within);
    area.show(ui.ctx(), |ui| {
        ui.set_max_width((within.width() - 20.0).clamp(120.0, 520.0));
        for m in model.messages.iter().rev() {
            let stripe = if m.is_error { ui.visuals().error_fg_color } else { ui.visuals().selection.bg_fill };
            Frame::popup(ui.style()).stroke(egui::Stroke::new(1.0, stripe)).show(ui, |ui| {
                ui.horizontal_top(|ui| {
                    let mark = if m.is_error { "⚠" } else { "ℹ" };
                    // A colour that stands out from the background of messages.
                    let readable =
                        if ui.visuals().dark_mode { stripe.lerp_to_gamma(Color32::WHITE, 0.3) } else { stripe };
                    ui.label(RichText::new(mark).color(readable).strong());
                    let close = ui.button("✖").on_hover_text("Close this message");
                    close.request(commands, ViewerCommand::Dismiss(m.id));
                    ui.add(egui::Label::new(&m.text).wrap().selectable(true));
                });
            });
        }
    });
}
