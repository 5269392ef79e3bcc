//! The state of steering and the delay of keys, in a line over the 3-D view.

use super::pad::Pad;
use super::show_caption;
use crate::command::{Commands, SteerCommand, SteerInput, ViewerCommand};
use crate::model::Model;
use eframe::egui::{Context, Key, Modifiers, Rect, Ui, vec2};

/// Takes the steering keys out of the input; while no direction is held down, the input of a pad counts.
pub fn keys(ctx: &Context, model: &Model, pad: Option<Pad>, commands: &mut Commands) {
    if pad.is_some_and(|p| p.toggles) {
        commands.push(ViewerCommand::Steer(SteerCommand::Toggle));
    }
    let Some(steering) = model.steering() else { return };
    let held = ctx.input(|i| {
        let axis = |more: Key, less: Key| f32::from(i8::from(i.key_down(more)) - i8::from(i.key_down(less)));
        SteerInput { ahead: axis(Key::W, Key::S), aside: axis(Key::D, Key::A), runs: i.modifiers.shift }
    });
    // Without a direction, Shift does not matter.
    let held = if held.moves() { held } else { pad.map_or(SteerInput::default(), |p| p.input) };
    if held != steering.input {
        commands.push(ViewerCommand::Steer(SteerCommand::Hold(held)));
    }
    for key in [Key::W, Key::A, Key::S, Key::D] {
        ctx.input_mut(|i| [Modifiers::NONE, Modifiers::SHIFT].map(|m| i.consume_key(m, key)));
    }
    if ctx.input_mut(|i| i.consume_key(Modifiers::NONE, Key::X)) || pad.is_some_and(|p| p.strikes) {
        commands.push(ViewerCommand::Steer(SteerCommand::Strike));
    }
}

/// Shows the state of steering, at the lower left.
pub fn show(ui: &Ui, rect: Rect, model: &Model) {
    let Some(steering) = model.steering() else { return };
    let mut text = "Steering: W A S D, Shift runs, X strikes, G ends".to_owned();
    if let (Some(last), Some((median, p95))) = (steering.lags.last(), steering.lags.median_and_p95()) {
        let (count, unseen) = steering.lags.count();
        text += &format!("\nfrom key to change: {last} frames, median {median}, 95 % {p95}, of {count} keys");
        if unseen > 0 {
            text += &format!("; {unseen} without effect");
        }
    }
    show_caption(ui, rect, text, 0.8, |size| rect.left_bottom() + vec2(16.0, -size.y - 14.0));
}
