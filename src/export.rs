//! `throng export`: running characters, motion, graphs and policies for other programs.

mod take;

use crate::args::{CommandResult, ReadArgs, fail, given_flags, is_bundle, open_bundle};
use crate::help;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use throng_core::base::error::ensure;
use throng_precompute::annotate::hits::{self, HitPoint};
use throng_precompute::import::{clip_in_file, is_motion, read_clip};
use throng_precompute::{ClipSet, Warnings, export, files, graph, pipeline, policy};

/// Write running characters, or motion, for other programs, from a scene, a recording, a bundle or a motion file.
///
/// Characters are written as glb, usda, bvh, npz, amass or csv. A scene is run as by `throng run SCENE`, a recording is
/// replayed, and characters run on a bundle as by `throng run BUNDLE`, or its clips are written. Frames are
/// kept in a temporary file beside the output.
#[derive(clap::Args)]
pub struct Args {
    /// Scene (.toml), recording (of `throng run --record`), bundle (.throng) or motion file (.bvh, .amc, .npz, .glb,
    /// .gltf, .fbx; FILE/CLIP for one of several in a file).
    file: PathBuf,
    /// Format to write: glb, usda, bvh, amass, npz, csv, instances, positions-csv, graph-json, policy-csv or hits-csv. For any input: `glb` (skins and animation), `usda` (UsdSkel), `bvh` and `amass` (a file for each
    /// character; SMPL order, axis-angle), `npz` (all in NumPy arrays) or `csv` (joints of all characters over time). For
    /// a motion file: `bvh` and `positions-csv` (frame,joint,x,y,z in metres, Y up), as it was read. For a bundle:
    /// `instances` (which clips play on characters, as NumPy arrays, to be drawn with `glb` of its `--clips`),
    /// `graph-json` (states and actions) or `policy-csv` (values with cell coordinates). For bundles and motion files:
    /// `hits-csv` (effective hits as seen from the planar root: +X left, Y up, +Z ahead, in metres).
    #[arg(long, hide_possible_values = true)]
    format: Format,
    /// File to write; standard output by default.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Write a clip on the database skeleton, at the database rate, instead of as it was read.
    #[arg(long)]
    retargeted: bool,
    #[command(flatten)]
    take: take::TakeArgs,
    #[command(flatten)]
    read: ReadArgs,
    /// Behaviour whose policy is written; the first by default.
    #[arg(long, value_name = "NAME")]
    behaviour: Option<String>,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Format {
    Glb,
    Usda,
    Bvh,
    Npz,
    Amass,
    Csv,
    Instances,
    PositionsCsv,
    GraphJson,
    PolicyCsv,
    HitsCsv,
}

/// True for the name of a motion file, or of a clip in one.
fn holds_motion(file: &Path) -> bool {
    is_motion(file) || clip_in_file(file).is_some()
}

pub fn run(args: &Args) -> CommandResult {
    export_file(args)?;
    let Some(out) = &args.out else { return Ok(()) };
    let name = out.to_string_lossy();
    let folder = files::folder_of(out).to_string_lossy();
    match args.format {
        Format::Glb | Format::Bvh if out.is_file() => help::next_step(&["inspect", &name]),
        Format::Glb | Format::Bvh | Format::Amass => help::next_step(&["inspect", &folder]),
        Format::Npz | Format::Instances => {
            help::next_command("python3", &["-c", &format!("import numpy; print(numpy.load({name:?}).files)")])
        }
        _ => help::next_command("head", &[&name]),
    }
}

fn export_file(args: &Args) -> CommandResult {
    let is_take = match args.format {
        Format::PositionsCsv | Format::HitsCsv | Format::GraphJson | Format::PolicyCsv => false,
        Format::Bvh => !holds_motion(&args.file),
        _ => true,
    };
    if !is_take {
        if let Some(given) = given_flags(&take::FLAGS).first() {
            return fail(format!("{given} is for glb, usda, bvh, npz, amass and csv"));
        }
        files::check_targets(&args.out, [&args.file])?;
    }
    match args.format {
        _ if is_take => take::run(args),
        Format::HitsCsv => {
            let points = match is_bundle(&args.file) {
                true => HitPoint::from_bundle(&open_bundle(&args.file)?),
                false => HitPoint::from_clip_set(&retargeted_clip(args)?),
            };
            write(args.out.as_deref(), |w| hits::write_csv(&points, w))
        }
        Format::GraphJson => {
            let tables = open_bundle(&args.file)?;
            write(args.out.as_deref(), |w| graph::write_graph_json(&graph::graph_rows(&tables), w))
        }
        Format::PolicyCsv => {
            let tables = open_bundle(&args.file)?;
            let known = &tables.meta().behaviours;
            let index = args.behaviour.as_ref().or(known.first()).and_then(|name| tables.find_policy(name).ok());
            let fault = || format!("{}: no such behaviour; there are: {}", args.file.display(), known.join(", "));
            let policy = &tables.policies()[index.ok_or_else(fault)?];
            write(args.out.as_deref(), |w| policy::write_csv(policy, w))
        }
        _ => clip(args),
    }
}

fn clip(args: &Args) -> CommandResult {
    let formats = "glb, usda, bvh, npz, amass, csv, graph-json, policy-csv or hits-csv";
    let fault = format!("a bundle is written as {formats}; positions-csv is of a motion file");
    ensure(!is_bundle(&args.file), || format!("{}: {fault}", args.file.display()))?;
    let raw = if args.retargeted {
        let set = retargeted_clip(args)?;
        export::to_raw(&set.clips[0], &set.skeleton)
    } else {
        let config = args.read.config_for(std::slice::from_ref(&args.file))?;
        read_clip(&args.file, &config.import)?.clip
    };
    write(args.out.as_deref(), |w| match args.format {
        Format::Bvh => export::bvh::write_clip(&raw, w),
        _ => export::positions_csv(&raw, w),
    })
}

/// The clip of the file on the database skeleton, as a build would use it.
fn retargeted_clip(args: &Args) -> CommandResult<ClipSet> {
    let config = args.read.config_for(std::slice::from_ref(&args.file))?;
    let imported = read_clip(&args.file, &config.import)?;
    Ok(pipeline::clips_of(&[imported], &config, &mut Warnings::default())?)
}

/// Writes to a file, which appears when it is complete, or to standard output.
fn write(out: Option<&Path>, body: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> CommandResult {
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
