//! Requests of a user who steers a character.

/// Steering input held down: each axis from -1 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SteerInput {
    /// Away from the camera.
    pub ahead: f32,
    /// To the right of the picture.
    pub aside: f32,
    /// Faster.
    pub runs: bool,
}

impl SteerInput {
    /// True if a direction is held down.
    pub fn moves(&self) -> bool {
        self.ahead != 0.0 || self.aside != 0.0
    }
}

/// Steering of the selected character.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SteerCommand {
    /// Take over the selected character, or release it.
    Toggle,
    /// Change the input that is held down.
    Hold(SteerInput),
    /// Strike.
    Strike,
}
