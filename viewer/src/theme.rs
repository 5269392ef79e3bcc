//! Colours in both themes: of text (the toolkit's is too faint), of the drawings of panels, and of numbers.

mod palette;
pub mod viridis;

pub use palette::ThemePalette;

use eframe::egui::{Color32, Context, Theme};

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
