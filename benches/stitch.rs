//! How long does it take to stitch a world, and to change one in which something moves? `cargo bench --bench stitch`
//! makes them up; `THRONG_WORLDS="a.toml b.toml" cargo bench --bench stitch` takes world files, whose bundles are there.

#[allow(dead_code, reason = "a part of it is enough here")]
#[path = "../tests/patch/made_up.rs"]
mod made_up;

use made_up::{BENCH, MadeUp, PANEL_M, panels, with};
use std::path::Path;
use std::time::Instant;
use throng_precompute::environment::Environment;
use throng_precompute::progress::Silent;
use throng_precompute::stitch::{Editor, Kit, Library, StitchConfig, WorldSource};
use throng_runtime::Bundle;
use throng_runtime::patch::{Patches, Placement};

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    // `cargo test` runs benches too: a small world is enough there.
    let whole = std::env::args().any(|a| a == "--bench");
    let files = std::env::var("THRONG_WORLDS").unwrap_or_default();
    for file in files.split_whitespace().map(Path::new) {
        let source = WorldSource::load(file)?;
        let tables = Bundle::open(&source.bundle)?;
        let kit = Kit::new(&tables, &source.bundle)?;
        let environment = source.environment(&kit.units, file)?;
        look(tables.patches(), &kit.library(&tables), environment, &source.stitch)?;
    }
    let sides: &[usize] = if whole { &[10, 30, 100] } else { &[4] };
    let made_up = MadeUp::new();
    for &side in sides.iter().filter(|_| files.is_empty()) {
        let mut environment = panels(side, side);
        environment.name = format!("{side} x {side} panels, benches on a quarter of them");
        for k in 0..side * side / 4 {
            let at = [k % (side / 2), k / (side / 2)].map(|n| 2.0 * n as f32 * PANEL_M);
            environment = with(environment, BENCH, at[0], at[1] + 0.8, 0.0);
        }
        let config = StitchConfig { allow_unreachable: true, ..StitchConfig::default() };
        look(&made_up.patches(), &made_up.library(), environment, &config)?;
    }
    Ok(())
}

/// Stitches a world, then moves one unit of every kind on and back again.
fn look(
    patches: &Patches,
    library: &Library<'_>,
    environment: Environment,
    config: &StitchConfig,
) -> Result<(), Failure> {
    let begin = Instant::now();
    let mut editor = Editor::new(patches, *library, environment, config, &Silent)?;
    let anew = begin.elapsed().as_secs_f64();
    let r = editor.report();
    println!(
        "{}: {} instances, {} cells, {} transitions",
        editor.environment().name,
        r.instances,
        r.cells,
        r.transitions
    );
    println!("  stitched in {anew:.3} s, {:.0} MB at most", r.peak_bytes as f64 / 1e6);

    for (kind, unit) in library.units.units.iter().enumerate() {
        let units = &editor.environment().units;
        let places: Vec<usize> = (0..units.len()).filter(|&u| units[u].unit == kind).collect();
        let Some(&place) = places.get(places.len() / 2) else { continue };
        let home = units[place].placement;
        let mut times = Vec::new();
        for k in 1..=10 {
            // Never a place where it was before: nothing of it is known.
            let shift = Placement::new(0.013 * k as f32, 0.0, 0.0, 0.0);
            let begin = Instant::now();
            if editor.drag(place, home.compose(shift)).is_ok() {
                times.push(begin.elapsed().as_secs_f64());
            }
        }
        editor.drag(place, home)?;
        times.sort_by(f64::total_cmp);
        if let Some(middle) = times.get(times.len() / 2) {
            let (low, high) = (times[0] * 1e3, times[times.len() - 1] * 1e3);
            println!(
                "  {} (place {place}) moved in {:.1} ms ({low:.1} to {high:.1}), {:.4} of stitching anew",
                unit.name,
                middle * 1e3,
                middle / anew
            );
        }
    }
    Ok(())
}
