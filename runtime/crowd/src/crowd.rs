//! The crowd as an application sees it: one type on the ground and in the air, compiled here.

use crate::error::{CrowdError, Result};
use crate::events::event::{CrowdEvent, EventCounts};
use crate::routes::order::{AgentOrder, AgentStatus};
use crate::{Agent, AtEnd, CrowdSetup, Forces, Id, PersonalInterest, Route, Sense};
use crate::{events::engine::Engine, safety::rule::PlanCandidate, space::Space, space::plan::MotionPlan};
use glam::{Vec2, Vec3};
use throng_base::Executor;
use throng_base::ground::{ExternalObstacle, ReservedRegion};
use throng_geometry::Capsule2d;

/// Agents that act at their own events and never overlap.
///
/// Every agent has one next event. Between two events it keeps its acceleration, so that its position at any time is
/// known exactly. At an event it looks at its neighbours, asks the force field for the desired motion, and takes the
/// nearest plan it can find for which the safety rule holds. Its next event is when its new bound touches another
/// bound, an obstacle or the side of its region (Kim, Kim and Shin 2003b, section 2.1), though not before the smallest
/// interval is over. The proof that no two agents ever overlap is in `safety/rule.rs`; it requires nothing of forces or
/// intervals.
///
/// Positions are in the world (m, Y up). On the ground, agents are discs in x and z; given heights are ignored, and
/// returned ones are 0. Within [`CrowdConfig::capacity`](crate::CrowdConfig), nothing here allocates except orders,
/// moved agents that find their path, and functions that return or take a `Vec`.
///
/// ```
/// # fn main() -> throng_base::Result<()> {
/// use throng_crowd::{Agent, AgentOrder, AtEnd, Crowd, CrowdSetup, Obstacle, Streets};
/// use glam::Vec3;
///
/// let block = Obstacle::Box { min: Vec3::new(-2.0, 0.0, -2.0), max: Vec3::new(2.0, 3.0, 2.0) };
/// let streets = Streets::new(&[block], 0.4)?;
/// let mut crowd = Crowd::on_ground(CrowdSetup::in_streets(&streets, 20))?;
/// let id = crowd.spawn(Agent::standing_at(Vec3::new(-5.0, 0.0, 0.0)))?;
/// crowd.order(id, AgentOrder::to_goal(Vec3::new(5.0, 0.0, 0.0)).then_at_end(AtEnd::Leave))?;
/// crowd.advance(20.0, &mut |event| println!("{event:?}"))?;
/// assert_eq!(crowd.num_agents(), 0);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Crowd {
    pub(crate) engine: SpaceEngine,
}

/// The engine of either space.
#[derive(Clone, Debug)]
pub(crate) enum SpaceEngine<G = Engine<Vec2>, A = Engine<Vec3>> {
    Ground(G),
    Air(A),
}

/// Evaluates an expression with the engine of either space.
macro_rules! each {
    ($either:expr, $engine:ident => $answer:expr) => {
        match $either {
            SpaceEngine::Ground($engine) => $answer,
            SpaceEngine::Air($engine) => $answer,
        }
    };
}
pub(crate) use each;

impl Crowd {
    /// A crowd of discs on the ground.
    ///
    /// # Errors
    /// [`CrowdError`] for a setting out of its range, agents that overlap or could not brake in time, a start or subgoal
    /// in an obstacle.
    pub fn on_ground(setup: CrowdSetup) -> Result<Self> {
        Ok(Self { engine: SpaceEngine::Ground(Engine::new(setup.map(Space::from_world))?) })
    }

    /// A crowd of balls in the air.
    ///
    /// # Errors
    /// As [`Crowd::on_ground`].
    pub fn in_air(setup: CrowdSetup) -> Result<Self> {
        Ok(Self { engine: SpaceEngine::Air(Engine::new(setup)?) })
    }

    /// Advances time to `until_s`; reports all events in order. Allocates nothing.
    ///
    /// # Errors
    /// [`CrowdError::Other`] for a time in the past, and [`CrowdError::Stalled`].
    pub fn advance(&mut self, until_s: f64, on_event: &mut impl FnMut(&CrowdEvent)) -> Result<()> {
        self.advance_with(on_event, |crowd| crowd.run(until_s))
    }

    /// Advances time in parts that `run` runs; the result equals that of [`Crowd::advance`] bit by bit. Pays from some
    /// thousand agents on. Takes memory for the parts when it is called first.
    ///
    /// # Errors
    /// As [`Crowd::advance`]. Some agents that act a little after those of a [`CrowdError::Stalled`] may have acted
    /// before it was detected.
    pub fn par_advance(
        &mut self,
        until_s: f64,
        run: &dyn Executor,
        on_event: &mut impl FnMut(&CrowdEvent),
    ) -> Result<()> {
        self.advance_with(on_event, |crowd| crowd.run_parallel(until_s, run))
    }

    /// Advances time to `until_s`, see [`Crowd::advance`], or to the first signal: an event of [`Crowd::set_senses`], a
    /// timer, or an arrival, a departure or being stuck of an agent that senses these. The signal is also reported to
    /// `on_event`. The present is then its time, so that orders, senses and timers can be changed before time goes on.
    /// Several signals of one time are returned one by one, in the order (time, kind, agent): events of the engine,
    /// then sensed events, then timers.
    ///
    /// # Errors
    /// As [`Crowd::advance`].
    pub fn advance_to_signal(
        &mut self,
        until_s: f64,
        on_event: &mut impl FnMut(&CrowdEvent),
    ) -> Result<Option<CrowdEvent>> {
        loop {
            if let Some(signal) = each!(&mut self.engine, e => e.sensors.signals.pop_front()) {
                return Ok(Some(signal));
            }
            each!(&mut self.engine, e => e.sensors.stops = true);
            let done = self.run(until_s);
            each!(&mut self.engine, e => e.sensors.stops = false);
            if !matches!(done, Err(CrowdError::Other(_))) {
                self.events().iter().for_each(&mut *on_event);
            }
            if done? && each!(&self.engine, e => e.sensors.signals.is_empty()) {
                return Ok(None);
            }
        }
    }

    /// Sets the senses of an agent, among those of the crowd ([`CrowdSetup::senses`]).
    ///
    /// # Errors
    /// [`throng_base::Error::Gone`].
    pub fn set_senses(&mut self, id: Id, sense: Sense) -> Result<()> {
        each!(&mut self.engine, e => e.set_sense(id, sense))
    }

    /// Wakes an agent at a time, once, with [`crate::CrowdEventKind::Timer`]; `None` lets it sleep.
    ///
    /// # Errors
    /// [`throng_base::Error::Gone`], and [`throng_base::Error::Value`] for a time in the past.
    pub fn set_timer(&mut self, id: Id, time_s: Option<f64>) -> Result<()> {
        each!(&mut self.engine, e => e.set_timer(id, time_s))
    }

    /// Desired speed of an agent from its next event on; its order stays (m/s, up to the largest of the config).
    ///
    /// # Errors
    /// [`throng_base::Error::Gone`], and [`throng_base::Error::Value`] for a speed out of range.
    pub fn set_speed(&mut self, id: Id, speed_mps: f32) -> Result<()> {
        each!(&mut self.engine, e => e.set_speed(id, speed_mps))
    }

    /// Something that draws one agent near or drives it away from its next event on, beside [`CrowdSetup::interests`]; `None` for
    /// nothing any more. Allocates nothing.
    ///
    /// - `n`: which of its interests (< 4).
    ///
    /// # Errors
    /// [`throng_base::Error::Gone`] of either agent, and [`throng_base::Error::Value`] for a setting out of its range.
    pub fn set_interest(&mut self, id: Id, n: usize, interest: Option<PersonalInterest>) -> Result<()> {
        each!(&mut self.engine, e => e.set_interest(id, n, interest.map(|i| i.map(Space::from_world))))
    }

    /// Lets two to four agents walk together, in place of the groups they were in; a single one walks alone again. They
    /// need orders of their own, which lead the same way. From their next events on they go abreast where there is
    /// room, three and four bent to a V in a crowd, and one after the other in narrow passages and where others come;
    /// members that are ahead wait. In the air, nothing of this happens. Allocates nothing.
    ///
    /// # Errors
    /// [`throng_base::Error::Gone`], and [`throng_base::Error::Value`] for another number of them, or one twice.
    pub fn set_companions(&mut self, ids: &[Id]) -> Result<()> {
        each!(&mut self.engine, e => e.set_companions(ids))
    }

    /// Companions of an agent: up to three others.
    pub fn companions(&self, id: Id) -> impl Iterator<Item = Id> + '_ {
        let companions = each!(&self.engine, e => e.companions(id));
        companions.into_iter().flatten()
    }

    /// Opens an obstacle of the setup, as if it were not there, or closes it again. Where the crowd knows its streets, paths lead
    /// through open ones and round closed ones; where all paths lead through closed ones, agents go there and wait. Those on
    /// their way plan again at their next event. Goals are refused in open ones too. Takes memory, and the first
    /// time that one is opened the time to make the streets.
    ///
    /// # Errors
    /// [`CrowdError::Inside`] with an agent that stands where it closes, or could not stop before it; [`CrowdError::Other`] for
    /// a moving obstacle, and for more than 64 of the streets that were ever opened. Nothing has changed then.
    pub fn set_open(&mut self, obstacle: usize, open: bool) -> Result<()> {
        each!(&mut self.engine, e => e.set_open(obstacle, open))
    }

    /// Senses of an agent, and the time at which it got them; before the start where it has got none (s).
    pub fn senses(&self, id: Id) -> (Sense, f64) {
        each!(&self.engine, e => (e.sensors.states[id.index()].sense, e.sensors.states[id.index()].changed.0))
    }

    /// True where a straight line keeps a clearance from all obstacles that paths lead round, and from closed doors or from all
    /// doors (m).
    pub fn sees(&self, from: Vec3, to: Vec3, clearance_m: f32, through_doors: bool) -> bool {
        let streets = each!(&self.engine, e => e.scenery.streets.as_ref());
        streets.is_none_or(|s| s.sees(from, to, clearance_m, through_doors))
    }

    /// True for an obstacle that is open; false for one that is not there.
    pub fn is_open(&self, obstacle: usize) -> bool {
        each!(&self.engine, e => obstacle < e.scenery.obstacles.len() && e.scenery.is_open(obstacle))
    }

    /// Lets an agent act as soon as possible, and not only at the end of its plan: at once, or when the smallest
    /// interval since its last event is over; at the end where that comes within an interval after. Others rely on its
    /// plan: without another safe one, it keeps its plan to the end, however often it is woken. Engines to compare with
    /// ignore this.
    ///
    /// # Errors
    /// [`throng_base::Error::Gone`].
    pub fn wake(&mut self, id: Id) -> Result<()> {
        each!(&mut self.engine, e => e.wake(id))
    }

    /// Runs the engine in stretches, and reports the events of each after it: the engine does not depend on the
    /// caller's types, and need not be compiled anew for them.
    #[inline]
    fn advance_with(
        &mut self,
        on_event: &mut impl FnMut(&CrowdEvent),
        mut run: impl FnMut(&mut Self) -> Result<bool>,
    ) -> Result<()> {
        loop {
            let done = run(self);
            // A time that is refused leaves the events of before.
            if !matches!(done, Err(CrowdError::Other(_))) {
                self.events().iter().for_each(&mut *on_event);
            }
            if done? {
                return Ok(());
            }
        }
    }

    /// Not inlined, so that it is compiled here and not with every caller.
    #[inline(never)]
    fn run(&mut self, until_s: f64) -> Result<bool> {
        each!(&mut self.engine, e => e.run(until_s))
    }

    /// Runs the engine in parallel parts, see [`Crowd::run`].
    #[inline(never)]
    fn run_parallel(&mut self, until_s: f64, run: &dyn Executor) -> Result<bool> {
        each!(&mut self.engine, e => e.run_parallel(until_s, run))
    }

    fn events(&self) -> &[CrowdEvent] {
        each!(&self.engine, e => &e.events)
    }

    /// Spawns an agent, now.
    ///
    /// # Errors
    /// [`CrowdError`] for a place that is taken, a full crowd, or a setting out of its range; nothing has changed then.
    pub fn spawn(&mut self, agent: Agent) -> Result<Id> {
        each!(&mut self.engine, e => e.spawn(agent.map(Space::from_world)))
    }

    /// Removes an agent, now.
    ///
    /// # Errors
    /// [`throng_base::Error::Gone`].
    pub fn despawn(&mut self, id: Id) -> Result<()> {
        each!(&mut self.engine, e => e.despawn(id))
    }

    /// Moves an agent elsewhere, at rest. It goes on with its order from there, or stays without one.
    ///
    /// # Errors
    /// [`CrowdError`] for a place that is taken or out of range, or from which no path leads to its goal; nothing has
    /// changed then.
    pub fn place(&mut self, id: Id, position: Vec3) -> Result<()> {
        each!(&mut self.engine, e => e.place(id, Space::from_world(position)))
    }

    /// Gives an agent an order, from its next event on; it holds until the next order. Along a route of the crowd, it
    /// takes no memory; to a goal, none after the first such order of the agent; through subgoals, it always does.
    /// Where the crowd knows its streets, a goal of any agent's present or recent order costs no search.
    ///
    /// # Errors
    /// [`throng_base::Error::NoPath`] where no path leads to the goal, and [`CrowdError`] for a goal in an obstacle or a
    /// setting out of its range; nothing has changed then.
    pub fn order(&mut self, id: Id, order: AgentOrder) -> Result<()> {
        each!(&mut self.engine, e => e.order(id, &order.map(Space::from_world)))
    }

    /// Progress of an agent with its order.
    ///
    /// # Errors
    /// [`throng_base::Error::Gone`].
    pub fn status(&self, id: Id) -> Result<AgentStatus> {
        each!(&self.engine, e => e.status(id).ok_or(throng_base::Error::Gone(id).into()))
    }

    /// Another route for agents to come and for [`AgentOrder::on_route`]; its number.
    ///
    /// # Errors
    /// [`CrowdError`] for a route that cannot be.
    pub fn add_route(&mut self, route: Route) -> Result<usize> {
        each!(&mut self.engine, e => e.add_route(route.map(Space::from_world)))
    }

    /// Appends the whole state: about 170 bytes an agent on the ground and 200 in the air, and 20 or 28 bytes a square
    /// of the density grid.
    pub fn save(&self, out: &mut Vec<u8>) {
        each!(&self.engine, e => e.save(out))
    }

    /// Restores a state of a crowd that was made with the same setup. It continues from there as it did then, bit by
    /// bit.
    ///
    /// # Errors
    /// [`throng_base::Error::Snapshot`]; nothing has changed then.
    pub fn load(&mut self, bytes: &[u8]) -> Result<()> {
        each!(&mut self.engine, e => e.load(bytes))
    }

    /// A hash of the state (64 bits): equal for equal motion of all.
    pub fn hash(&self) -> u64 {
        each!(&self.engine, e => e.hash())
    }

    /// The present (s).
    pub fn time_s(&self) -> f64 {
        each!(&self.engine, e => e.now)
    }

    /// Ids of all agents, in the order of their places.
    pub fn ids(&self) -> impl Iterator<Item = Id> + '_ {
        let (ground, air) = match &self.engine {
            SpaceEngine::Ground(e) => (Some(e.ids()), None),
            SpaceEngine::Air(e) => (None, Some(e.ids())),
        };
        ground.into_iter().flatten().chain(air.into_iter().flatten())
    }

    /// Most agents at a time.
    pub fn capacity(&self) -> usize {
        each!(&self.engine, e => e.states.len())
    }

    /// True where agents are discs on the ground.
    pub fn is_on_ground(&self) -> bool {
        matches!(self.engine, SpaceEngine::Ground(_))
    }

    /// Number of agents.
    pub fn num_agents(&self) -> usize {
        each!(&self.engine, e => e.num_agents())
    }

    /// Settings of an agent; position and velocity are those of now, the route that of its order.
    pub fn agent(&self, id: Id) -> Option<Agent> {
        each!(&self.engine, e => e.agent(id).map(|a| a.map(Space::to_world)))
    }

    /// Position of an agent at `time_s`: exact from its last event to its next one, and a guess before and after (m).
    pub fn position(&self, id: Id, time_s: f64) -> Option<Vec3> {
        each!(&self.engine, e => e.plan(id).map(|p| p.motion_at(time_s).0.to_world()))
    }

    /// Velocity at `time_s` (m/s).
    pub fn velocity(&self, id: Id, time_s: f64) -> Option<Vec3> {
        each!(&self.engine, e => e.plan(id).map(|p| p.motion_at(time_s).1.to_world()))
    }

    /// Velocity as a Kalman filter estimates it at its last event, without abrupt changes, for a body to follow (Kim,
    /// Kim and Shin 2003b, section 2.1) (m/s).
    pub fn smooth_velocity(&self, id: Id) -> Option<Vec3> {
        each!(&self.engine, e => e.smooth_velocity(id).map(Space::to_world))
    }

    /// Acceleration at `time_s` (m/s2).
    pub fn acceleration(&self, id: Id, time_s: f64) -> Option<Vec3> {
        each!(&self.engine, e => e.acceleration(id, time_s).map(Space::to_world))
    }

    /// Time-varying bound at `time_s`: centre and radius (Kim, Kim and Shin 2003b, eq. 3 and 4) (m, from its last event
    /// on).
    pub fn bound(&self, id: Id, time_s: f64) -> Option<(Vec3, f32)> {
        each!(&self.engine, e => e.bound(id, time_s).map(|(centre, radius)| (centre.to_world(), radius)))
    }

    /// Time of its next event, unless another agent makes it act before (s).
    pub fn next_event(&self, id: Id) -> Option<f64> {
        each!(&self.engine, e => e.plan(id).map(|p| e.due_time(&p)))
    }

    /// Time of its last event (s).
    pub fn last_event(&self, id: Id) -> Option<f64> {
        each!(&self.engine, e => e.plan(id).map(|p| p.start))
    }

    /// Both ends of the path of its centre if it brakes now with all its force (m).
    pub fn stop_region(&self, id: Id) -> Option<(Vec3, Vec3)> {
        each!(&self.engine, e => {
            let (from, to) = e.plan(id).map(|p| p.stop_region((e.now - p.start) as f32))?;
            Some((from.to_world(), to.to_world()))
        })
    }

    /// Sets the external obstacles: agents steer around their bodies, and keep out of the regions that they reserve. A
    /// crowd in the air ignores them.
    pub fn set_external_obstacles<'a>(&mut self, others: impl Iterator<Item = &'a ReservedRegion>) {
        if let SpaceEngine::Ground(engine) = &mut self.engine {
            engine.external_obstacles.replace_all(others);
        }
    }

    /// True where others than agents have reserved some of the ground of a capsule.
    pub fn is_reserved(&self, ground: &Capsule2d) -> bool {
        let SpaceEngine::Ground(engine) = &self.engine else { return false };
        let mut is_reserved = false;
        engine.external_obstacles.visit_reserved_near(&ground.bounds(), |other| {
            is_reserved = other.intersects(ground);
            !is_reserved
        });
        is_reserved
    }

    /// The body of an agent, and the ground that it holds: all that it takes until its plan ends, and for braking then.
    pub fn body_and_region(&self, id: Id) -> Option<(ExternalObstacle, Capsule2d)> {
        each!(&self.engine, e => {
            let plan = e.plan(id)?;
            let (position, velocity) = plan.motion_at(e.now);
            let end = plan.end.max(e.now);
            let now = MotionPlan { start: e.now, end, position, velocity, moving: (plan.moving - (e.now - plan.start) as f32).max(0.0), ..plan };
            let body = ExternalObstacle { place: position.on_ground(), velocity: velocity.on_ground(), radius_m: plan.radius };
            Some((body, PlanCandidate::new(now).reserved_region()))
        })
    }

    /// Remaining distance along its route (m).
    pub fn distance_left(&self, id: Id) -> Option<f32> {
        each!(&self.engine, e => e.distance_left(id))
    }

    /// True for an agent that waits before a closed door, or for its turn at a passage.
    pub fn waits(&self, id: Id) -> bool {
        each!(&self.engine, e => e.waits(id))
    }

    /// Number of the subgoal of its route to which it is on the way.
    pub fn route_leg(&self, id: Id) -> Option<u32> {
        each!(&self.engine, e => e.route_leg(id))
    }

    /// Unit vector in which it wants to go now; zero where it is at its goal.
    pub fn desired_direction(&self, id: Id) -> Option<Vec3> {
        each!(&self.engine, e => e.desired_direction(id).map(Space::to_world))
    }

    /// Forces on it now, term by term. Computed anew, and allocates: for inspection of single agents.
    pub fn forces(&self, id: Id) -> Option<Forces> {
        each!(&self.engine, e => e.forces(id).map(|f| f.map(Space::to_world)))
    }

    /// Memory that an agent takes: its state, its plan, what it senses, its places in queue and cells.
    pub fn bytes_per_agent(&self) -> usize {
        each!(&self.engine, e => e.bytes_per_agent())
    }

    /// Numbers of events.
    pub fn counts(&self) -> EventCounts {
        each!(&self.engine, e => e.counts)
    }

    /// Side of the cells that agents are registered in (m).
    pub fn cell_side(&self) -> f32 {
        each!(&self.engine, e => e.cells.side)
    }

    /// Action of agents at the end of a route.
    pub fn at_end(&self, route: usize) -> Option<AtEnd> {
        each!(&self.engine, e => e.scenery.paths.get(route).map(|path| path.route.at_end))
    }
}
