//! Runs a crowd and measures it.

use super::config::{CrowdScene, CrowdSpace};
use super::live::Live;
use super::meter::{Flow, GateMeter, LaneMeter, OverlapMeter, ProgressMeter, Sight};
use super::obstacle::plan;
use super::record::{CrowdRecord, Recorder};
use crate::error::BuildError;
use glam::{Vec2, Vec3};
use serde::Serialize;
use std::time::Instant;
use throng_runtime::crowd::{AtEnd, Counts, Space};

/// Running time of a thread from which on the system's ticks do not matter. [Unit: s]
const TOLD_S: f64 = 0.05;
/// Looks a simulated second. [Unit: Hz]
const LOOK_HZ: f64 = 30.0;

/// How a crowd is run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrowdRun {
    /// Simulated time; that of the scene where `None`. [Unit: s] [Limit: > 0]
    pub seconds: Option<f64>,
    /// Times the engine in a run of its own that nobody looks at, so that looking at everybody 30 times a second does not
    /// count, neither its time nor what it does to caches.
    pub timed_apart: bool,
    /// Threads of the engine.
    pub threads: usize,
    /// Keeps what a picture shows.
    pub recorded: bool,
}

impl Default for CrowdRun {
    fn default() -> Self {
        Self { seconds: None, timed_apart: false, threads: 1, recorded: false }
    }
}

/// What was measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct CrowdReport {
    /// The scene's name.
    pub scene: String,
    /// Number of members that started.
    pub members: usize,
    /// What found out when somebody had to act.
    pub engine: String,
    /// Simulated time. [Unit: s]
    pub simulated_s: f64,
    /// Wall time of the engine for one simulated second. [Unit: s]
    pub wall_s_per_simulated_s: f64,
    /// Time that the engine's thread was running, for one member and simulated second, so that what else a machine does
    /// counts little; wall time with several threads, in short runs, or where the system does not tell. [Unit: us]
    pub us_per_member_second: f64,
    /// Events of one member in one simulated second; in the fixed engine, steps that it took.
    pub events_per_member_second: f64,
    /// Those of them at which the bound of one member entered or left cells; only the engine `occupancy` has such events.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub crossings_per_member_second: Option<f64>,
    /// Times that one member chose what to do in one simulated second.
    pub decisions_per_member_second: f64,
    /// Pairs that overlapped by more than 1 mm, for one member and frame at 30 Hz.
    pub overlap_over_1mm_fraction: f64,
    /// Pairs that overlapped by more than 1 cm, for one member and frame at 30 Hz.
    pub overlap_over_1cm_fraction: f64,
    /// Deepest overlap of a pair. [Unit: m]
    pub max_overlap_m: f64,
    /// Mean speed towards the goal, along the planned way, of those who are not there. [Unit: m/s]
    pub progress_mps: f64,
    /// Mean desired speed, for comparison. [Unit: m/s]
    pub desired_mps: f64,
    /// Members that reached their goal.
    pub arrived: usize,
    /// Members that stayed within half a metre for 10 s on their way.
    pub stuck: usize,
    /// Members that know of a happening, where the scene has any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub informed: Option<usize>,
    /// Order of lanes in the last quarter of the time that groups met: 0 as mixed as by chance, 1 everybody in a lane.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lane_order: Option<f64>,
    /// Flow through the scene's gate.
    #[serde(flatten)]
    pub flow: Option<Flow>,
    /// Hash of the engine's state at the end, in hexadecimal: the same for the same scene, whatever the threads.
    pub state_hash: String,
}

/// Runs a crowd.
///
/// # Errors
/// [`BuildError::Stage`] for an impossible start, a goal without a way, an engine that does not get on, or a time out of
/// range.
pub fn run(scene: &CrowdScene, config: &CrowdRun) -> Result<(CrowdReport, CrowdRecord), BuildError> {
    match scene.space {
        CrowdSpace::Ground => in_pool(config.threads, || run_in::<Vec2>(scene, config))?,
        CrowdSpace::Air => in_pool(config.threads, || run_in::<Vec3>(scene, config))?,
    }
}

/// Runs work on threads of its own.
fn in_pool<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> Result<T, BuildError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    Ok(pool.map_err(|e| stage(e.to_string(), "Ask for fewer threads"))?.install(work))
}

fn stage(message: String, help: &str) -> BuildError {
    BuildError::Stage { stage: "scene", message, help: help.into() }
}

fn run_in<V: Space>(scene: &CrowdScene, config: &CrowdRun) -> Result<(CrowdReport, CrowdRecord), BuildError> {
    let seconds = config.seconds.unwrap_or(scene.seconds);
    if !(seconds > 0.0 && seconds <= 1e5) {
        return Err(stage(
            format!("expected a time above 0 and up to 100000 s, found {seconds} s"),
            "`throng run --help` lists what may be given",
        ));
    }
    let start = || {
        let mut live = Live::<V>::new(scene)?;
        if config.threads > 1 {
            live.on_all_threads();
        }
        Ok::<_, BuildError>(live)
    };
    let apart = config.timed_apart.then(|| {
        let mut live = start()?;
        let mut clock = Clock::new(config.threads);
        clock.time(|| live.advance(seconds))?;
        Ok::<_, BuildError>((clock, live.crowd().state_hash()))
    });
    let apart = apart.transpose()?;
    let mut live = start()?;
    let mut meters = Meters::new(scene, &live, config.recorded);
    let frames = (seconds * LOOK_HZ).ceil() as u64;
    let mut clock = Clock::new(config.threads);
    for frame in 0..=frames {
        let time_s = (frame as f64 / LOOK_HZ).min(seconds);
        clock.time(|| live.advance(time_s))?;
        meters.observe(&live, time_s, seconds);
    }
    let hash = live.crowd().state_hash();
    if let Some((timed, other)) = apart {
        clock = timed;
        if other != hash {
            return Err(stage(
                format!("two runs of \"{}\" ended in the states {other:016x} and {hash:016x}", scene.name),
                "This must never happen; please report it with the scene",
            ));
        }
    }
    let mut report = meters.report(&live, seconds, &clock);
    report.scene.clone_from(&scene.name);
    report.engine = scene.engine.name().into();
    report.state_hash = format!("{hash:016x}");
    Ok((report, meters.recorder.finish(scene, &live)))
}

/// Time that the engine took.
struct Clock {
    wall_s: f64,
    /// Of its thread alone; `None` where there are several, or the system does not tell.
    running_s: Option<f64>,
}

impl Clock {
    fn new(threads: usize) -> Self {
        Self { wall_s: 0.0, running_s: (threads == 1).then(running_s).flatten().map(|_| 0.0) }
    }

    /// Of its thread, if that was long enough to be told, and otherwise of the wall.
    fn busy_s(&self) -> f64 {
        self.running_s.filter(|s| *s > TOLD_S).unwrap_or(self.wall_s)
    }

    fn time<T>(&mut self, work: impl FnOnce() -> T) -> T {
        let (begin, running) = (Instant::now(), self.running_s.and_then(|_| running_s()));
        let done = work();
        self.wall_s += begin.elapsed().as_secs_f64();
        let ran = running.and_then(|begin| Some(running_s()? - begin));
        self.running_s = self.running_s.and_then(|sum| Some(sum + ran?));
        done
    }
}

/// Time that this thread was running so far, where the system tells it.
fn running_s() -> Option<f64> {
    let ran = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    Some(ran.split(' ').next()?.parse::<f64>().ok()? * 1e-9)
}

/// Everything that looks.
struct Meters<V> {
    overlaps: OverlapMeter,
    progress: ProgressMeter<V>,
    gate: Option<GateMeter>,
    lanes: Option<LaneMeter>,
    /// Of each group: it goes along the direction of lanes.
    goes_along: Vec<bool>,
    recorder: Recorder,
    places: Vec<(V, f32)>,
}

impl<V: Space> Meters<V> {
    fn new(scene: &CrowdScene, live: &Live<V>, recorded: bool) -> Self {
        Self {
            overlaps: OverlapMeter::default(),
            progress: ProgressMeter::default(),
            gate: scene.gate.as_ref().map(GateMeter::new),
            lanes: scene.lanes.as_ref().map(LaneMeter::new),
            goes_along: scene
                .lanes
                .as_ref()
                .map_or(Vec::new(), |l| goes_along(live, l.along.into(), scene.groups.len())),
            recorder: Recorder::new(recorded, live.num_members()),
            places: Vec::new(),
        }
    }

    fn observe(&mut self, live: &Live<V>, time_s: f64, seconds: f64) {
        let layout = live.layout();
        let at = |m: usize| live.position(m, time_s);
        let all = 0..live.num_members();
        self.places.clear();
        self.places.extend(all.clone().filter_map(|m| Some((at(m)?, layout.setup.members[m].radius))));
        self.overlaps.observe(&self.places);
        let sight = |m: usize| {
            let route = &layout.setup.routes[layout.setup.members[m].route];
            Sight {
                at: at(m),
                way: &layout.ways[m],
                way_number: live.times_sent(m),
                arrival_m: layout.arrivals[m],
                again: live.times_sent(m) == 0 && route.at_end == AtEnd::Again,
            }
        };
        self.progress.observe(time_s, all.clone().map(sight));
        if let Some(gate) = &mut self.gate {
            gate.observe(time_s, all.clone().map(|m| at(m).map(plan)));
        }
        if let Some(lanes) = &mut self.lanes {
            let seen = all.filter_map(|m| Some((plan(at(m)?), self.goes_along[layout.groups[m]])));
            lanes.observe(time_s, &seen.collect::<Vec<_>>());
        }
        self.recorder.observe(live, time_s, seconds);
    }

    fn report(&self, live: &Live<V>, seconds: f64, clock: &Clock) -> CrowdReport {
        let n = live.num_members();
        let member_seconds = n as f64 * seconds;
        let counts = live.crowd().counts();
        let frames = self.overlaps.member_frames.max(1) as f64;
        let members = &live.layout().setup.members;
        CrowdReport {
            members: n,
            simulated_s: seconds,
            wall_s_per_simulated_s: clock.wall_s / seconds,
            us_per_member_second: 1e6 * clock.busy_s() / member_seconds,
            events_per_member_second: events(&counts) as f64 / member_seconds,
            crossings_per_member_second: Some((counts.entering + counts.leaving) as f64 / member_seconds)
                .filter(|c| *c > 0.0),
            decisions_per_member_second: counts.decisions as f64 / member_seconds,
            overlap_over_1mm_fraction: self.overlaps.over_1mm as f64 / frames,
            overlap_over_1cm_fraction: self.overlaps.over_1cm as f64 / frames,
            max_overlap_m: self.overlaps.max_m,
            progress_mps: self.progress.progress_mps(),
            desired_mps: members.iter().map(|m| f64::from(m.speed)).sum::<f64>() / n as f64,
            arrived: self.progress.arrived(),
            stuck: self.progress.stuck(),
            informed: live.has_happenings().then(|| (0..n).filter(|&m| live.knows(m) > 0).count()),
            lane_order: self.lanes.as_ref().and_then(LaneMeter::last),
            flow: self.gate.as_ref().map(GateMeter::flow),
            ..CrowdReport::default()
        }
    }
}

/// Events inside of the crowd; where there are steps instead, everybody acts at each.
fn events(c: &Counts) -> u64 {
    if c.steps > 0 {
        return c.decisions;
    }
    c.resetting + c.colliding + c.meeting + c.entering + c.leaving + c.contacting + c.separating
}

/// Of each group: on the whole, its members go along a direction.
fn goes_along<V: Space>(live: &Live<V>, along: Vec2, num_groups: usize) -> Vec<bool> {
    let mut sums = vec![0.0; num_groups];
    for (way, &group) in live.layout().ways.iter().zip(&live.layout().groups) {
        sums[group] += (plan(way[way.len() - 1]) - plan(way[0])).dot(along);
    }
    sums.iter().map(|s| *s > 0.0).collect()
}
