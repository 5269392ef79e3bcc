//! Bodies that follow the members of a crowd, blended from example motions.

use super::config::{CrowdBodiesConfig, CrowdScene};
use super::live::Live;
use crate::error::BuildError;
use crate::scene::walkers::{BodiesConfig, blend_fault, named_space};
use crate::slip::SoleMeter;
use glam::{Vec2, Vec3};
use serde::Serialize;
use throng_runtime::blend::walkers::{Control, WalkerStart, Walkers, WalkersConfig};
use throng_runtime::blend::{BlendError, BlendSpace, HeightField};
use throng_runtime::{Joint, NUM_JOINTS, Planar, Skeleton, Tables};

/// Steps of bodies a simulated second. [Unit: Hz]
const STEP_HZ: f64 = 60.0;

/// World positions of the joints of everybody, `None` for those who have left. [Unit: m]
pub type BodyPoses = Vec<Option<[Vec3; NUM_JOINTS]>>;

/// What was measured of bodies.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct BodiesReport {
    /// Mean slip of planted feet, as [`SoleMeter`] measures it. [Unit: m/s]
    pub foot_slip_mean_mps: f64,
    /// 95th percentile of it. [Unit: m/s]
    pub foot_slip_p95_mps: f64,
    /// Farthest that hips were from the middle of their disc, over ground. [Unit: m]
    pub hips_off_max_m: f64,
}

/// Members of one blend space.
struct Troop<'a> {
    space: BlendSpace<'a>,
    walkers: Walkers,
    controls: Vec<Control>,
    /// Number of each in the crowd.
    members: Vec<usize>,
}

/// Runs a scene on the ground with bodies.
///
/// - returns where bodies are at the end, and what was measured.
///
/// # Errors
/// As [`super::run`], or [`BuildError::Stage`] for a blend space that the bundle does not have.
pub fn walk_bodies(
    scene: &CrowdScene,
    bodies: &CrowdBodiesConfig,
    tables: &Tables,
    seconds: f64,
) -> Result<(BodyPoses, BodiesReport), BuildError> {
    let mut live = Live::<Vec2>::new(scene)?;
    let skeletons = BodiesConfig { sizes: [0.9, 1.05], ..BodiesConfig::default() }.make(tables.skeleton(), scene.seed);
    let mut troops = Vec::with_capacity(bodies.spaces.len());
    for (t, name) in bodies.spaces.iter().enumerate() {
        let space = named_space(tables, "bodies.spaces", name, (&scene.name, &bodies.bundle))?;
        let members: Vec<usize> = (t..live.num_members()).step_by(bodies.spaces.len()).collect();
        troops.push(
            troop(&live, space, members, tables.skeleton(), &skeletons).map_err(|e| blend_fault(&scene.name, &e))?,
        );
    }
    let (mut slip, mut report) = (SoleMeter::new(live.num_members()), BodiesReport::default());
    let ground = HeightField::flat();
    let steps = (seconds * STEP_HZ).ceil() as u64;
    for step in 0..=steps {
        let time_s = (step as f64 / STEP_HZ).min(seconds);
        live.advance(time_s)?;
        // The first step only poses everybody.
        let dt_s = if step == 0 { 0.0 } else { (1.0 / STEP_HZ) as f32 };
        for t in &mut troops {
            t.members.iter().zip(&mut t.controls).for_each(|(&m, c)| steer(&live, m, time_s, c));
            t.walkers.step(&t.space, dt_s, &t.controls, &ground).map_err(|e| blend_fault(&scene.name, &e))?;
        }
        let num = troops.len();
        let walkers = |m: usize| &troops[m % num].walkers;
        slip.observe(dt_s, |m| (walkers(m).contacts(m / num), walkers(m).soles(m / num)));
        for m in 0..live.num_members() {
            if let Some(at) = live.position(m, time_s) {
                let hips = troops[m % num].walkers.joint_positions(m / num)[Joint::Hips.index()];
                let off = f64::from(at.distance(Vec2::new(hips.x, hips.z)));
                report.hips_off_max_m = report.hips_off_max_m.max(off);
            }
        }
    }
    (report.foot_slip_mean_mps, report.foot_slip_p95_mps) = (slip.mean_mps(), slip.p95_mps());
    let num = troops.len();
    let pose = |m: usize| live.position(m, seconds).map(|_| troops[m % num].walkers.joint_positions(m / num));
    Ok(((0..live.num_members()).map(pose).collect(), report))
}

/// Bodies of the members of one blend space, who face their way.
fn troop<'a>(
    live: &Live<Vec2>,
    space: BlendSpace<'a>,
    members: Vec<usize>,
    database: &Skeleton,
    skeletons: &[Skeleton],
) -> Result<Troop<'a>, BlendError> {
    let start = |&m: &usize| {
        let way = &live.layout().ways[m];
        let ahead = way.get(1).map_or(Vec2::Y, |&next| next - way[0]);
        let root = Planar { x: way[0].x, z: way[0].y, heading: ahead.x.atan2(ahead.y) };
        WalkerStart { body: m % skeletons.len(), root, phase: (m as f32 * 0.381_966).fract() }
    };
    let starts: Vec<WalkerStart> = members.iter().map(start).collect();
    let walkers = Walkers::new(&space, database, skeletons, WalkersConfig::default(), &starts)?;
    let control = |s: &WalkerStart| Control {
        position: Vec2::new(s.root.x, s.root.z),
        heading: Some(s.root.heading),
        ..Control::default()
    };
    Ok(Troop { space, walkers, controls: starts.iter().map(control).collect(), members })
}

/// What a body is asked: to be where its member is, and to move as it does. Those who stand keep their heading, those who have
/// left stay where they were.
fn steer(live: &Live<Vec2>, m: usize, time_s: f64, control: &mut Control) {
    /// Slower ones keep their heading. [Unit: m/s]
    const SLOW_MPS: f32 = 0.3;
    let (Some(at), Some(velocity)) = (live.position(m, time_s), live.smooth_velocity(m)) else {
        control.velocity = Vec2::ZERO;
        return;
    };
    (control.position, control.velocity) = (at, velocity);
    if velocity.length() > SLOW_MPS {
        control.heading = Some(velocity.x.atan2(velocity.y));
    }
}
