//! `throng export`: motion, graphs and policies for other programs.

use crate::args::{Outcome, ReadArgs, fail};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use throng_precompute::annotate::hits::{self, HitPoint};
use throng_precompute::import::read_clip;
use throng_precompute::{Warnings, export, files, graph, pipeline, policy};

/// Write a clip as positions or BVH, a bundle's graph or policy, or the effective hits of either.
#[derive(clap::Args)]
pub struct Args {
    /// Motion file (.bvh, .amc, .npz, .glb, .gltf, .fbx; FILE/CLIP for one of several in a file) or bundle (.throng).
    file: PathBuf,
    /// What to write: of a clip `positions-csv` (frame,joint,x,y,z in metres, Y up) or `bvh`; of a bundle
    /// `graph-json` (states and actions) or `policy-csv` (values with cell coordinates); of either `hits-csv` (effective
    /// hits as seen from the planar root: +X left, Y up, +Z ahead, in metres).
    #[arg(long)]
    format: Format,
    /// File to write; standard output by default.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Write a clip on the database skeleton, at the database rate, instead of as it was read.
    #[arg(long)]
    retargeted: bool,
    #[command(flatten)]
    read: ReadArgs,
    /// Behaviour whose policy is written; the first by default.
    #[arg(long, value_name = "NAME")]
    behaviour: Option<String>,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Format {
    PositionsCsv,
    Bvh,
    GraphJson,
    PolicyCsv,
    HitsCsv,
}

pub fn run(args: &Args) -> Outcome {
    match args.format {
        Format::PositionsCsv | Format::Bvh => clip(args),
        Format::HitsCsv => {
            let points = if crate::args::is_bundle(&args.file) {
                HitPoint::of_tables(&crate::args::open(&args.file)?)
            } else {
                let config = args.read.config()?;
                let imported = read_clip(&args.file, &config.import)?;
                HitPoint::of_set(&pipeline::clips_of(&[imported], &config, &mut Warnings::default())?)
            };
            write(args.out.as_deref(), |w| hits::write_csv(&points, w))
        }
        Format::GraphJson => {
            let tables = crate::args::open(&args.file)?;
            write(args.out.as_deref(), |w| graph::write_graph_json(&graph::graph_rows(&tables), w))
        }
        Format::PolicyCsv => {
            let tables = crate::args::open(&args.file)?;
            let name = args.behaviour.as_ref().or(tables.meta().behaviours.first());
            let Some(index) = name.and_then(|n| tables.find_policy(n).ok()) else {
                let known = tables.meta().behaviours.join(", ");
                return fail(format!("{}: no such behaviour; there are: {known}", args.file.display()));
            };
            write(args.out.as_deref(), |w| policy::write_csv(&tables.policies()[index], w))
        }
    }
}

fn clip(args: &Args) -> Outcome {
    if crate::args::is_bundle(&args.file) {
        return fail(format!(
            "{}: a bundle is written as graph-json, policy-csv or hits-csv, a clip as positions-csv, bvh or hits-csv",
            args.file.display()
        ));
    }
    let config = args.read.config()?;
    let imported = read_clip(&args.file, &config.import)?;
    let raw = if args.retargeted {
        let clips = pipeline::clips_of(&[imported], &config, &mut Warnings::default())?;
        export::to_raw(&clips.clips[0], &clips.skeleton)
    } else {
        imported.clip
    };
    write(args.out.as_deref(), |w| match args.format {
        Format::Bvh => export::bvh::write(&raw, w),
        _ => export::positions_csv(&raw, w),
    })
}

/// Writes to the file, which appears when it is complete, or to standard output.
fn write(out: Option<&Path>, body: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Outcome {
    match out {
        Some(path) => Ok(files::write_atomically(path, body)?),
        None => {
            let mut buffered = io::BufWriter::new(io::stdout().lock());
            body(&mut buffered)?;
            buffered.flush()?;
            Ok(())
        }
    }
}
