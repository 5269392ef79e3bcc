//! Result of stitching: the world's graph, and its component.

use super::component_cells::ComponentCells;
use super::joined::JoinedGraph;
use super::remains::WorldRemains;
use crate::stitch::place::place_patches::PlacedPatches;
use crate::stitch::report::StitchReport;

/// A stitched world, with its intermediate results.
pub(in crate::stitch) struct StitchResult {
    /// Placed patches.
    pub patches: PlacedPatches,
    /// The graph.
    pub joined: JoinedGraph,
    /// Membership of its cells in the component.
    pub component: ComponentCells,
    /// Remaining instances and pairs.
    pub remains: WorldRemains,
    /// Report.
    pub report: StitchReport,
}
