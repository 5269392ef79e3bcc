//! The engine behind a run, in two or three dimensions.

use super::bodies::{Follow, OnGround};
use super::moment::{Cast, CrowdMoment, Details, Figures, SeenAgent};
use crate::bundle::OpenBundle;
use glam::{Vec2, Vec3};
use std::sync::Arc;
use throng_precompute::BuildError;
use throng_precompute::scene::crowd::{
    CrowdScene, Engine, GroupConfig, Live, OverlapMeter, ProgressMeter, Sight, in_world, seen_obstacle,
};
use throng_runtime::crowd::{AtEnd, Event, Space};

/// A crowd that lives, with everything in world space.
pub(super) trait Sim: Send {
    /// Lets time pass; tells all that happens in its order.
    fn advance(&mut self, until_s: f64, tell: &mut dyn FnMut(&Event)) -> Result<(), BuildError>;
    /// The present (s).
    fn now(&self) -> f64;
    /// All agents now; `measures` looks for overlaps and progress, too. Bodies move on by `dt_s`, the time since this was
    /// called last.
    fn see(&mut self, watched: Option<usize>, measures: bool, dt_s: f32) -> Result<CrowdMoment, BuildError>;
    /// More of an agent; none if it has left.
    fn details(&self, agent: usize) -> Option<Details>;
    /// Where an agent was at a time near the present (m).
    fn place(&self, agent: usize, time_s: f64) -> Option<Vec3>;
    /// Corners of an agent's way (m).
    fn way(&self, agent: usize) -> Vec<Vec3>;
    /// What does not change.
    fn cast(&self, scene: &CrowdScene) -> Cast;
    fn snapshot(&self) -> Vec<u8>;
    fn state_hash(&self) -> u64;
}

/// A crowd in a space, and what is measured of it.
pub(super) struct In<V> {
    live: Live<V>,
    overlaps: OverlapMeter,
    progress: ProgressMeter<V>,
    places: Vec<(V, f32)>,
    figures: Figures,
    bodies: Option<Box<dyn Follow<V>>>,
}

impl<V: Space> In<V> {
    /// All agents at their starts, or in a saved state.
    pub fn new(scene: &CrowdScene, kept: Option<&[u8]>) -> Result<Self, BuildError> {
        let mut live = Live::new(scene)?;
        if let Some(bytes) = kept {
            live.restore(bytes)?;
        }
        let (overlaps, progress, figures) = Default::default();
        Ok(Self { live, overlaps, progress, places: Vec::new(), figures, bodies: None })
    }

    fn all(&self) -> std::ops::Range<usize> {
        0..self.live.num_agents()
    }

    fn seen(&self, m: usize, time_s: f64) -> Option<SeenAgent> {
        let (id, crowd) = (self.live.id(m), self.live.crowd());
        let (bound, bound_radius) = crowd.bound(id, time_s)?;
        Some(SeenAgent {
            at: crowd.position(id, time_s)?,
            velocity: crowd.velocity(id, time_s)?,
            bound,
            bound_radius,
            knows: self.live.knows(m) > 0,
        })
    }

    fn measure(&mut self, time_s: f64) {
        let (live, before) = (&self.live, self.overlaps.over_1mm);
        let layout = live.layout();
        let all = 0..live.num_agents();
        self.places.clear();
        let place = |m: usize| Some((live.position(m, time_s)?, layout.setup.agents[m].radius));
        self.places.extend(all.clone().filter_map(place));
        self.overlaps.observe(&self.places);
        let sight = |m: usize| Sight {
            at: live.position(m, time_s),
            way: &layout.ways[m],
            way_number: live.times_sent(m),
            arrival_m: layout.arrivals[m],
            again: live.times_sent(m) == 0 && layout.at_end(m) == Some(AtEnd::Again),
        };
        self.progress.observe(time_s, all.map(sight));
        self.figures = Figures {
            present: self.places.len(),
            overlaps: self.overlaps.over_1mm - before,
            deepest_m: self.overlaps.max_m,
            progress_mps: self.progress.progress_mps(),
            arrived: self.progress.arrived(),
            stuck: self.progress.stuck(),
        };
    }
}

impl In<Vec2> {
    /// Gives agents the bodies that the scene names, from a bundle.
    pub fn with_bodies(mut self, scene: &CrowdScene, bundle: Option<Arc<OpenBundle>>) -> Result<Self, BuildError> {
        if let (Some(config), Some(bundle)) = (&scene.bodies, bundle) {
            self.bodies = Some(Box::new(OnGround::new(scene, config, &bundle, &self.live)?));
        }
        Ok(self)
    }
}

impl<V: Space> Sim for In<V> {
    fn advance(&mut self, until_s: f64, tell: &mut dyn FnMut(&Event)) -> Result<(), BuildError> {
        self.live.advance_telling(until_s, &mut |e: &Event| tell(e))
    }

    fn now(&self) -> f64 {
        self.live.crowd().now()
    }

    fn see(&mut self, watched: Option<usize>, measures: bool, dt_s: f32) -> Result<CrowdMoment, BuildError> {
        let time_s = self.now();
        if measures {
            self.measure(time_s);
        }
        if let Some(bodies) = &mut self.bodies {
            bodies.step(&self.live, time_s, dt_s)?;
        }
        Ok(CrowdMoment {
            time_s,
            agents: self.all().map(|m| self.seen(m, time_s)).collect(),
            figures: self.figures,
            details: watched.and_then(|m| self.details(m)),
            bodies: self.bodies.as_ref().map(|b| b.see(&self.live, time_s)),
        })
    }

    fn details(&self, m: usize) -> Option<Details> {
        let (id, crowd) = (self.live.id(m), self.live.crowd());
        let (agent, f) = (crowd.agent(id)?, crowd.forces(id)?);
        let events = [crowd.last_event(id)?, crowd.next_event(id)?];
        let (from, to) = crowd.stop_region(id)?;
        // It was registered where it was at its last event.
        let (side, then) = (crowd.cell_side(), crowd.position(id, events[0])?);
        let corner = (then / side).floor() * side;
        Some(Details {
            agent: m,
            forces: [f.driving, f.interaction, f.decelerating, f.damping, f.turning, f.safety],
            taken: f.taken,
            limit: agent.acceleration,
            speed: agent.speed,
            desired: crowd.desired_direction(id)?,
            way_left: crowd.way_left(id)?,
            events,
            stop: [from, to],
            cell: corner,
            cell_side: side,
        })
    }

    fn place(&self, agent: usize, time_s: f64) -> Option<Vec3> {
        self.live.position(agent, time_s).map(in_world)
    }

    fn way(&self, agent: usize) -> Vec<Vec3> {
        self.live.layout().ways[agent].iter().map(|&p| in_world(p)).collect()
    }

    fn cast(&self, scene: &CrowdScene) -> Cast {
        let layout = self.live.layout();
        let name = |(g, c): (usize, &GroupConfig)| match c.name.as_str() {
            "" => format!("group {g}"),
            name => name.to_owned(),
        };
        let ends = layout.ways.iter().flat_map(|w| [w[0], w[w.len() - 1]]).map(in_world);
        let wide = |[l, h]: [Vec3; 2], p: Vec3| [l.min(p), h.max(p)];
        let extents = ends.fold([Vec3::INFINITY, Vec3::NEG_INFINITY], wide);
        Cast {
            in_the_air: V::DIMENSIONS == 3,
            names: scene.groups.iter().enumerate().map(name).collect(),
            groups: layout.groups.clone(),
            radii: layout.setup.agents.iter().map(|m| m.radius).collect(),
            skeletons: self.bodies.as_ref().map_or(Vec::new(), |b| b.skeletons()),
            speeds: layout.setup.agents.iter().map(|m| m.speed).collect(),
            obstacles: layout.setup.obstacles.iter().filter_map(seen_obstacle).collect(),
            extents,
            has_regions: scene.engine == Engine::Events,
        }
    }

    fn snapshot(&self) -> Vec<u8> {
        self.live.snapshot()
    }

    fn state_hash(&self) -> u64 {
        self.live.crowd().hash()
    }
}
