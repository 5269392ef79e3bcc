//! Result of stitching: the world's graph, and its component.

use super::joined::Joined;
use super::remains::Remains;
use super::settled::Settled;
use crate::stitch::place::lay::Laid;
use crate::stitch::report::StitchReport;

/// A stitched world, with its intermediate results.
pub(in crate::stitch) struct Made {
    /// Placed patches.
    pub laid: Laid,
    /// The graph.
    pub joined: Joined,
    /// Membership of its cells in the component.
    pub settled: Settled,
    /// Remaining instances and pairs.
    pub remains: Remains,
    /// Report.
    pub report: StitchReport,
}
