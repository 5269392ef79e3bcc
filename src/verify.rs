//! `throng verify`: is a bundle whole?

use crate::args::Outcome;
use crate::output;
use serde::Serialize;
use std::path::PathBuf;

/// Check a bundle: layout, checksums, every index and number.
///
/// JSON keys: file, name, generator, version, bundle_bytes, frames, clips, states, actions, policies, sections (object:
/// tag to bytes).
#[derive(clap::Args)]
pub struct Args {
    /// Bundle.
    file: PathBuf,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report {
    file: PathBuf,
    name: String,
    generator: String,
    version: u32,
    bundle_bytes: usize,
    frames: usize,
    clips: usize,
    states: usize,
    actions: usize,
    policies: Vec<String>,
    sections: std::collections::BTreeMap<String, usize>,
}

pub fn run(args: &Args) -> Outcome {
    let tables = crate::args::open(&args.file)?;
    let graph = tables.graph();
    let report = Report {
        file: args.file.clone(),
        name: tables.meta().name.clone(),
        generator: tables.meta().generator.clone(),
        version: throng_runtime::format::VERSION,
        bundle_bytes: tables.num_bytes(),
        frames: tables.frames().len(),
        clips: tables.clips().len(),
        states: graph.states.len(),
        actions: graph.action_segments.len(),
        policies: tables.meta().behaviours.clone(),
        sections: tables.section_sizes().iter().map(|(t, n)| (t.to_string(), *n)).collect(),
    };
    if args.json {
        return output::json(&report);
    }
    let sections: Vec<_> = tables.section_sizes().iter().map(|(t, n)| format!("{t} {n}")).collect();
    output::table(&[
        ("bundle", format!("{} is whole", args.file.display())),
        ("name", format!("{}, written by {}, format version {}", report.name, report.generator, report.version)),
        ("motion", format!("{} clips, {} frames", report.clips, report.frames)),
        ("graph", format!("{} states, {} actions", report.states, report.actions)),
        ("policies", report.policies.join(", ")),
        ("bytes", format!("{}: {}", report.bundle_bytes, sections.join(", "))),
    ])
}
