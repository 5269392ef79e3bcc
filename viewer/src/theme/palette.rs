//! Colours with a meaning, for dark and light themes.

use eframe::egui::{Color32, Visuals};

/// Colours with a meaning. Left and right are the colours of the pictures: they differ in hue and in lightness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThemePalette {
    /// The left side of a body.
    pub left: Color32,
    /// The right side.
    pub right: Color32,
    /// Trunk and head.
    pub trunk: Color32,
    /// Frames that the motion graph plays.
    pub kept: Color32,
    /// Excluded frames.
    pub excluded: Color32,
    /// States, and where actions lead.
    pub state: Color32,
    /// States at which the character stands.
    pub standing: Color32,
    /// Links into a state.
    pub incoming: Color32,
    /// Marks of the selected character.
    pub character: Color32,
    /// The play head.
    pub head: Color32,
    /// Good results.
    pub good: Color32,
    /// Warnings.
    pub warning: Color32,
    /// Colours of names (0xRRGGBB).
    tags: [u32; 6],
}

impl ThemePalette {
    const DARK: Self = Self {
        left: Color32::from_rgb(0xf0, 0xa6, 0x52),
        right: Color32::from_rgb(0x6a, 0xa3, 0xe8),
        trunk: Color32::from_rgb(0xa6, 0xae, 0xb8),
        kept: Color32::from_rgb(0x2f, 0x8f, 0x7e),
        excluded: Color32::from_rgb(0xc8, 0x6b, 0x66),
        state: Color32::from_rgb(0xc7, 0x9b, 0xff),
        standing: Color32::from_rgb(0xff, 0x8c, 0xb4),
        incoming: Color32::from_rgb(0xf2, 0xa0, 0x50),
        character: Color32::from_rgb(0xff, 0x5f, 0x50),
        head: Color32::from_rgb(0xff, 0xd8, 0x4d),
        good: Color32::from_rgb(0x5f, 0xd0, 0xa8),
        warning: Color32::from_rgb(0xff, 0xb0, 0x54),
        tags: [0x4a6fa5, 0x8a5a9b, 0x9a6b3f, 0x4d8659, 0x9b4f68, 0x3f848f],
    };

    const LIGHT: Self = Self {
        left: Color32::from_rgb(0xb0, 0x56, 0x00),
        right: Color32::from_rgb(0x2f, 0x63, 0xa8),
        trunk: Color32::from_rgb(0x6d, 0x77, 0x84),
        kept: Color32::from_rgb(0x6c, 0xc4, 0xb3),
        excluded: Color32::from_rgb(0xb5, 0x4a, 0x45),
        state: Color32::from_rgb(0x7a, 0x2b, 0xbf),
        standing: Color32::from_rgb(0xbe, 0x28, 0x6e),
        incoming: Color32::from_rgb(0xb2, 0x56, 0x00),
        character: Color32::from_rgb(0xd2, 0x1e, 0x14),
        head: Color32::from_rgb(0xc4, 0x2f, 0x1d),
        good: Color32::from_rgb(0x1b, 0x7a, 0x58),
        warning: Color32::from_rgb(0xa8, 0x5a, 0x00),
        tags: [0xbfd3ee, 0xdec6e8, 0xeed5b4, 0xc2e2c8, 0xf0c6d2, 0xbce0e5],
    };

    /// Marks of the selected character over the colour map, which is the same in every theme.
    pub const CHARACTER_ON_MAP: Color32 = Self::DARK.character;
    /// Marks of pointed or picked items over the colour map.
    pub const POINTED_ON_MAP: Color32 = Color32::from_rgb(0xff, 0xeb, 0x78);

    /// The colours that go with a theme.
    pub fn for_visuals(visuals: &Visuals) -> Self {
        if visuals.dark_mode { Self::DARK } else { Self::LIGHT }
    }

    /// Colour of a name: the same for the same name in every place.
    pub fn of_name(&self, name: &str) -> Color32 {
        let hash = name.bytes().fold(0x811c_9dc5_u32, |h, b| (h ^ u32::from(b)).wrapping_mul(0x0100_0193));
        let [_, r, g, b] = self.tags[(hash >> 8) as usize % self.tags.len()].to_be_bytes();
        Color32::from_rgb(r, g, b)
    }
}
