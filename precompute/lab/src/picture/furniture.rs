//! Common parts of pictures: headers, legends, grids and scale bars.

use super::text::{Align, TextStyle, draw_text, text_width};
use super::{Colour, Picture, PictureCamera, canvas::Area, colour};
use glam::{Vec2, Vec3};
use throng_geometry::BoundingBox;

/// Greatest number of grid lines in one direction.
const MAX_LINES: i32 = 400;

/// The largest of 1, 2, 5, 10, 20, ... (and their tenths) that is not above `wanted`; at least 0.1.
pub(super) fn nice_step(wanted: f32) -> f32 {
    let power = 10f32.powf(wanted.max(0.1).log10().floor());
    let times = [5.0, 2.0].into_iter().find(|t| t * power <= wanted).unwrap_or(1.0);
    times * power
}

/// The smallest of 1, 2, 5 times a power of ten that is not below `wanted`.
pub fn step_up(wanted: f64) -> f64 {
    let power = 10f64.powf(wanted.log10().floor());
    let times = [1.0, 2.0, 5.0, 10.0].into_iter().find(|t| t * power >= wanted * (1.0 - 1e-6)).unwrap_or(10.0);
    times * power
}

/// A length as text: metres, without needless digits.
pub(super) fn metres(length: f32) -> String {
    if length >= 1.0 { format!("{length:.0} m") } else { format!("{length:.1} m") }
}

/// Draws title and subtitle at the upper left.
pub(super) fn header(page: &mut Picture, unit: f32, title: &str, subtitle: &str) {
    let style = TextStyle { size: 34.0 * unit, colour: colour::INK, align: Align::Left, bold: true };
    draw_text(page, Vec2::new(18.0, 42.0) * unit, title, style);
    let style = TextStyle { size: 20.0 * unit, colour: colour::INK_SOFT, align: Align::Left, bold: false };
    draw_text(page, Vec2::new(18.0, 69.0) * unit, subtitle, style);
}

/// A page with a title, an empty panel for below it, and the position of the panel on the page (px).
pub(super) fn page_with_panel(size: (u32, u32), title: &str, subtitle: &str) -> (Picture, Picture, (i32, i32)) {
    let mut page = Picture::new(size.0, size.1, colour::PAPER);
    let unit = page.width() as f32 / 1600.0;
    header(&mut page, unit, title, subtitle);
    let (edge, top) = ((16.0 * unit) as u32, (84.0 * unit) as u32);
    let size = (page.width().saturating_sub(2 * edge), page.height().saturating_sub(top + edge));
    (page, Picture::new(size.0, size.1, colour::GROUND), (edge as i32, top as i32))
}

/// Draws coloured entries at the upper right of `area`, and a remark below them.
pub(super) fn legend(page: &mut Picture, area: Area, unit: f32, entries: &[(Colour, String)], remark: &str) {
    let style = TextStyle { size: 21.0 * unit, colour: colour::INK, align: Align::Right, bold: true };
    let mut x = area.max().x;
    let y = area.min.y + 42.0 * unit;
    for (tint, text) in entries.iter().rev() {
        draw_text(page, Vec2::new(x, y), text, style);
        x -= text_width(text, style.size) + 14.0 * unit;
        page.fill_disc(Vec2::new(x, y - 6.5 * unit), 7.0 * unit, *tint);
        x -= 30.0 * unit;
    }
    let style = TextStyle { size: 18.0 * unit, colour: colour::INK_SOFT, bold: false, ..style };
    draw_text(page, Vec2::new(area.max().x, area.min.y + 69.0 * unit), remark, style);
}

/// Draws lines on the ground, `step` metres apart, over the whole panel; every fifth is stronger.
pub(super) fn grid(panel: &mut Picture, camera: &PictureCamera, step: f32, unit: f32) {
    let size = Vec2::new(panel.width() as f32, panel.height() as f32);
    let corners = [Vec2::ZERO, size.with_y(0.0), size, size.with_x(0.0)].map(|c| camera.ground_point(c));
    let BoundingBox { min, max } = BoundingBox::around_points(corners.into_iter().flatten());
    if !(min.is_finite() && max.is_finite()) {
        return;
    }
    let range = |low: f32, high: f32| {
        let first = (low / step).ceil() as i32;
        first..=((high / step).floor() as i32).min(first.saturating_add(MAX_LINES))
    };
    let mut line = |i: i32, a: Vec3, b: Vec3| {
        let strong = i % 5 == 0;
        let (width, opacity) = if strong { (1.3, 0.9) } else { (0.9, 0.45) };
        panel.stroke_line(&[camera.project(a), camera.project(b)], width * unit, colour::GRID.alpha(opacity));
    };
    let at = |i: i32| i as f32 * step;
    range(min.x, max.x).for_each(|i| line(i, Vec3::new(at(i), 0.0, min.z), Vec3::new(at(i), 0.0, max.z)));
    range(min.z, max.z).for_each(|i| line(i, Vec3::new(min.x, 0.0, at(i)), Vec3::new(max.x, 0.0, at(i))));
}

/// Draws a length in metres at the lower left.
pub(super) fn scale_bar(panel: &mut Picture, camera: &PictureCamera, unit: f32) {
    let length = nice_step(0.14 * panel.width() as f32 / camera.px_per_m);
    let text = metres(length);
    let (bar, size) = (length * camera.px_per_m, 19.0 * unit);
    let width = bar + text_width(&text, size) + 34.0 * unit;
    let (x, y) = (12.0 * unit, panel.height() as f32 - 44.0 * unit);
    panel.fill_rect(Area::new(x, y, width, 32.0 * unit), 6.0 * unit, colour::PAPER.alpha(0.88));
    let (left, mid) = (x + 12.0 * unit, y + 16.0 * unit);
    let ends = [Vec2::new(left, mid), Vec2::new(left + bar, mid)];
    panel.stroke_line(&ends, 2.4 * unit, colour::INK);
    for end in ends {
        let tick = Vec2::new(0.0, 5.0 * unit);
        panel.stroke_line(&[end - tick, end + tick], 2.4 * unit, colour::INK);
    }
    let style = TextStyle { size, colour: colour::INK, align: Align::Left, bold: true };
    draw_text(panel, Vec2::new(left + bar + 10.0 * unit, mid + 6.0 * unit), &text, style);
}

/// Names on coloured plates; a plate that would cover an earlier one is moved up.
#[derive(Default)]
pub(super) struct NamePlates(Vec<Area>);

impl NamePlates {
    /// Draws a name on a plate whose lower middle is at `at`.
    pub fn draw_plate(&mut self, panel: &mut Picture, at: Vec2, unit: f32, name: &str, tint: Colour) {
        let size = 19.0 * unit;
        let width = text_width(name, size) + 14.0 * unit;
        let x = (at.x - 0.5 * width).clamp(2.0, (panel.width() as f32 - width - 2.0).max(2.0));
        let mut plate = Area::new(x, (at.y - 24.0 * unit).max(2.0), width, 24.0 * unit);
        while let Some(under) = self.0.iter().find(|other| other.overlaps(plate)).filter(|_| plate.min.y > 2.0) {
            plate.min.y = (under.min.y - plate.size.y - 2.0 * unit).max(2.0);
        }
        panel.fill_rect(plate, 5.0 * unit, tint);
        let style = TextStyle { size, colour: colour::GROUND, align: Align::Left, bold: true };
        draw_text(panel, plate.min + Vec2::new(7.0, 18.0) * unit, name, style);
        self.0.push(plate);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_do_not_lie_on_each_other() {
        let mut tags = NamePlates::default();
        let mut page = Picture::new(400, 300, colour::PAPER);
        for at in [Vec2::new(200.0, 250.0), Vec2::new(210.0, 245.0), Vec2::new(190.0, 255.0), Vec2::new(40.0, 250.0)] {
            tags.draw_plate(&mut page, at, 1.0, "ticket", colour::INK);
        }
        let plates = &tags.0;
        for (k, plate) in plates.iter().enumerate() {
            assert!(plates[..k].iter().all(|other| !other.overlaps(*plate)), "{plates:?}");
        }
        assert_eq!(plates[3].min.y, plates[0].min.y, "it has room where it is");
    }

    #[test]
    fn steps_are_one_two_or_five_times_a_power_of_ten() {
        for (wanted, step) in [(0.01, 0.1), (0.99, 0.5), (1.0, 1.0), (4.9, 2.0), (73.0, 50.0), (199.0, 100.0)] {
            assert!((nice_step(wanted) - step).abs() < 1e-4 * step, "{wanted}: {}", nice_step(wanted));
        }
        for (wanted, step) in [(0.9, 1.0), (1.1, 2.0), (166.0, 200.0), (0.003, 0.005), (6.0, 10.0)] {
            assert!((step_up(wanted) / step - 1.0).abs() < 1e-9, "{wanted}: {}", step_up(wanted));
        }
        assert_eq!(metres(0.5), "0.5 m");
        assert_eq!(metres(20.0), "20 m");
    }
}
