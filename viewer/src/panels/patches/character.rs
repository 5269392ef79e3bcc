//! The selected inhabitant: its activity, its planned path, and its orders.

use super::{PatchesPanelState, facts::unit};
use crate::command::{Commands, SceneCommand, ViewerCommand};
use crate::document::{SceneChoice, WorldDocument};
use crate::panels::paint::{PanelWidget, facts};
use crate::panels::{character_field, colour_of_view, offer_first_character, words};
use crate::{model::Model, run::RunInput, stage::world::KINDS};
use eframe::egui::text::LayoutJob;
use eframe::egui::{Align, DragValue, FontSelection, Label, RichText, Ui};
use throng_world::inhabitants::{InhabitantActivity, InhabitantGoal};

/// Default duration of an action (s).
const PERFORM_S: f32 = 10.0;

/// Shows the character that is selected.
pub fn show(ui: &mut Ui, model: &Model, world: &WorldDocument, state: &mut PatchesPanelState, commands: &mut Commands) {
    population(ui, world, state, commands);
    let run = &world.run;
    let Some(c) = model.selection.character.filter(|&c| c < run.num_characters()) else {
        let has_characters = run.num_characters() > 0;
        return offer_first_character(ui, "Click a character in the 3-D view, or", has_characters, commands);
    };
    ui.horizontal_wrapped(|ui| {
        ui.strong("Character");
        character_field(ui, c, run.num_characters(), commands);
        ui.weak(if run.order_of(c).is_some() { "follows its order" } else { "decides for itself" });
    });
    status(ui, world, c);
    show_orders(ui, world, c, state, commands);
}

fn population(ui: &mut Ui, world: &WorldDocument, state: &mut PatchesPanelState, commands: &mut Commands) {
    let run = &world.run;
    ui.horizontal_wrapped(|ui| {
        let mut n = state.characters.unwrap_or(run.num_characters());
        let field = DragValue::new(&mut n).range(1..=20_000).update_while_editing(false);
        let field = ui.add_enabled(world.working.is_none(), field);
        field.clone().on_hover_text("As many as there is room for, each on units of its own; restarts the world");
        state.characters = field.dragged().then_some(n);
        if !field.dragged() && n != run.num_characters() {
            let choice = SceneChoice { characters: n, ..world.choice };
            commands.push(ViewerCommand::Scene(SceneCommand::Restart(choice)));
        }
        ui.label("characters");
        let states = &run.reel.moment().states;
        let waiting = states.iter().filter(|m| m.activity == InhabitantActivity::Waiting).count();
        let done: u32 = states.iter().map(|m| m.num_fulfilled).sum();
        let tip = format!("The last step of all of them took {:.2} ms", 1e3 * run.step_s);
        ui.weak(format!("{waiting} wait · {done} orders done")).on_hover_text(tip);
    });
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        for (_, name, colour) in KINDS {
            let mut text = LayoutJob::default();
            for part in [RichText::new("■ ").color(colour_of_view(colour)), RichText::new(name).weak()] {
                part.append_to(&mut text, ui.style(), FontSelection::Default, Align::Center);
            }
            // The name stays in the row of its colour.
            ui.add(Label::new(text).extend());
        }
    });
}

fn status(ui: &mut Ui, world: &WorldDocument, c: usize) {
    let run = &world.run;
    let seen = run.reel.moment().states[c];
    let tags = &world.bundle().tables().meta().link_tags;
    let (inhabitants, id) = (&run.inhabitants, run.id(c));
    facts(ui, "character", true, |row| {
        let mut row = |name: &str, value: String| row(name, "", value.into());
        row("is to", words::goal(seen.goal, tags));
        row("now", words::inhabitant_activity(&seen));
        row("patch", format!("{} ({})", world.patch_name(seen.node.instance), seen.node.instance));
        if !run.reel.head.is_live() {
            row("way", "known at the last step only".into());
            return;
        }
        let rate = world.bundle().rate_hz();
        let path_steps = inhabitants.path_steps(id).unwrap_or_default();
        match inhabitants.last_plan(id).ok().flatten() {
            Some(p) => {
                let (seconds, num_left) = (p.num_frames as f32 / rate, path_steps.len());
                let way = format!("{:.1} m, {seconds:.1} s, {} steps; {num_left} of it left", p.length_m, p.num_steps);
                row("way", way);
                row("planning", format!("opened {} instances, {} nodes", p.opened_instances, p.opened_nodes));
            }
            None => row("way", "no path is planned".into()),
        }
        let held: Vec<String> = inhabitants.units_of(id).into_iter().flatten().map(|u| unit(world, u)).collect();
        row("holds", held.join(", "));
        if let Some(step) = path_steps.first().filter(|_| seen.activity == InhabitantActivity::Waiting) {
            let wanted = world.graph().resources(step.to.instance).iter();
            let others = wanted.filter_map(|&u| Some((u, inhabitants.holder(u).filter(|&h| h != id)?.index())));
            let text: Vec<String> =
                others.map(|(u, holder)| format!("{}, which {holder} holds", unit(world, u))).collect();
            row("waits for", if text.is_empty() { "units farther along its path".into() } else { text.join("; ") });
        }
    });
}

fn show_orders(ui: &mut Ui, world: &WorldDocument, c: usize, state: &mut PatchesPanelState, commands: &mut Commands) {
    let order = |goal| ViewerCommand::Input(RunInput::Goal { character: c, goal });
    ui.horizontal_wrapped(|ui| {
        let roam = ui.button("Roam").on_hover_text("Wander about until it gets another order");
        roam.request(commands, order(Some(InhabitantGoal::Roam)));
        if world.run.order_of(c).is_some() {
            let let_go = ui.button("Let go").on_hover_text("It decides for itself again, as the scene says");
            let_go.request(commands, order(None));
        }
        let tags = &world.bundle().tables().meta().link_tags;
        if tags.is_empty() {
            return;
        }
        let seconds = state.seconds.get_or_insert(PERFORM_S);
        for (t, tag) in tags.iter().enumerate() {
            let tip = format!("Go to the nearest place where motion is tagged {tag}, and do that");
            let goal = InhabitantGoal::Perform { tag: t as u16 + 1, seconds: *seconds };
            ui.button(tag).on_hover_text(tip).request(commands, order(Some(goal)));
        }
        ui.label("for");
        ui.add(DragValue::new(seconds).range(0.0..=600.0).speed(0.2).suffix(" s"));
    });
    ui.weak("Ctrl + click sends it somewhere.");
}
