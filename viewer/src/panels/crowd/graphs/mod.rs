//! The state-transition graphs of the selected agent, level by level: its states, and the edges that it took last.

mod layout;
mod paint;
mod route;

use super::selected_brain;
use crate::document::SceneDocument;
use crate::model::Model;
use crate::run::agents::{StateEntry, first_agent};
use eframe::egui::Ui;
use layout::StateGraphShape;
use throng_simulation::scenario::{AgentBrains, CurrentState};
use throng_simulation::scene::{EdgeConfig, StateGraphConfig};

/// Levels by their names, the highest first.
const LEVELS: [&str; 3] = ["social", "spatial", "primitive"];

/// Shows the graphs that the selected agent is in.
pub fn show(ui: &mut Ui, model: &Model, scene: &SceneDocument, brains: &AgentBrains) {
    let simulation = scene.run.simulation();
    let first = first_agent(simulation).unwrap_or(0);
    let Some(agent) = selected_brain(model, scene, brains) else {
        return drop(ui.weak("Select an agent."));
    };
    let states = brains.states_of(agent);
    if states.iter().all(Option::is_none) {
        return drop(ui.weak("It is in no state: it follows its goal and rules."));
    }
    for (level, now) in states.iter().enumerate() {
        let entry = scene.run.entry(first + agent, level);
        let graph = now.and_then(|now| Some((now, simulation.scene().graphs.get(now.graph)?)));
        match graph {
            Some((now, graph)) => show_graph(ui, level, now, graph, entry),
            None => drop(ui.weak(format!("{}: no graph in this state", LEVELS[level]))),
        }
    }
}

/// Shows one graph, and how the agent came to its state.
fn show_graph(ui: &mut Ui, level: usize, now: CurrentState<'_>, graph: &StateGraphConfig, entry: Option<StateEntry>) {
    let since = entry.and_then(|e| e.since_s).map_or_else(String::new, |s| format!(", since {s:.1} s"));
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        ui.strong(LEVELS[level]);
        ui.label(format!("{}: {}{since}", now.graph, now.state));
    });
    if let Some(above) = entry.and_then(|e| e.began_with) {
        ui.weak(format!("began anew as the {} state changed", LEVELS[above]));
    }
    let taken = entry.and_then(|e| e.edge).filter(|(edge, _)| *edge < graph.edges.len());
    let marks = paint::StateGraphMarks {
        now: graph.states.keys().position(|s| s == now.state),
        taken: taken.map(|t| t.0),
        is_anew: entry.is_some_and(|e| e.began_with.is_some()),
    };
    paint::show(ui, now.graph, graph, &StateGraphShape::from_config(graph), marks);
    if let Some((edge, at_s)) = taken {
        let stays = if graph.edges[edge].to == now.state { "" } else { " (before)" };
        ui.label(format!("took at {at_s:.1} s{stays}: {}", in_words(&graph.edges[edge])));
    }
    ui.add_space(4.0);
}

/// An edge as the scene file has it, in a line.
fn in_words(edge: &EdgeConfig) -> String {
    let from = edge.from.as_deref().unwrap_or("any state");
    let when = edge.when.as_ref().map_or_else(String::new, |w| format!(", when {w}"));
    let by_chance = edge.probability.map_or_else(String::new, |p| format!(", probability {p}"));
    format!("{from} > {}, on {}{when}{by_chance}", edge.to, edge.on)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_edge_is_told_with_its_predicate_and_probability() {
        let edge = EdgeConfig {
            from: Some("walk".into()),
            to: "bread".into(),
            on: "enters".into(),
            when: Some("place.free > 0".into()),
            probability: Some(0.3),
            alone: false,
        };
        assert_eq!(in_words(&edge), "walk > bread, on enters, when place.free > 0, probability 0.3");
        let any = EdgeConfig { from: None, when: None, probability: None, ..edge };
        assert_eq!(in_words(&any), "any state > bread, on enters");
    }
}
