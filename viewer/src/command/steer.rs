//! What is asked for by who steers a character.

/// What is held down: each from -1 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Held {
    /// Away from the camera.
    pub ahead: f32,
    /// To the right of the picture.
    pub aside: f32,
    /// Faster.
    pub runs: bool,
}

impl Held {
    /// True where a way is held down.
    pub fn moves(&self) -> bool {
        self.ahead != 0.0 || self.aside != 0.0
    }
}

/// Steering of the selected character.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SteerCommand {
    /// Take it over, or let it go.
    Toggle,
    /// Other keys are held down.
    Hold(Held),
    /// Strike.
    Strike,
}
