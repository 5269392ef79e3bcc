//! Lets characters do what a run has them do, and keeps it as a take, frame by frame.

use crate::run::{Recording, play};
use crate::trial::{self, TrialConfig};
use glam::{Quat, Vec3};
use std::ops::RangeInclusive;
use std::path::Path;
use throng_motion::error::BuildError;
use throng_motion::export::{Pose, Take, TakeWriter};
use throng_motion::progress::Progress;
use throng_runtime::base::limits::{SECONDS, STEP_HZ};
use throng_runtime::simulation::{CompiledScene, Motion, Simulation};
use throng_runtime::{Bundle, Cast, NUM_JOINTS, Planar, Skeleton};

/// Steps a simulated second where nothing else is said, as runs have it (Hz).
const RUN_HZ: f64 = 60.0;
/// Frames a second that may be asked for (Hz).
const RATES_HZ: RangeInclusive<f64> = 1.0..=1000.0;
/// Times nearer to each other than this are one (s).
const SAME_S: f64 = 1e-6;

/// What is performed.
#[derive(Clone, Copy, Debug)]
pub enum Show<'a> {
    /// A scene, from its start.
    Scene(&'a CompiledScene),
    /// A run that was kept, again.
    Recording(&'a Recording, &'a CompiledScene),
    /// Characters who each chase a target of their own.
    Trial(&'a Bundle, &'a TrialConfig),
    /// The clips of a bundle, one after the other.
    Clips(&'a Bundle),
}

/// Which part of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PerformConfig {
    /// Numbers of characters, or of clips; all of them where empty.
    pub characters: Vec<RangeInclusive<usize>>,
    /// First moment; the start where absent (s).
    pub from_s: Option<f64>,
    /// Last moment; the end where absent (s).
    pub to_s: Option<f64>,
    /// Frames a second; 30, or of clips their own, where absent (Hz).
    pub rate_hz: Option<f64>,
}

/// Frames a second where nothing else is said (Hz).
const FRAMES_HZ: f64 = 30.0;

/// Performs a show.
///
/// - `folder`: where the frames are kept until the take is dropped.
///
/// # Errors
/// [`BuildError::Stage`] for characters, times or a rate that the show does not have, and what running it fails with.
pub fn perform(
    show: Show<'_>,
    config: &PerformConfig,
    folder: &Path,
    progress: &dyn Progress,
) -> Result<Take, BuildError> {
    if let Some(hz) = config.rate_hz.filter(|hz| !RATES_HZ.contains(hz)) {
        let (least, most) = (RATES_HZ.start(), RATES_HZ.end());
        let what = format!("--fps {hz}: expected {least} to {most} frames a second");
        return Err(refused(what, "30 suits most programs"));
    }
    match show {
        Show::Clips(bundle) => clips(bundle, config, folder, progress),
        Show::Trial(bundle, trial) => of_trial(bundle, trial, config, folder, progress),
        Show::Scene(compiled) => {
            let span = Span::new(config, compiled.scene().seconds, None)?;
            let mut sim = Simulation::new(compiled).map_err(|e| refused(e, "Correct the scene"))?;
            let mut camera = Camera::of_scene(&sim, config, span, folder, progress)?;
            // As long as whole steps last.
            let seconds = ((span.to_s * RUN_HZ - SAME_S).ceil().max(1.0)) / RUN_HZ;
            play(&mut sim, seconds, RUN_HZ, seconds, |sim, _| camera.see(sim, RUN_HZ))?;
            camera.into_take(sim.time_s())
        }
        Show::Recording(recording, compiled) => {
            STEP_HZ.check("step_hz", None, recording.step_hz).map_err(|e| refused(e, "Record it again"))?;
            let span = Span::new(config, recording.seconds, Some(recording.seconds))?;
            let sim = Simulation::new(compiled).map_err(|e| refused(e, "Correct the scene"))?;
            let mut camera = Camera::of_scene(&sim, config, span, folder, progress)?;
            let hz = recording.step_hz;
            let until_s = Some(span.to_s + 1.0 / hz);
            let sim = recording.replay_seen(compiled, until_s, |sim, _| camera.see(sim, hz))?;
            camera.into_take(sim.time_s())
        }
    }
}

fn refused(what: impl std::fmt::Display, help: impl Into<String>) -> BuildError {
    BuildError::Stage { stage: "export", message: what.to_string(), help: help.into() }
}

/// From when to when (s).
#[derive(Clone, Copy)]
struct Span {
    from_s: f64,
    to_s: f64,
}

impl Span {
    /// - `end_s`: where it ends if nothing is said; `most_s`: after which there is nothing (s).
    fn new(config: &PerformConfig, end_s: f64, most_s: Option<f64>) -> Result<Self, BuildError> {
        let (from_s, to_s) = (config.from_s.unwrap_or(0.0), config.to_s.unwrap_or(end_s));
        let help = "Give --from and --to in seconds, the earlier one first";
        let most = most_s.unwrap_or(SECONDS.most);
        if !(from_s >= 0.0 && to_s >= from_s) {
            return Err(refused(format!("--from {from_s} --to {to_s}: expected 0 or later to no earlier"), help));
        }
        if to_s > most + SAME_S {
            return Err(refused(format!("--to {to_s}: expected {most} s at most, where it ends"), help));
        }
        Ok(Self { from_s, to_s })
    }

    fn num_frames(self, rate_hz: f64) -> usize {
        ((self.to_s - self.from_s) * rate_hz + SAME_S * rate_hz).floor() as usize + 1
    }
}

/// Numbers that are asked for, of so many.
fn chosen(config: &PerformConfig, total: usize, what: &str) -> Result<Vec<usize>, BuildError> {
    let help = format!("Give --characters as 0..{}, or as a list such as 0,4,7..9", total.saturating_sub(1));
    if total == 0 {
        return Err(refused(format!("there is no {what}"), "Name something else to export"));
    }
    if config.characters.is_empty() {
        return Ok((0..total).collect());
    }
    let mut out: Vec<usize> = Vec::new();
    for range in &config.characters {
        if range.is_empty() || *range.end() >= total {
            let (a, b) = (range.start(), range.end());
            return Err(refused(format!("--characters {a}..{b}: there are {total}, counted from 0"), help));
        }
        out.extend(range.clone());
    }
    out.sort_unstable();
    out.dedup();
    Ok(out)
}

/// Keeps what some characters do at evenly spaced times; between two steps, poses are blended.
struct Camera<'a> {
    writer: TakeWriter,
    who: Vec<usize>,
    span: Span,
    rate_hz: f64,
    num_frames: usize,
    next: usize,
    /// The step before, where it is needed.
    before: Option<(f64, Vec<Option<Pose>>)>,
    folder: &'a Path,
    progress: &'a dyn Progress,
}

impl<'a> Camera<'a> {
    fn new(
        actors: Vec<(usize, String, Skeleton)>,
        span: Span,
        config: &PerformConfig,
        folder: &'a Path,
        progress: &'a dyn Progress,
    ) -> Result<Self, BuildError> {
        let rate_hz = config.rate_hz.unwrap_or(FRAMES_HZ);
        let who: Vec<usize> = actors.iter().map(|a| a.0).collect();
        let together = who.len().max(2);
        let io = |source| BuildError::Io { path: folder.to_path_buf(), source };
        let writer = TakeWriter::new(folder, actors, rate_hz, together).map_err(io)?;
        let num_frames = span.num_frames(rate_hz);
        progress.begin("record", num_frames as u64, "frames");
        Ok(Self { writer, who, span, rate_hz, num_frames, next: 0, before: None, folder, progress })
    }

    /// Of characters of a scene who have bodies.
    fn of_scene(
        sim: &Simulation,
        config: &PerformConfig,
        span: Span,
        folder: &'a Path,
        progress: &'a dyn Progress,
    ) -> Result<Self, BuildError> {
        let mut who = chosen(config, sim.num_characters(), "character in the scene")?;
        let group = |c: usize| sim.groups().iter().find(|g| g.characters.contains(&c));
        let is_bare = |c: usize| group(c).is_none_or(|g| g.motion == Motion::None);
        let bare = who.iter().copied().find(|&c| is_bare(c));
        let is_asked = !config.characters.is_empty();
        who.retain(|&c| !is_bare(c));
        if let Some(c) = bare.filter(|_| is_asked || who.is_empty()) {
            let name = group(c).map_or("", |g| &g.name);
            let what = format!("character {c} has no body: its group \"{name}\" has motion = \"none\"");
            let help =
                "Give the group a bundle and motion = \"blend\"; `throng run --trajectories` writes where agents go";
            return Err(refused(what, help));
        }
        let skeleton = |c: usize| {
            let bundle = group(c).and_then(|g| sim.compiled().bundle(g.number).ok());
            bundle.map_or_else(Skeleton::default, |b| b.skeleton().clone())
        };
        let name = |c: usize| format!("{} {c}", group(c).map_or("character", |g| &g.name));
        let actors = who.into_iter().map(|c| (c, name(c), skeleton(c))).collect();
        Self::new(actors, span, config, folder, progress)
    }

    fn see(&mut self, sim: &Simulation, hz: f64) -> Result<(), BuildError> {
        self.observe(sim.time_s(), 1.0 / hz, |c| Some(Pose::of_model(sim.root(c)?, sim.pose(c)?)))
    }

    /// - `ahead_s`: time to the next step (s).
    fn observe(&mut self, time_s: f64, ahead_s: f64, pose: impl Fn(usize) -> Option<Pose>) -> Result<(), BuildError> {
        let all = |who: &[usize]| who.iter().map(|&c| pose(c)).collect::<Vec<_>>();
        let mut now = None;
        loop {
            let at_s = self.span.from_s + self.next as f64 / self.rate_hz;
            if self.next == self.num_frames || at_s > time_s + SAME_S {
                break;
            }
            self.progress.check()?;
            let now = now.get_or_insert_with(|| all(&self.who));
            for (a, to) in now.iter().enumerate() {
                let between = match (&self.before, to) {
                    (Some((before_s, from)), Some(to)) if at_s < time_s - SAME_S => {
                        let ratio = ((at_s - before_s) / (time_s - before_s)) as f32;
                        from[a].map(|from| from.towards(to, ratio))
                    }
                    _ => *to,
                };
                let io = |source| BuildError::Io { path: self.folder.to_path_buf(), source };
                self.writer.push(a, between).map_err(io)?;
            }
            self.next += 1;
            self.progress.advance(1);
        }
        let next_s = self.span.from_s + self.next as f64 / self.rate_hz;
        let is_between = self.next < self.num_frames && next_s < time_s + ahead_s - SAME_S;
        self.before = is_between.then(|| (time_s, now.unwrap_or_else(|| all(&self.who))));
        Ok(())
    }

    /// - `ended_s`: when the run ended (s).
    fn into_take(self, ended_s: f64) -> Result<Take, BuildError> {
        self.progress.end();
        if self.next == 0 {
            let what = format!("--from {}: the run has ended by {ended_s:.3} s", self.span.from_s);
            return Err(refused(what, "Begin earlier"));
        }
        self.writer.into_take().map_err(|source| BuildError::Io { path: self.folder.to_path_buf(), source })
    }
}

fn of_trial(
    bundle: &Bundle,
    trial: &TrialConfig,
    config: &PerformConfig,
    folder: &Path,
    progress: &dyn Progress,
) -> Result<Take, BuildError> {
    let span = Span::new(config, f64::from(trial.seconds), None)?;
    let hz = f64::from(trial.step_hz);
    let seconds = ((span.to_s * hz - SAME_S).ceil().max(1.0)) / hz;
    let trial = TrialConfig { seconds: seconds as f32, recorded: None, ..*trial };
    trial::check(bundle, &trial).map_err(|e| match e {
        BuildError::Stage { message, help, .. } => refused(message, format!("{help}, or export its --clips")),
        other => other,
    })?;
    let who = chosen(config, trial.characters, "character")?;
    let actors = who.into_iter().map(|c| (c, format!("character {c}"), bundle.skeleton().clone())).collect();
    let mut camera = Camera::new(actors, span, config, folder, progress)?;
    let (mut cast, _) = trial::scatter(bundle, &trial).map_err(|e| refused(e, "Check the bundle"))?;
    trial::play(&mut cast, &trial, |cast, step| {
        let bodies = cast.bodies();
        camera.observe(step as f64 / hz, 1.0 / hz, |c| Some(Pose::of_model(bodies.roots[c], &bodies.model[c])))
    })?;
    camera.into_take(seconds)
}

/// The clips of a bundle, as they are stored.
fn clips(bundle: &Bundle, config: &PerformConfig, folder: &Path, progress: &dyn Progress) -> Result<Take, BuildError> {
    if config.rate_hz.is_some() || config.from_s.is_some() || config.to_s.is_some() {
        let help = "Leave out --fps, --from and --to: clips are written whole, at the rate of the bundle";
        return Err(refused("clips have times and a rate of their own", help));
    }
    let who = chosen(config, bundle.clips().len(), "clip in the bundle")?;
    let names = &bundle.meta().clips;
    let actor = |&c: &usize| (c, names[c].name.clone(), bundle.skeleton().clone());
    let io = |source| BuildError::Io { path: folder.to_path_buf(), source };
    let mut writer = TakeWriter::new(folder, who.iter().map(actor).collect(), bundle.meta().rate_hz, 1).map_err(io)?;
    progress.begin("record", who.len() as u64, "clips");
    for (a, &clip) in who.iter().enumerate() {
        progress.check()?;
        let record = bundle.clips()[clip];
        for row in record.first_frame..record.first_frame + record.num_frames {
            writer.push(a, Some(stored(bundle, row as usize))).map_err(io)?;
        }
        writer.finish(a).map_err(io)?;
        progress.advance(1);
    }
    progress.end();
    writer.into_take().map_err(io)
}

/// A frame of a bundle.
fn stored(bundle: &Bundle, row: usize) -> Pose {
    let (row, code) = (&bundle.frames()[row], bundle.rotation_code());
    let [x, z, heading] = row.planar;
    let root = Planar::new(x, z, heading);
    let mut rotations: [Quat; NUM_JOINTS] = std::array::from_fn(|j| code.rotation(row, j));
    rotations[0] = (root.rotation() * rotations[0]).normalize();
    Pose::of_rotations(bundle.skeleton(), root.translation() + Vec3::Y * row.height, rotations)
}
