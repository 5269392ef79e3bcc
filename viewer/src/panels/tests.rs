//! What tests of panels share.

#[path = "../../tests/common/boxing.rs"]
pub(crate) mod boxing;

#[path = "../../tests/common/meeting.rs"]
pub(crate) mod meeting;

#[path = "../../tests/common/paces.rs"]
pub(crate) mod paces;

#[path = "../../tests/common/square.rs"]
pub(crate) mod square;

use crate::command::Command;
use crate::document::Bundle;
use crate::model::Model;
use crate::settings::Settings;
use eframe::egui::{Modifiers, PointerButton, Pos2, Ui, Vec2};
use egui_kittest::Harness;
use std::path::{Path, PathBuf};
use throng_runtime::format::VERSION;

/// The bundle of the current version that every checkout has.
pub(crate) fn golden_path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../data/golden/tables_v{VERSION}.throng"))
}

/// The bundle that is always there.
pub(crate) fn golden() -> Bundle {
    Bundle::open(&golden_path()).unwrap()
}

/// A file of captured motion; none, with a word on it, where there is no captured motion.
pub(crate) fn mocap(name: &str) -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/mocap");
    let path = std::env::var_os("THRONG_MOCAP").map_or_else(beside, PathBuf::from).join(name);
    if path.exists() {
        return Some(path);
    }
    eprintln!("skipped: no captured motion at {}; set THRONG_MOCAP to its folder", path.display());
    None
}

/// What a panel is tried with: a model, the panel's own state, and what it has asked for.
pub(crate) struct Trial<S> {
    pub(crate) model: Model,
    pub(crate) state: S,
    pub(crate) commands: Vec<Command>,
}

/// A panel alone in a window; what it asks for is kept and carried out.
pub(crate) fn trial<S: Default + 'static>(
    path: Option<&Path>,
    size: Vec2,
    show: impl Fn(&mut Ui, &Model, &mut S, &mut Vec<Command>) + 'static,
) -> Harness<'static, Trial<S>> {
    let mut model = Model::new(Settings::default());
    if let Some(path) = path {
        model.open_now(path).unwrap();
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
