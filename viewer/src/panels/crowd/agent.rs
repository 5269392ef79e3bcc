//! The selected agent: how it moves, when it acts next, the forces on it, and its brain.

use super::selected_brain;
use crate::command::{Commands, ViewerCommand};
use crate::panels::paint::{PanelWidget, facts, swatch};
use crate::panels::{character_field, colour_of_view, words};
use crate::run::agents::{AgentDetails, FORCE_TERMS, agent_details, first_agent};
use crate::stage::agents::{TAKEN, colour_of_force};
use crate::{document::SceneDocument, model::Model, render::Rgba};
use eframe::egui::{Color32, Grid, Rect, RichText, Sense, Ui, pos2, vec2};
use glam::Vec3;
use throng_base::thresholds::DIRECTION_SHOWN_MPS;
use throng_core::planar::wrap_angle;
use throng_simulation::scenario::AgentBrains;

/// Width of the bars of forces (points).
const BAR: f32 = 96.0;

/// Shows the agent.
pub fn show(ui: &mut Ui, model: &Model, scene: &SceneDocument, commands: &mut Commands) {
    let simulation = scene.run.simulation();
    let (n, first) = (simulation.num_characters(), first_agent(simulation).unwrap_or(0));
    let Some(who) = model.selection.character.filter(|&who| who < n) else {
        ui.horizontal_wrapped(|ui| {
            ui.weak("Click an agent in the view, or");
            let select = ui.small_button(format!("select agent {first}"));
            select.request(commands, ViewerCommand::SelectCharacter(Some(first)));
        });
        return;
    };
    ui.horizontal_wrapped(|ui| {
        let label = ui.label("number");
        character_field(ui, who, n, commands).labelled_by(label.id);
        ui.label(super::agent_name(scene, who));
        ui.small_button("none").request(commands, ViewerCommand::SelectCharacter(None));
    });
    let Some(details) = agent_details(simulation, who) else {
        ui.label(match simulation.root(who) {
            Some(_) => "It is no agent: it is not in the crowd.",
            None => "It has left the crowd.",
        });
        return;
    };
    motion(ui, simulation.time_s(), &details);
    ui.add_space(4.0);
    forces(ui, &details);
}

fn motion(ui: &mut Ui, time_s: f64, d: &AgentDetails) {
    facts(ui, "agent", false, |row| {
        let speed = d.velocity.length();
        row("speed", "Now, and desired", format!("{speed:.2} m/s, {:.2} wanted", d.speed).into());
        row("distance left", "Along its route", format!("{:.2} m", d.route_left).into());
        let bound = format!("{:.2} m, {:.2} m of it grown", d.bound_radius, d.bound_radius - d.radius);
        row("bound", "Radius of its time-varying bound now", bound.into());
        let [last, next] = d.events;
        let tip = "Its last event, and its next one unless another agent causes one earlier";
        row("acts", tip, format!("{:.0} ms ago, in {:.0} ms", 1e3 * (time_s - last), 1e3 * (next - time_s)).into());
    });
}

/// A table of all terms: colour, name, a bar, a number and where it points.
fn forces(ui: &mut Ui, d: &AgentDetails) {
    let dark = ui.visuals().dark_mode;
    let ahead = if d.velocity.length() > DIRECTION_SHOWN_MPS { d.velocity } else { d.desired };
    ui.weak(format!("Forces in m/s², of at most {:.1}; directions from where it goes", d.limit));
    let sum: Vec3 = d.forces.iter().sum();
    let rows = FORCE_TERMS.iter().zip(d.forces).enumerate();
    Grid::new("forces").num_columns(4).spacing([8.0, 2.0]).show(ui, |ui| {
        for (i, ((name, tip, _), force)) in rows {
            row(ui, (name, tip), colour_of_view(colour_of_force(i, dark)), force, (ahead, d.limit));
        }
        row(ui, ("sum", "All terms together"), ui.visuals().weak_text_color(), sum, (ahead, d.limit));
        let taken = colour_of_view(Rgba::hex(TAKEN[usize::from(!dark)]));
        let tip = "The acceleration that it took at its last event, after the safety rule";
        row(ui, ("taken", tip), taken, d.taken, (ahead, d.limit));
    });
}

fn row(ui: &mut Ui, (name, tip): (&str, &str), colour: Color32, force: Vec3, (ahead, limit): (Vec3, f32)) {
    ui.horizontal(|ui| {
        swatch(ui, colour);
        ui.label(name).on_hover_text(tip);
    });
    let (rect, _) = ui.allocate_exact_size(vec2(BAR, 12.0), Sense::hover());
    let painter = ui.painter();
    painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
    let share = (force.length() / limit.max(1e-6)).min(1.0);
    let bar = Rect::from_min_max(rect.min, pos2(rect.left() + share * rect.width(), rect.bottom()));
    painter.rect_filled(bar, 2.0, colour);
    ui.label(RichText::new(format!("{:>6.2}", force.length())).monospace());
    ui.label(if force.length() < 5e-3 { String::new() } else { direction(force, ahead) });
    ui.end_row();
}

/// Direction of a force relative to the heading; up or down where that is most of it.
fn direction(force: Vec3, ahead: Vec3) -> String {
    if force.y.abs() > 0.8 * force.length() {
        return if force.y > 0.0 { "up".into() } else { "down".into() };
    }
    let heading = |v: Vec3| v.x.atan2(v.z);
    words::direction(wrap_angle(heading(force) - heading(ahead)))
}

/// Shows states, reason, values and knowledge of the selected agent.
pub fn show_brain(ui: &mut Ui, model: &Model, scene: &SceneDocument, brains: &AgentBrains) {
    let Some(agent) = selected_brain(model, scene, brains) else { return drop(ui.weak("Select an agent.")) };
    let why = brains.explain(agent, scene.run.simulation().time_s());
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
        why.values.iter().for_each(|value| row(&value.name, format!("{:.2}", value.value)));
        for known in &why.knows {
            let from = known.from.map_or_else(String::new, |from| format!(" by {from}"));
            row("knows", format!("{}, {}{from} at {:.1} s", known.event, known.how, known.time_s));
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_relative_to_the_movement() {
        // Who walks along +Z has +X at the left.
        assert_eq!(direction(Vec3::X, Vec3::Z), "90° to the left");
        assert_eq!(direction(Vec3::Z, Vec3::X), "90° to the right");
        assert_eq!(direction(-Vec3::Z, Vec3::Z), "straight behind");
        assert_eq!(direction(Vec3::new(0.1, -1.0, 0.0), Vec3::Z), "down");
    }
}
