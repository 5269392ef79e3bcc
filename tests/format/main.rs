//! Every truncated, extended, flipped or re-versioned file is refused with an error, and none panics.

#[path = "../common/mod.rs"]
mod common;
mod damage;
mod frame;
mod overwritten;
mod patch;
mod records;
