//! Flat drawing: filled and stroked shapes on a picture, in pixels from its upper left corner.

use super::colour::Colour;
use glam::Vec2;
use std::path::Path;
use throng_motion::error::{BuildError, Result};
use throng_motion::files::write_atomically;
use tiny_skia::{
    FillRule, LineCap, LineJoin, Paint, PathBuilder, Pixmap, PremultipliedColorU8, Rect, Stroke, Transform,
};

/// Smallest and largest width and height of a picture (px).
pub const SIZE_LIMITS: (u32, u32) = (16, 16_384);

/// A finished or growing picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    pixmap: Pixmap,
}

impl Picture {
    /// A picture of one colour. The size is clamped to [`SIZE_LIMITS`] (px).
    pub fn new(width: u32, height: u32, background: Colour) -> Self {
        let (low, high) = SIZE_LIMITS;
        let size = (width.clamp(low, high), height.clamp(low, high));
        let mut pixmap = Pixmap::new(size.0, size.1).expect("a size within the limits makes a pixmap");
        pixmap.fill(background.to_skia());
        Self { pixmap }
    }

    /// Width (px).
    pub fn width(&self) -> u32 {
        self.pixmap.width()
    }

    /// Height (px).
    pub fn height(&self) -> u32 {
        self.pixmap.height()
    }

    /// The picture as the bytes of a PNG file: the same for the same picture.
    ///
    /// # Errors
    /// [`BuildError::Stage`] where the encoder refuses.
    pub fn to_png(&self) -> Result<Vec<u8>> {
        self.pixmap.encode_png().map_err(|e| {
            let (message, help) = (format!("PNG encoding failed: {e}"), "Ask for a smaller picture.".into());
            BuildError::Stage { stage: "picture", message, help }
        })
    }

    /// Writes a PNG file: to a temporary file beside `path`, then renamed, so that no half picture is ever seen.
    ///
    /// # Errors
    /// [`BuildError::Io`] with the path where the folder is missing or not writable.
    pub fn save_png(&self, path: &Path) -> Result<()> {
        let png = self.to_png()?;
        write_atomically(path, |file| file.write_all(&png))
    }

    /// Red, green, blue and opacity of a pixel, premultiplied; `None` outside.
    pub fn pixel(&self, x: u32, y: u32) -> Option<[u8; 4]> {
        // The pixel past the end of a row is outside, although the pixels of a row follow those of the one before.
        let inside = x < self.width() && y < self.height();
        inside.then(|| self.pixmap.pixel(x, y)).flatten().map(|c| [c.red(), c.green(), c.blue(), c.alpha()])
    }

    /// All pixels, row-major, premultiplied (width * height).
    pub(super) fn pixels_mut(&mut self) -> &mut [PremultipliedColorU8] {
        self.pixmap.pixels_mut()
    }

    /// Draws another picture over this one, its upper left corner at `at` (px).
    pub(super) fn draw_picture(&mut self, other: &Self, at: (i32, i32)) {
        let paint = tiny_skia::PixmapPaint::default();
        self.pixmap.draw_pixmap(at.0, at.1, other.pixmap.as_ref(), &paint, Transform::identity(), None);
    }

    /// Fills a rectangle with rounded corners.
    pub(super) fn fill_rect(&mut self, area: Area, radius: f32, colour: Colour) {
        self.fill(rounded_path(area, radius), colour);
    }

    /// Fills a disc.
    pub(super) fn fill_disc(&mut self, centre: Vec2, radius: f32, colour: Colour) {
        self.fill(PathBuilder::from_circle(centre.x, centre.y, radius), colour);
    }

    /// Strokes an ellipse whose axes are the picture's.
    pub(super) fn stroke_oval(&mut self, centre: Vec2, radii: Vec2, width: f32, colour: Colour) {
        let corner = centre - radii;
        let around = Rect::from_xywh(corner.x, corner.y, 2.0 * radii.x, 2.0 * radii.y);
        self.stroke(around.and_then(PathBuilder::from_oval), width, colour);
    }

    /// Fills a polygon.
    pub(super) fn fill_polygon(&mut self, points: &[Vec2], colour: Colour) {
        self.fill(polyline_path(points, true), colour);
    }

    /// Strokes a line through all points, round at its ends and corners.
    pub(super) fn stroke_line(&mut self, points: &[Vec2], width: f32, colour: Colour) {
        self.stroke(polyline_path(points, false), width, colour);
    }

    fn fill(&mut self, path: Option<tiny_skia::Path>, colour: Colour) {
        if let Some(path) = path {
            self.pixmap.fill_path(&path, &paint(colour), FillRule::Winding, Transform::identity(), None);
        }
    }

    fn stroke(&mut self, path: Option<tiny_skia::Path>, width: f32, colour: Colour) {
        let stroke = Stroke { width, line_cap: LineCap::Round, line_join: LineJoin::Round, ..Stroke::default() };
        if let Some(path) = path {
            self.pixmap.stroke_path(&path, &paint(colour), &stroke, Transform::identity(), None);
        }
    }
}

/// A rectangle of a picture (px).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Area {
    /// Upper left corner.
    pub min: Vec2,
    /// Width and height.
    pub size: Vec2,
}

impl Area {
    /// Rectangle from its left and upper edge, width and height.
    pub fn new(x: f32, y: f32, w: f32, h: f32) -> Self {
        Self { min: Vec2::new(x, y), size: Vec2::new(w.max(1.0), h.max(1.0)) }
    }

    /// Lower right corner.
    pub fn max(self) -> Vec2 {
        self.min + self.size
    }

    /// True if the rectangles share more than an edge.
    pub fn overlaps(self, other: Self) -> bool {
        self.min.cmplt(other.max()).all() && other.min.cmplt(self.max()).all()
    }
}

/// Composites premultiplied `top` over `bottom`.
pub(super) fn source_over(top: PremultipliedColorU8, bottom: PremultipliedColorU8) -> PremultipliedColorU8 {
    let rest = 255 - u32::from(top.alpha());
    let mix = |t: u8, b: u8| (u32::from(t) + (u32::from(b) * rest + 127) / 255).min(255) as u8;
    let a = mix(top.alpha(), bottom.alpha());
    let [r, g, b] = [mix(top.red(), bottom.red()), mix(top.green(), bottom.green()), mix(top.blue(), bottom.blue())];
    PremultipliedColorU8::from_rgba(r.min(a), g.min(a), b.min(a), a).unwrap_or(bottom)
}

fn paint(colour: Colour) -> Paint<'static> {
    let shader = tiny_skia::Shader::SolidColor(colour.to_skia());
    Paint { shader, anti_alias: true, ..Paint::default() }
}

fn polyline_path(points: &[Vec2], close: bool) -> Option<tiny_skia::Path> {
    if points.len() < 2 || points.iter().any(|p| !p.is_finite()) {
        return None;
    }
    let mut b = PathBuilder::new();
    b.move_to(points[0].x, points[0].y);
    points[1..].iter().for_each(|p| b.line_to(p.x, p.y));
    if close {
        b.close();
    }
    b.finish()
}

/// Path of a rounded rectangle. Quarter circles are quadratic curves: at the few pixels of a corner, the difference is invisible.
fn rounded_path(area: Area, radius: f32) -> Option<tiny_skia::Path> {
    let (a, b) = (area.min, area.max());
    let r = radius.min(0.5 * area.size.min_element()).max(0.0);
    let mut p = PathBuilder::new();
    p.move_to(a.x + r, a.y);
    p.line_to(b.x - r, a.y);
    p.quad_to(b.x, a.y, b.x, a.y + r);
    p.line_to(b.x, b.y - r);
    p.quad_to(b.x, b.y, b.x - r, b.y);
    p.line_to(a.x + r, b.y);
    p.quad_to(a.x, b.y, a.x, b.y - r);
    p.line_to(a.x, a.y + r);
    p.quad_to(a.x, a.y, a.x + r, a.y);
    p.close();
    p.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_clamped_and_shapes_land_where_they_should() {
        let mut p = Picture::new(0, 40, Colour::hex(0xffffff));
        assert_eq!((p.width(), p.height()), (16, 40));
        p.fill_rect(Area::new(4.0, 10.0, 8.0, 8.0), 0.0, Colour::hex(0xff0000));
        assert_eq!(p.pixel(8, 14), Some([255, 0, 0, 255]));
        assert_eq!(p.pixel(8, 20), Some([255; 4]));
        assert_eq!(p.pixel(16, 0), None);
    }

    #[test]
    fn what_is_not_finite_is_not_drawn() {
        let blank = Picture::new(32, 32, Colour::hex(0xffffff));
        let mut p = blank.clone();
        p.fill_polygon(&[Vec2::ZERO, Vec2::NAN, Vec2::ONE], Colour::hex(0));
        p.stroke_line(&[Vec2::ZERO, Vec2::INFINITY], 1.0, Colour::hex(0));
        p.fill_disc(Vec2::NAN, 3.0, Colour::hex(0));
        p.stroke_oval(Vec2::ZERO, Vec2::NAN, 1.0, Colour::hex(0));
        assert_eq!(p, blank);
    }

    #[test]
    fn a_saved_picture_reads_back_and_leaves_nothing_beside_it() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.png");
        let mut p = Picture::new(20, 20, Colour::hex(0x204060));
        p.fill_disc(Vec2::splat(10.0), 5.0, Colour::hex(0xffffff));
        p.save_png(&path).expect("writes");
        p.save_png(&path).expect("writes over the first one");
        assert_eq!(Pixmap::load_png(&path).expect("reads"), p.pixmap);
        assert_eq!(std::fs::read_dir(folder.path()).expect("lists").count(), 1);
    }

    #[test]
    fn a_missing_folder_is_named() {
        let path = Path::new("no-such-folder-here/a.png");
        let error = Picture::new(20, 20, Colour::hex(0)).save_png(path).expect_err("no folder");
        assert!(error.to_string().contains("no-such-folder-here"), "{error}");
    }
}
