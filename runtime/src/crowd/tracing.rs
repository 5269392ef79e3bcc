//! How a crowd finds out who has to act next: the scheme of 001, and what it shares with that of 000.

use super::bound::Bound;
use super::cells::Cells;
use super::decide::{Cause, Decider, Scratch};
use super::fixed::Fixed;
use super::occupancy::{Occupancy, narrowest};
use super::plan::Plan;
use super::{CrowdConfig, CrowdError, Member, Scheme, Space};
use serde::{Deserialize, Serialize};

/// A scheme of events, known when the code is compiled.
pub(crate) trait Tracing<V: Space> {
    /// When the bound of a new plan touches something first, and what.
    fn first_event(
        &self,
        at: &Decider<'_, V>,
        fresh: &Plan<V>,
        region: (V, V),
        near: &[u32],
        scratch: &Scratch<V>,
    ) -> (Cause, f32);
}

/// The scheme of 001 section 2.1: a bound stays in the region around the cell it is registered in, so that it can
/// only meet those who are registered in cells next to that.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Registration;

impl<V: Space> Tracing<V> for Registration {
    #[inline]
    fn first_event(
        &self,
        at: &Decider<'_, V>,
        fresh: &Plan<V>,
        region: (V, V),
        near: &[u32],
        scratch: &Scratch<V>,
    ) -> (Cause, f32) {
        let bound = Bound::from(fresh);
        let mut first = (Cause::Region, bound.first_exit(region.0, region.1));
        for &(address, velocity, distance) in &scratch.around {
            let other = at.cells.at(address);
            // Growth of both bounds from now on is the least that closes the gap.
            let age = (at.time - other.start) as f32;
            let gap = distance - fresh.radius - other.radius;
            let t = first.1;
            let speeds = (velocity - fresh.velocity).length() + 2.0 * other.limit * age;
            let grown = 0.5 * (fresh.limit * t * t + other.limit * (age + t) * (age + t));
            if gap > speeds * t + grown {
                continue;
            }
            let contact = bound.first_contact(&at.bound(other), at.time, t);
            if contact < t {
                first = (Cause::Member(other.index), contact);
            }
        }
        at.first_obstacle(&bound, near, first)
    }
}

/// What a scheme remembers.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(bound = "V: Space")]
pub(crate) enum Trace<V> {
    /// See [`super::Scheme::Registration`].
    #[default]
    Registration,
    /// See [`super::Scheme::Occupancy`].
    Occupancy(Occupancy),
    /// See [`super::Scheme::Fixed`].
    Fixed(Fixed<V>),
}

impl<V: Space> Trace<V> {
    /// Nothing yet.
    pub fn new(config: &CrowdConfig, cells: &Cells<V>, capacity: usize) -> Self {
        match config.scheme {
            Scheme::Registration => Self::Registration,
            Scheme::Occupancy => Self::Occupancy(Occupancy::new(cells.num_cells(), capacity)),
            Scheme::Fixed => Self::Fixed(Fixed::new(config.step_s, config.halvings, capacity)),
        }
    }

    /// One who comes is within the limits of the scheme.
    ///
    /// # Errors
    /// [`CrowdError::Value`].
    pub fn check(&self, index: usize, m: &Member<V>, side: f32, interval: f32) -> Result<(), CrowdError> {
        if matches!(self, Self::Occupancy(_)) && narrowest(m.radius, m.acceleration, interval) > side {
            let expected = "small enough that a bound is not wider than a cell after the smallest interval";
            return Err(CrowdError::Value {
                what: "member",
                index,
                field: "acceleration",
                got: m.acceleration,
                expected,
            });
        }
        Ok(())
    }

    /// True where what was read is of the same scheme as another one, as large, and right for the plans of its members.
    pub fn fits<'a>(&self, other: &Self, side: f32, now: f64, plan: impl Fn(u32) -> Option<&'a Plan<V>>) -> bool {
        match (self, other) {
            (Self::Registration, Self::Registration) => true,
            (Self::Occupancy(a), Self::Occupancy(b)) => a.fits(b, side, now, plan),
            (Self::Fixed(a), Self::Fixed(b)) => a.fits(b, now),
            _ => false,
        }
    }

    /// What is not read, but made of the rest; and memory.
    pub fn reserve(&mut self, cells: &Cells<V>, capacity: usize) {
        match self {
            Self::Registration => (),
            Self::Occupancy(occupancy) => occupancy.relink(cells),
            Self::Fixed(fixed) => fixed.reserve(capacity),
        }
    }
}
