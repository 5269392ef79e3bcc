//! Blackboards: entries on the global one and on those of cells, with author and end.

use super::{options_command, swatch};
use crate::command::{BlackboardCell, BlackboardFilter, Commands, ViewerCommand};
use crate::{document::SceneDocument, model::Model, panels::colour_of_view, panels::paint::PanelWidget};
use crate::{run::agents::first_agent, stage::agents::colour_of_message};
use eframe::egui::{Role, ScrollArea, TextStyle, Ui};
use throng_simulation::scenario::{AgentBrains, BlackboardPost};

/// Height of the list (points).
const HEIGHT: f32 = 120.0;

/// Shows the choice of levels and the list of entries.
pub fn show(ui: &mut Ui, model: &Model, scene: &SceneDocument, brains: &AgentBrains, commands: &mut Commands) {
    let now = model.selection.scene;
    if let Some((side_m, levels)) = brains.blackboard_levels() {
        ui.horizontal_wrapped(|ui| {
            ui.label("cells").on_hover_text("Cells on whose boards something is written are tinted on the floor");
            let named = (0..levels).map(|l| (BlackboardFilter::Level(l), format!("{} m", side_m * (1 << l) as f32)));
            let others = [(BlackboardFilter::Nothing, "none".into()), (BlackboardFilter::All, "all".into())];
            for (blackboards, text) in others.into_iter().chain(named) {
                let label = ui.selectable_label(now.blackboards == blackboards, &text);
                let label = label.named(Role::RadioButton, format!("board cells: {text}"));
                label.request(commands, options_command(model, |l| (l.blackboards, l.cell) = (blackboards, None)));
            }
        });
    }
    if let Some(cell) = now.cell {
        ui.horizontal(|ui| {
            ui.label(format!("cell {} of level {}", cell_text(cell), cell.level));
            ui.small_button("all cells").request(commands, options_command(model, |l| l.cell = None));
        });
    }
    let entries: Vec<BlackboardPost> = brains.posts().filter(|p| is_listed(p, now.blackboards, now.cell)).collect();
    if entries.is_empty() {
        return drop(ui.weak("Nothing is written."));
    }
    let height = ui.text_style_height(&TextStyle::Body) + 3.0;
    let area = ScrollArea::vertical().id_salt("boards").max_height(HEIGHT).auto_shrink([false, true]);
    area.show_rows(ui, height, entries.len(), |ui, rows| {
        for entry in &entries[rows] {
            let cell = entry.cell.map(|c| BlackboardCell::from_cell(&c));
            ui.horizontal(|ui| {
                swatch(ui, colour_of_view(colour_of_message(entry.event)));
                let place = cell.map_or_else(|| "global".into(), |c| format!("cell {}", cell_text(c)));
                let text = format!("{place}: {}", in_words(scene, brains, entry));
                let label = ui.selectable_label(cell.is_some() && cell == now.cell, &text);
                // A click reads the blackboard of the entry, and selects its author.
                if label.named(Role::Button, format!("Entry {text}")).clicked() {
                    commands.push(options_command(model, |l| l.cell = cell));
                    let first = first_agent(scene.run.simulation()).unwrap_or(0);
                    commands.extend(entry.by.map(|by| ViewerCommand::SelectCharacter(Some(first + by))));
                }
            });
        }
    });
}

fn is_listed(entry: &BlackboardPost, blackboards: BlackboardFilter, cell: Option<BlackboardCell>) -> bool {
    let of = entry.cell.map(|c| BlackboardCell::from_cell(&c));
    match (cell, blackboards) {
        (Some(_), _) => of == cell,
        (None, BlackboardFilter::Nothing) => of.is_none(),
        (None, BlackboardFilter::All) => true,
        (None, BlackboardFilter::Level(level)) => of.is_none_or(|of| of.level == level),
    }
}

fn cell_text(cell: BlackboardCell) -> String {
    format!("{}, {}", cell.at[0], cell.at[1])
}

/// Text of an entry: content, author, time, and end.
pub fn in_words(scene: &SceneDocument, brains: &AgentBrains, entry: &BlackboardPost) -> String {
    let simulation = scene.run.simulation();
    let first = first_agent(simulation).unwrap_or(0);
    let by =
        entry.by.map_or_else(|| "as it happened".into(), |by| format!("by {}", super::agent_name(scene, first + by)));
    let until = match entry.until_s {
        until if until.is_finite() => format!("for {:.1} s more", until - simulation.time_s()),
        _ => "for good".into(),
    };
    format!("{}, {by} at {:.1} s, {until}", brains.event_names()[entry.event], entry.since_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_simulation::scenario::BlackboardArea;

    #[test]
    fn entries_of_the_level_or_of_the_cell_that_is_looked_at_are_listed() {
        let cell = |level, middle| Some(BlackboardArea { level, middle, side_m: 4.0 * (1 << level) as f32 });
        let entry = |cell| BlackboardPost { event: 0, cell, by: None, since_s: 0.0, until_s: 9.0 };
        let all = [entry(None), entry(cell(0, [2.0, -2.0])), entry(cell(0, [6.0, -2.0])), entry(cell(2, [8.0, 8.0]))];
        let listed = |blackboards, cell| all.map(|e| is_listed(&e, blackboards, cell));
        assert_eq!(listed(BlackboardFilter::All, None), [true; 4]);
        assert_eq!(listed(BlackboardFilter::Nothing, None), [true, false, false, false]);
        assert_eq!(listed(BlackboardFilter::Level(2), None), [true, false, false, true]);
        let second = BlackboardCell { level: 0, at: [1, -1] };
        assert_eq!(listed(BlackboardFilter::All, Some(second)), [false, false, true, false]);
    }
}
