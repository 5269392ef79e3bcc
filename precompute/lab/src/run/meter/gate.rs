//! Measures the flow across a line.

use glam::Vec2;
use serde::Serialize;
use throng_simulation::scene::GateConfig;

/// Least and greatest measured flow of people through openings: about 1.2 on level ways (Weidmann 1993, Transporttechnik
/// der Fussgaenger), 1.3 as escape routes are planned for (Nelson and Mowrer 2002, SFPE Handbook), to 1.9 in experiments with
/// bottlenecks of about 1 m (Kretz, Gruenebohm and Schreckenberg 2006, J. Stat. Mech. P10014; Seyfried et al. 2009, Transp.
/// Res. Rec. 2122). The flow grows in proportion to the width up to 5 m (Liao et al. 2014, Transp. Res. Procedia 2), so that
/// these hold for a gap of 2 m (persons/(m s)).
pub const HUMAN_FLOW_PER_M_S: [f64; 2] = [1.2, 1.9];

/// Flow through a gate.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct GateFlow {
    /// Agents that have crossed it, in the more frequent direction.
    pub crossed: usize,
    /// Flow from the first to the last of the middle 80 % of crossings, so that neither the beginning nor the end counts.
    /// `None` if fewer than 10 agents have crossed (persons/(m s)).
    pub flow_per_m_s: Option<f64>,
    /// Least and greatest measured flow of people (persons/(m s)).
    pub human_flow_per_m_s: [f64; 2],
}

/// Counts crossings of a line.
#[derive(Clone, Debug)]
pub struct GateMeter {
    from: Vec2,
    along: Vec2,
    /// Last position of each agent.
    before: Vec<Option<Vec2>>,
    /// Times of crossings, to the left of the line and to its right (s).
    crossings: [Vec<f64>; 2],
}

impl GateMeter {
    /// A meter without crossings.
    pub fn new(gate: &GateConfig) -> Self {
        let from = Vec2::from(gate.from);
        Self { from, along: Vec2::from(gate.to) - from, before: Vec::new(), crossings: Default::default() }
    }

    /// Observes the positions of all agents, in the same order each time; `None` for an agent that has left.
    pub fn observe(&mut self, time_s: f64, agents: impl Iterator<Item = Option<Vec2>>) {
        for (m, now) in agents.enumerate() {
            if m == self.before.len() {
                self.before.push(now);
            } else if let (Some(a), Some(b)) = (std::mem::replace(&mut self.before[m], now), now)
                && let Some(side) = self.crossing_side(a, b)
            {
                self.crossings[side].push(time_s);
            }
        }
    }

    /// Side to which a step led across the gate: 0 left, 1 right; `None` without a crossing.
    fn crossing_side(&self, a: Vec2, b: Vec2) -> Option<usize> {
        let [sa, sb] = [a, b].map(|p| self.along.perp_dot(p - self.from));
        if (sa > 0.0) == (sb > 0.0) {
            return None;
        }
        let at = a.lerp(b, sa / (sa - sb));
        let share = (at - self.from).dot(self.along) / self.along.length_squared();
        (0.0..=1.0).contains(&share).then_some(usize::from(sb > 0.0))
    }

    /// The flow so far.
    pub fn flow(&self) -> GateFlow {
        let times = self.crossings.iter().max_by_key(|c| c.len()).map_or(&[][..], Vec::as_slice);
        let tenth = times.len() / 10;
        let middle = &times[tenth..times.len() - tenth];
        let seconds = middle.last().zip(middle.first()).map_or(0.0, |(l, f)| l - f);
        let flow = middle.len().saturating_sub(1) as f64 / seconds / f64::from(self.along.length());
        GateFlow {
            crossed: times.len(),
            flow_per_m_s: (times.len() >= 10 && seconds > 0.0).then_some(flow),
            human_flow_per_m_s: HUMAN_FLOW_PER_M_S,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_known_flow_is_measured_without_agents_that_pass_beside_the_gate() {
        let mut meter = GateMeter::new(&GateConfig { from: [0.0, -1.0], to: [0.0, 1.0] });
        // One every quarter second through a gate of 2 m: 2 persons/(m s). Every third walks beside it.
        let place = |i: usize, t: f64| {
            let x = (t - 1.0 - 0.25 * (i / 3 * 2 + i % 3) as f64) as f32;
            Some(Vec2::new(x, if i % 3 == 2 { 1.5 } else { 0.4 }))
        };
        for frame in 0..900 {
            let t = f64::from(frame) / 30.0;
            meter.observe(t, (0..120).map(|i| place(i, t)));
        }
        let flow = meter.flow();
        assert_eq!(flow.crossed, 80);
        assert!((flow.flow_per_m_s.unwrap() - 2.0).abs() < 0.05, "{flow:?}");
    }

    #[test]
    fn few_crossings_are_no_flow() {
        let mut meter = GateMeter::new(&GateConfig { from: [0.0, -1.0], to: [0.0, 1.0] });
        assert_eq!(meter.flow().crossed, 0);
        for x in [-1.0, 1.0, -1.0] {
            meter.observe(0.0, [Some(Vec2::new(x, 0.0)), None].into_iter());
        }
        assert_eq!((meter.flow().crossed, meter.flow().flow_per_m_s), (1, None));
    }
}
