//! Watches what two people do together: how often, how near to the capture, and how long they wait for each other.

use crate::histogram::Histogram;
use serde::Serialize;
use throng_core::Cast;
use throng_core::planar::wrap_angle;
use throng_runtime::simulation::inhabited::Inhabited;
use throng_runtime::world::inhabitants::{InhabitantEvent, Wish};

/// What was measured of people who do something together.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct PartnerFigures {
    /// Times that two began to do something together.
    pub pairs_begun: u64,
    /// Times that two did it as long as they wished.
    pub pairs_finished: u64,
    /// Times that one of two left in the middle of it, or was told something else.
    pub pairs_broken_off: u64,
    /// Times that two were to come together and did not begin.
    pub pairs_given_up: u64,
    /// Distance of a partner from where the capture has it, once both have begun for half a second, 95th percentile of all
    /// steps (m).
    pub partner_off_p95_m: f64,
    /// The same at worst (m).
    pub partner_off_max_m: f64,
    /// How far a partner is turned from its heading in the capture, 95th percentile (deg).
    pub partner_turned_p95_deg: f64,
    /// The same at worst (deg).
    pub partner_turned_max_deg: f64,
    /// How long the first one of two waited for the other one, mean (s).
    pub partner_wait_mean_s: f64,
    /// The same, 95th percentile (s).
    pub partner_wait_p95_s: f64,
    /// The same at worst (s).
    pub partner_wait_max_s: f64,
}

/// Values up to a thousand, to a hundredth.
type Hundredths = Histogram<100, 100_001>;

/// Looks at pairs after each step.
#[derive(Default)]
pub(super) struct PartnerMeter {
    begun: u64,
    finished: u64,
    broken_off: u64,
    given_up: u64,
    off_mm: Hundredths,
    turned_deg: Hundredths,
    waited_s: Hundredths,
}

impl PartnerMeter {
    /// Looks at all people of a world.
    pub fn look(&mut self, people: &Inhabited) {
        let inhabitants = people.inhabitants();
        for &(id, event) in inhabitants.events() {
            match event {
                InhabitantEvent::Began { .. } => {
                    self.begun += 1;
                    if let Ok(Some(m)) = inhabitants.meeting(id)
                        && m.waited_s > 0.0
                    {
                        self.waited_s.add(m.waited_s);
                    }
                }
                InhabitantEvent::BrokenOff => self.broken_off += 1,
                InhabitantEvent::GaveUp => self.given_up += 1,
                InhabitantEvent::Fulfilled => {
                    let is_pair = inhabitants.state(id).is_ok_and(|s| matches!(s.wish, Wish::Meet { .. }));
                    self.finished += u64::from(is_pair);
                }
                InhabitantEvent::NoWay => {}
            }
        }
        for &id in inhabitants.ids() {
            if let Ok(Some(m)) = inhabitants.meeting(id)
                && let Some([is, captured]) = m.partner
            {
                self.off_mm.add(1e3 * (is.x - captured.x).hypot(is.z - captured.z));
                self.turned_deg.add(wrap_angle(is.heading - captured.heading).abs().to_degrees());
            }
        }
    }

    /// What was measured; nothing where nobody was to do anything together.
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
            partner_off_max_m: 1e-3 * self.off_mm.max(),
            partner_turned_p95_deg: self.turned_deg.quantile(0.95),
            partner_turned_max_deg: self.turned_deg.max(),
            partner_wait_mean_s: self.waited_s.mean(),
            partner_wait_p95_s: self.waited_s.quantile(0.95),
            partner_wait_max_s: self.waited_s.max(),
        })
    }
}
