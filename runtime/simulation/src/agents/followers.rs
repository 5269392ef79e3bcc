//! Bodies that follow agents, blended from example motions.

use super::{Agents, plan};
use crate::compile::CompiledScene;
use crate::kind::{PART, Tick, load_walkers, refused};
use crate::wander::skeletons;
use glam::{Vec2, Vec3};
use std::sync::Arc;
use throng_base::{Bytes, Result, run_each};
use throng_core::blend::walkers::{Control, WalkerStart, Walkers, WalkersConfig};
use throng_core::{Cast, Contacts, Mat3x4, NUM_JOINTS, Planar};
use throng_crowd::{Id, Space};

/// Slower agents keep their heading (m/s).
const SLOW_MPS: f32 = 0.3;

/// Bodies of one blend space.
#[derive(Clone, Debug)]
struct Troop {
    walkers: Walkers,
    ids: Vec<Id>,
    controls: Vec<Control>,
    /// Number of each in the crowd.
    agents: Vec<usize>,
}

/// Bodies of the agents of one group; those who have left stay where they were.
#[derive(Clone, Debug)]
pub(super) struct Followers {
    /// What messages call them.
    key: String,
    scene: Arc<crate::scene::Scene>,
    /// Number of the first agent.
    first: usize,
    count: usize,
    /// Agents take them in turn, by their numbers in the crowd.
    troops: Vec<Troop>,
}

impl Followers {
    /// Bodies of a group where its agents are now. Poses are there after the first step.
    ///
    /// # Errors
    /// [`throng_base::Error::Text`] for a blend space that the bundle does not have.
    pub fn new<V: Space>(compiled: &CompiledScene, group: usize, agents: &Agents<V>) -> Result<Self> {
        let (scene, bundle) = (compiled.shared(), compiled.bundle(group)?);
        let config = &scene.groups[group];
        let first = agents.layout.groups.iter().position(|&g| g == group).unwrap_or(0);
        let bodies = skeletons(&config.bodies(), bundle.skeleton(), scene.seed);
        let mut troops = Vec::with_capacity(config.spaces.len());
        for t in 0..config.spaces.len() {
            let space = compiled.space(group, t)?;
            let members: Vec<usize> = (first..first + config.count).filter(|m| m % config.spaces.len() == t).collect();
            let starts: Vec<WalkerStart> = members.iter().map(|&m| start(agents, m, bodies.len())).collect();
            let made = Walkers::with_capacity(space, &bodies, WalkersConfig::default(), starts.len());
            let made = made.and_then(|mut walkers| {
                let ids = starts.iter().map(|s| walkers.spawn(*s)).collect::<Result<Vec<Id>>>()?;
                Ok((walkers, ids))
            });
            let (walkers, ids) = made.map_err(|e| scene.fault(&format!("groups[{group}]"), e))?;
            let control = |s: &WalkerStart| Control {
                position: Some(Vec2::new(s.root.x, s.root.z)),
                heading: Some(s.root.heading),
                ..Control::default()
            };
            troops.push(Troop { walkers, ids, controls: starts.iter().map(control).collect(), agents: members });
        }
        let key = format!("groups[{group}]");
        Ok(Self { key, scene: Arc::clone(scene), first, count: config.count, troops })
    }

    /// Moves all bodies on, to where their agents are.
    pub fn step<V: Space>(&mut self, agents: &Agents<V>, tick: &Tick<'_>) -> Result<()> {
        for t in &mut self.troops {
            let parts = t.agents.chunks(PART).zip(t.controls.chunks_mut(PART));
            run_each(tick.run, parts, |(own, controls)| {
                own.iter().zip(controls).for_each(|(&m, c)| steer(agents, m, tick.until_s, c));
            });
            let mut pairs = t.ids.iter().zip(&t.controls);
            let told = pairs.try_for_each(|(&id, &control)| t.walkers.order(id, control));
            told.and_then(|()| t.walkers.step(tick.dt_s, tick.run)).map_err(|e| self.scene.fault(&self.key, e))?;
        }
        Ok(())
    }

    /// What the next steps depend on, troop by troop: what bodies were told last, and the walkers.
    pub fn saved(&self) -> Vec<(Vec<Control>, Bytes)> {
        let troop = |t: &Troop| {
            let mut walkers = Bytes::default();
            t.walkers.save(&mut walkers.0);
            (t.controls.clone(), walkers)
        };
        self.troops.iter().map(troop).collect()
    }

    /// Goes back to what was saved.
    ///
    /// # Errors
    /// [`throng_base::Error::Snapshot`]; a part may have been loaded then.
    pub fn load(&mut self, troops: Vec<(Vec<Control>, Bytes)>) -> Result<()> {
        if troops.len() != self.troops.len() {
            return Err(refused("bodies", "it has other blend spaces"));
        }
        for (own, (controls, walkers)) in self.troops.iter_mut().zip(troops) {
            let mut told = own.ids.iter().zip(&controls);
            if controls.len() != own.ids.len() || !told.all(|(&id, c)| c.check(id).is_ok()) {
                return Err(refused("bodies", "they are told what cannot be"));
            }
            load_walkers(&mut own.walkers, &own.ids, &walkers.0)?;
            own.controls = controls;
        }
        Ok(())
    }

    /// True where the body of an agent is among them.
    pub fn holds(&self, agent: usize) -> bool {
        (self.first..self.first + self.count).contains(&agent)
    }

    /// Planar root of an agent's body.
    pub fn root(&self, agent: usize) -> Planar {
        let (walkers, w) = self.walkers_of(agent);
        walkers.root(w)
    }

    /// Joints of an agent in model space, which [`Followers::root`] places in the world.
    pub fn pose(&self, agent: usize) -> &[Mat3x4; NUM_JOINTS] {
        let (walkers, w) = self.walkers_of(agent);
        crate::kind::joints(walkers.pose(w))
    }

    /// Planted parts of an agent's feet.
    pub fn contacts(&self, agent: usize) -> Contacts {
        let (walkers, w) = self.walkers_of(agent);
        walkers.contacts(w)
    }

    /// Bottom of the heel and ball of both feet of an agent, in the world (m).
    pub fn soles(&self, agent: usize) -> [[Vec3; 2]; 2] {
        let (walkers, w) = self.walkers_of(agent);
        walkers.soles(w)
    }

    fn walkers_of(&self, agent: usize) -> (&Walkers, usize) {
        let num = self.troops.len();
        let troop = &self.troops[agent % num];
        (&troop.walkers, (agent - troop.agents[0]) / num)
    }
}

/// Where a body begins: facing the way that its agent moves or is to go.
fn start<V: Space>(agents: &Agents<V>, m: usize, num_bodies: usize) -> WalkerStart {
    let now = agents.crowd.now();
    let way = &agents.layout.ways[m];
    let ahead = way.get(1).map_or(Vec2::Y, |&next| plan(next - way[0]));
    let velocity = agents.velocity(m, now).map(plan).filter(|v| v.length() > SLOW_MPS);
    let (at, ahead) = (plan(agents.position(m, now).unwrap_or(way[0])), velocity.unwrap_or(ahead));
    let root = Planar { x: at.x, z: at.y, heading: ahead.x.atan2(ahead.y) };
    WalkerStart { body: m % num_bodies, root, phase: (m as f32 * 0.381_966).fract() }
}

/// What a body is asked: to be where its agent is, and to move as it does. Those who stand keep their heading, those who
/// have left stay where they were.
fn steer<V: Space>(agents: &Agents<V>, m: usize, time_s: f64, control: &mut Control) {
    let (Some(at), Some(velocity)) = (agents.position(m, time_s), agents.smooth_velocity(m)) else {
        control.velocity = Vec2::ZERO;
        return;
    };
    (control.position, control.velocity) = (Some(plan(at)), plan(velocity));
    if control.velocity.length() > SLOW_MPS {
        control.heading = Some(control.velocity.x.atan2(control.velocity.y));
    }
}
