//! What agents live by: why the selected one does what it does, and how news spread.

use crate::command::Command;
use crate::document::SceneDocument;
use crate::model::Model;
use crate::run::Input;
use crate::run::agents::first_agent;
use eframe::egui::{Grid, Ui};
use throng_runtime::simulation::scenario::Minds;

/// Shows states, reason, values and knowledge of the selected agent.
pub fn show_agent(ui: &mut Ui, model: &Model, scene: &SceneDocument, minds: &Minds) {
    let first = first_agent(scene.run().simulation()).unwrap_or(0);
    let Some(agent) = model.selection.character.and_then(|who| who.checked_sub(first)).filter(|a| *a < minds.len())
    else {
        ui.weak("Select an agent.");
        return;
    };
    let why = minds.explain(agent);
    let because = &why.because;
    let by = match (&because.rule, &because.edge_to) {
        (Some(rule), _) => format!(", rule \"{rule}\""),
        (None, Some(state)) => format!(", edge to {state}"),
        (None, None) => String::new(),
    };
    let with = because.other.map_or_else(String::new, |other| format!(" with {other}"));
    let at = because.place.as_ref().map_or_else(String::new, |place| format!(" at {place}"));
    Grid::new("mind").num_columns(2).spacing([14.0, 3.0]).show(ui, |ui| {
        let mut row = |name: &str, text: String| {
            ui.label(name);
            ui.label(text);
            ui.end_row();
        };
        row("state", if why.states.is_empty() { "none".into() } else { why.states.join(" > ") });
        row("does", if why.action.is_empty() { "follows its goal".into() } else { why.action.clone() });
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

/// Shows how every event has spread, and lets it happen.
pub fn show_news(ui: &mut Ui, minds: &Minds, commands: &mut Vec<Command>) {
    Grid::new("news").num_columns(4).spacing([14.0, 3.0]).show(ui, |ui| {
        for spread in minds.spread() {
            ui.label(&spread.event);
            ui.label(format!("{} know", spread.informed)).on_hover_text("Agents who know of it");
            ui.label(format!("{} told", spread.told)).on_hover_text("Agents who were told of it by another one");
            let tip = "Lets it happen now; what was recorded after the step shown is dropped";
            if ui.small_button("happen").on_hover_text(tip).clicked() {
                commands.push(Command::Input(Input::Event(spread.event)));
            }
            ui.end_row();
        }
    });
    for (state, count) in minds.in_states() {
        ui.weak(format!("{count} in {state}"));
    }
}
