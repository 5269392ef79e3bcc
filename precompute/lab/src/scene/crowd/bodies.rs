//! Bodies that follow the agents of a crowd, blended from example motions.

use super::config::{CrowdBodiesConfig, CrowdScene};
use super::live::Live;
use crate::scene::walkers::{BodiesConfig, blend_fault, named_space};
use crate::slip::Soles;
use glam::{Vec2, Vec3};
use throng_motion::error::BuildError;
use throng_runtime::blend::BlendSpace;
use throng_runtime::blend::walkers::{Control, WalkerStart, Walkers, WalkersConfig};
use throng_runtime::{Bundle, Cast, Contacts, Error, Id, Inline, Mat3x4, NUM_JOINTS, Planar, Skeleton};

/// Slower agents keep their heading (m/s).
const SLOW_MPS: f32 = 0.3;

/// Agents of one blend space.
struct Troop {
    walkers: Walkers,
    ids: Vec<Id>,
    controls: Vec<Control>,
    /// Number of each in the crowd.
    agents: Vec<usize>,
}

/// Bodies of all agents of a crowd on the ground; those who have left stay where they were.
pub struct Bodies {
    scene: String,
    skeletons: Vec<Skeleton>,
    /// Agents take them in turn.
    troops: Vec<Troop>,
}

impl Troop {
    fn step(&mut self, dt_s: f32) -> Result<(), Error> {
        for (id, control) in self.ids.iter().zip(&self.controls) {
            self.walkers.order(*id, *control)?;
        }
        self.walkers.step(dt_s, &Inline)
    }
}

impl Bodies {
    /// Bodies of everybody where they are in the present of `live`. Poses are there after the first step.
    ///
    /// # Errors
    /// [`BuildError::Stage`] for a blend space that the bundle does not have.
    pub fn new(
        scene: &CrowdScene,
        bodies: &CrowdBodiesConfig,
        tables: &Bundle,
        live: &Live<Vec2>,
    ) -> Result<Self, BuildError> {
        let sizes = BodiesConfig { sizes: [0.9, 1.05], ..BodiesConfig::default() };
        let skeletons = sizes.make(tables.skeleton(), scene.seed);
        let mut troops = Vec::with_capacity(bodies.spaces.len());
        for (t, name) in bodies.spaces.iter().enumerate() {
            let space = named_space(tables, "bodies.spaces", name, (&scene.name, &bodies.bundle))?;
            let agents: Vec<usize> = (t..live.num_agents()).step_by(bodies.spaces.len()).collect();
            let troop = troop(live, space, agents, &skeletons);
            troops.push(troop.map_err(|e| blend_fault(&scene.name, &e))?);
        }
        Ok(Self { scene: scene.name.clone(), skeletons, troops })
    }

    /// Moves all bodies on by `dt_s`, to where agents are at `time_s`.
    ///
    /// # Errors
    /// [`BuildError::Stage`] where `dt_s` is not in `0..=1`.
    pub fn step(&mut self, live: &Live<Vec2>, time_s: f64, dt_s: f32) -> Result<(), BuildError> {
        for t in &mut self.troops {
            t.agents.iter().zip(&mut t.controls).for_each(|(&m, c)| steer(live, m, time_s, c));
            t.step(dt_s).map_err(|e| blend_fault(&self.scene, &e))?;
        }
        Ok(())
    }

    fn walkers_of(&self, agent: usize) -> (&Walkers, usize) {
        let num = self.troops.len();
        (&self.troops[agent % num].walkers, agent / num)
    }

    /// Skeletons, which agents take in turn (>= 1).
    pub fn skeletons(&self) -> &[Skeleton] {
        &self.skeletons
    }

    /// Planar root of an agent's body (agent < number of agents).
    pub fn root(&self, agent: usize) -> Planar {
        let (walkers, w) = self.walkers_of(agent);
        walkers.root(w)
    }

    /// Joints of an agent in model space, which [`Bodies::root`] places in the world (NUM_JOINTS).
    /// (agent < number of agents)
    pub fn pose(&self, agent: usize) -> &[Mat3x4] {
        let (walkers, w) = self.walkers_of(agent);
        walkers.pose(w)
    }

    /// World positions of an agent's joints (m, agent < number of agents).
    pub fn joint_positions(&self, agent: usize) -> [Vec3; NUM_JOINTS] {
        let (walkers, w) = self.walkers_of(agent);
        walkers.joint_positions(w)
    }

    /// Planted parts of an agent's feet, and bottom of the heel and ball of both in the world (m).
    /// (agent < number of agents)
    pub fn feet(&self, agent: usize) -> (Contacts, Soles) {
        let (walkers, w) = self.walkers_of(agent);
        (walkers.contacts(w), walkers.soles(w))
    }
}

/// Bodies of the agents of one blend space, who face the way that they move or are to go.
fn troop(live: &Live<Vec2>, space: BlendSpace, agents: Vec<usize>, skeletons: &[Skeleton]) -> Result<Troop, Error> {
    let now = live.crowd().now();
    let start = |&m: &usize| {
        let way = &live.layout().ways[m];
        let ahead = way.get(1).map_or(Vec2::Y, |&next| next - way[0]);
        let velocity = live.velocity(m, now).filter(|v| v.length() > SLOW_MPS);
        let (at, ahead) = (live.position(m, now).unwrap_or(way[0]), velocity.unwrap_or(ahead));
        let root = Planar { x: at.x, z: at.y, heading: ahead.x.atan2(ahead.y) };
        WalkerStart { body: m % skeletons.len(), root, phase: (m as f32 * 0.381_966).fract() }
    };
    let starts: Vec<WalkerStart> = agents.iter().map(start).collect();
    let mut walkers = Walkers::with_capacity(space, skeletons, WalkersConfig::default(), starts.len())?;
    let ids = starts.iter().map(|s| walkers.spawn(*s)).collect::<Result<_, _>>()?;
    let control = |s: &WalkerStart| Control {
        position: Some(Vec2::new(s.root.x, s.root.z)),
        heading: Some(s.root.heading),
        ..Control::default()
    };
    Ok(Troop { walkers, ids, controls: starts.iter().map(control).collect(), agents })
}

/// What a body is asked: to be where its agent is, and to move as it does. Those who stand keep their heading, those who have
/// left stay where they were.
fn steer(live: &Live<Vec2>, m: usize, time_s: f64, control: &mut Control) {
    let (Some(at), Some(velocity)) = (live.position(m, time_s), live.smooth_velocity(m)) else {
        control.velocity = Vec2::ZERO;
        return;
    };
    (control.position, control.velocity) = (Some(at), velocity);
    if velocity.length() > SLOW_MPS {
        control.heading = Some(velocity.x.atan2(velocity.y));
    }
}
