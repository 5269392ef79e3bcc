//! Text, in Ubuntu Light (Ubuntu Font Licence 1.0), which comes with the crate `epaint_default_fonts`.

use super::canvas::{Picture, source_over};
use super::colour::Colour;
use ab_glyph::{Font, FontRef, Glyph, PxScale, ScaleFont, point};
use glam::Vec2;

/// Horizontal alignment of a line of text to its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Align {
    /// The text begins at the point.
    Left,
    /// The text is centred at the point.
    Centre,
    /// The text ends at the point.
    Right,
}

/// Style of a line of text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TextStyle {
    /// Height from one line to the next (px).
    pub size: f32,
    /// Colour of the letters.
    pub colour: Colour,
    /// Horizontal alignment to the point.
    pub align: Align,
    /// True for thicker strokes.
    pub bold: bool,
}

/// Draws one line whose baseline passes through `at`.
pub(super) fn draw_text(picture: &mut Picture, at: Vec2, text: &str, style: TextStyle) {
    let width = text_width(text, style.size);
    let x = match style.align {
        Align::Left => at.x,
        Align::Centre => at.x - 0.5 * width,
        Align::Right => at.x - width,
    };
    draw_line(picture, Vec2::new(x, at.y), text, style);
    if style.bold {
        draw_line(picture, Vec2::new(x + 0.035 * style.size, at.y), text, style);
    }
}

/// Width of one line (px).
pub(super) fn text_width(text: &str, size: f32) -> f32 {
    layout(&font(), text, size).1
}

/// # Panics
/// If the font that is compiled in is not one, which a test excludes.
fn font() -> FontRef<'static> {
    FontRef::try_from_slice(epaint_default_fonts::UBUNTU_LIGHT).expect("the font that is compiled in parses")
}

/// Glyphs along the baseline from the origin, and their width.
fn layout(font: &FontRef<'_>, text: &str, size: f32) -> (Vec<Glyph>, f32) {
    let scaled = font.as_scaled(PxScale::from(size.clamp(1.0, 1000.0)));
    let mut x = 0.0;
    let mut last = None;
    let mut glyphs = Vec::with_capacity(text.len());
    for c in text.chars() {
        let id = scaled.glyph_id(c);
        if let Some(previous) = last.replace(id) {
            x += scaled.kern(previous, id);
        }
        glyphs.push(id.with_scale_and_position(scaled.scale(), point(x, 0.0)));
        x += scaled.h_advance(id);
    }
    (glyphs, x)
}

fn draw_line(picture: &mut Picture, origin: Vec2, text: &str, style: TextStyle) {
    if !origin.is_finite() {
        return;
    }
    let font = font();
    for mut glyph in layout(&font, text, style.size).0 {
        glyph.position.x += origin.x;
        glyph.position.y += origin.y;
        if let Some(outline) = font.outline_glyph(glyph) {
            let corner = outline.px_bounds().min;
            outline.draw(|x, y, coverage| {
                blend(picture, (corner.x as i64 + x as i64, corner.y as i64 + y as i64), coverage, style.colour);
            });
        }
    }
}

/// Blends a colour over a pixel. The power makes up for thin strokes on a light ground looking too light.
fn blend(picture: &mut Picture, at: (i64, i64), coverage: f32, colour: Colour) {
    let (w, h) = (picture.width() as i64, picture.height() as i64);
    if at.0 < 0 || at.1 < 0 || at.0 >= w || at.1 >= h {
        return;
    }
    let over = colour.alpha(colour.a * coverage.clamp(0.0, 1.0).powf(0.75)).to_skia().premultiply().to_color_u8();
    let pixel = &mut picture.pixels_mut()[(at.1 * w + at.0) as usize];
    *pixel = source_over(over, *pixel);
}

#[cfg(test)]
mod tests {
    use super::*;

    const STYLE: TextStyle = TextStyle { size: 20.0, colour: Colour::hex(0), align: Align::Left, bold: false };

    #[test]
    fn longer_text_is_wider_and_width_grows_with_size() {
        assert!(text_width("ab", 20.0) > text_width("a", 20.0));
        assert!((text_width("crowd", 40.0) / text_width("crowd", 20.0) - 2.0).abs() < 0.01);
        assert_eq!(text_width("", 20.0), 0.0);
    }

    #[test]
    fn alignment_moves_the_ink() {
        let ink = |align| {
            let mut p = Picture::new(200, 40, Colour::hex(0xffffff));
            draw_text(&mut p, Vec2::new(100.0, 25.0), "mmmm", TextStyle { align, ..STYLE });
            let dark = |x: u32| (0..40).any(|y| p.pixel(x, y).is_some_and(|c| c[0] < 128));
            ((0..99).any(dark), (102..200).any(dark))
        };
        assert_eq!(ink(Align::Left), (false, true));
        assert_eq!(ink(Align::Centre), (true, true));
        assert_eq!(ink(Align::Right), (true, false));
    }

    #[test]
    fn text_over_the_edge_is_cut_off() {
        let mut p = Picture::new(30, 30, Colour::hex(0xffffff));
        draw_text(&mut p, Vec2::new(-20.0, 5.0), "over the edge on both sides", STYLE);
        draw_text(&mut p, Vec2::new(f32::NAN, 5.0), "nowhere", STYLE);
        assert!((0..30).any(|x| p.pixel(x, 0).is_some_and(|c| c[0] < 255)));
    }
}
