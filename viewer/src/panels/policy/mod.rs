//! The policy: the value of a state for every place of the target, and why an action was taken.

mod chart;
mod heat;
mod map;
mod why;

use crate::command::{Commands, ViewerCommand};
use crate::run::{GoalSubject, explain_choice};
use crate::{bundle::OpenBundle, model::Model, panels::clip_frame, panels::paint::PanelWidget};
use eframe::egui::{ComboBox, Ui};
use glam::{Vec2, Vec3};
use heat::HeatPicture;
use throng_core::policy::PolicyTable;
pub(super) use why::behaviour_name;

/// View settings of the policy.
#[derive(Clone, Debug)]
pub struct PolicyPanelState {
    /// Pictures that are kept, one for each map.
    heats: Vec<HeatPicture>,
    arrows: bool,
    /// All heights side by side.
    slices: bool,
    /// The height, or time, that is shown alone; clamped to the last one.
    slice: u32,
    /// Candidates listed.
    shown: usize,
    /// Segment whose arrow is kept on the map.
    picked: Option<u32>,
    /// Segment whose row is under the pointer in this frame, and in the one before.
    hovered: Option<u32>,
    hovered_before: Option<u32>,
}

impl Default for PolicyPanelState {
    fn default() -> Self {
        Self {
            heats: Vec::new(),
            arrows: true,
            slices: true,
            slice: 0,
            shown: 6,
            picked: None,
            hovered: None,
            hovered_before: None,
        }
    }
}

/// Shows a behaviour's policy and the choice of the selected character.
pub fn show(ui: &mut Ui, model: &Model, state: &mut PolicyPanelState, commands: &mut Commands) {
    let Some(bundle) = model.document.bundle() else {
        return drop(ui.weak("Policies are part of a bundle; open one to see them."));
    };
    let number = model.selection.policy;
    let Some(policy) = bundle.motion_set.policy(number) else {
        return drop(ui.weak("This bundle has no behaviour. Build it from a config with `behaviours`."));
    };
    state.hovered_before = state.hovered.take();
    let character = model.selection.character;
    let chooser = character.and_then(|c| model.document.chooser(c));
    let why = chooser.as_ref().and_then(explain_choice);
    behaviour(ui, bundle, number, commands);
    facts(ui, bundle, policy, number);
    ui.separator();
    show_state(ui, model, bundle, commands);
    if let Some(looked_at) = model.inspected_state().filter(|&s| (s as usize) < policy.actions().num_states()) {
        let why = why.as_ref().filter(|w| w.state == looked_at);
        let then = why.and_then(|w| {
            w.behaviours.iter().find(|b| b.policy == number).map_or(Some(w.local_target), |b| coming_target(b.target))
        });
        let document = model.generation;
        state.slice = state.slice.min(policy.grid_of(looked_at).record().num_heights - 1);
        let targets = [local_target(model, number), then];
        let shown = map::PolicyMapInput { document, bundle, policy, number, state: looked_at, why, targets };
        map::show(ui, &shown, state);
    }
    ui.separator();
    why::show(ui, model, state, chooser.as_ref(), why.as_ref(), commands);
}

/// Time left from which on a blow is none that is coming (s).
const NEVER_S: f32 = 100.0;

/// A target, unless it stands for no coming blow.
fn coming_target(target: Vec3) -> Option<Vec3> {
    (target.y < NEVER_S).then_some(target)
}

/// Subject of a behaviour relative to the selected character, at present (m).
fn local_target(model: &Model, policy: usize) -> Option<Vec3> {
    let chooser = model.document.chooser(model.selection.character?)?;
    let is_threat = chooser.goals.iter().any(|g| g.policy == policy && g.subject == GoalSubject::Threat);
    let target = if is_threat { chooser.threat } else { Some(chooser.target) };
    let target = coming_target(target?)?;
    let local = chooser.characters.root(chooser.number).inverse_transform_point(Vec2::new(target.x, target.z));
    Some(Vec3::new(local.x, target.y, local.y))
}

fn behaviour(ui: &mut Ui, bundle: &OpenBundle, number: usize, commands: &mut Commands) {
    ComboBox::new("behaviour", "behaviour").selected_text(behaviour_name(bundle, number)).show_ui(ui, |ui| {
        for policy in 0..bundle.tables().policies().len() {
            let label = ui.selectable_label(policy == number, behaviour_name(bundle, policy));
            label.request(commands, ViewerCommand::SelectPolicy(policy));
        }
    });
}

fn facts(ui: &mut Ui, bundle: &OpenBundle, policy: &PolicyTable, number: usize) {
    let Some(record) = bundle.tables().policy_records().get(number) else { return };
    let grid = policy.grid();
    let g = grid.record();
    let third = if grid.is_space_time() { "times" } else { "heights" };
    let heights = if g.num_heights > 1 { format!(" × {} {third}", g.num_heights) } else { String::new() };
    let rate_hz = bundle.rate_hz();
    let half_life_s = 0.5f32.ln() / record.discount.ln() / rate_hz;
    let extent = format!("{} rings × {} angles{heights}, up to {:.1} m", g.num_rings, g.num_angles, grid.radius());
    let discount = format!("discount {:.4} a frame (halves in {half_life_s:.1} s)", record.discount);
    let solution = format!("{} sweeps, residual {:.1e}", record.num_sweeps, record.residual);
    ui.weak(format!("{extent}; {discount}; {solution}, within {:.1e} of the best values", record.epsilon));
}

/// The selected state, and how to select another.
fn show_state(ui: &mut Ui, model: &Model, bundle: &OpenBundle, commands: &mut Commands) {
    let graph = bundle.tables().graph();
    let Some(state) = model.inspected_state() else {
        ui.horizontal_wrapped(|ui| {
            ui.label("No state is selected: click one in the motion graph, or");
            ui.small_button("select state 0").request(commands, ViewerCommand::SelectState(Some(0)));
        });
        return;
    };
    let Some(record) = graph.states.get(state as usize) else { return };
    let (clip, frame) = clip_frame(bundle, record.frame);
    ui.horizontal_wrapped(|ui| {
        ui.strong(format!("State {state}"));
        ui.label(format!("{} {frame}", bundle.clip_name(clip)));
        if model.selection.state.is_none() {
            ui.weak("where the selected character last chose");
        } else if model.selection.character.is_some() {
            ui.small_button("follow the character").request(commands, ViewerCommand::SelectState(None));
        }
    });
}

#[cfg(test)]
mod tests;
