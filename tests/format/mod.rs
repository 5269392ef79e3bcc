//! Every truncated, extended, flipped or re-versioned file is refused with an error, and none panics.

mod damage;
mod frame;
mod overwritten;
pub(crate) mod patch;
mod records;
