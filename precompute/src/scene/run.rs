//! Runs a scene and measures it.

use super::config::Scene;
use super::play::{Cast, Play};
use crate::error::BuildError;
use crate::slip::SlipMeter;
use glam::Vec3;
use serde::Serialize;
use std::time::Instant;
use throng_runtime::sparring::Part;
use throng_runtime::troupe::{Repertoire, TroupeError};
use throng_runtime::{NUM_JOINTS, Planar, Tables};

/// How a scene is run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunConfig {
    /// Simulated time. [Unit: s]
    pub seconds: f32,
    /// Steps a simulated second. [Unit: Hz]
    pub step_hz: f32,
    /// Characters that are recorded, from the first: two of pairs, one of others, where the scene has them.
    pub recorded: bool,
}

impl Default for RunConfig {
    fn default() -> Self {
        Self { seconds: 15.0, step_hz: 60.0, recorded: false }
    }
}

/// What was measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SceneReport {
    /// The scene's name.
    pub scene: String,
    /// Number of characters.
    pub characters: usize,
    /// Simulated time. [Unit: s]
    pub simulated_s: f32,
    /// Steps of all characters a second of wall time on one thread: choices, poses, blows, reactions.
    pub steps_per_second: f64,
    /// Blows that landed, a simulated minute and character.
    pub hits_per_minute: f64,
    /// Share of the blows thrown that landed.
    pub landed_fraction: f64,
    /// Share of the blows thrown that arms caught.
    pub blocked_fraction: f64,
    /// Blows thrown.
    pub thrown: u32,
    /// Mean speed of planted heels and toes. [Unit: m/s]
    pub foot_slip_mean_mps: f64,
    /// 95th percentile of the speed of planted heels and toes. [Unit: m/s]
    pub foot_slip_p95_mps: f64,
    /// Deepest that heads, necks, trunks and pelvises of a pair went into each other. [Unit: m]
    pub max_penetration_m: f64,
    /// Share of the time that pairs were more than a few centimetres inside each other.
    pub deep_fraction: f64,
    /// Distance over ground from the opponent or target, mean over time and characters. [Unit: m]
    pub distance_mean_m: f64,
    /// The greatest such distance after the first 5 s; none where the run is no longer. [Unit: m]
    pub distance_max_m: Option<f64>,
}

/// What a run leaves to be drawn.
#[derive(Clone, Debug, Default)]
pub struct SceneRecord {
    /// The recorded characters, every step.
    pub frames: Vec<SceneFrame>,
    /// What became of their blows.
    pub events: Vec<SceneEvent>,
    /// Planar roots of everybody at the end.
    pub roots: Vec<Planar>,
    /// World positions of all joints of everybody at the end. [Unit: m]
    pub poses: Vec<[Vec3; NUM_JOINTS]>,
    /// Opponents' heads or targets of everybody at the end. [Unit: m]
    pub targets: Vec<Vec3>,
}

/// The recorded characters at one step.
#[derive(Clone, Debug)]
pub struct SceneFrame {
    /// [Unit: s]
    pub time_s: f32,
    /// World positions of all joints of one or two characters. [Unit: m]
    pub poses: Vec<[Vec3; NUM_JOINTS]>,
    /// Where the target is, if there is one. [Unit: m]
    pub target: Option<Vec3>,
}

/// A blow of a recorded character that met something.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneEvent {
    /// [Unit: s]
    pub time_s: f32,
    /// Who struck.
    pub character: usize,
    /// Where. [Unit: m]
    pub point: Vec3,
    /// What of the opponent; none for a target.
    pub part: Option<Part>,
}

/// Runs a scene on a bundle.
///
/// # Errors
/// [`BuildError::Stage`] as [`Scene::play`], or for a config out of range.
pub fn run(tables: &Tables, scene: &Scene, config: &RunConfig) -> Result<(SceneReport, SceneRecord), BuildError> {
    let fail = |message: String| BuildError::Stage {
        stage: "scene",
        message,
        help: "`throng run --help` lists what may be given".into(),
    };
    let sound = config.step_hz >= 1.0 && config.step_hz < 1e5 && config.seconds > 0.0 && config.seconds < 1e5;
    if !sound {
        let (s, hz) = (config.seconds, config.step_hz);
        return Err(fail(format!("expected a time and at least 1 step a second, found {s} s, {hz} Hz")));
    }
    let repertoire = Repertoire::new(tables);
    let mut play = scene.play(tables, &repertoire)?;
    let mut watch = Watch::new(play.troupe().num_characters());
    let dt = 1.0 / config.step_hz;
    let steps = (config.seconds * config.step_hz).round().max(1.0) as usize;
    let mut busy_s = 0.0;
    for step in 0..=steps {
        let begin = Instant::now();
        // The first step only takes the first choice.
        let step_s = if step == 0 { 0.0 } else { dt };
        play.step(&repertoire, step_s).map_err(|e: TroupeError| fail(e.to_string()))?;
        busy_s += begin.elapsed().as_secs_f64();
        watch.observe(&play, step_s, config.recorded);
    }
    let report = watch.report(scene, &play, config, (steps + 1) as f64 / busy_s.max(1e-9));
    Ok((report, watch.finish(&play)))
}

/// Looks at a scene after every step.
struct Watch {
    slip: SlipMeter,
    record: SceneRecord,
    distance_sum: f64,
    distances: u64,
    distance_max: Option<f32>,
}

/// Time that characters have to come together before their greatest distance counts. [Unit: s]
const COMING_S: f64 = 5.0;

impl Watch {
    fn new(num_characters: usize) -> Self {
        Self {
            slip: SlipMeter::new(num_characters),
            record: SceneRecord::default(),
            distance_sum: 0.0,
            distances: 0,
            distance_max: None,
        }
    }

    fn observe(&mut self, play: &Play, dt: f32, recorded: bool) {
        self.slip.observe(play.troupe(), dt);
        for c in 0..play.troupe().num_characters() {
            let (root, target) = (play.troupe().root(c), target_of(play, c));
            let distance = (root.x - target.x).hypot(root.z - target.z);
            self.distance_sum += f64::from(distance);
            self.distances += 1;
            if play.time_s() > COMING_S {
                self.distance_max = Some(self.distance_max.map_or(distance, |most| most.max(distance)));
            }
        }
        if recorded {
            self.record(play);
        }
    }

    fn record(&mut self, play: &Play) {
        let time_s = play.time_s() as f32;
        let (shown, target) = match &play.cast {
            Cast::Pairs(_) => (2, None),
            Cast::Targets(practice) => (1, practice.targets().first().map(|t| t.position())),
        };
        let troupe = play.troupe();
        let poses = (0..shown.min(troupe.num_characters())).map(|c| troupe.joint_positions(c)).collect();
        self.record.frames.push(SceneFrame { time_s, poses, target });
        let event = |character: u32, point, part| SceneEvent { time_s, character: character as usize, point, part };
        let events: Vec<SceneEvent> = match &play.cast {
            Cast::Pairs(p) => p.landed().iter().map(|l| event(l.blow.character, l.blow.point, Some(l.part))).collect(),
            Cast::Targets(p) => p.hits().iter().map(|h| event(h.blow.character, h.blow.point, None)).collect(),
        };
        self.record.events.extend(events.into_iter().filter(|e| e.character < shown));
    }

    fn report(&self, scene: &Scene, play: &Play, config: &RunConfig, steps_per_second: f64) -> SceneReport {
        let (n, blows) = (play.troupe().num_characters(), play.blows());
        let (max_penetration_m, deep_s) = match &play.cast {
            Cast::Pairs(p) => (f64::from(p.figures().max_penetration_m), f64::from(p.figures().deep_s)),
            Cast::Targets(_) => (0.0, 0.0),
        };
        let seconds = f64::from(config.seconds);
        let share = |count: u32| f64::from(count) / f64::from(blows.thrown.max(1));
        SceneReport {
            scene: scene.name.clone(),
            characters: n,
            simulated_s: config.seconds,
            steps_per_second,
            hits_per_minute: f64::from(blows.landed) * 60.0 / seconds / n as f64,
            landed_fraction: share(blows.landed),
            blocked_fraction: share(blows.blocked),
            thrown: blows.thrown,
            foot_slip_mean_mps: self.slip.mean_mps(),
            foot_slip_p95_mps: self.slip.p95_mps(),
            max_penetration_m,
            deep_fraction: deep_s / (seconds * (n / 2).max(1) as f64),
            distance_mean_m: self.distance_sum / self.distances.max(1) as f64,
            distance_max_m: self.distance_max.map(f64::from),
        }
    }

    fn finish(mut self, play: &Play) -> SceneRecord {
        let n = play.troupe().num_characters();
        self.record.roots = (0..n).map(|c| play.troupe().root(c)).collect();
        self.record.poses = (0..n).map(|c| play.troupe().joint_positions(c)).collect();
        self.record.targets = (0..n).map(|c| target_of(play, c)).collect();
        self.record
    }
}

/// What a character is after: the opponent's head, or its target. [Unit: m]
fn target_of(play: &Play, character: usize) -> Vec3 {
    match &play.cast {
        Cast::Pairs(p) => p.heads()[character],
        Cast::Targets(p) => p.targets()[character].position(),
    }
}
