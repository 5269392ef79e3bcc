//! Runs characters and records them as a take, frame by frame.

mod bundle;
mod take_recorder;

use crate::run::{RunRecording, play_scene};
use crate::trial::TrialConfig;
pub use bundle::record_instances;
use std::{ops::RangeInclusive, path::Path};
use take_recorder::TakeRecorder;
use throng_core::Bundle;
use throng_core::base::limits::{EXPORT_HZ, MOMENT_S, SECONDS, STEP_HZ};
use throng_motion::error::{BuildError, Result, ensure};
use throng_motion::{export::Take, progress::Progress};
use throng_simulation::{CompiledScene, Simulation};

/// Default number of steps a simulated second, as for runs (Hz).
const RUN_HZ: f64 = 60.0;
/// Largest difference of times that count as equal (s).
const TIME_TOLERANCE_S: f64 = 1e-6;

/// Source of a take.
#[derive(Clone, Copy, Debug)]
pub enum PerformSource<'a> {
    /// A scene, from its start.
    Scene(&'a CompiledScene),
    /// A recorded run, replayed.
    Recording(&'a RunRecording, &'a CompiledScene),
    /// Characters that each chase a target of their own.
    Trial(&'a Bundle, &'a TrialConfig),
    /// The clips of a bundle, one after the other.
    Clips(&'a Bundle),
}

/// Part of the source to record.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PerformConfig {
    /// Numbers of characters, or of clips; all of them where empty.
    pub characters: Vec<RangeInclusive<usize>>,
    /// First time; the start if absent (s).
    pub from_s: Option<f64>,
    /// Last time; the end if absent (s).
    pub to_s: Option<f64>,
    /// Frames a second; if absent 30, or the own rate of clips (Hz).
    pub rate_hz: Option<f64>,
}

/// A part to record, the folder of its frames until the take is dropped, and who hears how far it is.
#[derive(Clone, Copy)]
struct TakeJob<'a> {
    config: &'a PerformConfig,
    folder: &'a Path,
    progress: &'a dyn Progress,
}

impl TakeJob<'_> {
    /// Error of a file in the folder.
    fn file_error(&self, source: std::io::Error) -> BuildError {
        BuildError::Io { path: self.folder.to_path_buf(), source }
    }
}

/// Default number of frames a second (Hz).
const FRAMES_HZ: f64 = 30.0;

/// Runs a source and records the take.
///
/// - `folder`: folder for the frames until the take is dropped.
///
/// # Errors
/// [`BuildError::Stage`] for characters, times or a rate that the source does not have, and the errors of running it.
pub fn perform(show: PerformSource<'_>, cfg: &PerformConfig, folder: &Path, progress: &dyn Progress) -> Result<Take> {
    cfg.rate_hz()?;
    let job = TakeJob { config: cfg, folder, progress };
    match show {
        PerformSource::Clips(bundle) => bundle::perform_clips(bundle, job),
        PerformSource::Trial(bundle, trial) => bundle::perform_trial(bundle, trial, job),
        PerformSource::Scene(compiled) => {
            let span = TakeSpan::new(cfg, compiled.scene().seconds, None)?;
            let mut sim = Simulation::new(compiled).map_err(|e| export_error(e, "Correct the scene"))?;
            let mut camera = TakeRecorder::for_scene(&sim, span, job)?;
            // Prolonged to whole steps.
            let seconds = ((span.to_s * RUN_HZ - TIME_TOLERANCE_S).ceil().max(1.0)) / RUN_HZ;
            play_scene(&mut sim, seconds, RUN_HZ, seconds, |sim, _| camera.observe_simulation(sim, RUN_HZ))?;
            camera.into_take(sim.time_s())
        }
        PerformSource::Recording(recording, compiled) => {
            STEP_HZ.check("step_hz", None, recording.step_hz).map_err(|e| export_error(e, "Record it again"))?;
            let span = TakeSpan::new(cfg, recording.seconds, Some(recording.seconds))?;
            let sim = Simulation::new(compiled).map_err(|e| export_error(e, "Correct the scene"))?;
            let mut camera = TakeRecorder::for_scene(&sim, span, job)?;
            let hz = recording.step_hz;
            let until_s = Some(span.to_s + 1.0 / hz);
            let sim = recording.replay_observed(compiled, until_s, |sim, _| camera.observe_simulation(sim, hz))?;
            camera.into_take(sim.time_s())
        }
    }
}

impl PerformConfig {
    /// Frames a second (Hz).
    fn rate_hz(&self) -> Result<f64> {
        let hz = self.rate_hz.unwrap_or(FRAMES_HZ);
        EXPORT_HZ.check("fps", None, hz)?;
        Ok(hz)
    }
}

fn export_error(what: impl std::fmt::Display, help: impl Into<String>) -> BuildError {
    BuildError::Stage { stage: "export", message: what.to_string(), help: help.into() }
}

/// Time span to record (s).
#[derive(Clone, Copy)]
struct TakeSpan {
    from_s: f64,
    to_s: f64,
}

impl TakeSpan {
    /// The time span of a config.
    ///
    /// - `end_s`: default end (s); `most_s`: latest possible end (s).
    fn new(config: &PerformConfig, end_s: f64, most_s: Option<f64>) -> Result<Self> {
        let (from_s, to_s) = (config.from_s.unwrap_or(0.0), config.to_s.unwrap_or(end_s));
        let help = "Give --from and --to in seconds, the earlier one first";
        let most = most_s.unwrap_or(SECONDS.most);
        MOMENT_S.check("from", None, from_s)?;
        MOMENT_S.check("to", None, to_s)?;
        if config.to_s.is_none() && to_s < from_s {
            return Err(export_error(format!("--from {from_s}: expected {to_s} s at most, where it ends"), help));
        }
        if to_s < from_s {
            return Err(export_error(format!("--from {from_s} --to {to_s}: the end is earlier than the start"), help));
        }
        if to_s > most + TIME_TOLERANCE_S {
            return Err(export_error(format!("--to {to_s}: expected {most} s at most, where it ends"), help));
        }
        Ok(Self { from_s, to_s })
    }

    fn num_frames(self, rate_hz: f64) -> usize {
        ((self.to_s - self.from_s) * rate_hz + TIME_TOLERANCE_S * rate_hz).floor() as usize + 1
    }
}

/// The selected numbers, out of `total`; `what` names one of them in messages.
fn selected_numbers(config: &PerformConfig, total: usize, what: &str) -> Result<Vec<usize>> {
    let help = format!("Give --characters as 0..{}, or as a list such as 0,4,7..9", total.saturating_sub(1));
    ensure(total > 0, || export_error(format!("there is no {what}"), "Name something else to export"))?;
    if config.characters.is_empty() {
        return Ok((0..total).collect());
    }
    let mut is_chosen = vec![false; total];
    for range in &config.characters {
        if range.is_empty() || *range.end() >= total {
            let (a, b) = (range.start(), range.end());
            return Err(export_error(format!("--characters {a}..{b}: there are {total}, counted from 0"), help));
        }
        is_chosen[range.clone()].fill(true);
    }
    Ok((0..total).filter(|&k| is_chosen[k]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_that_overlap_take_no_more_room_than_all() {
        let config = |characters| PerformConfig { characters, ..PerformConfig::default() };
        let some = config(vec![7..=9, 0..=0, 8..=8]);
        assert_eq!(selected_numbers(&some, 10, "character").unwrap(), [0, 7, 8, 9]);
        let all = config(vec![0..=999_999; 1000]);
        assert_eq!(selected_numbers(&all, 1_000_000, "character").unwrap().len(), 1_000_000);
        assert!(selected_numbers(&config(vec![3..=10]), 10, "character").is_err());
    }

    #[test]
    fn spans_outside_of_the_scene_are_refused_with_what_was_given() {
        for (from_s, to_s, wanted) in [
            (Some(500.0), None, "--from 500: expected 90 s at most, where it ends"),
            (Some(5.0), Some(4.0), "--from 5 --to 4: the end is earlier than the start"),
            (None, Some(91.0), "--to 91: expected 90 s at most, where it ends"),
        ] {
            let config = PerformConfig { from_s, to_s, ..PerformConfig::default() };
            let refused = TakeSpan::new(&config, 90.0, Some(90.0)).err().expect("it is refused").to_string();
            assert!(refused.contains(wanted), "{refused}");
        }
    }
}
