//! Colours, and the palette all pictures share.

use tiny_skia::Color;

/// An sRGB colour with straight alpha.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Colour {
    /// Red (0 to 1).
    pub r: f32,
    /// Green (0 to 1).
    pub g: f32,
    /// Blue (0 to 1).
    pub b: f32,
    /// Opacity (0 to 1).
    pub a: f32,
}

impl Colour {
    /// An opaque colour from 0xRRGGBB.
    pub const fn hex(rgb: u32) -> Self {
        let [_, r, g, b] = rgb.to_be_bytes();
        Self { r: r as f32 / 255.0, g: g as f32 / 255.0, b: b as f32 / 255.0, a: 1.0 }
    }

    /// Copy of this colour with the given opacity.
    pub const fn alpha(self, a: f32) -> Self {
        Self { a, ..self }
    }

    /// `self` at `t = 0`, `other` at `t = 1`.
    pub fn mix(self, other: Self, t: f32) -> Self {
        let lerp = |a: f32, b: f32| a + (b - a) * t;
        Self { r: lerp(self.r, other.r), g: lerp(self.g, other.g), b: lerp(self.b, other.b), a: lerp(self.a, other.a) }
    }

    /// Converts to the colour of the 2-D painter; components out of range or not finite are clamped.
    pub(super) fn to_skia(self) -> Color {
        let unit = |v: f32| if v.is_finite() { v.clamp(0.0, 1.0) } else { 0.0 };
        Color::from_rgba(unit(self.r), unit(self.g), unit(self.b), unit(self.a)).unwrap_or(Color::BLACK)
    }
}

/// Page behind the panels.
pub const PAPER: Colour = Colour::hex(0xf4f2ee);
/// Panels: the ground, the strips.
pub const GROUND: Colour = Colour::hex(0xfdfcfa);
/// Grid lines on the ground.
pub const GRID: Colour = Colour::hex(0xd9d5cc);
/// Text and strong lines.
pub const INK: Colour = Colour::hex(0x23282f);
/// Secondary text.
pub const INK_SOFT: Colour = Colour::hex(0x6b727b);
/// Characters that have reached their target.
pub const REACHED: Colour = Colour::hex(0x1f9e89);
/// Characters on their way.
pub const ON_THE_WAY: Colour = Colour::hex(0xe8743b);
/// Torso and pelvis.
pub const BODY: Colour = Colour::hex(0x7d8794);
/// Head and hands.
pub const SKIN: Colour = Colour::hex(0xd9c2ac);
/// Limbs of the left side. Left and right differ in hue and in lightness.
pub const LEFT: Colour = Colour::hex(0xe9963e);
/// Limbs of the right side.
pub const RIGHT: Colour = Colour::hex(0x2f63a8);
/// Mark of the character that a strip shows.
pub const MARK: Colour = Colour::hex(0x7a2bbf);
