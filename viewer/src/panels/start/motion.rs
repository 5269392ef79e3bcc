//! Motion of one's own: a place to drop it, and dialogs to choose it with.

use super::heading;
use crate::panels::SystemDialog;
use eframe::egui::{Frame, Label, Margin, RichText, Shape, Stroke, Ui};

/// Shows the place.
pub fn show(ui: &mut Ui, dialog: &mut Option<SystemDialog>) {
    heading(ui, "Your own motion");
    let is_over = ui.input(|i| !i.raw.hovered_files.is_empty());
    let visuals = ui.visuals();
    let fill = if is_over { visuals.selection.bg_fill.gamma_multiply(0.4) } else { visuals.extreme_bg_color };
    let edge = if is_over { visuals.selection.stroke.color } else { visuals.weak_text_color() };
    let shown = Frame::NONE.fill(fill).corner_radius(8).inner_margin(Margin::same(14)).show(ui, |ui| {
        ui.set_width(ui.available_width());
        ui.label(RichText::new("Drop a folder or files here").size(16.0).strong());
        let what = "A folder, a .zip or files of motion (.bvh, .amc, .npz, .glb, .fbx) are built and run. A bundle, a \
                    scene, a world or a single clip is opened.";
        ui.add(Label::new(RichText::new(what).weak()).wrap());
        ui.add_space(6.0);
        ui.horizontal_wrapped(|ui| {
            for (text, kind) in [("Choose a folder…", SystemDialog::Folder), ("Choose files…", SystemDialog::Files)]
            {
                if ui.button(text).clicked() {
                    *dialog = Some(kind);
                }
            }
        });
    });
    let rect = shown.response.rect.shrink(1.0);
    let corners = [rect.left_top(), rect.right_top(), rect.right_bottom(), rect.left_bottom(), rect.left_top()];
    ui.painter().extend(Shape::dashed_line(&corners, Stroke::new(1.5, edge), 6.0, 5.0));
}
