//! Settings and setup of a crowd.

use crate::{Agent, ForceField, Interest, Obstacle, Route, Senses, SteeringConfig, routes::streets::Streets};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use throng_base::{Result, error::check_value, limits::CAPACITY};

/// Scheme by which the crowd schedules its agents' events.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Scheme {
    /// Bounds are registered in the cell of their centre (Kim, Kim and Shin 2003b, section 2.1): resetting and colliding
    /// events.
    #[default]
    Registration,
    /// Bounds are listed in every cell they occupy (Kim, Kim and Shin 2003a, section 2): entering,
    /// leaving, resetting, colliding, contacting and separating events. No collision is looked for within a group of
    /// agents in contact. The guarantee is the same.
    Occupancy,
    /// For comparison: all agents act at every step of time, and where discs overlap the step is undone and half of it
    /// tried (Kim, Kim and Shin 2003b, section 4). Nothing but the forces keeps agents apart.
    #[cfg(feature = "fixed-steps")]
    Fixed,
    /// For comparison: [`Scheme::Fixed`] in which every agent checks every other one (Kim, Kim and Shin 2003a, section 5).
    #[cfg(feature = "fixed-steps")]
    Pairs,
}

impl Scheme {
    /// Most events of one agent in a smallest interval: those that make it act, in `Occupancy` two of them, after each of
    /// which its bound enters and leaves the cells behind every face of a box and meets an agent or not.
    pub(crate) fn most_events(self) -> u32 {
        if matches!(self, Self::Occupancy) { 2 * (1 + 2 * 6 + 2) } else { 1 }
    }
}

/// Step of `Scheme::Fixed` (s), and how often it is halved, unless a setup says otherwise.
const STEPS: (f32, u32) = (1.0 / 30.0, 4);

/// Settings of a crowd.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CrowdConfig {
    /// Scheme by which events are scheduled.
    pub scheme: Scheme,
    /// Smallest time between two events of one agent, and so of a pair (s, 0.001 to 1).
    pub smallest_interval_s: f32,
    /// Side of the cells that agents are registered in; 0 leaves it to the crowd. An agent sees those in its own and the
    /// neighbouring cells (m, enough for every agent to stop within half of it, see [`crate::Crowd::cell_side`]).
    pub cell_side_m: f32,
    /// Step of `Scheme::Fixed` (s, 0.001 to 1).
    #[cfg(feature = "fixed-steps")]
    pub step_s: f32,
    /// Number of times that a step of `Scheme::Fixed` is halved. At the end of the shortest step, agents that overlap lose the
    /// velocity toward each other; overlaps that remain are counted (0 to 16).
    #[cfg(feature = "fixed-steps")]
    pub halvings: u32,
    /// Most agents at a time; memory for them is taken at once. 0 stands for those at the start (0 to 1000000).
    pub capacity: usize,
    /// Largest radius of agents to come; 0 stands for those at the start (m).
    pub largest_radius_m: f32,
    /// Largest desired speed of agents to come and of [`crate::Crowd::order`]; 0 stands for those at the start (m/s).
    pub largest_speed_mps: f32,
    /// Least of the largest accelerations of agents to come; 0 stands for those at the start (m/s2).
    pub least_acceleration_mps2: f32,
    /// The numbers of steering that were tuned by trial.
    pub steering: SteeringConfig,
}

impl CrowdConfig {
    /// Settings on which a state depends: the same whether or not the build has engines to compare with, unless one of
    /// them runs.
    pub(crate) fn state_key(&self) -> impl Serialize + use<> {
        #[cfg(feature = "fixed-steps")]
        let steps = (self.step_s, self.halvings);
        #[cfg(not(feature = "fixed-steps"))]
        let steps = STEPS;
        let fixed = (self.scheme != Scheme::Registration).then_some(steps);
        let largest = (self.capacity, self.largest_radius_m, self.largest_speed_mps);
        (self.scheme, self.smallest_interval_s, self.cell_side_m, fixed, largest, self.steering)
    }

    /// Every setting within its limits.
    pub(crate) fn check(&self) -> Result<()> {
        let within = |what, got: f32, least: f32, most: f32, expected| {
            check_value(what, None, got, (least..=most).contains(&got), expected)
        };
        within("config.smallest_interval_s", self.smallest_interval_s, 0.001, 1.0, "between 0.001 and 1")?;
        #[cfg(feature = "fixed-steps")]
        within("config.step_s", self.step_s, 0.001, 1.0, "between 0.001 and 1")?;
        #[cfg(feature = "fixed-steps")]
        within("config.halvings", self.halvings as f32, 0.0, 16.0, "at most 16")?;
        CAPACITY.check_count("config.capacity", self.capacity)?;
        within("config.largest_radius_m", self.largest_radius_m, 0.0, 999.0, "between 0 and 999")?;
        within("config.largest_speed_mps", self.largest_speed_mps, 0.0, 999.0, "between 0 and 999")?;
        within("config.least_acceleration_mps2", self.least_acceleration_mps2, 0.0, 1e4, "between 0 and 10000")?;
        self.steering.check()
    }
}

impl Default for CrowdConfig {
    fn default() -> Self {
        Self {
            scheme: Scheme::default(),
            smallest_interval_s: 0.1,
            cell_side_m: 0.0,
            #[cfg(feature = "fixed-steps")]
            step_s: STEPS.0,
            #[cfg(feature = "fixed-steps")]
            halvings: STEPS.1,
            capacity: 0,
            largest_radius_m: 0.0,
            largest_speed_mps: 0.0,
            least_acceleration_mps2: 0.0,
            steering: SteeringConfig::default(),
        }
    }
}

/// Setup of a crowd at time 0.
#[derive(Clone, Debug)]
pub struct CrowdSetup<V = Vec3> {
    /// Agents at the start.
    pub agents: Vec<Agent<V>>,
    /// Routes of agents that start or enter on one; those with an order have a route of their own.
    pub routes: Vec<Route<V>>,
    /// Force fields of agents (>= 1 where there are agents).
    pub fields: Vec<ForceField>,
    /// Obstacles.
    pub obstacles: Vec<Obstacle<V>>,
    /// Obstacles that are doors, by number: open at the start. See [`crate::Crowd::set_open`].
    pub doors: Vec<usize>,
    /// Interests that attract or repel agents.
    pub interests: Vec<Interest<V>>,
    /// Zones and cells that agents may sense.
    pub senses: Senses<V>,
    /// Finds the paths of orders round obstacles; without it, agents go straight to their goals.
    pub streets: Option<Streets>,
    /// Settings of the crowd.
    pub config: CrowdConfig,
}

impl<V: Default> Default for CrowdSetup<V> {
    /// No agents and no obstacles, with the default field.
    fn default() -> Self {
        Self {
            agents: Vec::new(),
            routes: Vec::new(),
            fields: vec![ForceField::default()],
            obstacles: Vec::new(),
            doors: Vec::new(),
            interests: Vec::new(),
            senses: Senses::default(),
            streets: None,
            config: CrowdConfig::default(),
        }
    }
}

impl CrowdSetup {
    /// An empty crowd of pedestrians between the obstacles of some streets: radii up to 0.3 m, speeds up to 2 m/s.
    ///
    /// - `capacity`: most agents at a time.
    pub fn in_streets(streets: &Streets, capacity: usize) -> Self {
        Self {
            obstacles: streets.obstacles().to_vec(),
            streets: Some(streets.clone()),
            config: CrowdConfig { capacity, largest_radius_m: 0.3, largest_speed_mps: 2.0, ..CrowdConfig::default() },
            ..Self::default()
        }
    }
}

impl<V> CrowdSetup<V> {
    /// Converts it to another space.
    pub fn map<W>(self, f: impl Fn(V) -> W) -> CrowdSetup<W> {
        CrowdSetup {
            agents: self.agents.into_iter().map(|a| a.map(&f)).collect(),
            routes: self.routes.into_iter().map(|r| r.map(&f)).collect(),
            fields: self.fields,
            obstacles: self.obstacles.into_iter().map(|o| o.map(&f)).collect(),
            doors: self.doors,
            interests: self.interests.into_iter().map(|i| i.map(&f)).collect(),
            senses: self.senses.map(&f),
            streets: self.streets,
            config: self.config,
        }
    }
}
