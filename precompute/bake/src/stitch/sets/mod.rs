//! Bits, sets of cells, and shared values that are stored once.

pub(in crate::stitch) mod numbers;
pub(in crate::stitch) mod rows;
