//! Runs a scene in a world and measures it.

use super::config::WorldScene;
use super::life::{Life, trunks};
use super::overlap::OverlapMeter;
use crate::environment::{Body, PlacedGeometry};
use crate::error::BuildError;
use crate::scene::RunConfig;
use crate::slip::SlipMeter;
use glam::Vec3;
use serde::Serialize;
use std::collections::BTreeSet;
use std::time::Instant;
use throng_runtime::troupe::{Repertoire, Troupe};
use throng_runtime::world::WorldGraph;
use throng_runtime::world::inhabitants::Doing;
use throng_runtime::{NUM_JOINTS, Tables};

/// Time between looks at who is in whom or in what. [Unit: s]
const LOOK_S: f32 = 0.1;
/// Deeper than this in a unit is a penetration. [Unit: m]
const PENETRATION_M: f32 = 0.08;
/// Who wishes to go somewhere and stays within `STUCK_M` for this long is stuck. [Unit: s]
const STUCK_S: f64 = 30.0;
/// See [`STUCK_S`]. [Unit: m]
const STUCK_M: f32 = 0.5;

/// What was measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct WorldReport {
    /// The scene's name.
    pub scene: String,
    /// Number of characters.
    pub characters: usize,
    /// Simulated time. [Unit: s]
    pub simulated_s: f32,
    /// Steps of everybody a second of wall time on one thread: control, poses.
    pub steps_per_second: f64,
    /// Times at which the trunks of two characters came into each other.
    pub character_overlaps: u64,
    /// Deepest that two were in each other. [Unit: m]
    pub deepest_overlap_m: f64,
    /// Times at which somebody came deeper into a unit than a few centimetres.
    pub environment_penetrations: u64,
    /// Deepest that somebody was in a unit. [Unit: m]
    pub deepest_penetration_m: f64,
    /// Characters that wished to go somewhere and stayed where they were for half a minute or longer.
    pub stuck: usize,
    /// Wishes that were fulfilled, a simulated minute and character.
    pub fulfilled_per_minute: f64,
    /// Distance over ground and up, a simulated minute and character, on average. [Unit: m]
    pub travelled_m_per_minute: f64,
    /// Share of the time that was spent waiting for others.
    pub waiting_fraction: f64,
    /// Mean speed of planted heels and toes. [Unit: m/s]
    pub foot_slip_mean_mps: f64,
    /// 95th percentile of the speed of planted heels and toes. [Unit: m/s]
    pub foot_slip_p95_mps: f64,
}

/// What a run leaves to be drawn.
#[derive(Clone, Debug, Default)]
pub struct WorldRecord {
    /// World positions of all joints of everybody at the end. [Unit: m]
    pub poses: Vec<[Vec3; NUM_JOINTS]>,
    /// World positions of all joints of the followed characters: time, and one pose each. [Unit: s, m]
    pub followed: Vec<(f32, Vec<[Vec3; NUM_JOINTS]>)>,
    /// Where things were seen that should not be: time, character, what. [Unit: s]
    pub faults: Vec<(f32, usize, String)>,
}

/// Runs a scene in a world.
///
/// - `geometry`: what stands in the world.
/// - `follow`: characters whose motion is recorded.
///
/// # Errors
/// [`BuildError::Stage`] as [`WorldScene::live`], or for a config out of range.
pub fn run(
    scene: &WorldScene,
    tables: &Tables,
    graph: &WorldGraph<'_>,
    geometry: &PlacedGeometry,
    config: &RunConfig,
    follow: &[usize],
) -> Result<(WorldReport, WorldRecord), BuildError> {
    let fail = |message: String| BuildError::Stage {
        stage: "scene",
        message,
        help: "`throng run --help` lists what may be given".into(),
    };
    let (s, hz) = (config.seconds, config.step_hz);
    if !((1.0..1e5).contains(&hz) && s > 0.0 && s < 1e5) {
        return Err(fail(format!("expected a time and at least 1 step a second, found {s} s, {hz} Hz")));
    }
    let repertoire = Repertoire::new(tables);
    let mut life = scene.live(tables, &repertoire, graph)?;
    let mut watch = Watch::new(&life, tables, geometry);
    let steps = (s * hz).round().max(1.0) as usize;
    let look_every = ((LOOK_S * hz).round() as usize).max(1);
    let mut busy_s = 0.0;
    for step in 0..=steps {
        // The first step only poses everybody.
        let dt = if step == 0 { 0.0 } else { 1.0 / hz };
        let begin = Instant::now();
        life.step(&repertoire, graph, dt).map_err(|e| fail(e.to_string()))?;
        busy_s += begin.elapsed().as_secs_f64();
        watch.slip.observe(life.inhabitants().troupe(), dt);
        if step % look_every == 0 {
            watch.look(&life, follow);
        }
    }
    let report = watch.report(scene, &life, s, (steps + 1) as f64 / busy_s.max(1e-9));
    let troupe = life.inhabitants().troupe();
    watch.record.poses = (0..troupe.num_characters()).map(|c| troupe.joint_positions(c)).collect();
    Ok((report, watch.record))
}

/// Where a character was when it last came forward.
#[derive(Clone, Copy, Debug)]
struct Progress {
    at: Vec3,
    since_s: f64,
}

/// Looks at a world every tenth of a second.
struct Watch<'a> {
    body: Body,
    geometry: &'a PlacedGeometry,
    overlaps: OverlapMeter,
    slip: SlipMeter,
    record: WorldRecord,
    /// Who is in which unit now.
    inside: BTreeSet<(usize, usize)>,
    penetrations: u64,
    deepest_m: f32,
    progress: Vec<Progress>,
    stuck: BTreeSet<usize>,
    last: Vec<Vec3>,
    travelled_m: f64,
    looks: u64,
    waiting: u64,
}

impl<'a> Watch<'a> {
    fn new(life: &Life, tables: &Tables, geometry: &'a PlacedGeometry) -> Self {
        let n = life.inhabitants().num_characters();
        Self {
            body: Body::new(tables.skeleton()),
            geometry,
            overlaps: OverlapMeter::default(),
            slip: SlipMeter::new(n),
            record: WorldRecord::default(),
            inside: BTreeSet::new(),
            penetrations: 0,
            deepest_m: 0.0,
            progress: vec![Progress { at: Vec3::splat(f32::MAX), since_s: 0.0 }; n],
            stuck: BTreeSet::new(),
            last: Vec::new(),
            travelled_m: 0.0,
            looks: 0,
            waiting: 0,
        }
    }

    fn look(&mut self, life: &Life, follow: &[usize]) {
        let trunks = trunks(life);
        self.overlaps.observe(&trunks);
        self.look_around(life.inhabitants().troupe(), life.time_s());
        self.look_for_stuck(life, &trunks);
        if !self.last.is_empty() {
            let way = trunks.iter().zip(&self.last).map(|(t, l)| f64::from((t[0] - *l).length()));
            self.travelled_m += way.sum::<f64>();
        }
        self.last = trunks.iter().map(|t| t[0]).collect();
        if !follow.is_empty() {
            let troupe = life.inhabitants().troupe();
            let poses = follow.iter().map(|&c| troupe.joint_positions(c)).collect();
            self.record.followed.push((life.time_s() as f32, poses));
        }
    }

    /// Who is in which unit?
    fn look_around(&mut self, troupe: &Troupe, time_s: f64) {
        let mut inside = BTreeSet::new();
        for c in 0..troupe.num_characters() {
            let (root, pose) = (troupe.root(c), troupe.pose(c));
            let (turn, by) = (root.rotation(), root.translation());
            let transforms = std::array::from_fn(|j| (turn * pose[j].translation() + by, turn * pose[j].rotation()));
            let body = self.body.pose(&transforms, troupe.contacts(c));
            let Some((unit, p)) = body.penetration_in(self.geometry, PENETRATION_M) else {
                continue;
            };
            self.deepest_m = self.deepest_m.max(p.depth);
            inside.insert((c, unit));
            if !self.inside.contains(&(c, unit)) {
                self.penetrations += 1;
                let what = format!("{} {:.2} m in unit {unit}", p.joint.name(), p.depth);
                self.record.faults.push((time_s as f32, c, what));
            }
        }
        self.inside = inside;
    }

    fn look_for_stuck(&mut self, life: &Life, trunks: &[[Vec3; 2]]) {
        for (c, (trunk, progress)) in trunks.iter().zip(&mut self.progress).enumerate() {
            let doing = life.inhabitants().status(c).doing;
            self.looks += 1;
            self.waiting += u64::from(doing == Doing::Waiting);
            let at_will = matches!(doing, Doing::Performing | Doing::Arrived);
            if at_will || (trunk[0] - progress.at).length() > STUCK_M {
                *progress = Progress { at: trunk[0], since_s: life.time_s() };
            } else if life.time_s() - progress.since_s > STUCK_S {
                self.stuck.insert(c);
            }
        }
    }

    fn report(&self, scene: &WorldScene, life: &Life, simulated_s: f32, steps_per_second: f64) -> WorldReport {
        let n = life.inhabitants().num_characters();
        let character_minutes = f64::from(simulated_s) / 60.0 * n as f64;
        let fulfilled: u32 = (0..n).map(|c| life.inhabitants().status(c).num_fulfilled).sum();
        WorldReport {
            scene: scene.name.clone(),
            characters: n,
            simulated_s,
            steps_per_second,
            character_overlaps: self.overlaps.count(),
            deepest_overlap_m: f64::from(self.overlaps.deepest_m()),
            environment_penetrations: self.penetrations,
            deepest_penetration_m: f64::from(self.deepest_m),
            stuck: self.stuck.len(),
            fulfilled_per_minute: f64::from(fulfilled) / character_minutes,
            travelled_m_per_minute: self.travelled_m / character_minutes,
            waiting_fraction: self.waiting as f64 / self.looks.max(1) as f64,
            foot_slip_mean_mps: self.slip.mean_mps(),
            foot_slip_p95_mps: self.slip.p95_mps(),
        }
    }
}
