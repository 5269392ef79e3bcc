//! Takes from a bundle: characters that run on it, the clips that they play, and its stored clips.

use super::take_recorder::TakeRecorder;
use super::{PerformConfig, TIME_TOLERANCE_S, TakeJob, TakeSpan, export_error, selected_numbers};
use crate::trial::{self, TrialConfig};
use glam::{Quat, Vec3};
use std::path::Path;
use throng_base::maths;
use throng_core::{Bundle, CharacterGroup, NUM_JOINTS, Planar};
use throng_motion::error::{BuildError, Result};
use throng_motion::export::{ActorPose, CrowdInstance, InstanceRecording, Take, TakeWriter};
use throng_motion::progress::Progress;

pub fn perform_trial(bundle: &Bundle, trial: &TrialConfig, job: TakeJob<'_>) -> Result<Take> {
    let (span, trial) = trial_span(bundle, trial, job.config)?;
    let (hz, who) = (f64::from(trial.step_hz), selected_numbers(job.config, trial.characters, "character")?);
    let actors = who.into_iter().map(|c| (c, format!("character {c}"), bundle.skeleton().clone())).collect();
    let mut camera = TakeRecorder::new(actors, span, job)?;
    let (mut group, _) = trial::scatter_characters(bundle, &trial).map_err(|e| export_error(e, "Check the bundle"))?;
    trial::play(&mut group, &trial, |group, step| {
        let bodies = group.bodies();
        camera.observe(step as f64 / hz, 1.0 / hz, |c| Some(ActorPose::from_model(bodies.roots[c], &bodies.model[c])))
    })?;
    camera.into_take(f64::from(trial.seconds))
}

/// Recorded time span of a trial, and the trial, prolonged to whole steps.
fn trial_span(bundle: &Bundle, trial: &TrialConfig, config: &PerformConfig) -> Result<(TakeSpan, TrialConfig)> {
    let span = TakeSpan::new(config, f64::from(trial.seconds), None)?;
    let hz = f64::from(trial.step_hz);
    let seconds = ((span.to_s * hz - TIME_TOLERANCE_S).ceil().max(1.0)) / hz;
    let trial = TrialConfig { seconds: seconds as f32, recorded: None, ..*trial };
    trial::check(bundle, &trial).map_err(|e| match e {
        BuildError::Stage { message, help, .. } => export_error(message, format!("{help}, or export its --clips")),
        other => other,
    })?;
    Ok((span, trial))
}

/// Lets characters run on a bundle, and records which clip each of them plays and where: at the last step before each
/// frame, without transitions between clips and locks of planted feet.
///
/// - `folder`: folder for the frames until they are dropped.
///
/// # Errors
/// As [`super::perform`].
pub fn record_instances(
    bundle: &Bundle,
    trial: &TrialConfig,
    config: &PerformConfig,
    folder: &Path,
    progress: &dyn Progress,
) -> Result<InstanceRecording> {
    let (span, trial) = trial_span(bundle, trial, config)?;
    let (step_hz, rate_hz) = (f64::from(trial.step_hz), config.rate_hz()?);
    let who = selected_numbers(config, trial.characters, "character")?;
    let clips = bundle.meta().clips.iter().map(|c| c.name.clone()).collect();
    let io = |e| TakeJob { config, folder, progress }.file_error(e);
    let mut out = InstanceRecording::new(folder, clips, who.clone(), rate_hz).map_err(io)?;
    let (mut next, frames) = (0, span.num_frames(rate_hz));
    progress.begin("record", frames as u64, "frames");
    let (mut group, _) = trial::scatter_characters(bundle, &trial).map_err(|e| export_error(e, "Check the bundle"))?;
    trial::play(&mut group, &trial, |group, step| {
        let until_s = (step + 1) as f64 / step_hz - TIME_TOLERANCE_S;
        while next < frames && span.from_s + next as f64 / rate_hz < until_s {
            progress.check()?;
            for (i, &c) in who.iter().enumerate() {
                let (segment, frames) = group.characters().segment(c);
                out.push(i, playing_instance(bundle, segment, frames, group.characters().root(c))).map_err(io)?;
            }
            next += 1;
            progress.advance(1);
        }
        Ok(())
    })?;
    progress.end();
    out.finish().map_err(io)?;
    Ok(out)
}

/// Clip instance of a character that is `frames` frames into a segment, at its planar root.
fn playing_instance(bundle: &Bundle, segment: u32, frames: f32, root: Planar) -> CrowdInstance {
    let Some(segment) = bundle.graph().segments.get(segment as usize) else {
        return CrowdInstance { place: [root.x, root.z, root.heading], ..CrowdInstance::default() };
    };
    let clip = bundle.clips()[segment.clip as usize];
    let last = clip.first_frame + clip.num_frames - 1;
    let at = (segment.start as f32 + frames).min(last as f32);
    let (before, ratio) = (at.floor() as u32, at.fract());
    let [a, b] = [before, (before + 1).min(last)].map(|row| bundle.frames()[row as usize].planar);
    let own = Planar::from_array(std::array::from_fn(|k| a[k] + (b[k] - a[k]) * ratio));
    let place = root.compose(own.inverse());
    let time_s = (at - clip.first_frame as f32) / bundle.meta().rate_hz as f32;
    CrowdInstance { clip: Some(segment.clip), time_s, place: [place.x, place.z, place.heading] }
}

/// Takes the clips of a bundle as they are stored.
pub fn perform_clips(bundle: &Bundle, job: TakeJob<'_>) -> Result<Take> {
    let TakeJob { config, folder, progress } = job;
    if config.rate_hz.is_some() || config.from_s.is_some() || config.to_s.is_some() {
        let help = "Leave out --fps, --from and --to: clips are written whole, at the rate of the bundle";
        return Err(export_error("clips have times and a rate of their own", help));
    }
    let who = selected_numbers(config, bundle.clips().len(), "clip in the bundle")?;
    let names = &bundle.meta().clips;
    let actor = |&c: &usize| (c, names[c].name.clone(), bundle.skeleton().clone());
    let io = |e| job.file_error(e);
    let mut writer = TakeWriter::library(folder, who.iter().map(actor).collect(), bundle.meta().rate_hz).map_err(io)?;
    progress.begin("record", who.len() as u64, "clips");
    for (a, &clip) in who.iter().enumerate() {
        progress.check()?;
        let record = bundle.clips()[clip];
        for row in record.first_frame..record.first_frame + record.num_frames {
            writer.push(a, Some(stored_pose(bundle, row as usize))).map_err(io)?;
        }
        writer.finish(a).map_err(io)?;
        progress.advance(1);
    }
    progress.end();
    writer.into_take().map_err(io)
}

/// Pose of a stored frame of a bundle.
fn stored_pose(bundle: &Bundle, row: usize) -> ActorPose {
    let (row, code) = (&bundle.frames()[row], bundle.rotation_code());
    let root = Planar::from_array(row.planar);
    let mut rotations: [Quat; NUM_JOINTS] = std::array::from_fn(|j| code.rotation(row, j));
    rotations[0] = maths::compose(root.rotation(), rotations[0]).normalize();
    ActorPose::from_rotations(bundle.skeleton(), root.translation() + Vec3::Y * row.height, rotations)
}
