//! Joins overlapping patches, and keeps the largest strongly connected component.
//!
//! [`prepare`] finds joints once for all pairs with equal relative placement, [`allow`] builds the graph,
//! [`component_cells`] finds its component and [`assemble`] writes the world.

pub(in crate::stitch) mod allow;
pub(in crate::stitch) mod assemble;
pub(in crate::stitch) mod component_cells;
pub(in crate::stitch) mod crossing;
pub(in crate::stitch) mod joined;
pub(in crate::stitch) mod outcome;
pub(in crate::stitch) mod prepare;
pub(in crate::stitch) mod reach;
pub(in crate::stitch) mod remains;
pub(in crate::stitch) mod situation;
pub(in crate::stitch) mod table;
