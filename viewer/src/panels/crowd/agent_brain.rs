//! Brain of the selected agent: its states, reasons, values and knowledge.

use super::selected_brain;
use crate::document::SceneDocument;
use crate::model::Model;
use crate::panels::paint::facts;
use eframe::egui::Ui;
use throng_simulation::scenario::AgentBrains;

/// Shows states, reason, values and knowledge of the selected agent.
pub fn show(ui: &mut Ui, model: &Model, scene: &SceneDocument, brains: &AgentBrains) {
    let Some(agent) = selected_brain(model, scene, brains) else {
        ui.weak("Select an agent.");
        return;
    };
    let why = brains.explain(agent, scene.run().simulation().time_s());
    let because = &why.because;
    let by = match (&because.rule, &because.edge_to) {
        (Some(rule), _) => format!(", rule \"{rule}\""),
        (None, Some(state)) => format!(", edge to {state}"),
        (None, None) => String::new(),
    };
    let with = because.other.map_or_else(String::new, |other| format!(" with {other}"));
    let at = because.place.as_ref().map_or_else(String::new, |place| format!(" at {place}"));
    facts(ui, "agent brain", false, |row| {
        let mut row = |name: &str, text: String| row(name, "", text.into());
        row("state", if why.states.is_empty() { "none".into() } else { why.states.join(" > ") });
        let nothing = if why.states.is_empty() { "follows its goal" } else { "nothing: its behaviour is over" };
        row("does", if why.action.is_empty() { nothing.into() } else { why.action.clone() });
        row("because", format!("{}{with}{at} at {:.1} s{by}", because.event, because.time_s));
        if let Some(place) = &why.slot_of {
            row("slot", place.clone());
        }
        for value in &why.values {
            row(&value.name, format!("{:.2}", value.value));
        }
        for known in &why.knows {
            let from = known.from.map_or_else(String::new, |from| format!(" by {from}"));
            row("knows", format!("{}, {}{from} at {:.1} s", known.event, known.how, known.time_s));
        }
    });
}
