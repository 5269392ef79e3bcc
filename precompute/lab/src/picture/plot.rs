//! A plot: lines through points over two axes that begin at 0.

use super::canvas::{Area, Picture};
use super::colour::{self, Colour};
use super::furniture::{header, legend};
use super::text::{Align, TextStyle, draw_text};
use glam::Vec2;

/// Colours of lines, in their order.
const LINES: [u32; 4] = [0x2f63a8, 0xe8743b, 0x1f9e89, 0x7a2bbf];
/// Approximate number of marks on an axis.
const MARKS: f64 = 6.0;

/// Input of [`plot`].
#[derive(Clone, Debug, PartialEq)]
pub struct Plot<'a> {
    /// First line.
    pub title: &'a str,
    /// Second line.
    pub subtitle: &'a str,
    /// Titles of the axes: to the right, and upwards.
    pub axes: [&'a str; 2],
    /// Lines: their names, and their points from left to right.
    pub lines: Vec<(String, Vec<[f64; 2]>)>,
}

/// Draws a plot. Points that are not finite, or below 0, are left out.
pub fn plot(p: &Plot<'_>) -> Picture {
    let mut page = Picture::new(1200, 760, colour::PAPER);
    header(&mut page, 1.0, p.title, p.subtitle);
    let entries: Vec<_> = p.lines.iter().enumerate().map(|(i, l)| (line_colour(i), l.0.clone())).collect();
    legend(&mut page, Area::new(0.0, 0.0, 1184.0, 84.0), 1.0, &entries, "");
    let area = Area::new(110.0, 116.0, 1060.0, 554.0);
    page.fill_rect(area, 0.0, colour::GROUND);
    let is_good = |q: &&[f64; 2]| q.iter().all(|v| v.is_finite() && *v >= 0.0);
    let most = |axis: usize| {
        let all = p.lines.iter().flat_map(|l| l.1.iter().filter(is_good)).map(|q| q[axis]);
        all.fold(0.0, f64::max).max(1e-12) * 1.05
    };
    let most = [most(0), most(1)];
    let place = |[x, y]: [f64; 2]| {
        let share = Vec2::new((x / most[0]) as f32, 1.0 - (y / most[1]) as f32);
        area.min + share * area.size
    };
    draw_axes(&mut page, area, p.axes, most, place);
    for (i, (_, points)) in p.lines.iter().enumerate() {
        let points: Vec<Vec2> = points.iter().filter(is_good).map(|q| place(*q)).collect();
        page.stroke_line(&points, 3.0, line_colour(i));
        points.iter().for_each(|q| page.fill_disc(*q, 5.0, line_colour(i)));
    }
    page
}

fn line_colour(i: usize) -> Colour {
    Colour::hex(LINES[i % LINES.len()])
}

fn draw_axes(page: &mut Picture, area: Area, names: [&str; 2], most: [f64; 2], place: impl Fn([f64; 2]) -> Vec2) {
    let style = TextStyle { size: 19.0, colour: colour::INK_SOFT, align: Align::Centre, bold: false };
    for axis in 0..2 {
        let step = step_up(most[axis] / MARKS);
        for k in 0..=(most[axis] / step) as u32 {
            let value = f64::from(k) * step;
            let at = place(if axis == 0 { [value, 0.0] } else { [0.0, value] });
            let text = number(value, step);
            if axis == 0 {
                page.stroke_line(&[at, Vec2::new(at.x, area.min.y)], 1.0, colour::GRID);
                draw_text(page, at + Vec2::new(0.0, 24.0), &text, style);
            } else {
                page.stroke_line(&[at, Vec2::new(area.max().x, at.y)], 1.0, colour::GRID);
                draw_text(page, at + Vec2::new(-10.0, 6.0), &text, TextStyle { align: Align::Right, ..style });
            }
        }
    }
    let style = TextStyle { colour: colour::INK, bold: true, ..style };
    draw_text(page, Vec2::new(area.min.x + 0.5 * area.size.x, area.max().y + 58.0), names[0], style);
    let at = area.min + Vec2::new(0.0, -12.0);
    draw_text(page, at, names[1], TextStyle { align: Align::Left, ..style });
}

/// The smallest of 1, 2, 5 times a power of ten that is not below `wanted`.
pub fn step_up(wanted: f64) -> f64 {
    let power = 10f64.powf(wanted.log10().floor());
    let times = [1.0, 2.0, 5.0, 10.0].into_iter().find(|t| t * power >= wanted * (1.0 - 1e-6)).unwrap_or(10.0);
    times * power
}

/// A number with as many digits as its step needs.
fn number(value: f64, step: f64) -> String {
    let digits = (-step.log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_round_and_have_the_digits_they_need() {
        for (wanted, step) in [(0.9, 1.0), (1.1, 2.0), (166.0, 200.0), (0.003, 0.005), (6.0, 10.0)] {
            assert!((step_up(wanted) / step - 1.0).abs() < 1e-9, "{wanted}: {}", step_up(wanted));
        }
        assert_eq!([number(0.15, 0.05), number(400.0, 200.0)], ["0.15", "400"]);
    }

    #[test]
    fn lines_end_where_their_points_are() {
        let lines =
            vec![("a".to_owned(), vec![[0.0, 0.0], [1000.0, 2.0], [f64::NAN, 1.0]]), ("b".to_owned(), Vec::new())];
        let page = plot(&Plot { title: "t", subtitle: "s", axes: ["agents", "seconds"], lines });
        let end = Vec2::new(110.0 + 1060.0 / 1.05, 116.0 + 554.0 * (1.0 - 1.0 / 1.05));
        assert_eq!(page.pixel(end.x as u32, end.y as u32), Some([0x2f, 0x63, 0xa8, 255]));
        assert_eq!(page.pixel(600, 150), Some([0xfd, 0xfc, 0xfa, 255]));
    }
}
