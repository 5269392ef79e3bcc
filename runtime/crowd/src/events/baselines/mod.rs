//! Engines to compare with: bounds listed in every cell (Kim, Kim and Shin 2003a), and fixed steps of time.
//!
//! They share cells, plans, decisions and counts with the engine, and would need most of it to be public if they stood
//! in a crate of their own: so they are a part of this one that only a feature turns on. The engine holds a [`Baseline`]
//! in place of its own scheme, and a baseline runs on the engine: the two need each other.

mod contacts;
mod crossing;
pub(crate) mod fixed;
pub(crate) mod occupancy;
pub(crate) mod occupancy_events;

use self::fixed::Fixed;
use self::occupancy::Occupancy;
use crate::error::{CrowdError, check};
use crate::events::engine::Engine;
use crate::safety::bound::narrowest_cell;
use crate::space::cells::Cells;
use crate::space::plan::Plan;
use crate::{Agent, CrowdConfig, Scheme, Space};
use serde::{Deserialize, Serialize};

/// What another scheme than [`Scheme::Registration`] remembers.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound = "V: Space")]
pub(crate) enum Baseline<V> {
    /// See [`Scheme::Occupancy`].
    Occupancy(Occupancy),
    /// See [`Scheme::Fixed`].
    Fixed(Fixed<V>),
}

impl<V: Space> Baseline<V> {
    /// Nothing yet; none for the engine's own scheme.
    pub fn new(config: &CrowdConfig, cells: &Cells<V>, capacity: usize) -> Option<Self> {
        match config.scheme {
            Scheme::Registration => None,
            Scheme::Occupancy => Some(Self::Occupancy(Occupancy::new(cells.num_cells(), capacity))),
            Scheme::Fixed | Scheme::Pairs => Some(Self::Fixed(Fixed::new(config.step_s, config.halvings, capacity))),
        }
    }

    /// True if what was read is of the same scheme as another one, as large, and right for the plans of its agents.
    pub fn fits<'a>(&self, other: &Self, side: f32, now: f64, plan: impl Fn(u32) -> Option<&'a Plan<V>>) -> bool {
        match (self, other) {
            (Self::Occupancy(a), Self::Occupancy(b)) => a.fits(b, side, now, plan),
            (Self::Fixed(a), Self::Fixed(b)) => a.fits(b, now),
            _ => false,
        }
    }

    /// True for the scheme under which agents may overlap.
    pub fn lets_overlap(&self) -> bool {
        matches!(self, Self::Fixed(_))
    }

    /// Makes what is not read, and takes memory.
    pub fn reserve(&mut self, cells: &Cells<V>, capacity: usize) {
        match self {
            Self::Occupancy(occupancy) => occupancy.relink(cells),
            Self::Fixed(fixed) => fixed.reserve(capacity),
        }
    }
}

impl<V: Space> Engine<V> {
    /// Runs the baseline, if there is one.
    pub fn run_baseline(&mut self, until_s: f64) -> Option<Result<bool, CrowdError>> {
        // Taken out, so that it can be changed together with the rest.
        let mut baseline = self.baseline.take()?;
        let result = match &mut baseline {
            Baseline::Occupancy(occupancy) => self.run_occupancy(occupancy, until_s),
            Baseline::Fixed(fixed) => self.run_steps(fixed, until_s),
        };
        self.baseline = Some(baseline);
        Some(result)
    }

    /// A newcomer is within the limits of the scheme.
    pub fn check_baseline(&self, n: usize, agent: &Agent<V>) -> Result<(), CrowdError> {
        if !matches!(self.baseline, Some(Baseline::Occupancy(_))) {
            return Ok(());
        }
        let longest = self.scenery.steering.blocked_intervals * self.scenery.interval;
        let good = narrowest_cell(agent.radius, agent.acceleration, longest) <= self.cells.side();
        let expected = "small enough that a bound is not wider than a cell after the smallest interval";
        Ok(check("agent.acceleration", n, agent.acceleration, good, expected)?)
    }

    /// Lists an agent that entered.
    pub fn list(&mut self, plan: &Plan<V>) {
        if let Some(Baseline::Occupancy(occupancy)) = &mut self.baseline {
            occupancy.list(&self.cells, plan);
        }
    }

    /// Takes an agent that left out of the lists.
    pub fn unlist(&mut self, index: u32) {
        let mut baseline = self.baseline.take();
        if let Some(Baseline::Occupancy(occupancy)) = &mut baseline {
            self.forget(occupancy, index);
        }
        self.baseline = baseline;
    }
}
