//! Reports of several runs, a line each.

use super::run::CrowdReport;

impl CrowdReport {
    /// What stands above the columns of [`CrowdReport::row`].
    pub const HEADINGS: &str = "scene       members engine     us/member/s  events/s  decisions/s   m/s of wanted  \
                                overlaps>1mm  deepest  there  stuck";

    /// A line below [`CrowdReport::HEADINGS`].
    pub fn row(&self) -> String {
        format!(
            "{:11} {:7} {:9} {:12.2} {:9.2} {:12.2} {:5.2} of {:6.2} {:11.3} % {:5.2} mm {:6} {:6}",
            self.scene,
            self.members,
            self.engine,
            self.us_per_member_second,
            self.events_per_member_second,
            self.decisions_per_member_second,
            self.progress_mps,
            self.desired_mps,
            100.0 * self.overlap_over_1mm_fraction,
            1000.0 * self.max_overlap_m,
            self.arrived,
            self.stuck,
        )
    }
}
