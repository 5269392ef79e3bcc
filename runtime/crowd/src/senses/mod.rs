//! Sensed events of agents beside each other's bounds: meetings, zones, cells that they cross; and timers.
//!
//! All of them come in the engine's queue, at the time at which they happen. Between two of its own events, the motion
//! of an agent is known, so that these times are computed and not polled. Each agent has one entry: its first sensed
//! event during its plan. An agent with a new plan looks for it anew, among all agents whose swept boxes its own
//! touches; an entry about a plan that its partner no longer follows only leads to a new search.

pub(crate) mod crossing;

use crate::{Space, space::plan::MotionPlan};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use throng_base::{Result, error::check_value};
use throng_geometry::{Bounds2d, BoxGrid};

/// Zones, cells and distances that agents of a crowd may sense.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Senses<V = Vec3> {
    /// Two agents meet where their middles are so near; 0 for never (m, 0 to 1000).
    pub meet_m: f32,
    /// Places, by number.
    pub zones: Vec<Zone<V>>,
    /// Side of the square cells, over the ground, that agents cross; 0 for none (m, 0 or 0.1 to 1e5).
    pub cell_m: f32,
}

/// Disc or ball whose entries and exits agents sense, by their centres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Zone<V = Vec3> {
    /// Centre (m).
    pub centre: V,
    /// (m, 0.001 to 1e5)
    pub radius: f32,
}

/// Senses of one agent. Two agents meet where one sends on a channel that the other receives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sense {
    /// Channels on which it sends.
    pub sends: u32,
    /// Channels on which it hears.
    pub receives: u32,
    /// Channels on which only an approach counts. On the others, the agent meets those that are near at once when it gets these senses.
    pub once: u32,
    /// True where it senses zones.
    pub zones: bool,
    /// True where it senses cells.
    pub cells: bool,
    /// True where its arrivals, departures and being stuck are signals.
    pub arrivals: bool,
}

impl Sense {
    /// Channels on which one of two hears the other: on any, and on those where being near is enough once its own senses change.
    pub(crate) fn channels(&self, other: &Self) -> (u32, u32) {
        let (there, back) = (self.sends & other.receives, other.sends & self.receives);
        (there | back, (there | back) & !self.once)
    }
}

impl<V> Senses<V> {
    /// Converts it to another space.
    pub fn map<W>(self, f: impl Fn(V) -> W) -> Senses<W> {
        let zones = self.zones.into_iter().map(|z| Zone { centre: f(z.centre), radius: z.radius });
        Senses { meet_m: self.meet_m, zones: zones.collect(), cell_m: self.cell_m }
    }
}

impl<V: Space> Senses<V> {
    /// Every number within its limits.
    pub(crate) fn check(&self) -> Result<()> {
        let good = (0.0..=1000.0).contains(&self.meet_m);
        check_value("senses.meet_m", None, self.meet_m, good, "between 0 and 1000")?;
        let good = self.cell_m == 0.0 || (0.1..=1e5).contains(&self.cell_m);
        check_value("senses.cell_m", None, self.cell_m, good, "0, or between 0.1 and 100000")?;
        for zone in &self.zones {
            let good = (1e-3..=1e5).contains(&zone.radius) && zone.centre.is_finite();
            let expected = "between 0.001 and 100000, about a finite centre";
            check_value("senses.zones.radius", None, zone.radius, good, expected)?;
        }
        Ok(())
    }
}

/// Next sensed event of an agent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum SensedEvent {
    Met(u32),
    CameTo(u32),
    WentFrom(u32),
    /// Crossing of so many cells along each axis.
    Crossed {
        by: [i16; 2],
    },
}

/// State of an agent that senses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SensingState {
    pub sense: Sense,
    /// Next sensed event, if any, and its time (s).
    pub next: Option<(f64, SensedEvent)>,
    /// Start of the plan of the partner that it meets next (s).
    pub partner_start: f64,
    /// Time of the last change of its channels, and the number of changes in the crowd until then. The agent that
    /// changed later meets the other one.
    pub changed: (f64, u64),
    /// Last agent that it met for being near at that time: each once, in the order of their numbers.
    pub last: Option<u32>,
    /// Time of its timer (s).
    pub timer: f64,
}

impl Default for SensingState {
    fn default() -> Self {
        Self {
            sense: Sense::default(),
            next: None,
            partner_start: 0.0,
            changed: (-1.0, 0),
            last: None,
            timer: f64::INFINITY,
        }
    }
}

/// State of sensing in a crowd.
#[derive(Clone, Debug)]
pub(crate) struct Sensors<V> {
    pub senses: Senses<V>,
    /// State of each agent.
    pub states: Vec<SensingState>,
    /// Swept boxes of all agents that send or receive.
    pub boxes: BoxGrid,
    pub zones: BoxGrid,
    /// Number of changes of channels in the crowd.
    pub changes: u64,
    /// True where events at which the engine stops are noted.
    pub stops: bool,
    /// Signals that were noted, in their order.
    pub signals: std::collections::VecDeque<crate::CrowdEvent>,
}

impl<V: Space> Sensors<V> {
    pub fn new(senses: &Senses<V>, capacity: usize) -> Self {
        let mut zones = BoxGrid::with_capacity(senses.zones.len());
        for (number, zone) in senses.zones.iter().enumerate() {
            zones.set(number, Bounds2d::around_disc(zone.centre.on_ground(), zone.radius));
        }
        Self {
            senses: senses.clone(),
            states: vec![SensingState::default(); capacity],
            boxes: BoxGrid::with_capacity(capacity),
            zones,
            changes: 0,
            stops: false,
            signals: std::collections::VecDeque::with_capacity(3 * capacity.max(16)),
        }
    }

    /// States of agents that sense anything or have a timer, for snapshots.
    pub fn saved(&self) -> Vec<(u32, SensingState)> {
        (0..).zip(self.states.iter().copied()).filter(|(_, own)| *own != SensingState::default()).collect()
    }

    /// True for what a snapshot of this crowd may hold.
    pub fn is_possible(&self, saved: &[(u32, SensingState)], now: f64, is_there: impl Fn(u32) -> bool) -> bool {
        let num = self.states.len() as u32;
        let is_sensed = |what: SensedEvent| match what {
            SensedEvent::Met(other) => other < num && self.senses.meet_m > 0.0,
            SensedEvent::CameTo(zone) | SensedEvent::WentFrom(zone) => (zone as usize) < self.senses.zones.len(),
            SensedEvent::Crossed { .. } => self.senses.cell_m > 0.0,
        };
        let is_next = |(time, what): (f64, SensedEvent)| (now..=1e10).contains(&time) && is_sensed(what);
        saved.windows(2).all(|w| w[0].0 < w[1].0)
            && saved.iter().all(|(m, own)| {
                *m < num
                    && is_there(*m)
                    && own.timer >= now
                    && own.next.is_none_or(is_next)
                    && !own.partner_start.is_nan()
                    && own.changed.1 < 1 << 62
            })
    }

    /// True where any agent can sense anything.
    pub fn is_on(&self) -> bool {
        self.states.iter().any(|own| own.sense != Sense::default() || own.timer.is_finite())
    }

    /// The cell, over the ground, of a place.
    pub fn cell_at(&self, at: V) -> [i32; 2] {
        let at = at.on_ground() / self.senses.cell_m;
        [at.x.floor() as i32, at.y.floor() as i32]
    }
}

/// A box, over the ground, around all of a plan from a time on.
pub(crate) fn swept_bounds<V: Space>(plan: &MotionPlan<V>, from: f64) -> Bounds2d {
    let (first, last) = (plan.motion_at(from).0.on_ground(), plan.motion_at(plan.end).0.on_ground());
    let mut bounds = Bounds2d { min: first.min(last), max: first.max(last) };
    // Where a component of the velocity turns.
    let (velocity, acceleration) = (plan.velocity.on_ground(), plan.acceleration.on_ground());
    for axis in 0..2 {
        let turn = -velocity[axis] / acceleration[axis];
        if turn > (from - plan.start) as f32 && turn < ((plan.end - plan.start) as f32).min(plan.moving) {
            let at = plan.motion_after(turn).0.on_ground();
            bounds = bounds.union(Bounds2d { min: at, max: at });
        }
    }
    // More than rounding.
    bounds.expanded_by(1e-3)
}
