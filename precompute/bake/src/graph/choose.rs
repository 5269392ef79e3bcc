//! Choice of transitions that become actions: near ones, with different outcomes, and enough of them.

use super::connect::{EventLinks, GraphInputs};
use super::{config::MotionGraphConfig, matches::TransitionLink};
use crate::share::{gather_rows, own_numbers};
use rayon::prelude::*;
use throng_base::Comm;
use throng_core::{Planar, planar::wrap_angle};
use throng_motion::error::Result;

/// Turn within the horizon beyond which an outcome is a turn to a side (rad).
const TURN: f32 = 0.35;
/// Travel within the horizon below which an outcome is staying (m).
const STAY: f32 = 0.25;
/// Action slots of each state reserved for the component.
pub(super) const RESERVED: usize = 4;

/// Outcome of the motion after an event.
#[derive(Clone, Copy, Debug)]
pub(super) struct MotionOutcome {
    /// Place after the horizon, in the event's frame.
    pub place: Planar,
    pub kind: OutcomeKind,
}

/// Kind of an outcome: side of the turn, and direction of travel as one of five.
pub(super) type OutcomeKind = (i8, u8);

impl GraphInputs<'_> {
    /// Chosen links of every event at a threshold, best first.
    ///
    /// - `matches`: all links up to `max_error` of this rank's events, best first.
    /// - `comm`: processes that choose for the other events.
    ///
    /// For every kind of outcome (turning left, right or not; staying, going forward, back or to a side) the best link
    /// is taken, whatever its error; then the rest up to the threshold, unless a better one leads nearly to the same
    /// place.
    ///
    /// # Errors
    /// [`throng_base::Error::Rank`].
    pub fn choose(&self, matches: &[Vec<TransitionLink>], threshold: f32, comm: &dyn Comm) -> Result<EventLinks> {
        let of_one = |event: usize| {
            let mut choice = LinkChoice::new(&matches[event], self);
            for link in matches[event].iter().take_while(|l| l.error <= threshold) {
                if choice.accepts(link.event()) {
                    choice.chosen.push(*link);
                }
            }
            sort(&mut choice.chosen);
            choice.chosen
        };
        let chosen = own_numbers(comm, matches.len()).into_par_iter().map(of_one).collect();
        gather_rows(comm, matches.len(), chosen)
    }
}

/// Choice among the links of one event. A lower threshold chooses a subset of what a higher one does.
pub(super) struct LinkChoice<'a> {
    /// Links taken: the next best among the acceptable ones, in no order.
    pub chosen: Vec<TransitionLink>,
    most: usize,
    outcomes: &'a [MotionOutcome],
    config: &'a MotionGraphConfig,
}

impl<'a> LinkChoice<'a> {
    /// Takes the best link of every kind of outcome.
    ///
    /// - `best_first`: at least those links.
    pub fn new(best_first: &[TransitionLink], given: &GraphInputs<'a>) -> Self {
        let GraphInputs { outcomes, config, .. } = *given;
        let most = config.max_actions.saturating_sub(1 + RESERVED).max(1);
        let mut chosen: Vec<TransitionLink> = Vec::new();
        for link in best_first {
            let kind = outcomes[link.event()].kind;
            if chosen.len() < most && chosen.iter().all(|l| outcomes[l.event()].kind != kind) {
                chosen.push(*link);
            }
        }
        Self { chosen, most, outcomes, config }
    }

    /// True if there is room for a link to an event and no better one leads nearly to the same place; once false, it
    /// stays false.
    pub fn accepts(&self, event: usize) -> bool {
        let (config, b) = (self.config, self.outcomes[event].place);
        let same = |l: &TransitionLink| {
            let a = self.outcomes[l.event()].place;
            let [x, z] = [a.x - b.x, a.z - b.z].map(f64::from);
            let is_near = x * x + z * z < config.outcome_distance * config.outcome_distance
                && f64::from(wrap_angle(a.heading - b.heading).abs()) < config.outcome_angle;
            l.event() == event || is_near
        };
        self.chosen.len() < self.most && !self.chosen.iter().any(same)
    }
}

impl MotionOutcome {
    pub fn new(place: Planar) -> Self {
        let side = i8::from(place.heading > TURN) - i8::from(place.heading < -TURN);
        let (is_along, is_ahead, is_left) = (place.z.abs() >= place.x.abs(), place.z > 0.0, place.x > 0.0);
        let travel = match (is_along, is_ahead, is_left) {
            _ if place.x.hypot(place.z) < STAY => 0,
            (true, true, _) => 1,
            (true, false, _) => 2,
            (false, _, true) => 3,
            (false, _, false) => 4,
        };
        Self { place, kind: (side, travel) }
    }
}

/// Sorts links, best first.
pub(super) fn sort(links: &mut [TransitionLink]) {
    links.sort_unstable_by_key(TransitionLink::rank);
}
