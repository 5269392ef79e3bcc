//! Runs a scene of walkers and measures it.

use super::config::{ShownStyle, WalkersScene};
use super::path::curve;
use crate::error::BuildError;
use crate::scene::RunConfig;
use crate::slip::SoleMeter;
use glam::{Vec2, Vec3};
use serde::Serialize;
use std::time::Instant;
use throng_runtime::blend::HeightField;
use throng_runtime::blend::walkers::{Control, WalkerStart, Walkers, WalkersConfig};
use throng_runtime::{Joint, NUM_JOINTS, Tables};

/// Characters that are recorded for the picture, from the first: one of them is shown.
const RECORDED: usize = 24;
/// Time between moments that are recorded. [Unit: s]
const LOOK_S: f32 = 0.1;
/// Legs and the joints of their knees.
const KNEES: [[Joint; 3]; 2] =
    [[Joint::LeftThigh, Joint::LeftShin, Joint::LeftFoot], [Joint::RightThigh, Joint::RightShin, Joint::RightFoot]];

/// What was measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct WalkersReport {
    /// The scene's name.
    pub scene: String,
    /// Number of characters.
    pub characters: usize,
    /// Simulated time. [Unit: s]
    pub simulated_s: f32,
    /// Steps of everybody a second of wall time on one thread: paths, weights, postures, retargeting.
    pub steps_per_second: f64,
    /// Mean speed of the paths. [Unit: m/s]
    pub speed_mean_mps: f64,
    /// Fastest that anybody went. [Unit: m/s]
    pub speed_max_mps: f64,
    /// Mean slip of planted feet, as [`SoleMeter`] measures it. [Unit: m/s]
    pub foot_slip_mean_mps: f64,
    /// Its 95th percentile. [Unit: m/s]
    pub foot_slip_p95_mps: f64,
    /// Fastest change of a knee's angle. [Unit: rad/s]
    pub knee_rate_max_radps: f64,
    /// Farthest that an ankle or toe joint was below the ground. [Unit: m]
    pub below_ground_max_m: f64,
}

/// What a run leaves to be drawn.
#[derive(Clone, Debug, Default)]
pub struct WalkersRecord {
    /// World positions of all joints of everybody at the end. [Unit: m]
    pub poses: Vec<[Vec3; NUM_JOINTS]>,
    /// Of the first characters, ten times a second: time, speeds, poses. [Unit: s, m/s, m]
    pub followed: Vec<(f32, Vec<f32>, Vec<[Vec3; NUM_JOINTS]>)>,
}

/// Runs a scene of walkers.
///
/// # Errors
/// [`BuildError::Stage`] as [`WalkersScene::walk`], or for a config out of range.
pub fn run(
    scene: &WalkersScene,
    tables: &Tables,
    walkers: WalkersConfig,
    config: &RunConfig,
) -> Result<(WalkersReport, WalkersRecord), BuildError> {
    let (s, hz) = (config.seconds, config.step_hz);
    if !((1.0..1e5).contains(&hz) && s > 0.0 && s < 1e5) {
        return Err(BuildError::Stage {
            stage: "scene",
            message: format!("expected a time and at least 1 step a second, found {s} s, {hz} Hz"),
            help: "`throng run --help` lists what may be given".into(),
        });
    }
    let mut walk = scene.walk(tables, walkers)?;
    let n = walk.num_characters();
    let (mut slip, mut record) = (SoleMeter::new(n), WalkersRecord::default());
    let mut report = WalkersReport { scene: scene.name.clone(), characters: n, simulated_s: s, ..Default::default() };
    let mut knees = vec![[0.0f32; 2]; n];
    let steps = (s * hz).round().max(1.0) as usize;
    let look_every = ((LOOK_S * hz).round() as usize).max(1);
    let mut busy_s = 0.0;
    for step in 0..=steps {
        // The first step only poses everybody.
        let dt = if step == 0 { 0.0 } else { 1.0 / hz };
        let begin = Instant::now();
        walk.step(dt)?;
        busy_s += begin.elapsed().as_secs_f64();
        slip.observe(dt, |c| (walk.contacts(c), walk.soles(c)));
        for (c, before) in knees.iter_mut().enumerate() {
            let pose = walk.joint_positions(c);
            let now = knee_angles(&pose);
            if dt > 0.0 {
                let rate = (0..2).map(|k| (now[k] - before[k]).abs() / dt).fold(0.0, f32::max);
                report.knee_rate_max_radps = report.knee_rate_max_radps.max(f64::from(rate));
            }
            *before = now;
            report.below_ground_max_m = report.below_ground_max_m.max(f64::from(below(&pose, walk.ground())));
            report.speed_mean_mps += f64::from(walk.speed(c));
            report.speed_max_mps = report.speed_max_mps.max(f64::from(walk.speed(c)));
        }
        if config.recorded && step % look_every == 0 {
            let who = 0..n.min(RECORDED);
            let speeds = who.clone().map(|c| walk.speed(c)).collect();
            record.followed.push((step as f32 / hz, speeds, who.map(|c| walk.joint_positions(c)).collect()));
        }
    }
    report.steps_per_second = (steps + 1) as f64 / busy_s.max(1e-9);
    report.speed_mean_mps /= ((steps + 1) * n) as f64;
    (report.foot_slip_mean_mps, report.foot_slip_p95_mps) = (slip.mean_mps(), slip.p95_mps());
    record.poses = (0..n).map(|c| walk.joint_positions(c)).collect();
    Ok((report, record))
}

/// Angles at the knees; pi where a leg is straight. [Unit: rad]
fn knee_angles(pose: &[Vec3; NUM_JOINTS]) -> [f32; 2] {
    KNEES.map(|leg| {
        let [hip, knee, ankle] = leg.map(|j| pose[j.index()]);
        (hip - knee).angle_between(ankle - knee)
    })
}

/// How far the lowest ankle or toe joint is below the ground. [Unit: m]
fn below(pose: &[Vec3; NUM_JOINTS], ground: &HeightField) -> f32 {
    let feet = [Joint::LeftFoot, Joint::LeftToe, Joint::RightFoot, Joint::RightToe].map(|j| pose[j.index()]);
    feet.map(|p| ground.at(Vec2::new(p.x, p.z)).height - p.y).into_iter().fold(0.0, f32::max)
}

/// One style on the shown path.
#[derive(Clone, Debug)]
pub struct StyleWalk {
    /// What it is called, with its speed.
    pub name: String,
    /// World positions of all joints, moment after moment. [Unit: m]
    pub poses: Vec<[Vec3; NUM_JOINTS]>,
}

/// Walks the same path in every style of a scene, side by side.
///
/// - `length_m`: of the path.
/// - `apart_m`: between the moments that are kept, along the path.
///
/// # Errors
/// [`BuildError::Stage`] for a blend space that the bundle does not have.
pub fn walk_styles(
    scene: &WalkersScene,
    tables: &Tables,
    length_m: f32,
    apart_m: f32,
) -> Result<Vec<StyleWalk>, BuildError> {
    scene.shown.iter().map(|style| walk_style(scene, tables, style, length_m, apart_m)).collect()
}

fn walk_style(
    scene: &WalkersScene,
    tables: &Tables,
    style: &ShownStyle,
    length_m: f32,
    apart_m: f32,
) -> Result<StyleWalk, BuildError> {
    const DT_S: f32 = 1.0 / 120.0;
    /// The body is in its stride before the path begins. [Unit: m]
    const RUN_UP_M: f32 = 4.0;
    let space = scene.space(tables, &style.space)?;
    let (skeleton, ground) = (tables.skeleton(), HeightField::flat());
    let control = |along: f32| {
        let (position, heading) = if along < 0.0 { (Vec2::new(0.0, along), 0.0) } else { curve(along) };
        let mut values = Control::default().style;
        values[0] = style.style;
        let velocity = Vec2::new(heading.sin(), heading.cos()) * style.speed;
        Control { position, velocity, heading: Some(heading), turning_rate: None, style: values }
    };
    let mut walkers = Walkers::new(
        &space,
        skeleton,
        std::slice::from_ref(skeleton),
        WalkersConfig::default(),
        &[WalkerStart::default()],
    )
    .map_err(|e| scene.fault(&e))?;
    let (mut along, mut poses) = (-RUN_UP_M, Vec::new());
    while along < length_m {
        walkers.step(&space, DT_S, &[control(along)], &ground).map_err(|e| scene.fault(&e))?;
        if along >= poses.len() as f32 * apart_m {
            poses.push(walkers.joint_positions(0));
        }
        along += style.speed * DT_S;
    }
    Ok(StyleWalk { name: format!("{}, {:.1} m/s", style.name, style.speed), poses })
}
