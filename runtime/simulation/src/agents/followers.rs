//! Bodies of the agents of a scene, blended from example motions.

use super::SceneAgents;
use super::stage::{BodyActivity, CrowdStage};
use super::things::{BodyGrasps, grasps};
use super::troop::{SavedTroop, Troop};
use crate::motion_kind::{GroupStep, check_snapshot};
use crate::{compile::CompiledScene, wander::random_skeletons};
use glam::{Vec2, Vec3Swizzles};
use std::{ops::Range, sync::Arc};
use throng_base::{Result, maths};
use throng_core::walkers::{Performance, PerformanceProgress, Walkers, WalkersConfig};
use throng_core::{Mat3x4, NUM_JOINTS, Skeleton, blend::ActivityId, body::ArmLayer};
use throng_crowd::{Id, Space};

/// Cosine of the largest angle to the front at which gestures are shown.
const ARMS_REACH: f32 = -0.2;

/// Bodies of the agents of one group; bodies of agents that have left stay where they were.
#[derive(Clone, Debug)]
pub(super) struct Followers {
    /// Key of the group in the scene file, for messages.
    key: String,
    scene: Arc<crate::scene::Scene>,
    /// Numbers of its agents.
    pub agents: Range<usize>,
    /// Skeletons; agents take them in turn, by their numbers in the crowd.
    bodies: Vec<Skeleton>,
    /// Activities of the bundle for each troop and each motion tag of the scenario.
    activities: Vec<Vec<Vec<ActivityId>>>,
    /// Last activity ordered of each body (count).
    pub ordered: Vec<BodyActivity>,
    /// Troops; agents take them in turn, by their numbers in the crowd.
    troops: Vec<Troop>,
}

impl Followers {
    /// Bodies of a group at the current positions of its agents. Poses are valid after the first step.
    ///
    /// # Errors
    /// [`throng_base::Error::Text`] for a blend space that the bundle does not have.
    pub fn new<V: Space>(compiled: &CompiledScene, group: usize, agents: &SceneAgents<V>) -> Result<Self> {
        let (scene, bundle) = (&compiled.scene, compiled.bundle(group)?);
        let config = &scene.groups[group];
        let first = agents.layout().groups.iter().position(|&g| g == group).unwrap_or(0);
        let bodies = random_skeletons(&config.bodies(), bundle.skeleton(), scene.seed);
        let key = format!("groups[{group}]");
        let mut troops = Vec::with_capacity(config.spaces.len());
        let motions = compiled.scenario().map_or(&[] as &[String], |s| s.motion_tags());
        let mut activities = Vec::new();
        for t in 0..config.spaces.len() {
            let space = compiled.blend_space(group, t)?;
            activities.push(motions.iter().map(|tag| space.activities().ids_of_tag(tag).collect()).collect());
            let numbers = (first..first + config.count).filter(|m| m % config.spaces.len() == t);
            let room = numbers.clone().count();
            let made = Walkers::with_capacity(space, &bodies, WalkersConfig::default(), room).and_then(|walkers| {
                let mut troop = Troop::new(walkers);
                for m in numbers {
                    let Some(id) = agents.id(m) else { continue };
                    let path = &agents.layout().paths[m];
                    let ahead = path.get(1).map_or(Vec2::Y, |&next| (next - path[0]).on_ground());
                    troop.add_body(agents.crowd(), id, ahead, bodies.len())?;
                }
                Ok(troop)
            });
            troops.push(made.map_err(|e| scene.fault(&key, e))?);
        }
        let (agents, ordered) = (first..first + config.count, vec![BodyActivity::default(); config.count]);
        Ok(Self { key, scene: Arc::clone(scene), agents, bodies, activities, ordered, troops })
    }

    /// Advances all bodies to the current positions of their agents.
    pub fn step<V: Space>(&mut self, outside: &CrowdStage<V>, tick: &GroupStep<'_>) -> Result<()> {
        let crowd = &outside.crowd;
        for &agent in &outside.newcomers {
            if let Some(id) = outside.ids[agent as usize].filter(|_| self.agents.contains(&(agent as usize))) {
                let (t, row) = self.locate(agent as usize);
                let troop = &mut self.troops[t];
                // One that has left before, and comes again, has a body.
                let entered = match row < troop.agents.len() {
                    true => troop.give_body(row, crowd, id),
                    false => troop.add_body(crowd, id, Vec2::Y, self.bodies.len()),
                };
                entered.map_err(|e| self.scene.fault(&self.key, e))?;
            }
        }
        for agent in self.agents.clone() {
            self.order_activity(outside, agent)?;
        }
        let done = self.troops.iter_mut().try_for_each(|t| t.step(crowd, tick.dt_s, tick.run));
        done.map_err(|e| self.scene.fault(&self.key, e))
    }

    /// Orders what the body of an agent does beside walking: to face and look at a place, and to perform an activity repeatedly, or
    /// once where it is a greeting.
    fn order_activity<V: Space>(&mut self, outside: &CrowdStage<V>, agent: usize) -> Result<()> {
        let (t, row) = self.locate(agent);
        let shown = outside.shown[agent];
        let Some(at) = outside.ids[agent].and_then(|id| outside.crowd.position(id, outside.crowd.time_s())) else {
            return Ok(());
        };
        let waits = self.puts_off_gesture(outside, agent);
        let troop = &mut self.troops[t];
        let faces = outside.faced_position(agent);
        let ahead = faces.map(|faces| (faces - at).xz());
        let gesture = outside.gesture_now(agent);
        let aimed = gesture.and_then(|g| g.1);
        troop.order_gaze(row, ahead.or(aimed.filter(|_| waits).map(|to| (to - at).xz())), faces.or(aimed));
        troop.order_gesture(row, gesture.filter(|_| !waits));
        let speed_mps = outside.ids[agent].and_then(|id| outside.crowd.smooth_velocity(id)).map_or(0.0, |v| v.length());
        let held = faces.and_then(|_| troop.held_position(row, at.xz(), speed_mps));
        troop.order_stand(row, shown.stands.map(|at| at.xz()).or(held));
        let ordered = &mut self.ordered[agent - self.agents.start];
        let before = std::mem::replace(ordered, shown);
        let is_new = before != shown;
        let Some(motion) = shown.motion else { return if is_new { troop.order_activity(row, None) } else { Ok(()) } };
        let heading = ahead.filter(|a| a.length_squared() > 1e-4).map(|a| maths::atan2(a.x, a.y));
        if let Some(activity) = shown.once {
            // An agent that still walked at the order has not begun.
            let begins = is_new || troop.walkers.performing(row).is_none() && outside.things.is_awaited(agent as u32);
            return if begins { troop.order_activity(row, Some(Performance { activity, heading })) } else { Ok(()) };
        }
        let all = &self.activities[t][usize::from(motion)];
        let performing = troop.walkers.performing(row);
        if all.is_empty() || !is_new && (performing.is_some() || troop.is_played_once(all[0])) {
            return Ok(());
        }
        if troop.is_played_once(all[0]) {
            if performing.is_some_and(|p| all.contains(&p.activity)) {
                return Ok(());
            }
            // Who still walks lets it go: it is ordered again until it has begun.
            *ordered = before;
        }
        // The choice differs between agents and changes with time.
        let turn = agent + (outside.crowd.time_s() * 0.37) as usize;
        troop.order_activity(row, Some(Performance { activity: all[turn % all.len()], heading }))
    }

    /// True where the gesture of an agent is aimed behind its body: it is put off until the body has turned, which it does at once
    /// where it stands and faces nobody.
    pub fn puts_off_gesture<V: Space>(&self, outside: &CrowdStage<V>, agent: usize) -> bool {
        let Some((_, Some(to))) = outside.gesture_now(agent).filter(|_| self.has_body(agent)) else { return false };
        let (walkers, row) = self.walkers_of(agent);
        let to = walkers.root(row).inverse_transform_point(to.xz());
        to.y < ARMS_REACH * to.length()
    }

    /// State that the next steps depend on, troop by troop.
    pub fn to_saved(&self) -> Vec<SavedTroop> {
        self.troops.iter().map(Troop::to_saved).collect()
    }

    /// Restores a saved state.
    ///
    /// # Errors
    /// [`throng_base::Error::Snapshot`]; a part may have been loaded then.
    pub fn load(&mut self, troops: &[SavedTroop], ids: &[Option<Id>], ordered: &[BodyActivity]) -> Result<()> {
        check_snapshot(troops.len() == self.troops.len(), "bodies", "it has other blend spaces")?;
        check_snapshot(ordered.len() == self.ordered.len(), "bodies", "it has other agents")?;
        let num = self.troops.len();
        for (t, (own, saved)) in self.troops.iter_mut().zip(troops).enumerate() {
            let mine = self.agents.clone().filter(|m| m % num == t);
            own.agents.clear();
            own.agents.extend(mine.filter_map(|m| ids[m]));
            own.load(saved)?;
        }
        self.ordered.copy_from_slice(ordered);
        Ok(())
    }

    /// Grasps by which hands take things and put them down, for each body, troop and motion tag.
    pub fn grasps(&self) -> Vec<BodyGrasps> {
        let of_body = |body: &Skeleton| {
            let of_troop = |(troop, tags): (&Troop, &Vec<Vec<ActivityId>>)| {
                let set = troop.walkers.space().activities();
                tags.iter().map(|activities| grasps(set, activities, body)).collect()
            };
            self.troops.iter().zip(&self.activities).map(of_troop).collect()
        };
        self.bodies.iter().map(of_body).collect()
    }

    /// True where an agent has entered, so that its body exists.
    pub fn has_body(&self, agent: usize) -> bool {
        self.locate(agent).1 < self.walkers_of(agent).0.len()
    }

    /// Activity that the body of an agent performs.
    pub fn performing(&self, agent: usize) -> Option<PerformanceProgress> {
        let (walkers, w) = self.walkers_of(agent);
        walkers.performing(w)
    }

    /// Ends the reaching of all hands.
    pub fn free_hands(&mut self) {
        self.troops.iter_mut().for_each(Troop::free_hands);
    }

    /// Orders a hand of an agent's body (0 left, 1 right) to reach for something in the next step.
    pub fn order_reach(&mut self, agent: usize, side: usize, reach: ArmLayer) {
        let (t, row) = self.locate(agent);
        self.troops[t].order_reach(row, side, reach);
    }

    /// Joints of an agent in model space; its root places them in the world.
    pub fn pose(&self, agent: usize) -> &[Mat3x4; NUM_JOINTS] {
        let (walkers, w) = self.walkers_of(agent);
        crate::motion_kind::single_pose(walkers.pose(w))
    }

    pub fn walkers_of(&self, agent: usize) -> (&Walkers, usize) {
        let (t, row) = self.locate(agent);
        (&self.troops[t].walkers, row)
    }

    /// Number of an agent's troop, and of its body there.
    fn locate(&self, agent: usize) -> (usize, usize) {
        let num = self.troops.len();
        (agent % num, (agent - self.agents.start) / num)
    }
}
