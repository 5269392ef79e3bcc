//! Colours of the view, as plain data.

use eframe::egui::ecolor::linear_f32_from_gamma_u8;
use glam::Vec4;

/// An sRGB colour with straight alpha, eight bits a channel.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, bytemuck::Pod, bytemuck::Zeroable,
)]
#[repr(C)]
pub struct Rgba(pub [u8; 4]);

impl Rgba {
    /// White.
    pub const WHITE: Self = Self::hex(0xff_ff_ff);

    /// An opaque colour from 0xRRGGBB.
    pub const fn hex(rgb: u32) -> Self {
        Self([(rgb >> 16) as u8, (rgb >> 8) as u8, rgb as u8, 255])
    }

    /// This colour with another opacity (0 to 1).
    pub fn alpha(self, alpha: f32) -> Self {
        let [r, g, b, _] = self.0;
        Self([r, g, b, (alpha.clamp(0.0, 1.0) * 255.0).round() as u8])
    }

    /// `self` at `t = 0`, `other` at `t = 1`.
    pub fn mix(self, other: Self, t: f32) -> Self {
        let t = t.clamp(0.0, 1.0);
        Self(std::array::from_fn(|i| (self.0[i] as f32 * (1.0 - t) + other.0[i] as f32 * t).round() as u8))
    }

    /// Linear light, alpha unchanged.
    pub fn linear(self) -> Vec4 {
        let [r, g, b, a] = self.0;
        let [r, g, b] = [r, g, b].map(linear_f32_from_gamma_u8);
        Vec4::new(r, g, b, a as f32 / 255.0)
    }
}

/// Colours of everything in the view without a colour of its own, in the order of `shaders/scene.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct SceneColours {
    /// Above the horizon, far up.
    pub sky: Rgba,
    /// Horizon, and the colour into which the ground fades.
    pub horizon: Rgba,
    /// The ground.
    pub ground: Rgba,
    /// Lines every metre.
    pub grid: Rgba,
    /// Lines every ten metres.
    pub grid_strong: Rgba,
    /// The line along X.
    pub axis_x: Rgba,
    /// The line along Z.
    pub axis_z: Rgba,
    /// Shadow on the ground; alpha is its strength.
    pub shadow: Rgba,
    /// Light from above; alpha is its strength.
    pub light_above: Rgba,
    /// Light from below; alpha is its strength.
    pub light_below: Rgba,
    /// Light of the sun; alpha is its strength.
    pub light_key: Rgba,
    /// Edge of selected characters.
    pub selected: Rgba,
}

impl SceneColours {
    /// Warm paper for light themes, slate for dark ones.
    pub fn for_theme(dark: bool) -> Self {
        let pick = |on_light, on_dark| Rgba(if dark { on_dark } else { on_light });
        let plain = |on_light, on_dark| Rgba::hex(if dark { on_dark } else { on_light });
        Self {
            sky: plain(0xd9dee5, 0x14171c),
            horizon: plain(0xeceae6, 0x23272e),
            ground: plain(0xf1efeb, 0x2a2e35),
            grid: plain(0xd3cfc7, 0x3a3f48),
            grid_strong: plain(0xb3aea4, 0x545b67),
            axis_x: plain(0xc9625c, 0xb4544f),
            axis_z: plain(0x4f7fc4, 0x4d7cc0),
            shadow: pick([0x3a, 0x3f, 0x4c, 150], [0x06, 0x08, 0x0b, 190]),
            light_above: pick([0xf2, 0xf5, 0xff, 170], [0xdc, 0xe6, 0xff, 120]),
            light_below: pick([0xd8, 0xcf, 0xc2, 105], [0x8a, 0x86, 0x80, 70]),
            light_key: pick([0xff, 0xf3, 0xe2, 175], [0xff, 0xf1, 0xdc, 190]),
            selected: plain(0x7a2bbf, 0xc79bff),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_mix_and_become_linear() {
        assert_eq!(Rgba::hex(0x102030).0, [0x10, 0x20, 0x30, 255]);
        assert_eq!(Rgba::hex(0).mix(Rgba::WHITE, 0.5).0, [128, 128, 128, 255]);
        assert_eq!(Rgba::WHITE.alpha(0.5).0[3], 128);
        assert!((Rgba::hex(0x808080).linear().x - 0.2158).abs() < 1e-3);
    }
}
