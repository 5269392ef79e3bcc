//! What tests of panels share.

use crate::command::Commands;
use crate::fixtures::quietly;
use crate::model::Model;
use crate::settings::ViewerSettings;
use eframe::egui::{Modifiers, PointerButton, Pos2, Ui, Vec2};
use egui_kittest::Harness;
use std::path::Path;

/// What a panel is tried with: a model, the panel's own state, and what it has asked for.
pub(crate) struct Trial<S> {
    pub(crate) model: Model,
    pub(crate) state: S,
    pub(crate) commands: Commands,
}

/// A panel alone in a window; what it asks for is kept and carried out.
pub(crate) fn trial<S: Default + 'static>(
    path: Option<&Path>,
    size: Vec2,
    show: impl Fn(&mut Ui, &Model, &mut S, &mut Commands) + 'static,
) -> Harness<'static, Trial<S>> {
    let mut model = Model::new(ViewerSettings::default());
    if let Some(path) = path {
        quietly(|with| model.open_now(path, with)).unwrap();
    }
    let trial = Trial { model, state: S::default(), commands: Vec::new() };
    Harness::builder().with_size(size).build_ui_state(
        move |ui, t: &mut Trial<S>| {
            let mut commands = Vec::new();
            show(ui, &t.model, &mut t.state, &mut commands);
            for command in &commands {
                t.model.apply(ui.ctx(), command.clone());
            }
            t.commands.extend(commands);
        },
        trial,
    )
}

/// Presses a button of the mouse and releases it.
pub(crate) fn click<S>(harness: &mut Harness<'_, S>, pos: Pos2) {
    harness.hover_at(pos);
    for pressed in [true, false] {
        let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
        harness.event(eframe::egui::Event::PointerButton { pos, button, pressed, modifiers });
    }
    harness.run_steps(2);
}
