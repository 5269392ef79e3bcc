//! The panels. One panel, one file, one entry in [`PANELS`].
//!
//! A panel is a function of the borrowed [`Model`]: it shows the model, and adds its requests to the list of commands.
//! It keeps only its view settings (a filter, a zoom) as its own state.

pub mod blend;
pub mod build;
pub mod control;
pub mod crowd;
pub mod database;
pub mod dock;
pub mod glitches;
pub mod graph;
pub mod hits;
pub mod keys;
pub mod messages;
pub mod paint;
pub mod patches;
pub mod plan;
pub mod policy;
pub mod report;
pub mod start;
pub mod statistics;
pub mod top_bar;
pub mod transport;
pub mod viewport;
pub mod words;

use crate::command::{Commands, ViewerCommand};
use crate::{bundle::OpenBundle, model::Model, render::Rgba, settings::PanelKind};
use eframe::egui::{Color32, DragValue, Key, Response, Ui};
use paint::PanelWidget;

/// A panel.
#[derive(Clone, Copy, Debug)]
pub struct PanelEntry {
    /// Which one.
    pub kind: PanelKind,
    /// Title of the panel.
    pub title: &'static str,
    /// Purpose, in a phrase.
    pub purpose: &'static str,
    /// Key that opens and closes it.
    pub key: Key,
    /// Shows it.
    pub show: fn(&mut Ui, &Model, &mut PanelStates, &mut Commands),
}

/// Says that no character is selected, and offers a button that selects the first one.
///
/// - `hint`: how to select one otherwise, up to the "or" before the button.
/// - `has_characters`: false leaves the button out.
fn offer_first_character(ui: &mut Ui, hint: &str, has_characters: bool, commands: &mut Commands) {
    ui.horizontal_wrapped(|ui| {
        ui.weak(hint);
        if has_characters {
            ui.small_button("select character 0").request(commands, ViewerCommand::SelectCharacter(Some(0)));
        }
    });
}

/// A field with the number of the selected character, which selects another one.
fn character_field(ui: &mut Ui, character: usize, num_characters: usize, commands: &mut Commands) -> Response {
    let mut number = character;
    let field = ui.add(DragValue::new(&mut number).range(0..=num_characters - 1));
    commands.extend(field.changed().then_some(ViewerCommand::SelectCharacter(Some(number))));
    field
}

/// Clip of a frame row, and the frame within it (row < number of frames).
fn clip_frame(bundle: &OpenBundle, row: u32) -> (usize, u32) {
    let clip = bundle.clip_of(row);
    (clip, row - bundle.tables().clips()[clip].first_frame)
}

/// Name of the clip of a frame row, and the time within it (row < number of frames).
fn moment(bundle: &OpenBundle, row: u32) -> String {
    let (clip, frame) = clip_frame(bundle, row);
    format!("{} {:.2} s", bundle.clip_name(clip), frame as f32 / bundle.rate_hz())
}

/// Shows a segment from its first frame on.
fn show_segment(bundle: &OpenBundle, segment: u32) -> ViewerCommand {
    let (clip, frame) = clip_frame(bundle, bundle.tables().graph().segments[segment as usize].start);
    ViewerCommand::ShowClip { clip, frame }
}

/// A colour of the 3-D view for a panel, opaque.
fn colour_of_view(colour: Rgba) -> Color32 {
    let [r, g, b, _] = colour.0;
    Color32::from_rgb(r, g, b)
}

/// Entry of a panel that keeps view settings.
macro_rules! panel {
    ($kind:ident, $state:ident, $key:ident, $title:literal, $purpose:literal) => {
        PanelEntry {
            kind: PanelKind::$kind,
            title: $title,
            purpose: $purpose,
            key: Key::$key,
            show: |ui, model, states, commands| $state::show(ui, model, &mut states.$state, commands),
        }
    };
}

/// All panels, in the order of their tabs.
pub const PANELS: &[PanelEntry] = &[
    panel! { Control, control, F1, "Control", "targets, behaviours, number of characters, seed" },
    panel! { Policy, policy, F2, "Policy",
    "what a state is worth for every place of the target, and why an action was taken" },
    PanelEntry {
        kind: PanelKind::Statistics,
        title: "Statistics",
        purpose: "time of a step and a frame, memory, foot slip, arrivals, blows",
        key: Key::F3,
        show: |ui, model, _, _| statistics::show(ui, model),
    },
    panel! { Graph, graph, F4, "Motion graph", "states, actions and where they lead; a click plays an action" },
    panel! { Database, database, F5, "Database", "clips, their contacts, tags, poses, and the actions from a frame" },
    panel! { Report, report, F6, "Import report", "what import found in a motion file; what a bundle was made of" },
    panel! { Hits, hits, F7, "Hits", "where blows land, from three sides; a click shows the clip" },
    panel! { Patches, patches, F8, "Patches",
    "worlds of motion patches: links of a patch, paths, orders, and units to move" },
    panel! { Blend, blend, F9, "Blend",
    "blend spaces: examples, weights and keytimes; drag the point, and a character walks there" },
    panel! { Crowd, crowd, F10, "Crowd", "agents of a scene: bounds, events, forces, event rates" },
    panel! { Plan, plan, F11, "Plan",
    "tasks of limbs: drag targets and obstacles, plan, compare motions, see the trees" },
];

/// A dialog of the system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SystemDialog {
    /// That chooses one or several files.
    Files,
    /// That chooses a folder.
    Folder,
    /// That chooses a character of the user's own.
    Body,
}

/// State of all panels.
#[derive(Clone, Default)]
pub struct PanelStates {
    /// The 3-D view.
    pub viewport: viewport::ViewportState,
    /// The motion graph.
    pub graph: graph::GraphPanelState,
    /// Policies.
    pub policy: policy::PolicyPanelState,
    /// Control.
    pub control: control::SceneControlState,
    /// The list of keys is shown.
    pub help: bool,
    /// The 3-D view is shown alone, without bars.
    pub bare: bool,
    /// A dialog of the system is wanted.
    pub dialog: Option<SystemDialog>,
    /// The start page.
    pub start: start::StartPageState,
    /// The database browser.
    pub database: database::DatabasePanelState,
    /// The import report.
    pub report: report::ReportPanelState,
    /// Effective hits.
    pub hits: hits::HitsPanelState,
    /// Worlds of motion patches.
    pub patches: patches::PatchesPanelState,
    /// Blend spaces.
    pub blend: blend::BlendPanelState,
    /// Scenes of crowds.
    pub crowd: crowd::CrowdPanelState,
    /// Tasks of limbs.
    pub plan: plan::PlanPanelState,
}

#[cfg(test)]
pub(crate) mod tests;
