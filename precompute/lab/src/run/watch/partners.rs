//! Measures pairs of people that act together: how often, how near to the capture, and how long they wait for each other.

use crate::histogram::Histogram;
use serde::Serialize;
use throng_core::CharacterGroup;
use throng_core::planar::wrap_angle;
use throng_simulation::inhabitant_group::InhabitantGroup;
use throng_world::inhabitants::{InhabitantEvent, InhabitantGoal};

/// Figures of pairs of people that act together.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct PartnerFigures {
    /// Times that two people began to act together.
    pub pairs_begun: u64,
    /// Times that two people completed their action.
    pub pairs_finished: u64,
    /// Times that one of two people left during the action, or got another order.
    pub pairs_broken_off: u64,
    /// Times that two people were to meet and did not begin.
    pub pairs_given_up: u64,
    /// Distance of a partner from its place in the capture, from half a second after both have begun, 95th percentile of all
    /// steps (m).
    pub partner_off_p95_m: f64,
    /// Largest distance of a partner from its place in the capture (m).
    pub partner_off_max_m: f64,
    /// Angle of a partner off its heading in the capture, 95th percentile (deg).
    pub partner_turned_p95_deg: f64,
    /// Largest angle of a partner off its heading in the capture (deg).
    pub partner_turned_max_deg: f64,
    /// Time that the first of two waited for the other, mean (s).
    pub partner_wait_mean_s: f64,
    /// Time that the first of two waited for the other, 95th percentile (s).
    pub partner_wait_p95_s: f64,
    /// Longest time that the first of two waited for the other (s).
    pub partner_wait_max_s: f64,
}

/// Histogram of values up to a thousand, to a hundredth.
type HundredthsHistogram = Histogram<100, 100_001>;

/// Measures pairs after each step.
#[derive(Default)]
pub(super) struct PartnerMeter {
    begun: u64,
    finished: u64,
    broken_off: u64,
    given_up: u64,
    off_mm: HundredthsHistogram,
    turned_deg: HundredthsHistogram,
    waited_s: HundredthsHistogram,
}

impl PartnerMeter {
    /// Observes all people of a world.
    pub fn observe(&mut self, people: &InhabitantGroup) {
        let inhabitants = people.inhabitants();
        for &(id, event) in inhabitants.events() {
            match event {
                InhabitantEvent::Began { .. } => {
                    self.begun += 1;
                    if let Ok(Some(m)) = inhabitants.meeting_state(id)
                        && m.waited_s > 0.0
                    {
                        self.waited_s.add(m.waited_s);
                    }
                }
                InhabitantEvent::BrokenOff => self.broken_off += 1,
                InhabitantEvent::GaveUp => self.given_up += 1,
                InhabitantEvent::Fulfilled => {
                    let is_pair = inhabitants.state(id).is_ok_and(|s| matches!(s.goal, InhabitantGoal::Meet { .. }));
                    self.finished += u64::from(is_pair);
                }
                InhabitantEvent::NoPath => {}
            }
        }
        for &id in inhabitants.ids() {
            if let Ok(Some(m)) = inhabitants.meeting_state(id)
                && let Some([is, captured]) = m.partner
            {
                self.off_mm.add(1e3 * (is.x - captured.x).hypot(is.z - captured.z));
                self.turned_deg.add(wrap_angle(is.heading - captured.heading).abs().to_degrees());
            }
        }
    }

    /// The figures; none if no pair was to act together.
    pub fn figures(&self) -> Option<PartnerFigures> {
        if self.begun + self.given_up == 0 {
            return None;
        }
        Some(PartnerFigures {
            pairs_begun: self.begun / 2,
            pairs_finished: self.finished / 2,
            pairs_broken_off: self.broken_off / 2,
            pairs_given_up: self.given_up / 2,
            partner_off_p95_m: 1e-3 * self.off_mm.quantile(0.95),
            partner_off_max_m: 1e-3 * self.off_mm.max,
            partner_turned_p95_deg: self.turned_deg.quantile(0.95),
            partner_turned_max_deg: self.turned_deg.max,
            partner_wait_mean_s: self.waited_s.mean(),
            partner_wait_p95_s: self.waited_s.quantile(0.95),
            partner_wait_max_s: self.waited_s.max,
        })
    }
}
