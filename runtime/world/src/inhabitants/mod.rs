//! Inhabitants: characters that live in a world, hold the units they need, and pursue their goals (Lee, Choi and Lee
//! 2006, section 7).

mod chains;
mod character_group;
mod config;
mod decide;
mod ground;
mod offers;
mod pairs;
mod paths;
mod purpose;
mod reservations;
mod scatter;
mod schedule;
mod snapshot;
mod targets;

pub use character_group::{InhabitantEvent, PLACED_WITHIN_M};
pub use config::{InhabitantActivity, InhabitantGoal, InhabitantState, InhabitantsConfig};
pub use pairs::MeetingState;
pub use scatter::scatter_rest_nodes;

use super::plan::{WorldPlan, WorldPlanner};
use super::{World, WorldGraph, WorldNode, WorldStep};
use chains::Chains;
use ground::InstanceCapsules;
use pairs::{PairMeeting, PairOffer, PartingReason};
use paths::InhabitantPaths;
use purpose::Purpose;
use reservations::UnitReservations;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use throng_base::{Id, Result};
use throng_core::characters::{Characters, PolicyOrder};
use throng_core::{Contacts, Joint, Planar, Roster, body::BodyLayers, glam::Vec3};

/// State of an inhabitant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct InhabitantMemory {
    /// Node that its motion leads to.
    at: WorldNode,
    /// Instances that its motion leads through: the one where it began, and the one whose link it plays.
    through: [u32; 2],
    /// Time at which it reserved its chain (s).
    reserved_s: f64,
    goal: InhabitantGoal,
    activity: InhabitantActivity,
    num_fulfilled: u32,
    /// Time at which it was first refused a unit, since it last got one (s).
    refused_s: Option<f64>,
    /// Last time at which the one who held it went on (s).
    went_on_s: f64,
    /// Random numbers drawn so far.
    draws: u32,
    /// Direction in which it roams.
    purpose: Purpose,
    /// Steps of its path in a row that it was not refused.
    progress: u32,
    /// Times in a row that it lost patience.
    impatience: u32,
    /// Steps of its detour that are left.
    detour: u32,
    /// Time at which it goes on after its detour (s).
    until_s: f64,
    /// Time that it has performed the action of its goal (frames).
    performed: u32,
    /// True where it is blocked, and another character cannot pass.
    obstructs: bool,
    /// Times that it lost patience, and of these behind characters that do not go on; since when, see `num_orders`.
    tries: [u32; 2],
    order_number: u32,
    /// Meeting with a partner, if there is one.
    meeting: Option<PairMeeting>,
    /// True while it plays what two do together.
    plays_pair: bool,
    /// Reason why its meeting ended since the last step, if it did.
    parted: Option<PartingReason>,
    /// Time at which it goes on after an action with a partner: it need not rest for long (s).
    leaves_s: Option<f64>,
}

impl InhabitantMemory {
    /// Least remaining time of the action that it performs (frames).
    fn frames_left(&self, rate_hz: f32) -> f32 {
        match self.goal {
            InhabitantGoal::Perform { seconds, .. } | InhabitantGoal::Meet { seconds, .. } => {
                seconds * rate_hz - self.performed as f32
            }
            _ => 0.0,
        }
        .max(0.0)
    }

    /// Calls `visit` with the instances whose units a character needs: of the present step and of those after it.
    fn visit_needed_instances(&self, graph: &WorldGraph, chain: &[WorldStep], mut visit: impl FnMut(u32)) {
        self.through.iter().for_each(|&instance| visit(instance));
        visit(self.at.instance);
        for step in chain {
            if graph.link(step).is_some() {
                visit(step.instance);
            }
            visit(step.to.instance);
        }
    }

    /// At rest in a place, without a goal.
    fn resting_at(node: WorldNode) -> Self {
        Self { at: node, through: [node.instance; 2], ..Self::default() }
    }

    /// Replaces the goal, which it has not begun to pursue.
    fn with_goal(self, goal: InhabitantGoal) -> Self {
        let activity = if goal.is_roaming() { InhabitantActivity::Roaming } else { InhabitantActivity::Planning };
        let Self { at, through, reserved_s, num_fulfilled, draws, purpose, progress, .. } = self;
        let Self { plays_pair, parted, leaves_s, .. } = self;
        let new = Self { goal, activity, through, num_fulfilled, draws, purpose, progress, ..Self::resting_at(at) };
        Self { reserved_s, plays_pair, parted, leaves_s, ..new }
    }
}

/// Characters in a world, with their goals, as a [`throng_core::CharacterGroup`]. All memory is allocated in
/// [`Inhabitants::new`], except for saving and loading.
///
/// Each holds the units of the instance it is in, and takes all units that it needs up to the next node from which a
/// rest cell can be reached without more. Others keep out of them, except in passages and climbs: there they may follow
/// at a distance at which bodies do not touch, where both are sure to leave the units. A character refused a reservation rests within the
/// units it holds, tries again, and after a while makes a random detour, longer each time. If its place is taken by one
/// that stays, it waits, and moves out of the way of others, until the place is free or it gets another order.
///
/// ```no_run
/// use throng_core::{Bundle, CharacterGroup, Inline, glam::Vec3};
/// use throng_world::World;
/// use throng_world::inhabitants::{InhabitantGoal, Inhabitants, InhabitantsConfig, scatter_rest_nodes};
///
/// let world = World::open("playground.world", &Bundle::open("playground.throng")?)?;
/// let mut people = Inhabitants::new(&world, 10, InhabitantsConfig::default())?;
/// for start in scatter_rest_nodes(world.graph(), 10, 1) {
///     people.spawn(start)?;
/// }
/// people.order(people.ids()[0], InhabitantGoal::GoNear { place: Vec3::ZERO, within_m: 3.0 })?;
/// people.step(1.0 / 60.0, &Inline)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Inhabitants {
    world: World,
    config: InhabitantsConfig,
    /// Ids of present characters, in the order of bodies. All that follows is in the same order.
    roster: Roster,
    characters: Characters,
    roots: Vec<Planar>,
    /// Orders without policies, for their layers.
    orders: Vec<PolicyOrder>,
    states: Vec<InhabitantMemory>,
    chains: Chains,
    paths: InhabitantPaths,
    reservations: UnitReservations,
    /// Capsule of each instance, by its number; made when there are external obstacles.
    grounds: Option<Arc<InstanceCapsules>>,
    planner: WorldPlanner,
    /// Instances that offer each tag, by `tag - 1`.
    offers: Vec<Vec<u32>>,
    /// Number of characters whose target needs each unit.
    num_bound: Vec<u32>,
    /// Places for actions of two.
    pair_offers: Vec<PairOffer>,
    events: Vec<(Id, InhabitantEvent)>,
    rate_hz: f32,
    time_s: f64,
    /// Number of orders, and of characters that entered, left or were placed.
    num_orders: u32,
}

impl Inhabitants {
    /// Room for so many characters in a world.
    ///
    /// # Errors
    /// [`throng_base::Error::Value`] for a setting or capacity out of its range.
    pub fn new(world: &World, capacity: usize, config: InhabitantsConfig) -> Result<Self> {
        config.check(capacity)?;
        let (motion_set, graph) = (world.motion_set(), world.graph());
        Ok(Self {
            world: world.clone(),
            roster: Roster::with_capacity(capacity),
            characters: Characters::with_capacity(motion_set, config.characters, capacity)?,
            roots: Vec::with_capacity(capacity),
            orders: Vec::with_capacity(capacity),
            states: Vec::with_capacity(capacity),
            chains: Chains::new(capacity),
            paths: InhabitantPaths::new(capacity, config.max_path),
            reservations: UnitReservations::new(graph),
            grounds: None,
            planner: WorldPlanner::new(graph),
            offers: offers::offers_by_tag(graph),
            num_bound: vec![0; graph.world().units.len()],
            pair_offers: pairs::pair_offers(graph),
            // In one step, a character may lose its partner, find no path, begin and arrive.
            events: Vec::with_capacity(4 * capacity),
            rate_hz: motion_set.rate_hz,
            time_s: 0.0,
            num_orders: 0,
            config,
        })
    }

    /// The world that they live in.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Most characters.
    pub fn capacity(&self) -> usize {
        self.roster.capacity()
    }

    /// Ids of present characters, in the order of bodies.
    pub fn ids(&self) -> &[Id] {
        self.roster.ids()
    }

    /// Motion of the inhabitants, in the order of [`Inhabitants::ids`].
    pub fn characters(&self) -> &Characters {
        &self.characters
    }

    /// Replaces what the body of a character does beside its motion: where it looks, what its arms do.
    ///
    /// # Errors
    /// [`throng_base::Error::Gone`], or what is wrong with the layers.
    pub fn set_layers(&mut self, id: Id, layers: BodyLayers) -> Result<()> {
        let (at, order) = (self.roster.row(id)?, PolicyOrder::IDLE.with_layers(layers));
        order.check(Some(id), self.world.motion_set())?;
        self.orders[at] = order;
        Ok(())
    }

    /// Displaces a part of the body of a character, which then comes back, see [`Characters::push`].
    ///
    /// # Errors
    /// [`throng_base::Error::Gone`], [`throng_base::Error::Value`] for a displacement that is not finite (m).
    pub fn push(&mut self, id: Id, joint: Joint, displacement: Vec3) -> Result<()> {
        self.characters.push(self.roster.row(id)?, joint, displacement)
    }

    /// State of a character.
    ///
    /// # Errors
    /// [`throng_base::Error::Gone`].
    pub fn state(&self, id: Id) -> Result<InhabitantState> {
        let s = &self.states[self.roster.row(id)?];
        let waited_s = s.refused_s.map_or(0.0, |since| (self.time_s - since) as f32);
        Ok(InhabitantState { node: s.at, goal: s.goal, activity: s.activity, num_fulfilled: s.num_fulfilled, waited_s })
    }

    /// Planted parts of a character's feet.
    ///
    /// # Errors
    /// [`throng_base::Error::Gone`].
    pub fn contacts(&self, id: Id) -> Result<Contacts> {
        Ok(self.characters.contacts(self.roster.row(id)?))
    }

    /// Steps that a character is sure to take after the present one: what they need is held.
    ///
    /// # Errors
    /// [`throng_base::Error::Gone`].
    pub fn reserved_steps(&self, id: Id) -> Result<&[WorldStep]> {
        Ok(self.chains.steps_of(self.roster.row(id)?))
    }

    /// Steps of its path that a character has not begun yet, as far as they are kept; empty where it has none.
    ///
    /// # Errors
    /// [`throng_base::Error::Gone`].
    pub fn path_steps(&self, id: Id) -> Result<&[WorldStep]> {
        Ok(self.paths.steps_of(self.roster.row(id)?))
    }

    /// Result of a character's last planning, if there was one.
    ///
    /// # Errors
    /// [`throng_base::Error::Gone`].
    pub fn last_plan(&self, id: Id) -> Result<Option<&WorldPlan>> {
        Ok(self.paths.last_plan(self.roster.row(id)?))
    }

    /// Holder of a unit: of those that follow each other, the one that reserved it first (unit < number of units).
    pub fn holder(&self, unit: u32) -> Option<Id> {
        self.reservations.holder_of(unit).map(|c| self.roster.ids()[c as usize])
    }

    /// Units that a character holds; not those in which it follows another one.
    ///
    /// # Errors
    /// [`throng_base::Error::Gone`].
    pub fn units_of(&self, id: Id) -> Result<impl Iterator<Item = u32> + '_> {
        Ok(self.reservations.units_of(self.roster.row(id)? as u32))
    }
}
