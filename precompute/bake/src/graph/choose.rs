//! Choice of transitions that become actions: near ones, with different outcomes, and enough of them.

use super::config::MotionGraphConfig;
use super::matches::TransitionLink;
use crate::share::{gather_rows, own_numbers};
use rayon::prelude::*;
use throng_base::Comm;
use throng_core::Planar;
use throng_core::planar::wrap_angle;
use throng_motion::error::Result;

/// Turn within the horizon beyond which an outcome is a turn to a side (rad).
const TURN: f32 = 0.35;
/// Travel within the horizon below which an outcome is staying (m).
const STAY: f32 = 0.25;
/// Action slots of each state reserved for the component.
const RESERVED: usize = 4;

/// Outcome of the motion after an event.
#[derive(Clone, Copy, Debug)]
pub(super) struct MotionOutcome {
    /// Place after the horizon, in the event's frame.
    pub place: Planar,
    pub kind: OutcomeKind,
}

/// Kind of an outcome: side of the turn, and direction of travel as one of five.
pub(super) type OutcomeKind = (i8, u8);

/// Chosen links of every event at a threshold, best first.
///
/// - `matches`: all links up to `max_error` of this rank's events, best first.
/// - `outcomes`: of the motion after each event.
/// - `comm`: processes that choose for the other events.
///
/// For every kind of outcome (turning left, right or not; staying, going forward, back or to a side) the best link is
/// taken, whatever its error; then the rest up to the threshold, unless a better one leads nearly to the same place.
///
/// # Errors
/// [`throng_base::Error::Rank`].
pub(super) fn choose(
    matches: &[Vec<TransitionLink>],
    outcomes: &[MotionOutcome],
    threshold: f32,
    config: &MotionGraphConfig,
    comm: &dyn Comm,
) -> Result<Vec<Vec<TransitionLink>>> {
    let of_one = |event: usize| choose_links(&matches[event], outcomes, threshold, config);
    let chosen = own_numbers(comm, matches.len()).into_par_iter().map(of_one).collect();
    gather_rows(comm, matches.len(), chosen)
}

/// Chooses the links of one event; see [`choose`].
fn choose_links(
    all: &[TransitionLink],
    outcomes: &[MotionOutcome],
    threshold: f32,
    config: &MotionGraphConfig,
) -> Vec<TransitionLink> {
    let mut choice = LinkChoice::new(all, outcomes, config);
    for link in all.iter().take_while(|l| l.error <= threshold) {
        if choice.accepts(link.event()) {
            choice.push(*link);
        }
    }
    let mut chosen = choice.chosen;
    sort(&mut chosen);
    chosen
}

/// Choice among the links of one event. A lower threshold chooses a subset of what a higher one does.
pub(super) struct LinkChoice<'a> {
    chosen: Vec<TransitionLink>,
    most: usize,
    outcomes: &'a [MotionOutcome],
    config: &'a MotionGraphConfig,
}

impl<'a> LinkChoice<'a> {
    /// Takes the best link of every kind of outcome.
    ///
    /// - `best_first`: at least those links.
    pub fn new(best_first: &[TransitionLink], outcomes: &'a [MotionOutcome], config: &'a MotionGraphConfig) -> Self {
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

    pub fn is_full(&self) -> bool {
        self.chosen.len() >= self.most
    }

    /// True if there is room for a link to an event and no better one leads nearly to the same place; once false, it
    /// stays false.
    pub fn accepts(&self, event: usize) -> bool {
        let same = |l: &TransitionLink| {
            l.event() == event || same_outcome(&self.outcomes[l.event()], &self.outcomes[event], self.config)
        };
        !self.is_full() && !self.chosen.iter().any(same)
    }

    /// Takes the next best link among the acceptable ones.
    pub fn push(&mut self, link: TransitionLink) {
        self.chosen.push(link);
    }

    /// Links taken, in no order.
    pub fn chosen(&self) -> &[TransitionLink] {
        &self.chosen
    }
}

impl MotionOutcome {
    pub fn new(place: Planar) -> Self {
        Self { place, kind: kind_of(&place) }
    }
}

fn kind_of(outcome: &Planar) -> OutcomeKind {
    let side = if outcome.heading > TURN {
        1
    } else if outcome.heading < -TURN {
        -1
    } else {
        0
    };
    let travel = if outcome.x.hypot(outcome.z) < STAY {
        0
    } else if outcome.z.abs() >= outcome.x.abs() {
        if outcome.z > 0.0 { 1 } else { 2 }
    } else if outcome.x > 0.0 {
        3
    } else {
        4
    };
    (side, travel)
}

/// Sorts links, best first.
pub(super) fn sort(links: &mut [TransitionLink]) {
    links.sort_unstable_by_key(TransitionLink::rank);
}

fn same_outcome(
    MotionOutcome { place: a, .. }: &MotionOutcome,
    MotionOutcome { place: b, .. }: &MotionOutcome,
    config: &MotionGraphConfig,
) -> bool {
    let [x, z] = [a.x - b.x, a.z - b.z].map(f64::from);
    x * x + z * z < config.outcome_distance * config.outcome_distance
        && f64::from(wrap_angle(a.heading - b.heading).abs()) < config.outcome_angle
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_base::SingleRank;

    fn links(errors: &[(usize, f32)]) -> Vec<TransitionLink> {
        errors.iter().map(|&(event, error)| TransitionLink::new(event, error)).collect()
    }

    fn events(links: &[TransitionLink]) -> Vec<usize> {
        links.iter().map(|l| l.event()).collect()
    }

    #[test]
    fn of_equal_outcomes_the_better_stays() {
        let mut matches = vec![Vec::new(); 6];
        matches[0] = links(&[(1, 0.1), (2, 0.2), (3, 0.3), (4, 0.4), (5, 0.9)]);
        let outcomes = [0.0, 1.0, 1.0, 1.02, 2.0, 3.0].map(|z| MotionOutcome::new(Planar::new(0.0, z, 0.0)));
        let chosen = choose(&matches, &outcomes, 0.5, &MotionGraphConfig::default(), &SingleRank).unwrap();
        assert_eq!(events(&chosen[0]), [1, 4]);
    }

    #[test]
    fn the_best_of_each_kind_of_outcome_is_taken_beyond_the_threshold() {
        let mut matches = vec![Vec::new(); 7];
        matches[0] = links(&[(1, 0.1), (2, 0.6), (3, 0.7), (4, 0.8), (5, 0.9), (6, 0.95)]);
        let outcomes = [
            Planar::IDENTITY,
            Planar::new(0.0, 1.0, 0.0),
            Planar::new(0.0, 1.2, 0.0),
            Planar::new(0.0, 1.0, 1.0),
            Planar::new(0.0, 1.0, 2.0),
            Planar::new(0.0, -1.0, -1.0),
            Planar::new(0.1, 0.1, 0.0),
        ]
        .map(MotionOutcome::new);
        let chosen = choose(&matches, &outcomes, 0.5, &MotionGraphConfig::default(), &SingleRank).unwrap();
        assert_eq!(events(&chosen[0]), [1, 3, 5, 6]);
    }

    #[test]
    fn leaves_room_below_the_most_actions() {
        let mut matches = vec![Vec::new(); 100];
        matches[0] = (1..100).map(|event| TransitionLink::new(event, 0.1)).collect();
        let outcomes: Vec<MotionOutcome> =
            (0..100).map(|z| MotionOutcome::new(Planar::new(0.0, z as f32, 0.0))).collect();
        let chosen =
            choose(&matches, &outcomes, 0.5, &MotionGraphConfig { max_actions: 10, ..Default::default() }, &SingleRank)
                .unwrap();
        assert_eq!(chosen[0].len(), 9 - RESERVED);
    }
}
