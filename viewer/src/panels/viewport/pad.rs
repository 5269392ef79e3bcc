//! Steering by gamepad: the left stick is the direction, a trigger runs, one button strikes, another one takes over a
//! character.
//!
//! Built with the feature `gamepad` (gilrs), which on Linux needs the headers of libudev; without it no pad is ever there.

use crate::command::SteerInput;

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
