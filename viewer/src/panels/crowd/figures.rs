//! Figures of all agents.

use crate::document::SceneDocument;
use crate::panels::paint::{facts, time_text};
use crate::theme::ThemePalette;
use eframe::egui::{RichText, Ui};
use throng_simulation::AnyCharacterGroup;

/// Shows figures of the moment shown.
pub fn show(ui: &mut Ui, scene: &SceneDocument) {
    let simulation = scene.run.simulation();
    let Some(f) = scene.run.figures().agents else { return };
    let discs = (0..simulation.num_characters()).filter_map(|who| simulation.disc(who));
    let speed = discs.map(|d| f64::from(d.velocity.length())).sum::<f64>() / f.present.max(1) as f64;
    let speeds: Vec<f64> = simulation.character_groups().iter().flat_map(desired_speeds).collect();
    let n = speeds.len();
    let desired = speeds.iter().sum::<f64>() / n.max(1) as f64;
    let palette = ThemePalette::for_visuals(ui.visuals());
    let good = |is_good: bool| if is_good { palette.good } else { palette.warning };
    facts(ui, "now", false, |row| {
        row("simulated", "Since the start of the scene", RichText::new(time_text(simulation.time_s())));
        let left = if f.present < n { format!(", {} have left", n - f.present) } else { String::new() };
        row("agents", "Who is there", RichText::new(format!("{}{left}", f.present)));
        let tip = "Mean speed along planned paths so far, of agents not yet at their goals";
        row("progress", tip, RichText::new(format!("{:.2} m/s, {desired:.2} wanted", f.progress_mps)));
        row("speed now", "Mean of all agents", RichText::new(format!("{speed:.2} m/s")));
        let overlaps = RichText::new(format!("{} pairs over 1 mm", f.overlaps)).color(good(f.overlaps == 0));
        row("overlaps", "Pairs that overlap now", overlaps);
        let deepest = if f.deepest_m > 0.0 { format!("{:.2} mm", 1e3 * f.deepest_m) } else { "none so far".into() };
        row("deepest", "The deepest overlap so far", RichText::new(deepest).color(good(f.deepest_m <= 1e-3)));
        row("arrived", "Agents that have reached their goals", RichText::new(format!("{} of {n}", f.arrived)));
        let stuck = RichText::new(f.stuck.to_string()).color(good(f.stuck == 0));
        row("stuck", "Agents that moved less than half a metre in 10 s on their way, or came no nearer in 20 s", stuck);
    });
}

/// Desired speeds of the agents among characters, at their start (m/s).
fn desired_speeds(group: &AnyCharacterGroup) -> Vec<f64> {
    match group {
        AnyCharacterGroup::Ground(agents) => agents.layout().setup.agents.iter().map(|a| f64::from(a.speed)).collect(),
        AnyCharacterGroup::Air(agents) => agents.layout().setup.agents.iter().map(|a| f64::from(a.speed)).collect(),
        _ => Vec::new(),
    }
}
