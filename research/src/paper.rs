//! Comparison of a build with Lee and Lee (2004), section 6, which it follows.

use std::fmt::Write;
use throng_bake::report::BuildReport;

/// One figure, with its value in Lee and Lee (2004) and in this build.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PaperFigure {
    /// Name of the figure.
    pub figure: String,
    /// Value in Lee and Lee 2004; empty if not given.
    pub paper: &'static str,
    /// Value in this build.
    pub here: String,
}

/// Figures of Lee and Lee (2004), section 6, with those of a build.
pub fn compare_with_paper(r: &BuildReport) -> Vec<PaperFigure> {
    let line = |figure: &str, paper, here| PaperFigure { figure: figure.into(), paper, here };
    let range = |range: Option<[f32; 2]>, per_unit: f32, unit: &str| {
        let decimals = if per_unit > 1.0 { 1 } else { 3 };
        range.map_or("none".into(), |[a, b]| {
            format!("{:.decimals$} to {:.decimals$} {unit}", a * per_unit, b * per_unit)
        })
    };
    let seconds = |frames: usize| frames as f64 / r.rate_hz;
    let mut lines = vec![
        line("motion", "about 8 min at 15 Hz, one boxer", format!("{:.1} min at {:.0} Hz", r.minutes_in, r.rate_hz)),
        line("effective hitting points", "788", format!("{}, mirrored copies included", r.hits.count)),
        line("  angles", "-1.114 to 1.317 rad", range(r.hits.angle_rad, 1.0, "rad")),
        line("  distances", "29.7 to 129.3 cm", range(r.hits.distance_m, 100.0, "cm")),
        line("  heights", "126.6 to 162.4 cm", range(r.hits.height_m, 100.0, "cm")),
        line(
            "frames in the component",
            "6453 (7 min 17 s)",
            format!("{} of {} ({:.0} s)", r.frames_kept, r.frames_in, seconds(r.frames_kept)),
        ),
        line("states", "437", r.states.to_string()),
        line("transitions", "27072", r.actions.to_string()),
    ];
    let megabytes = |of: &dyn Fn(&str) -> bool| {
        r.policies.iter().filter(|p| of(&p.name)).map(|p| p.value_bytes).sum::<usize>() as f64 / 1e6
    };
    let (two, all) = (megabytes(&|name| PAPER.contains(&name)), megabytes(&|_| true));
    lines.push(line("policy tables", "0.9 MB", format!("{two:.2} MB of the two, {all:.2} MB of {}", r.policies.len())));
    for p in &r.policies {
        let paper = match p.name.as_str() {
            "approach" => "5 x 13 cells, 1 million random updates, 1 h",
            "throw-punches" => "10 x 10 x 4 cells, 7 h",
            _ => "",
        };
        lines.push(line(
            &format!("  {}", p.name),
            paper,
            format!(
                "{} cells, {:.2} MB of values, {} sweeps ({} greedy), {:.2} s, value residual {:.1e}",
                p.cells,
                p.value_bytes as f64 / 1e6,
                p.sweeps,
                p.greedy_sweeps,
                p.seconds,
                p.residual
            ),
        ));
    }
    lines
}

/// Names of the behaviours of Lee and Lee (2004), in configs that follow them.
const PAPER: [&str; 2] = ["approach", "throw-punches"];

/// Comparison as a table in Markdown, with a heading that names the build.
pub fn markdown(r: &BuildReport) -> String {
    let mut out = format!("# {} beside Lee and Lee (2004)\n\n", r.name);
    out += "What `throng build` measured, beside what Lee and Lee report (*Precomputing Avatar Behavior from Human Motion \
            Data*, SCA 2004, section 6; times on a Pentium IV of 2.4 GHz). Times are those of the machine that built it.\n\n";
    out += "| | Lee and Lee 2004 | this build |\n|---|---|---|\n";
    for l in compare_with_paper(r) {
        let _ = writeln!(out, "| {} | {} | {} |", l.figure.trim_start(), l.paper, l.here);
    }
    out
}
