//! Surroundings inferred from the contacts of clips: files, a report and a picture.

use crate::args::{CommandResult, fail};
use crate::{help, output, progress};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::Path;
use throng_core::{Joint, base::error::ensure};
use throng_precompute::environment::{InferReport, InferredEnvironment, infer_environment};
use throng_precompute::picture::{self, BodyColours, BodyFigure, Colour, Picture};
use throng_precompute::picture::{WorldCamera, WorldFigure, WorldSheet};
use throng_precompute::{BuildError, Clip, ClipSet, Warnings, files, import, pipeline, stitch::SavedFiles};

/// Least distance between bodies in a picture (m).
const MIN_DISTANCE_M: f32 = 0.5;
/// Greatest number of bodies in a picture.
const MAX_BODIES: usize = 14;
/// Distance between candidate frames of a picture (frames).
const FRAME_STRIDE: usize = 5;
/// Greatest number of clips that a title names.
const MAX_NAMED_CLIPS: usize = 4;
/// Width and height of one view (px).
const SIZE: (u32, u32) = (1600, 900);
/// View directions of the picture, along +Z and along +X, tilted down: heading and elevation (rad).
const VIEW_ANGLES: [(f32, f32); 2] = [(0.0, 0.3), (std::f32::consts::FRAC_PI_2, 0.3)];

/// Printed report.
#[derive(Serialize, JsonSchema)]
pub struct EnvironmentReport<'a> {
    /// Names of the clips.
    clips: Vec<&'a str>,
    /// Frames of all clips.
    frames: usize,
    #[serde(flatten)]
    inferred: &'a InferReport,
    #[serde(flatten)]
    saved: Option<SavedFiles>,
}

/// Infers the surroundings in which the people in the clips stand, sit and hang; writes, draws and reports them.
pub fn run(args: &super::Args) -> CommandResult {
    files::check_targets(args.environment_out.iter().chain(&args.environment_png), &args.files)?;
    if let Some(bundle) = args.files.iter().find(|f| crate::args::is_bundle(f)) {
        return fail(format!("{}: expected a motion file: surroundings are inferred from clips", bundle.display()));
    }
    let fault = "--hits-png is for one clip or bundle without --environment-out and --environment-png";
    ensure(args.hits_png.is_none(), || fault)?;
    let set = read_clips(args)?;
    let stem = |p: &Path| p.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    let name = args.environment_out.as_deref().map_or_else(|| set.clips[0].name.clone(), stem);
    let clips: Vec<&Clip> = set.clips.iter().collect();
    let inferred = infer_environment(&clips, &set.skeleton, &name)?;
    let saved = args.environment_out.as_ref().map(|path| inferred.save(path)).transpose()?;
    if let Some(path) = &args.environment_png {
        draw(&set, &inferred)?.save_png(path)?;
    }
    let report = EnvironmentReport {
        clips: set.clips.iter().map(|c| c.name.as_str()).collect(),
        frames: set.num_frames(),
        inferred: &inferred.report,
        saved,
    };
    if args.json {
        return output::json(&report);
    }
    print(&report)?;
    let files = args.files.iter().map(|f| f.to_string_lossy());
    // First a picture of what was found, then the bundle.
    let out = args.environment_out.as_ref().filter(|_| args.environment_png.is_none());
    let png = out.map(|out| out.with_extension("png").to_string_lossy().into_owned());
    let mut words = vec![if png.is_some() { "inspect" } else { "build" }.into()];
    words.extend(files);
    words.extend(png.into_iter().flat_map(|png| ["--environment-png".into(), png.into()]));
    help::next_step(&words.iter().map(|word| &**word).collect::<Vec<_>>())
}

/// Reads the clips as a build with default settings does, so that heights agree.
fn read_clips(args: &super::Args) -> CommandResult<ClipSet> {
    let mut config = args.read.config_for(&args.files)?;
    config.import.strict = true;
    let raw = import::read(&args.files, &config.import, &progress::BuildProgressBar::default())?;
    let mut warnings = Warnings::default();
    let clips = pipeline::clips_of(&raw.clips, &config, &mut warnings)?;
    output::warnings(&[], &warnings.messages);
    ensure(!clips.clips.is_empty(), || "expected at least one clip, found none")?;
    Ok(clips)
}

/// Draws the person at several moments in the inferred surroundings, from two sides.
fn draw(set: &ClipSet, inferred: &InferredEnvironment) -> Result<Picture, BuildError> {
    let geometry = inferred.geometry()?;
    let units = picture::world_units(&geometry);
    let bodies = spread_bodies(set);
    let tint = |i: usize| Colour::hex([0x4a6fa5, 0xb5653f, 0x5f8f56, 0x87609c][i % 4]);
    let figure = |(i, f): (usize, &BodyFigure)| WorldFigure { figure: *f, colours: BodyColours::plain(tint(i)) };
    let figures: Vec<WorldFigure> = bodies.iter().enumerate().map(figure).collect();
    let mut names: Vec<&str> = set.clips.iter().take(MAX_NAMED_CLIPS).map(|c| c.name.as_str()).collect();
    names.extend((set.clips.len() > MAX_NAMED_CLIPS).then_some("..."));
    let title = format!("{}: inferred from {}", inferred.environment.name, names.join(", "));
    let subtitle = inferred.report.to_string().lines().take(2).collect::<Vec<_>>().join("; ");
    let view = |(heading, elevation)| {
        picture::world_sheet(&WorldSheet {
            title: &title,
            subtitle: &subtitle,
            size: SIZE,
            figures: &figures,
            units: &units,
            camera: WorldCamera { heading, elevation, focus: None },
            ..WorldSheet::default()
        })
    };
    let [front, side] = VIEW_ANGLES.map(view);
    Ok(picture::sheet(&[&front, &side]))
}

/// Selects bodies far from each other: the first one, then repeatedly the one farthest from all selected ones.
fn spread_bodies(set: &ClipSet) -> Vec<BodyFigure> {
    let (skeleton, mut all) = (&set.skeleton, Vec::new());
    for clip in &set.clips {
        let frames = (0..clip.num_frames()).step_by(FRAME_STRIDE).filter(|&f| clip.is_usable(f));
        all.extend(frames.map(|f| BodyFigure::from_transforms(skeleton, &clip.joint_transforms(skeleton, f))));
    }
    let mut near = vec![f32::INFINITY; all.len()];
    let mut out = Vec::new();
    let mut next = all.first();
    while let Some(one) = next.filter(|_| out.len() < MAX_BODIES) {
        out.push(*one);
        let hips = one.joint(Joint::Hips);
        near.iter_mut().zip(&all).for_each(|(d, f)| *d = d.min(f.joint(Joint::Hips).distance(hips)));
        let farthest = near.iter().zip(&all).filter(|(d, _)| **d > MIN_DISTANCE_M).max_by(|a, b| a.0.total_cmp(b.0));
        next = farthest.map(|(_, f)| f);
    }
    out
}

fn print(report: &EnvironmentReport) -> CommandResult {
    let (clips, frames) = (&report.clips, report.frames);
    output::text(format_args!("{} clips, {frames} frames: {}\n{}\n", clips.len(), clips.join(", "), report.inferred))?;
    if let Some(saved) = &report.saved {
        let SavedFiles { environment_out, units_out, world_out } = saved;
        let files = [environment_out, units_out, world_out].map(|f| f.display().to_string());
        output::text(format_args!("written {}\n", files.join(", ")))?;
    }
    Ok(())
}
