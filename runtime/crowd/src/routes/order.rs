//! What an agent is told to do, and how far it has come.

use crate::AtEnd;
use glam::Vec3;
use throng_base::Id;

/// An order to go somewhere. It holds until the next one.
#[derive(Clone, Debug, PartialEq)]
pub struct Go<V = Vec3> {
    pub(crate) way: Way<V>,
    pub(crate) at_end: AtEnd,
    pub(crate) arrival_m: f32,
    pub(crate) speed_mps: Option<f32>,
}

/// Where an order leads.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Way<V> {
    /// To a goal, round obstacles where the crowd knows its streets.
    To(V),
    /// Through subgoals.
    Along(Vec<V>),
    /// Along a route of the crowd.
    Route(usize),
}

impl<V> Go<V> {
    fn new(way: Way<V>) -> Self {
        Self { way, at_end: AtEnd::Stay, arrival_m: 0.5, speed_mps: None }
    }

    /// To a goal (m): round obstacles where the crowd knows its streets, otherwise straight.
    pub fn to(goal: V) -> Self {
        Self::new(Way::To(goal))
    }

    /// Through subgoals, in order, as they are (m, >= 1).
    pub fn along(subgoals: Vec<V>) -> Self {
        Self::new(Way::Along(subgoals))
    }

    /// Along a route of [`crate::Setup::routes`] or [`crate::Crowd::add_route`], which says what is done at its end.
    pub fn on_route(number: usize) -> Self {
        Self::new(Way::Route(number))
    }

    /// What is done at the end; [`AtEnd::Stay`] unless told otherwise.
    pub fn then(mut self, at_end: AtEnd) -> Self {
        self.at_end = at_end;
        self
    }

    /// How near to the goal counts as being there (m, > 0); 0.5 m unless told otherwise.
    pub fn within(mut self, arrival_m: f32) -> Self {
        self.arrival_m = arrival_m;
        self
    }

    /// Desired speed from now on (m/s, >= 0); the one it has unless told otherwise.
    pub fn at_speed(mut self, speed_mps: f32) -> Self {
        self.speed_mps = Some(speed_mps);
        self
    }

    /// The same in another space.
    pub(crate) fn map<W>(self, f: impl Fn(V) -> W) -> Go<W> {
        let Self { way, at_end, arrival_m, speed_mps } = self;
        let way = match way {
            Way::To(goal) => Way::To(f(goal)),
            Way::Along(subgoals) => Way::Along(subgoals.into_iter().map(f).collect()),
            Way::Route(number) => Way::Route(number),
        };
        Go { way, at_end, arrival_m, speed_mps }
    }
}

/// How far an agent has come. It never says that there is no way: [`crate::Crowd::order`] refuses such an order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Status {
    /// On its way.
    Going {
        /// Way that is left along its route (m).
        left_m: f32,
    },
    /// At the end of its route, or at its place without an order.
    There,
    /// It has made no progress for some time, see [`crate::SteeringConfig::stuck_after_s`].
    Blocked {
        /// The nearest agent in front of it, if there is one within its sight.
        by: Option<Id>,
    },
}
