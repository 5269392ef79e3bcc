//! Reports of several runs of agents, one line each.

use super::figures::SceneFigures;

impl SceneFigures {
    /// Headings of the columns of [`SceneFigures::row`].
    pub const HEADINGS: &str = "scene       agents engine     us/agent/s  events/s  decisions/s   m/s of wanted  \
                                overlaps>1mm  deepest  there  stuck";

    /// A line below [`SceneFigures::HEADINGS`].
    pub fn row(&self, scene: &str) -> String {
        let f = self.crowd.clone().unwrap_or_default();
        let a_second = |v: Option<f64>| v.unwrap_or(f64::NAN);
        format!(
            "{scene:11} {:7} {:9} {:12.2} {:9.2} {:12.2} {:5.2} of {:6.2} {:11.3} % {:5.2} mm {:6} {:6}",
            self.agents.unwrap_or(0),
            self.engine.as_deref().unwrap_or_default(),
            a_second(f.us_per_agent_second),
            a_second(f.events_per_agent_second),
            a_second(f.decisions_per_agent_second),
            f.progress_mps,
            f.desired_mps,
            100.0 * f.overlap_over_1mm_fraction,
            1000.0 * f.max_overlap_m,
            f.arrived,
            self.stuck.unwrap_or(0),
        )
    }
}
