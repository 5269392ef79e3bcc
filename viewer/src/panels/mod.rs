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

use crate::command::Command;
use crate::model::Model;
use crate::settings::PanelKind;
use eframe::egui::{Key, Ui};

/// A panel.
#[derive(Clone, Copy, Debug)]
pub struct Panel {
    /// Which one.
    pub kind: PanelKind,
    /// Title of the panel.
    pub title: &'static str,
    /// Purpose, in a phrase.
    pub purpose: &'static str,
    /// Key that opens and closes it.
    pub key: Key,
    /// Shows it.
    pub show: fn(&mut Ui, &Model, &mut PanelStates, &mut Vec<Command>),
}

/// All panels, in the order of their tabs.
pub const PANELS: &[Panel] = &[
    Panel {
        kind: PanelKind::Control,
        title: "Control",
        purpose: "targets, behaviours, number of characters, seed",
        key: Key::F1,
        show: |ui, model, states, commands| control::show(ui, model, &mut states.control, commands),
    },
    Panel {
        kind: PanelKind::Policy,
        title: "Policy",
        purpose: "what a state is worth for every place of the target, and why an action was taken",
        key: Key::F2,
        show: |ui, model, states, commands| policy::show(ui, model, &mut states.policy, commands),
    },
    Panel {
        kind: PanelKind::Statistics,
        title: "Statistics",
        purpose: "time of a step and a frame, memory, foot slip, arrivals, blows",
        key: Key::F3,
        show: |ui, model, _, _| statistics::show(ui, model),
    },
    Panel {
        kind: PanelKind::Graph,
        title: "Motion graph",
        purpose: "states, actions and where they lead; a click plays an action",
        key: Key::F4,
        show: |ui, model, states, commands| graph::show(ui, model, &mut states.graph, commands),
    },
    Panel {
        kind: PanelKind::Database,
        title: "Database",
        purpose: "clips, their contacts, tags, poses, and the actions from a frame",
        key: Key::F5,
        show: |ui, model, states, commands| database::show(ui, model, &mut states.database, commands),
    },
    Panel {
        kind: PanelKind::Report,
        title: "Import report",
        purpose: "what import found in a motion file; what a bundle was made of",
        key: Key::F6,
        show: |ui, model, states, commands| report::show(ui, model, &mut states.report, commands),
    },
    Panel {
        kind: PanelKind::Hits,
        title: "Hits",
        purpose: "where blows land, from three sides; a click shows the clip",
        key: Key::F7,
        show: |ui, model, states, commands| hits::show(ui, model, &mut states.hits, commands),
    },
    Panel {
        kind: PanelKind::Patches,
        title: "Patches",
        purpose: "worlds of motion patches: links of a patch, paths, orders, and units to move",
        key: Key::F8,
        show: |ui, model, states, commands| patches::show(ui, model, &mut states.patches, commands),
    },
    Panel {
        kind: PanelKind::Blend,
        title: "Blend",
        purpose: "blend spaces: examples, weights and keytimes; drag the point, and a character walks there",
        key: Key::F9,
        show: |ui, model, states, commands| blend::show(ui, model, &mut states.blend, commands),
    },
    Panel {
        kind: PanelKind::Crowd,
        title: "Crowd",
        purpose: "agents of a scene: bounds, events, forces, event rates",
        key: Key::F10,
        show: |ui, model, states, commands| crowd::show(ui, model, &mut states.crowd, commands),
    },
    Panel {
        kind: PanelKind::Plan,
        title: "Plan",
        purpose: "tasks of limbs: drag targets and obstacles, plan, compare motions, see the trees",
        key: Key::F11,
        show: |ui, model, states, commands| plan::show(ui, model, &mut states.plan, commands),
    },
];

/// A dialog of the system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dialog {
    /// That chooses one or several files.
    Files,
    /// That chooses a folder.
    Folder,
    /// That chooses a character of the user's own.
    Body,
}

/// State of all panels.
#[derive(Clone, Debug, Default)]
pub struct PanelStates {
    /// The 3-D view.
    pub viewport: viewport::State,
    /// The motion graph.
    pub graph: graph::State,
    /// Policies.
    pub policy: policy::State,
    /// Control.
    pub control: control::State,
    /// The list of keys is shown.
    pub help: bool,
    /// The 3-D view is shown alone, without bars.
    pub bare: bool,
    /// A dialog of the system is wanted.
    pub dialog: Option<Dialog>,
    /// The start page.
    pub start: start::State,
    /// The database browser.
    pub database: database::State,
    /// The import report.
    pub report: report::State,
    /// Effective hits.
    pub hits: hits::State,
    /// Worlds of motion patches.
    pub patches: patches::State,
    /// Blend spaces.
    pub blend: blend::State,
    /// Scenes of crowds.
    pub crowd: crowd::State,
    /// Tasks of limbs.
    pub plan: plan::State,
}

impl PanelKind {
    /// Entry of the panel in [`PANELS`].
    pub fn panel(self) -> Option<&'static Panel> {
        PANELS.iter().find(|p| p.kind == self)
    }
}

#[cfg(test)]
pub(crate) mod tests;
