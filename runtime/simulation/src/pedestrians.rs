//! Agents with bodies as a character group: they enter and leave, find their paths, avoid each other, are saved and loaded.

use crate::CharacterEvent;
use crate::agents::troop::{SavedTroop, Troop};
use crate::agents::{advance_crowd, character_event};
use crate::motion_kind::{check_snapshot, saved_bytes};
use glam::{Vec2, Vec3, Vec3Swizzles};
use serde::{Deserialize, Serialize};
use throng_base::{Bytes, Error, Executor, Result, SnapshotKind, error::check_value, limits::STEP_S};
use throng_core::walkers::{Walkers, WalkersConfig};
use throng_core::{AdoptReport, Bundle, CharacterGroup, OrderStatus, Planar, PosedBodies, Skeleton, blend::BlendSpace};
use throng_crowd::{Agent, AgentOrder, Crowd, CrowdError, Id};

/// Events of each agent in a step for which memory is allocated at the start.
const EVENTS: usize = 4;

/// Kind of the snapshot; both parts have a hash of their setup.
const KIND: SnapshotKind = SnapshotKind { what: "pedestrians", tag: *b"PEDS", version: 3, setup: 0 };

/// State that changes with time.
#[derive(Serialize, Deserialize)]
struct SavedPedestrians {
    crowd: Bytes,
    /// Agent of each body, row by row.
    agents: Vec<Id>,
    troop: SavedTroop,
}

/// Agents of a crowd on the ground, each with a blended body that follows its disc.
///
/// All memory is allocated in [`Pedestrians::new`], except for orders, for loading and adopting, and for the parts of large
/// crowds that several threads run (from the first step). Ids are those of the crowd.
///
/// ```no_run
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use glam::Vec3;
/// use throng_core::{Bundle, CharacterGroup, Inline};
/// use throng_crowd::{Agent, AgentOrder, AtEnd, Crowd, CrowdSetup, Streets};
/// use throng_simulation::Pedestrians;
///
/// let bundle = Bundle::open("locomotion.throng")?;
/// let crowd = Crowd::on_ground(CrowdSetup::in_streets(&Streets::new(&[], 0.4)?, 320))?;
/// let mut people = Pedestrians::new(crowd, bundle.blend("ahead-neutral")?, &[], Default::default())?;
/// let id = people.spawn(Agent::standing_at(Vec3::ZERO))?;
/// people.order(id, AgentOrder::to_goal(Vec3::new(9.0, 0.0, 0.0)).then_at_end(AtEnd::Leave))?;
/// people.step(1.0 / 60.0, &Inline)?;
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Pedestrians {
    crowd: Crowd,
    troop: Troop,
    /// Number of different bodies, which agents take in turn.
    num_bodies: usize,
    events: Vec<(Id, CharacterEvent)>,
}

impl Pedestrians {
    /// Gives bodies to a crowd: to all agents that are there, and to those that will enter.
    ///
    /// - `bodies`: skeletons that agents take in turn, by their places in the crowd, as in
    ///   [`Walkers::with_capacity`]; none stands for the skeleton of the examples.
    ///
    /// # Errors
    /// [`Error::Value`] for a crowd in the air, or for a body or setting out of range.
    pub fn new(crowd: Crowd, space: BlendSpace, bodies: &[Skeleton], config: WalkersConfig) -> Result<Self> {
        let dimensions = if crowd.is_on_ground() { 2.0 } else { 3.0 };
        let expected = "2: bodies walk on the ground; make the crowd with `Crowd::on_ground`";
        check_value("number of dimensions of the crowd", None, dimensions, crowd.is_on_ground(), expected)?;
        let walkers = Walkers::with_capacity(space, bodies, config, crowd.capacity())?;
        let (troop, events) = (Troop::new(walkers), Vec::with_capacity(EVENTS * crowd.capacity()));
        let mut people = Self { troop, num_bodies: bodies.len().max(1), events, crowd };
        people.crowd.ids().collect::<Vec<_>>().into_iter().try_for_each(|id| people.give_body(id))?;
        Ok(people)
    }

    /// The crowd: positions of agents at any time, their velocities and decisions.
    pub fn crowd(&self) -> &Crowd {
        &self.crowd
    }

    /// The bodies as walkers, row by row as in [`CharacterGroup::bodies`]: feet, phases and weights.
    pub fn walkers(&self) -> &Walkers {
        &self.troop.walkers
    }

    /// Gives an agent a body that faces the direction in which the agent moves or is to go.
    fn give_body(&mut self, id: Id) -> Result<()> {
        let ahead = self.crowd.desired_direction(id).map_or(Vec2::ZERO, |ahead| ahead.xz());
        self.troop.add_body(&self.crowd, id, ahead, self.num_bodies)
    }

    fn row(&self, id: Id) -> Result<usize> {
        self.troop.bodies().row(id).ok_or(Error::Gone(id))
    }

    /// Restores a saved state; a part may have been loaded where it is refused.
    fn load_parts(&mut self, saved: &SavedPedestrians) -> Result<()> {
        self.crowd.load(&saved.crowd.0)?;
        let mut agents = saved.agents.clone();
        agents.sort_unstable();
        check_snapshot(self.crowd.ids().eq(agents), KIND.what, "bodies are of others than those who are there")?;
        self.troop.agents.clone_from(&saved.agents);
        self.troop.load(&saved.troop)?;
        self.events.clear();
        Ok(())
    }
}

impl CharacterGroup for Pedestrians {
    type Start = Agent;
    type Order = AgentOrder;
    /// [`CharacterEvent::Arrived`], [`CharacterEvent::Left`], [`CharacterEvent::Stuck`] or [`CharacterEvent::RunInto`].
    type Event = CharacterEvent;

    /// # Errors
    /// [`Error::Full`], [`Error::Occupied`] for a place that another agent or an obstacle takes, [`Error::Value`] or
    /// [`Error::Index`] for a faulty agent.
    fn spawn(&mut self, start: Agent) -> Result<Id> {
        let id = self.crowd.spawn(start)?;
        if let Err(e) = self.give_body(id) {
            self.crowd.despawn(id)?;
            return Err(e);
        }
        Ok(id)
    }

    /// Removes an agent. The last one takes its row in [`CharacterGroup::bodies`].
    fn despawn(&mut self, id: Id) -> Result<()> {
        let row = self.row(id)?;
        self.crowd.despawn(id)?;
        self.troop.remove_body(row)
    }

    /// Moves an agent, at rest. It goes on with its order from there; an agent without an order, or at its goal, stays there.
    ///
    /// # Errors
    /// [`Error::Gone`], [`Error::Occupied`] for a place that another agent or an obstacle takes, [`Error::NoPath`] where its
    /// order cannot be followed from there, [`Error::Value`].
    fn place(&mut self, id: Id, root: Planar) -> Result<()> {
        let row = self.row(id)?;
        check_value("heading", Some(id), root.heading, root.heading.abs() < 1e6, "a finite number below 1e6 (rad)")?;
        self.crowd.place(id, Vec3::new(root.x, 0.0, root.z))?;
        self.troop.move_body(row, root)
    }

    /// Gives an order, which counts from the agent's next event on.
    ///
    /// # Errors
    /// [`Error::Gone`], [`Error::NoPath`], [`Error::Occupied`] for subgoals in an obstacle, [`Error::Value`] for a speed or
    /// place out of range, [`Error::Index`] for a route that does not exist.
    fn order(&mut self, id: Id, order: AgentOrder) -> Result<()> {
        self.crowd.order(id, order).map_err(|e| match e {
            CrowdError::Goal { subgoal, obstacle, .. } => {
                Error::Occupied { who: id, by: format!("obstacle {obstacle}, at subgoal {subgoal} of its way,") }
            }
            e => e.into(),
        })
    }

    /// # Errors
    /// [`Error::Value`] for a time out of range (0 to 1 s); nothing has changed then. The same error names an agent that
    /// acts too often for time to pass ([`CrowdError::Stalled`]).
    fn step(&mut self, dt_s: f32, run: &dyn Executor) -> Result<()> {
        STEP_S.check("dt_s", None, dt_s)?;
        self.events.clear();
        let events = &mut self.events;
        let until_s = self.crowd.time_s() + f64::from(dt_s);
        let done = advance_crowd(&mut self.crowd, until_s, run, &mut |e| {
            events.extend(character_event(e.kind).map(|happened| (e.agent, happened)));
        });
        // Bodies of agents that have left are removed, even where the step failed.
        for &(id, happened) in &self.events {
            if let (CharacterEvent::Left, Some(row)) = (happened, self.troop.bodies().row(id)) {
                self.troop.remove_body(row)?;
            }
        }
        done?;
        self.troop.step(&self.crowd, dt_s, run)
    }

    /// Status of an agent, never [`OrderStatus::Idle`] nor [`OrderStatus::NoPath`]: an agent without an order is where it should be, and
    /// an order without a path is refused.
    fn status(&self, id: Id) -> Result<OrderStatus> {
        Ok(match self.crowd.status(id)? {
            throng_crowd::AgentStatus::Going { left_m } => OrderStatus::Going { left_m },
            throng_crowd::AgentStatus::Arrived => OrderStatus::Arrived,
            throng_crowd::AgentStatus::Blocked { by } => OrderStatus::Blocked { by },
        })
    }

    /// Events of the last step, in the order of their times.
    fn events(&self) -> &[(Id, CharacterEvent)] {
        &self.events
    }

    fn bodies(&self) -> PosedBodies<'_> {
        self.troop.bodies()
    }

    fn save(&self, out: &mut Vec<u8>) {
        let crowd = saved_bytes(|out| self.crowd.save(out));
        KIND.write(&SavedPedestrians { crowd, agents: self.troop.agents.clone(), troop: self.troop.to_saved() }, out);
    }

    fn load(&mut self, bytes: &[u8]) -> Result<()> {
        let saved: SavedPedestrians = KIND.read_all(bytes)?;
        // Tried on a clone, so that nothing changes where a part is refused.
        self.clone().load_parts(&saved)?;
        self.load_parts(&saved)
    }

    /// Takes the blend space of the same name, see [`Walkers`]; paths and positions stay.
    fn adopt(&mut self, new: &Bundle) -> Result<AdoptReport> {
        self.troop.walkers.adopt(new)
    }
}
