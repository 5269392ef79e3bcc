//! `throng inspect`: content of a motion file or bundle.

mod environment;
mod scene;

use crate::args::{CommandResult, MOTION_FLAGS, ReadArgs, SelectArgs, fail, given_flags, is_bundle};
use crate::{help, keys, output, progress};
use std::path::PathBuf;
use throng_core::base::error::ensure;
use throng_precompute::inspect::{self, BundleReport, ClipReport, FolderReport, LevelReport, hit_picture};
use throng_precompute::{files, import, picture};

/// Report the content of a motion file (format, units, axes, rest pose, roles, foot contacts, effective hits, and why), of
/// many files (one line each, and what they lack for which behaviour), of a bundle or of a level; or infer the surroundings of the
/// captured clips from contacts.
#[derive(clap::Args)]
#[command(after_long_help = help())]
pub struct Args {
    /// Motion: files (.bvh, .amc, .npz, .glb, .gltf, .fbx; FILE/CLIP for one of several in a file), folders and archives
    /// (.zip), searched to any depth, and patterns; or one bundle (.throng) or level (.level).
    #[arg(required = true, value_name = "FILE_OR_FOLDER")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    read: ReadArgs,
    #[command(flatten)]
    select: SelectArgs,
    /// Draw the effective hitting points from the front, from above and from the side (PNG).
    #[arg(long, value_name = "FILE")]
    hits_png: Option<PathBuf>,
    /// Draw the blend spaces of a bundle: figures at the corners and in the middle of the parameters, three phases each (PNG).
    #[arg(long, value_name = "FILE")]
    blends_png: Option<PathBuf>,
    /// Write the surroundings inferred from contacts (TOML): the surfaces under feet, seats and hands of the clips of one
    /// session. `-units` and `-world` are appended to the name for its units and for a world stitched of them. Heights
    /// are those of a build of the same files with default settings.
    #[arg(long, value_name = "FILE")]
    environment_out: Option<PathBuf>,
    /// Draw the person in the inferred surroundings (PNG).
    #[arg(long, value_name = "FILE")]
    environment_png: Option<PathBuf>,
    /// Find where the limbs of one clip collide with the scene of a task: part, obstacle, from when to when, how deep.
    #[arg(long, value_name = "TASK")]
    scene: Option<PathBuf>,
    /// Print one JSON object; `throng help keys` lists its keys.
    #[arg(long)]
    json: bool,
}

/// Help on the JSON keys, for each kind of input.
fn help() -> String {
    let clip = keys::json_keys_under::<ClipReport>("JSON keys (of a motion file)");
    let bundle = keys::json_keys_under::<BundleReport>("JSON keys (of a bundle)");
    let with = "JSON keys (with --environment-out or --environment-png)";
    let folder = keys::json_keys_under::<FolderReport>("JSON keys (of several motion files or a folder)");
    let scene = keys::json_keys_under::<scene::SceneCollisionReport>("JSON keys (with --scene)");
    let level = keys::json_keys_under::<LevelReport>("JSON keys (of a level)");
    [clip, folder, bundle, level, scene, keys::json_keys_under::<environment::EnvironmentReport<'static>>(with)]
        .join("\n")
}

pub fn run(args: &Args) -> CommandResult {
    if let Some(task) = &args.scene {
        return scene::run(args, task);
    }
    if args.environment_out.is_some() || args.environment_png.is_some() {
        return environment::run(args);
    }
    if let [file] = &args.files[..]
        && crate::level::is_level(file)
    {
        let none = args.hits_png.is_none() && args.blends_png.is_none();
        ensure(none, || "a level has neither hits nor blend spaces; `throng level FILE.level --png OUT.png` draws it")?;
        return output::report(&LevelReport::new(file, &throng_level::Level::open(file)?), args.json, |r| {
            output::text(format_args!("{r}\n"))
        });
    }
    files::check_targets(args.hits_png.iter().chain(&args.blends_png), &args.files)?;
    let is_clip = |p: &PathBuf| {
        import::expand(std::slice::from_ref(p)).is_ok_and(|all| all == [p.clone()]) && !import::holds_several(p)
    };
    let is_one = |p: &PathBuf| is_bundle(p) || is_clip(p);
    let file = match args.files.as_slice() {
        [file] if !file.exists() || is_one(file) => file,
        _ => return inspect_many(args),
    };
    ensure(!args.select.is_given(), || "--use and --leave are for a folder, or several files")?;
    let stem = file.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    let title = format!("{stem}: effective hitting points");
    if is_bundle(file) {
        let tables = crate::args::open_bundle(file)?;
        if let Some(path) = &args.hits_png {
            hit_picture::bundle_hit_picture(&tables, &title).save_png(path)?;
        }
        if let Some(path) = &args.blends_png {
            ensure(!tables.meta().blends.is_empty(), || "--blends-png: the bundle has no blend space")?;
            picture::blend_sheet(&tables)?.save_png(path)?;
        }
        return print(args, &BundleReport::new(file, &tables)?, "run");
    }
    ensure(args.blends_png.is_none(), || "--blends-png is for a bundle")?;
    let inspected = inspect::inspect_clip(file, &args.read.config_for(&args.files)?)?;
    if let Some(path) = &args.hits_png {
        hit_picture::clip_hit_picture(&inspected.clips, &title).save_png(path)?;
    }
    print(args, &inspected.report, "build")
}

/// Inspects several files, or those of a folder.
fn inspect_many(args: &Args) -> CommandResult {
    ensure(args.hits_png.is_none(), || "--hits-png is for one clip or bundle")?;
    ensure(args.blends_png.is_none(), || "--blends-png is for a bundle")?;
    if let Some(bundle) = args.files.iter().find(|f| is_bundle(f)) {
        return fail(format!("{}: expected a bundle alone, or motion alone", bundle.display()));
    }
    let (mut config, bar) = (args.read.config_for(&args.files)?, progress::BuildProgressBar::default());
    args.select.add_to(&mut config);
    let report = inspect::inspect_all(&args.files, &config, &bar)?;
    if report.files.iter().all(|f| f.verdict == "skipped") {
        output::report(&report, args.json, |r| output::text(r))?;
        return fail(format!("none of {} file(s) can be read: a build would make nothing of them", report.files.len()));
    }
    print(args, &report, "build")
}

/// Prints a report, and the command to go on with from the files.
fn print(args: &Args, report: &(impl serde::Serialize + std::fmt::Display), next: &str) -> CommandResult {
    if args.json {
        return output::json(report);
    }
    output::text(report)?;
    let files = args.files.iter().map(|f| f.to_string_lossy().into_owned());
    let words: Vec<String> = std::iter::once(next.to_owned()).chain(files).chain(given_flags(&MOTION_FLAGS)).collect();
    help::next_step(&words.iter().map(String::as_str).collect::<Vec<_>>())
}
