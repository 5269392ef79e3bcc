//! Plots as SVG files: lines through points over two axes that begin at 0.

use std::fmt::Write;
use throng_precompute::picture::step_up;

/// Colours of lines, in their order.
const LINES: [&str; 4] = ["#2f63a8", "#e8743b", "#1f9e89", "#7a2bbf"];
/// Approximate number of marks on an axis.
const MARKS: f64 = 6.0;
/// Left, top, width and height of the area of the lines (px).
const AREA: [f64; 4] = [110.0, 116.0, 1060.0, 554.0];

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
pub fn plot(p: &Plot<'_>) -> String {
    let is_good = |q: &&[f64; 2]| q.iter().all(|v| v.is_finite() && *v >= 0.0);
    let most = [0, 1].map(|axis| {
        let all = p.lines.iter().flat_map(|l| l.1.iter().filter(is_good)).map(|q| q[axis]);
        all.fold(0.0, f64::max).max(1e-12) * 1.05
    });
    let [left, top, width, height] = AREA;
    let place = |[x, y]: [f64; 2]| [left + width * x / most[0], top + height * (1.0 - y / most[1])];
    let mut out = String::from(
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 1200 760' font-family='sans-serif' font-size='19'>\n\
         <rect width='1200' height='760' fill='#fdfcfa'/>\n",
    );
    let mut text = |[x, y]: [f64; 2], style: &str, text: &str| {
        let text = text.replace('&', "&amp;").replace('<', "&lt;");
        writeln!(out, "<text x='{x:.1}' y='{y:.1}' {style}>{text}</text>").expect("memory takes text");
    };
    text([18.0, 42.0], "font-size='34'", p.title);
    text([18.0, 69.0], "", p.subtitle);
    text([left + 0.5 * width, top + height + 58.0], "text-anchor='middle'", p.axes[0]);
    text([left, top - 12.0], "", p.axes[1]);
    for (i, (name, _)) in p.lines.iter().enumerate() {
        text([left + width, 42.0 + 24.0 * i as f64], &format!("text-anchor='end' fill='{}'", line_colour(i)), name);
    }
    for axis in 0..2 {
        let step = step_up(most[axis] / MARKS);
        for k in 0..=(most[axis] / step) as u32 {
            let value = f64::from(k) * step;
            match (axis, place([value; 2])) {
                (0, [x, _]) => text([x, top + height + 24.0], "text-anchor='middle'", &number(value, step)),
                (_, [_, y]) => text([left - 10.0, y + 6.0], "text-anchor='end'", &number(value, step)),
            }
        }
    }
    writeln!(out, "<path d='M{left} {top}v{height}h{width}' fill='none' stroke='#6b727b'/>")
        .expect("memory takes text");
    for (i, (_, points)) in p.lines.iter().enumerate() {
        let points = points.iter().filter(is_good).map(|q| place(*q)).map(|[x, y]| format!("{x:.1},{y:.1}"));
        let (points, colour) = (points.collect::<Vec<_>>().join(" "), line_colour(i));
        writeln!(out, "<polyline points='{points}' fill='none' stroke='{colour}' stroke-width='3'/>")
            .expect("memory takes text");
    }
    out + "</svg>\n"
}

fn line_colour(i: usize) -> &'static str {
    LINES[i % LINES.len()]
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
    fn marks_have_the_digits_they_need() {
        assert_eq!([number(0.15, 0.05), number(400.0, 200.0)], ["0.15", "400"]);
    }

    #[test]
    fn lines_go_through_their_good_points() {
        let lines =
            vec![("a".to_owned(), vec![[0.0, 0.0], [1000.0, 2.0], [f64::NAN, 1.0]]), ("b".to_owned(), Vec::new())];
        let page = plot(&Plot { title: "t & u", subtitle: "s", axes: ["agents", "seconds"], lines });
        assert!(page.contains("<polyline points='110.0,670.0 1119.5,142.4' fill='none' stroke='#2f63a8'"), "{page}");
        assert!(page.contains(">t &amp; u<") && page.contains(">200<") && page.contains(">0.5<"), "{page}");
    }
}
