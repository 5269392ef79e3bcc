//! Bodies that follow the members of a crowd, blended from example motions.

use super::config::{CrowdBodiesConfig, CrowdScene};
use super::live::Live;
use crate::error::BuildError;
use crate::scene::walkers::{BodiesConfig, blend_fault, named_space};
use crate::slip::{SoleMeter, Soles};
use glam::{Vec2, Vec3};
use serde::Serialize;
use throng_runtime::blend::walkers::{Control, WalkerStart, Walkers, WalkersConfig};
use throng_runtime::blend::{BlendError, BlendSpace, HeightField};
use throng_runtime::{Contacts, Joint, Mat3x4, NUM_JOINTS, Planar, Skeleton, Tables};

/// Steps of bodies a simulated second. [Unit: Hz]
const STEP_HZ: f64 = 60.0;

/// Slower members keep their heading. [Unit: m/s]
const SLOW_MPS: f32 = 0.3;

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

/// Bodies of all members of a crowd on the ground; those who have left stay where they were.
pub struct Bodies<'a> {
    scene: String,
    skeletons: Vec<Skeleton>,
    /// Members take them in turn.
    troops: Vec<Troop<'a>>,
    ground: HeightField,
}

impl<'a> Bodies<'a> {
    /// Bodies of everybody where they are in the present of `live`. Poses are there after the first step.
    ///
    /// # Errors
    /// [`BuildError::Stage`] for a blend space that the bundle does not have.
    pub fn new(
        scene: &CrowdScene,
        bodies: &CrowdBodiesConfig,
        tables: &'a Tables,
        live: &Live<Vec2>,
    ) -> Result<Self, BuildError> {
        let sizes = BodiesConfig { sizes: [0.9, 1.05], ..BodiesConfig::default() };
        let skeletons = sizes.make(tables.skeleton(), scene.seed);
        let mut troops = Vec::with_capacity(bodies.spaces.len());
        for (t, name) in bodies.spaces.iter().enumerate() {
            let space = named_space(tables, "bodies.spaces", name, (&scene.name, &bodies.bundle))?;
            let members: Vec<usize> = (t..live.num_members()).step_by(bodies.spaces.len()).collect();
            let troop = troop(live, space, members, tables.skeleton(), &skeletons);
            troops.push(troop.map_err(|e| blend_fault(&scene.name, &e))?);
        }
        Ok(Self { scene: scene.name.clone(), skeletons, troops, ground: HeightField::flat() })
    }

    /// Moves all bodies on by `dt_s`, to where members are at `time_s`.
    ///
    /// # Errors
    /// [`BuildError::Stage`] where `dt_s` is not in `0..=1`.
    pub fn step(&mut self, live: &Live<Vec2>, time_s: f64, dt_s: f32) -> Result<(), BuildError> {
        for t in &mut self.troops {
            t.members.iter().zip(&mut t.controls).for_each(|(&m, c)| steer(live, m, time_s, c));
            let done = t.walkers.step(&t.space, dt_s, &t.controls, &self.ground);
            done.map_err(|e| blend_fault(&self.scene, &e))?;
        }
        Ok(())
    }

    fn walkers_of(&self, member: usize) -> (&Walkers, usize) {
        let num = self.troops.len();
        (&self.troops[member % num].walkers, member / num)
    }

    /// Skeletons, which members take in turn. [Size: >= 1]
    pub fn skeletons(&self) -> &[Skeleton] {
        &self.skeletons
    }

    /// Planar root of a member's body. [Limit: member < number of members]
    pub fn root(&self, member: usize) -> Planar {
        let (walkers, w) = self.walkers_of(member);
        walkers.root(w)
    }

    /// Joints of a member in model space, which [`Bodies::root`] places in the world. [Size: NUM_JOINTS]
    /// [Limit: member < number of members]
    pub fn pose(&self, member: usize) -> &[Mat3x4] {
        let (walkers, w) = self.walkers_of(member);
        walkers.pose(w)
    }

    /// World positions of a member's joints. [Unit: m] [Limit: member < number of members]
    pub fn joint_positions(&self, member: usize) -> [Vec3; NUM_JOINTS] {
        let (walkers, w) = self.walkers_of(member);
        walkers.joint_positions(w)
    }

    /// Planted parts of a member's feet, and bottom of the heel and ball of both in the world. [Unit: m]
    /// [Limit: member < number of members]
    pub fn feet(&self, member: usize) -> (Contacts, Soles) {
        let (walkers, w) = self.walkers_of(member);
        (walkers.contacts(w), walkers.soles(w))
    }
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
    let mut bodies = Bodies::new(scene, bodies, tables, &live)?;
    let (mut slip, mut report) = (SoleMeter::new(live.num_members()), BodiesReport::default());
    let steps = (seconds * STEP_HZ).ceil() as u64;
    for step in 0..=steps {
        let time_s = (step as f64 / STEP_HZ).min(seconds);
        live.advance(time_s)?;
        // The first step only poses everybody.
        let dt_s = if step == 0 { 0.0 } else { (1.0 / STEP_HZ) as f32 };
        bodies.step(&live, time_s, dt_s)?;
        slip.observe(dt_s, |m| bodies.feet(m));
        for m in 0..live.num_members() {
            if let Some(at) = live.position(m, time_s) {
                let hips = bodies.joint_positions(m)[Joint::Hips.index()];
                let off = f64::from(at.distance(Vec2::new(hips.x, hips.z)));
                report.hips_off_max_m = report.hips_off_max_m.max(off);
            }
        }
    }
    (report.foot_slip_mean_mps, report.foot_slip_p95_mps) = (slip.mean_mps(), slip.p95_mps());
    let pose = |m: usize| live.position(m, seconds).map(|_| bodies.joint_positions(m));
    Ok(((0..live.num_members()).map(pose).collect(), report))
}

/// Bodies of the members of one blend space, who face the way that they move or are to go.
fn troop<'a>(
    live: &Live<Vec2>,
    space: BlendSpace<'a>,
    members: Vec<usize>,
    database: &Skeleton,
    skeletons: &[Skeleton],
) -> Result<Troop<'a>, BlendError> {
    let now = live.crowd().now();
    let start = |&m: &usize| {
        let way = &live.layout().ways[m];
        let ahead = way.get(1).map_or(Vec2::Y, |&next| next - way[0]);
        let velocity = live.velocity(m, now).filter(|v| v.length() > SLOW_MPS);
        let (at, ahead) = (live.position(m, now).unwrap_or(way[0]), velocity.unwrap_or(ahead));
        let root = Planar { x: at.x, z: at.y, heading: ahead.x.atan2(ahead.y) };
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
    let (Some(at), Some(velocity)) = (live.position(m, time_s), live.smooth_velocity(m)) else {
        control.velocity = Vec2::ZERO;
        return;
    };
    (control.position, control.velocity) = (at, velocity);
    if velocity.length() > SLOW_MPS {
        control.heading = Some(velocity.x.atan2(velocity.y));
    }
}
