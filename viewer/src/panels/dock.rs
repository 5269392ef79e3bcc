//! Docks of panels: tabs, and the open panel.

use super::{PANELS, PanelStates, paint::PanelWidget};
use crate::command::{Commands, ViewerCommand};
use crate::{model::Model, settings::Dock};
use eframe::egui::{self, Ui};

/// Shows the tabs of a dock, and the panel that is open.
pub fn show(ui: &mut Ui, dock: Dock, model: &Model, states: &mut PanelStates, commands: &mut Commands) {
    let open = model.settings.panel(dock);
    ui.add_space(3.0);
    ui.horizontal_wrapped(|ui| {
        for panel in PANELS.iter().filter(|p| p.kind.dock() == dock) {
            let tip = format!("{} ({})", panel.purpose, panel.key.name());
            let tab = ui.selectable_label(open == Some(panel.kind), panel.title).on_hover_text(tip);
            if open != Some(panel.kind) {
                tab.request(commands, ViewerCommand::TogglePanel(panel.kind));
            }
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if let Some(kind) = open {
                let close = ui.small_button("✖").on_hover_text("Close the panel");
                close.request(commands, ViewerCommand::TogglePanel(kind));
            }
        });
    });
    ui.separator();
    let Some(panel) = PANELS.iter().find(|p| open == Some(p.kind)) else { return };
    match dock {
        Dock::Side => {
            egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| (panel.show)(ui, model, states, commands));
        }
        Dock::Bottom => (panel.show)(ui, model, states, commands),
    }
}
