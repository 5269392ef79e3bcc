//! Engines of either space driven as a crowd is, and what tests set up.

use crate::events::engine::Engine;
use crate::*;
use throng_base::Executor;

/// The interface of [`Crowd`] on an engine of either space.
pub(crate) trait Drive<V> {
    fn advance(&mut self, until_s: f64, on_event: &mut dyn FnMut(&CrowdEvent)) -> Result<(), CrowdError>;
    fn par_advance(&mut self, until_s: f64, on_event: &mut dyn FnMut(&CrowdEvent)) -> Result<(), CrowdError>;
    fn position(&self, id: Id, time_s: f64) -> Option<V>;
    fn velocity(&self, id: Id, time_s: f64) -> Option<V>;
    fn next_event(&self, id: Id) -> Option<f64>;
    fn last_event(&self, id: Id) -> Option<f64>;
    fn bytes(&self) -> Vec<u8>;
}

/// Runs parts on so many threads, the last ones first.
pub(crate) struct Threads(pub usize);

impl Executor for Threads {
    fn run(&self, num_parts: usize, part: &(dyn Fn(usize) + Sync)) {
        std::thread::scope(|scope| {
            for first in 0..self.0 {
                scope.spawn(move || (first..num_parts).step_by(self.0).rev().for_each(part));
            }
        });
    }
}

impl<V: Space> Drive<V> for Engine<V> {
    fn advance(&mut self, until_s: f64, on_event: &mut dyn FnMut(&CrowdEvent)) -> Result<(), CrowdError> {
        drive(self, on_event, |e| e.run(until_s))
    }

    fn par_advance(&mut self, until_s: f64, on_event: &mut dyn FnMut(&CrowdEvent)) -> Result<(), CrowdError> {
        drive(self, on_event, |e| e.run_parallel(until_s, &Threads(3)))
    }

    fn position(&self, id: Id, time_s: f64) -> Option<V> {
        self.plan(id).map(|p| p.motion_at(time_s).0)
    }

    fn velocity(&self, id: Id, time_s: f64) -> Option<V> {
        self.plan(id).map(|p| p.motion_at(time_s).1)
    }

    fn next_event(&self, id: Id) -> Option<f64> {
        self.plan(id).map(|p| self.due_time(&p))
    }

    fn last_event(&self, id: Id) -> Option<f64> {
        self.plan(id).map(|p| p.start)
    }

    fn bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.save(&mut bytes);
        bytes
    }
}

/// Advances time, see [`Crowd::advance`].
pub(super) fn drive<V: Space>(
    engine: &mut Engine<V>,
    on_event: &mut dyn FnMut(&CrowdEvent),
    run: impl Fn(&mut Engine<V>) -> Result<bool, CrowdError>,
) -> Result<(), CrowdError> {
    loop {
        let done = run(engine);
        engine.events.iter().for_each(&mut *on_event);
        if done? {
            return Ok(());
        }
    }
}

/// A small seeded generator of shares.
pub(crate) struct Shares(pub(crate) u64);

impl Shares {
    pub(crate) fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }
}

/// An order to go along a route.
pub(super) fn along<V: Space>(route: Route<V>, speed: f32) -> AgentOrder<V> {
    AgentOrder::along_subgoals(route.subgoals)
        .with_arrival(route.arrival_radius)
        .then_at_end(route.at_end)
        .at_speed(speed)
}

pub(super) fn to<V: Space>(goal: V) -> Route<V> {
    Route { subgoals: vec![goal], arrival_radius: 0.5, at_end: AtEnd::Stay }
}

/// Agents on a jittered lattice that want to go to the other side of it.
pub(crate) fn crossing<V: Space>(num: usize, spacing: f32) -> CrowdSetup<V> {
    let mut shares = Shares(3);
    let across = (num as f32).powf(1.0 / V::DIMENSIONS as f32).ceil() as usize;
    let mut setup = CrowdSetup::default();
    for i in 0..num {
        let at = [i % across, i / across % across, i / across / across];
        let c = at.map(|c| (c as f32 - 0.5 * across as f32 + 0.3 * shares.next()) * spacing);
        let position = V::from_coordinates(c);
        setup.routes.push(to(-position));
        setup.agents.push(Agent { position, route: Some(i), radius: 0.25 + 0.05 * shares.next(), ..Agent::default() });
    }
    setup
}
