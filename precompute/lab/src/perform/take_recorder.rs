//! Records frames of running characters.

use super::{TIME_TOLERANCE_S, TakeJob, TakeSpan, export_error, selected_numbers};
use throng_core::Skeleton;
use throng_motion::error::{Result, ensure};
use throng_motion::export::{ActorPose, Take, TakeWriter};
use throng_simulation::{GroupMotion, Simulation};

/// Records the poses of some characters at evenly spaced times; poses between two steps are blended.
pub struct TakeRecorder<'a> {
    writer: TakeWriter,
    who: Vec<usize>,
    span: TakeSpan,
    rate_hz: f64,
    num_frames: usize,
    next: usize,
    /// Time and poses of the previous step, if they are needed.
    before: Option<(f64, Vec<Option<ActorPose>>)>,
    job: TakeJob<'a>,
}

impl<'a> TakeRecorder<'a> {
    pub fn new(actors: Vec<(usize, String, Skeleton)>, span: TakeSpan, job: TakeJob<'a>) -> Result<Self> {
        let rate_hz = job.config.rate_hz()?;
        let who: Vec<usize> = actors.iter().map(|a| a.0).collect();
        let writer = TakeWriter::new(job.folder, actors, rate_hz).map_err(|e| job.file_error(e))?;
        let num_frames = span.num_frames(rate_hz);
        job.progress.begin("record", num_frames as u64, "frames");
        Ok(Self { writer, who, span, rate_hz, num_frames, next: 0, before: None, job })
    }

    /// Recorder of the characters of a scene that have bodies.
    pub fn for_scene(sim: &Simulation, span: TakeSpan, job: TakeJob<'a>) -> Result<Self> {
        let mut who = selected_numbers(job.config, sim.num_characters(), "character in the scene")?;
        let group = |c: usize| sim.groups().iter().find(|g| g.characters.contains(&c));
        let is_bare = |c: usize| group(c).is_none_or(|g| g.motion == GroupMotion::None);
        let bare = who.iter().copied().find(|&c| is_bare(c));
        let is_asked = !job.config.characters.is_empty();
        who.retain(|&c| !is_bare(c));
        if let Some(c) = bare.filter(|_| is_asked || who.is_empty()) {
            let name = group(c).map_or("", |g| &g.name);
            let what = format!("character {c} has no body: its group \"{name}\" has motion = \"none\"");
            let help =
                "Give the group a bundle and motion = \"blend\"; `throng run --trajectories` writes where agents go";
            return Err(export_error(what, help));
        }
        let skeleton = |c: usize| {
            let bundle = group(c).and_then(|g| sim.compiled().find_bundle(g.number));
            bundle.map_or_else(Skeleton::default, |b| b.skeleton().clone())
        };
        let name = |c: usize| format!("{} {c}", group(c).map_or("character", |g| &g.name));
        let actors = who.into_iter().map(|c| (c, name(c), skeleton(c))).collect();
        Self::new(actors, span, job)
    }

    pub fn observe_simulation(&mut self, sim: &Simulation, hz: f64) -> Result<()> {
        self.observe(sim.time_s(), 1.0 / hz, |c| Some(ActorPose::from_model(sim.root(c)?, sim.pose(c)?)))
    }

    /// Observes a step.
    ///
    /// - `ahead_s`: time to the next step (s).
    pub fn observe(&mut self, time_s: f64, ahead_s: f64, pose: impl Fn(usize) -> Option<ActorPose>) -> Result<()> {
        let all = |who: &[usize]| who.iter().map(|&c| pose(c)).collect::<Vec<_>>();
        let mut now = None;
        loop {
            let at_s = self.span.from_s + self.next as f64 / self.rate_hz;
            if self.next == self.num_frames || at_s > time_s + TIME_TOLERANCE_S {
                break;
            }
            self.job.progress.check()?;
            let now = now.get_or_insert_with(|| all(&self.who));
            for (a, to) in now.iter().enumerate() {
                let between = match (&self.before, to) {
                    (Some((before_s, from)), Some(to)) if at_s < time_s - TIME_TOLERANCE_S => {
                        let ratio = ((at_s - before_s) / (time_s - before_s)) as f32;
                        from[a].map(|from| from.lerp(to, ratio))
                    }
                    _ => *to,
                };
                self.writer.push(a, between).map_err(|e| self.job.file_error(e))?;
            }
            self.next += 1;
            self.job.progress.advance(1);
        }
        let next_s = self.span.from_s + self.next as f64 / self.rate_hz;
        let is_between = self.next < self.num_frames && next_s < time_s + ahead_s - TIME_TOLERANCE_S;
        self.before = is_between.then(|| (time_s, now.unwrap_or_else(|| all(&self.who))));
        Ok(())
    }

    /// Completes the take.
    ///
    /// - `ended_s`: when the run ended (s).
    pub fn into_take(self, ended_s: f64) -> Result<Take> {
        self.job.progress.end();
        let what = || format!("--from {}: the run has ended by {ended_s:.3} s", self.span.from_s);
        ensure(self.next > 0, || export_error(what(), "Begin earlier"))?;
        self.writer.into_take().map_err(|e| self.job.file_error(e))
    }
}
