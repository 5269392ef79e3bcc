//! `crowd`: what the product's `bench crowd` measures, on all engines, and a plot of it.

use crate::args::CommandResult;
use crate::bench_crowd::{self, CrowdBenchRun};
use std::path::PathBuf;
use throng_research::plot::{Plot, plot};

/// Measure crowds with one or several engines, sizes and scenes.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    bench: bench_crowd::Args,
    /// Plot of the time for one simulated second over the number of agents.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
}

pub fn run(args: &Args) -> CommandResult {
    let runs = bench_crowd::run(&args.bench)?;
    if let Some(svg) = &args.svg {
        std::fs::write(svg, plot_times(&runs))?;
    }
    Ok(())
}

/// Plots the time over the number of agents, a line for each scene and engine, as figure 6 of Kim, Kim and Shin 2003.
fn plot_times(runs: &[CrowdBenchRun]) -> String {
    let scene = runs.first().map_or("", |r| &r.scene);
    let is_one = runs.iter().all(|r| r.scene == scene);
    let mut lines: Vec<(String, Vec<[f64; 2]>)> = Vec::new();
    for r in runs {
        let name = if is_one { engine(r).to_owned() } else { format!("{}, {}", r.scene, engine(r)) };
        let point = [agents(r) as f64, 1e-3 * r.us_per_agent() * agents(r) as f64];
        match lines.iter_mut().find(|l| l.0 == name) {
            Some(line) => line.1.push(point),
            None => lines.push((name, vec![point])),
        }
    }
    plot(&Plot {
        title: &format!("{}: time to simulate one second", if is_one { scene } else { "crowds" }),
        subtitle: &compare_engines(runs).filter(|_| is_one).unwrap_or_else(|| "without drawing or measuring".into()),
        axes: ["agents", "time for one simulated second (ms)"],
        lines,
    })
}

/// Text that compares the slowest and the fastest engine at the largest number of agents; `None` for one engine.
fn compare_engines(runs: &[CrowdBenchRun]) -> Option<String> {
    let most = runs.iter().map(agents).max()?;
    let all = || runs.iter().filter(|r| agents(r) == most);
    let slow = all().max_by(|a, b| a.wall_s().total_cmp(&b.wall_s()))?;
    let fast = all().min_by(|a, b| a.wall_s().total_cmp(&b.wall_s()))?;
    let times = slow.wall_s() / fast.wall_s();
    let text = format!("with {most} agents, {} takes {times:.1} times as long as {}", engine(slow), engine(fast));
    (engine(slow) != engine(fast) && times.is_finite()).then_some(text)
}

fn agents(run: &CrowdBenchRun) -> usize {
    run.figures.agents.unwrap_or(0)
}

fn engine(run: &CrowdBenchRun) -> &str {
    run.figures.engine.as_deref().unwrap_or_default()
}
