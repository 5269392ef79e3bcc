//! What stitching leaves: the world's graph, and what of it belongs to the component.

use super::joined::Joined;
use super::remains::Remains;
use super::settled::Settled;
use crate::stitch::place::lay::Laid;
use crate::stitch::report::StitchReport;

/// A stitched world and all that was found on the way.
pub(in crate::stitch) struct Made {
    /// Patches in their places.
    pub laid: Laid,
    /// The graph.
    pub joined: Joined,
    /// What its cells are to the component.
    pub settled: Settled,
    /// What is left of its instances and pairs.
    pub remains: Remains,
    /// What came of it.
    pub report: StitchReport,
}
