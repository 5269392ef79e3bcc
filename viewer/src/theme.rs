//! Colours in both themes: of text (the toolkit's is too faint), of the drawings of panels, and of numbers.

pub mod viridis;

use eframe::egui::{Color32, Context, Theme, Visuals};

/// Theme, grey of text, grey of weak text, and colour of errors.
const COLOURS: [(Theme, u8, u8, Color32); 2] = [
    (Theme::Dark, 185, 140, Color32::from_rgb(0xff, 0x7b, 0x72)),
    (Theme::Light, 50, 105, Color32::from_rgb(0xb3, 0x26, 0x1e)),
];

/// Sets the colours of text.
pub fn prepare(ctx: &Context) {
    for (theme, text, weak, fault) in COLOURS {
        ctx.style_mut_of(theme, |style| {
            style.visuals.widgets.noninteractive.fg_stroke.color = Color32::from_gray(text);
            style.visuals.weak_text_color = Some(Color32::from_gray(weak));
            style.visuals.error_fg_color = fault;
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::Rgba;

    /// Contrast ratio of the Web Content Accessibility Guidelines 2, section 1.4.3.
    fn contrast(a: Color32, b: Color32) -> f32 {
        let luminance = |c: Color32| {
            let c = Rgba::from(c);
            0.2126 * c.r() + 0.7152 * c.g() + 0.0722 * c.b() + 0.05
        };
        let (a, b) = (luminance(a), luminance(b));
        a.max(b) / a.min(b)
    }

    #[test]
    fn text_stands_out_from_what_it_is_written_on() {
        let ctx = Context::default();
        prepare(&ctx);
        for theme in [Theme::Dark, Theme::Light] {
            let v = &ctx.style_of(theme).visuals;
            for back in [v.panel_fill, v.window_fill, v.extreme_bg_color] {
                let (text, weak) = (contrast(v.text_color(), back), contrast(v.weak_text_color(), back));
                assert!(weak >= 4.5 && text > 1.4 * weak, "{theme:?}: {text} {weak} on {back:?}");
                assert!(contrast(v.error_fg_color, back) >= 4.5, "{theme:?}: faults on {back:?}");
            }
            let p = ThemePalette::for_visuals(v);
            for colour in [p.left, p.right, p.standing, p.incoming, p.character, p.head, p.good, p.warning] {
                let ratio = contrast(colour, v.panel_fill);
                assert!(ratio >= 4.5, "{theme:?}: {ratio} of {colour:?}");
            }
        }
    }
}

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
    /// Marks of the selected character over the colour map, which is the same in every theme.
    pub const CHARACTER_ON_MAP: Color32 = Color32::from_rgb(0xff, 0x5f, 0x50);
    /// Marks of pointed or picked items over the colour map.
    pub const POINTED_ON_MAP: Color32 = Color32::from_rgb(0xff, 0xeb, 0x78);

    /// The colours that go with a theme.
    pub fn for_visuals(visuals: &Visuals) -> Self {
        let pick = |on_dark, on_light| rgb(if visuals.dark_mode { on_dark } else { on_light });
        Self {
            left: pick(0xf0a652, 0xb05600),
            right: pick(0x6aa3e8, 0x2f63a8),
            trunk: pick(0xa6aeb8, 0x6d7784),
            kept: pick(0x2f8f7e, 0x6cc4b3),
            excluded: pick(0xc86b66, 0xb54a45),
            state: pick(0xc79bff, 0x7a2bbf),
            standing: pick(0xff8cb4, 0xbe286e),
            incoming: pick(0xf2a050, 0xb25600),
            character: pick(0xff5f50, 0xd21e14),
            head: pick(0xffd84d, 0xc42f1d),
            good: pick(0x5fd0a8, 0x1b7a58),
            warning: pick(0xffb054, 0xa85a00),
            tags: match visuals.dark_mode {
                true => [0x4a6fa5, 0x8a5a9b, 0x9a6b3f, 0x4d8659, 0x9b4f68, 0x3f848f],
                false => [0xbfd3ee, 0xdec6e8, 0xeed5b4, 0xc2e2c8, 0xf0c6d2, 0xbce0e5],
            },
        }
    }

    /// Colour of a name: the same for the same name in every place.
    pub fn of_name(&self, name: &str) -> Color32 {
        let hash = name.bytes().fold(0x811c_9dc5_u32, |h, b| (h ^ u32::from(b)).wrapping_mul(0x0100_0193));
        rgb(self.tags[(hash >> 8) as usize % self.tags.len()])
    }
}

/// A colour from 0xRRGGBB.
pub fn rgb(colour: u32) -> Color32 {
    let [_, r, g, b] = colour.to_be_bytes();
    Color32::from_rgb(r, g, b)
}
