//! The state of steering and the delay of keys, in a line over the 3-D view.

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

/// Dead zone: smaller deflections count as none, since sticks do not return exactly to the middle.
const DEAD: f32 = 0.25;
/// Farther out than this one runs, as with the trigger.
const RUNS: f32 = 0.95;
/// Steps to which deflections are rounded, so that a trembling hand does not change the input in every frame.
const STEPS: f32 = 8.0;

/// Requests of a pad in a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pad {
    /// Input that is held down.
    pub input: SteerInput,
    /// Strike.
    pub strikes: bool,
    /// Take over the selected character, or release it.
    pub toggles: bool,
}

/// Input of a stick.
///
/// - `x`, `y`: to the right and ahead (-1 to 1); `trigger`: pressure (0 to 1).
pub fn stick_input(x: f32, y: f32, trigger: f32) -> SteerInput {
    let length = x.hypot(y);
    if length.is_nan() || length <= DEAD {
        return SteerInput::default();
    }
    let step = |v: f32| (v * STEPS).round() / STEPS;
    SteerInput { ahead: step(y), aside: step(x), runs: trigger > 0.5 || length > RUNS }
}

/// The pads that are plugged in.
#[derive(Default)]
pub struct Pads {
    #[cfg(feature = "gamepad")]
    all: Option<gilrs::Gilrs>,
    #[cfg(feature = "gamepad")]
    tried: bool,
}

impl Pads {
    /// Requests since the last frame; none without a pad.
    #[cfg(not(feature = "gamepad"))]
    pub fn read(&mut self) -> Option<Pad> {
        None
    }

    /// Requests since the last frame; none without a pad.
    #[cfg(feature = "gamepad")]
    pub fn read(&mut self) -> Option<Pad> {
        use gilrs::{Axis, Button, EventType};
        if !std::mem::replace(&mut self.tried, true) {
            // A system without any support for pads has none.
            self.all = gilrs::Gilrs::new().ok();
        }
        let all = self.all.as_mut()?;
        let mut pad = Pad::default();
        while let Some(event) = all.next_event() {
            match event.event {
                EventType::ButtonPressed(Button::South, _) => pad.strikes = true,
                EventType::ButtonPressed(Button::Start, _) => pad.toggles = true,
                _ => {}
            }
        }
        let (_, first) = all.gamepads().next()?;
        let pressed = |button| first.button_data(button).map_or(0.0, |b| b.value());
        let trigger = pressed(Button::RightTrigger2).max(pressed(Button::RightTrigger));
        pad.input = stick_input(first.value(Axis::LeftStickX), first.value(Axis::LeftStickY), trigger);
        Some(pad)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sticks_lead_where_they_point_and_rest_in_the_middle() {
        assert_eq!(stick_input(0.0, 0.0, 1.0), SteerInput::default());
        assert_eq!(stick_input(0.2, -0.1, 0.0), SteerInput::default());
        assert_eq!(stick_input(f32::NAN, 0.5, 0.0), SteerInput::default());
        let walks = stick_input(0.0, 0.6, 0.0);
        assert!(walks.moves() && !walks.runs && walks.aside == 0.0 && (walks.ahead - 0.625).abs() < 1e-6);
        assert!(stick_input(0.0, 0.6, 0.9).runs && stick_input(-1.0, 0.0, 0.0).runs);
        // A hand that shakes is no new way.
        assert_eq!(stick_input(0.5, 0.51, 0.0), stick_input(0.51, 0.49, 0.0));
    }
}
