//! The bar at the top: file, view, panels, help.

use super::{PANELS, PanelStates, SystemDialog, paint::PanelWidget, words::counted};
use crate::command::{Commands, ViewStage, ViewerCommand};
use crate::document::{OpenDocument, path_list};
use crate::model::{Model, name_of};
use crate::render::CameraPreset;
use crate::settings::{Colouring, ViewerSettings};
use eframe::egui::{self, MenuBar, ThemePreference, Ui};
use throng_crowd::Scheme;
use throng_simulation::scene::engine;

/// Shows the bar.
pub fn show(ui: &mut Ui, model: &Model, states: &mut PanelStates, commands: &mut Commands) {
    MenuBar::new().ui(ui, |ui| {
        ui.menu_button("File", |ui| file(ui, model, states, commands));
        ui.menu_button("View", |ui| view(ui, model, states, commands));
        ui.menu_button("Panels", |ui| panels(ui, model, commands));
        if ui.button("Keys").on_hover_text("All keys (H)").clicked() {
            states.help = !states.help;
        }
        ui.separator();
        if model.document.bundle().is_some() {
            stages(ui, model, commands);
            ui.separator();
        }
        ui.add(egui::Label::new(title(model)).truncate());
    });
}

fn title(model: &Model) -> String {
    if let Some(paths) = model.loading() {
        let (name, line) = (name_of(paths), model.building().and_then(|b| b.log().status.status_line()));
        return line.map_or_else(|| format!("Reading {name} …"), |line| format!("Building {name}: {line}"));
    }
    let name = name_of(&model.asked);
    match &model.document {
        OpenDocument::Nothing => "Nothing open".into(),
        OpenDocument::Bundle(b) => {
            let t = b.bundle.tables();
            let (clips, states, spaces) = (t.clips().len(), t.graph().states.len(), b.bundle.blends.len());
            let mut parts = vec![name, format!("{clips} clips")];
            if states > 0 || spaces == 0 {
                parts.push(format!("{states} states · {} actions", t.graph().action_segments.len()));
            }
            if spaces > 0 {
                parts.push(counted(spaces, "blend space"));
            }
            parts.join(" · ")
        }
        OpenDocument::World(w) => {
            let (units, instances) = (w.placed().len(), w.graph().num_instances());
            let edits = if w.revision > 0 { " · edited" } else { "" };
            format!("{name} · {units} units · {instances} patches · {} characters{edits}", w.run.num_characters())
        }
        OpenDocument::Scene(s) => {
            let (groups, choice) = (s.run.simulation().groups().len(), s.choice);
            let engine = match choice.engine == Scheme::default() {
                true => String::new(),
                false => format!(" · engine {}", engine::name(choice.engine)),
            };
            let groups = counted(groups, "group");
            format!("{name} · {groups} · {} characters · seed {}{engine}", choice.characters, choice.seed)
        }
        OpenDocument::Task(t) => {
            let (things, motions) = (counted(t.task().things.len(), "thing"), counted(t.motions().len(), "motion"));
            let edits = if t.is_changed() { " · changed" } else { "" };
            format!("{name} · {} to do · {things} · {motions}{edits}", t.task().num_steps())
        }
        OpenDocument::Clip(c) => {
            format!("{name} · {} joints · {:.1} s at {} Hz", c.report.joints, c.report.duration_s, c.report.rate_hz)
        }
    }
}

fn file(ui: &mut Ui, model: &Model, states: &mut PanelStates, commands: &mut Commands) {
    let tip = "A bundle, a scene, a world, a task, or files of motion; or drop them on the window (Ctrl+O)";
    if ui.button("Open…").on_hover_text(tip).clicked() {
        states.dialog = Some(SystemDialog::Files);
    }
    if ui.button("Open folder…").on_hover_text("A folder of motion, which is built first").clicked() {
        states.dialog = Some(SystemDialog::Folder);
    }
    ui.menu_button("Open recent", |ui| {
        if model.settings.opened.is_empty() {
            ui.weak("Nothing yet");
        }
        for paths in &model.settings.opened {
            ui.button(path_list(paths)).request(commands, ViewerCommand::Open(paths.clone()));
        }
    });
    for (text, request) in [("Reload", ViewerCommand::Reload), ("Start page", ViewerCommand::Close)] {
        ui.add_enabled(model.document.path().is_some(), egui::Button::new(text)).request(commands, request);
    }
    ui.separator();
    if ui.button("Quit").clicked() {
        ui.send_viewport_cmd(egui::ViewportCommand::Close);
    }
}

fn view(ui: &mut Ui, model: &Model, states: &mut PanelStates, commands: &mut Commands) {
    let mut s = model.settings.clone();
    ui.button("Show everything").on_hover_text("A").request(commands, ViewerCommand::FrameAll);
    ui.menu_button("Camera", |ui| {
        for preset in CameraPreset::ALL {
            let mut camera = s.camera;
            preset.turn(&mut camera);
            ui.button(preset.name()).request(commands, ViewerCommand::Camera(camera));
        }
    });
    ui.checkbox(&mut s.follow, "Follow the selected character");
    ui.separator();
    ui.menu_button("Body", |ui| {
        radios(ui, &mut s.body, model.bodies());
        ui.separator();
        let tip = "In proportions and clothes; feet stand where they are";
        ui.checkbox(&mut s.varied, "Bodies vary").on_hover_text(tip);
        let tip = "A character with a skin, as .glb; everybody wears it";
        if ui.button("Your own…").on_hover_text(tip).clicked() {
            states.dialog = Some(SystemDialog::Body);
        }
    });
    ui.menu_button("Colours", |ui| radios(ui, &mut s.colouring, Colouring::ALL));
    ui.separator();
    let o = &mut s.overlays;
    ui.checkbox(&mut o.contacts, "Contacts");
    ui.checkbox(&mut o.trails, "Trails of the roots");
    ui.checkbox(&mut o.trajectory, "Where the action leads");
    ui.checkbox(&mut o.targets, "Targets");
    ui.checkbox(&mut o.joint_axes, "Joint axes");
    ui.checkbox(&mut o.of_all, "Of all characters");
    ui.checkbox(&mut o.onion_skin, "Onion skin of clips");
    ui.separator();
    appearance(ui, &mut s);
    if s != model.settings {
        commands.push(ViewerCommand::Settings(Box::new(s)));
    }
}

fn appearance(ui: &mut Ui, s: &mut ViewerSettings) {
    ui.menu_button("Theme", |ui| {
        let system = (ThemePreference::System, "As the system");
        radios(ui, &mut s.theme, [(ThemePreference::Dark, "Dark"), (ThemePreference::Light, "Light"), system]);
    });
    ui.menu_button("Size of text", |ui| {
        let sizes = [0.8, 0.9, 1.0, 1.1, 1.25, 1.5, 1.75, 2.0];
        radios(ui, &mut s.zoom, sizes.map(|zoom| (zoom, format!("{:.0} %", zoom * 100.0))));
    });
}

/// Shows a button for each value; the one of the present value is pressed.
fn radios<T: PartialEq>(ui: &mut Ui, value: &mut T, all: impl IntoIterator<Item = (T, impl ToString)>) {
    for (one, name) in all {
        ui.radio_value(value, one, name.to_string());
    }
}

fn panels(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    for panel in PANELS {
        let open = [model.settings.side_panel, model.settings.bottom_panel].contains(&Some(panel.kind));
        let text = format!("{} ({})", panel.title, panel.key.name());
        let label = ui.selectable_label(open, text).on_hover_text(panel.purpose);
        label.request(commands, ViewerCommand::TogglePanel(panel.kind));
    }
}

fn stages(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    let run = match &model.document {
        OpenDocument::World(_) => (ViewStage::Crowd, "World", "The characters of the world"),
        OpenDocument::Scene(_) => (ViewStage::Crowd, "Scene", "The groups of the scene"),
        _ => (ViewStage::Crowd, "Crowd", "The run of a crowd"),
    };
    let all = [
        run,
        (ViewStage::Blend, "Blend", "A character walking in a blend space"),
        (ViewStage::Clip, "Clip", "A clip alone"),
    ];
    let there = model.stages();
    for (stage, name, tip) in all.into_iter().filter(|s| there.contains(&s.0)) {
        let label = ui.selectable_label(model.shown_stage() == stage, name).on_hover_text(format!("{tip} (C)"));
        label.request(commands, ViewerCommand::Stage(stage));
    }
}
