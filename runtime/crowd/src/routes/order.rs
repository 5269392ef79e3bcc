//! Orders of agents, and their progress.

use crate::AtEnd;
use glam::Vec3;
use throng_base::Id;

/// An order to go somewhere. It holds until the next one.
#[derive(Clone, Debug, PartialEq)]
pub struct AgentOrder<V = Vec3> {
    pub(crate) destination: OrderDestination<V>,
    pub(crate) at_end: AtEnd,
    pub(crate) arrival_m: f32,
    pub(crate) speed_mps: Option<f32>,
    pub(crate) begin: RouteBegin,
}

/// Leg on which an agent begins a route that leads round; others begin at the first one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RouteBegin {
    /// Leg to the subgoal of this number.
    Leg(u32),
    /// Leg that is nearest to the agent.
    Nearest,
}

/// Destination of an order.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum OrderDestination<V> {
    /// A goal, reached round obstacles where the crowd knows its streets.
    ToGoal(V),
    /// Through subgoals.
    AlongSubgoals(Vec<V>),
    /// Along a route of the crowd.
    Route(usize),
}

impl<V> AgentOrder<V> {
    fn new(destination: OrderDestination<V>) -> Self {
        Self { destination, at_end: AtEnd::Stay, arrival_m: 0.5, speed_mps: None, begin: RouteBegin::Leg(0) }
    }

    /// Order to go to a goal (m): round obstacles where the crowd knows its streets, otherwise straight.
    pub fn to_goal(goal: V) -> Self {
        Self::new(OrderDestination::ToGoal(goal))
    }

    /// Through subgoals, in order, as they are (m, >= 1).
    pub fn along_subgoals(subgoals: Vec<V>) -> Self {
        Self::new(OrderDestination::AlongSubgoals(subgoals))
    }

    /// Along a route of [`crate::CrowdSetup::routes`] or [`crate::Crowd::add_route`], which says what is done at its end; one that leads
    /// round is begun at the nearest leg.
    pub fn on_route(number: usize) -> Self {
        Self::new(OrderDestination::Route(number)).beginning_at(RouteBegin::Nearest)
    }

    /// Sets the action at the end; by default [`AtEnd::Stay`].
    pub fn then_at_end(mut self, at_end: AtEnd) -> Self {
        self.at_end = at_end;
        self
    }

    /// Sets the distance from the goal within which the agent has arrived (m, > 0); by default 0.5 m.
    pub fn with_arrival(mut self, arrival_m: f32) -> Self {
        self.arrival_m = arrival_m;
        self
    }

    /// Sets the desired speed from now on (m/s, >= 0); by default it does not change.
    pub fn at_speed(mut self, speed_mps: f32) -> Self {
        self.speed_mps = Some(speed_mps);
        self
    }

    /// Sets the leg at which a route begins; by default the first one.
    pub fn beginning_at(mut self, begin: RouteBegin) -> Self {
        self.begin = begin;
        self
    }

    /// Converts it to another space.
    pub(crate) fn map<W>(self, f: impl Fn(V) -> W) -> AgentOrder<W> {
        let Self { destination, at_end, arrival_m, speed_mps, begin } = self;
        let destination = match destination {
            OrderDestination::ToGoal(goal) => OrderDestination::ToGoal(f(goal)),
            OrderDestination::AlongSubgoals(subgoals) => {
                OrderDestination::AlongSubgoals(subgoals.into_iter().map(f).collect())
            }
            OrderDestination::Route(number) => OrderDestination::Route(number),
        };
        AgentOrder { destination, at_end, arrival_m, speed_mps, begin }
    }
}

/// Progress of an agent. There is no status for an unreachable goal: [`crate::Crowd::order`] refuses such an order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AgentStatus {
    /// Moving towards the goal.
    Going {
        /// Remaining distance along its route (m).
        left_m: f32,
    },
    /// At the end of its route, or at its place without an order.
    Arrived,
    /// No progress for some time, see [`crate::SteeringConfig::stuck_after_s`].
    Blocked {
        /// The nearest agent in front of it, if there is one within its sight.
        by: Option<Id>,
    },
}
