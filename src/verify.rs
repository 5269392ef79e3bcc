//! `throng verify`: checks that a bundle is intact.

use crate::{args::CommandResult, keys, output};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::PathBuf;

/// Check a bundle: layout, checksums, every index and number.
#[derive(clap::Args)]
#[command(after_long_help = keys::json_keys::<VerifyReport>())]
pub struct Args {
    /// Bundle.
    file: PathBuf,
    /// Print one JSON object; `throng help keys` lists its keys.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize, JsonSchema)]
struct VerifyReport {
    /// The file.
    file: PathBuf,
    /// Name of the database.
    name: String,
    /// Program and version that wrote the bundle.
    generator: String,
    /// Version of the format.
    version: u32,
    /// Length of the file (bytes).
    bundle_bytes: usize,
    /// Frames of all clips.
    frames: usize,
    /// Clips, mirrored copies included.
    clips: usize,
    /// States of the motion graph.
    states: usize,
    /// Actions of all states.
    actions: usize,
    /// Names of the behaviours.
    policies: Vec<String>,
    /// Size of each section, by tag (bytes).
    sections: std::collections::BTreeMap<String, usize>,
}

pub fn run(args: &Args) -> CommandResult {
    let tables = crate::args::open_bundle(&args.file)?;
    let graph = tables.graph();
    let report = VerifyReport {
        file: args.file.clone(),
        name: tables.meta().name.clone(),
        generator: tables.meta().generator.clone(),
        version: throng_core::format::VERSION,
        bundle_bytes: tables.num_bytes(),
        frames: tables.frames().len(),
        clips: tables.clips().len(),
        states: graph.states.len(),
        actions: graph.action_segments.len(),
        policies: tables.meta().behaviours.clone(),
        sections: tables.section_sizes().map(|(t, n)| (t.to_string(), n)).collect(),
    };
    if args.json {
        return output::json(&report);
    }
    let sections: Vec<_> = tables.section_sizes().map(|(t, n)| format!("{t} {n}")).collect();
    output::table(&[
        ("bundle", format!("{} is whole", args.file.display())),
        ("name", format!("{}, written by {}, format version {}", report.name, report.generator, report.version)),
        ("motion", format!("{} clips, {} frames", report.clips, report.frames)),
        ("graph", format!("{} states, {} actions", report.states, report.actions)),
        ("policies", report.policies.join(", ")),
        ("bytes", format!("{}: {}", report.bundle_bytes, sections.join(", "))),
    ])
}
