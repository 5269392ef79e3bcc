//! The promise of import: real files with all their quirks read as what they mean, and files that are damaged are
//! refused with the place and the way out.

mod body;
mod detection;
mod formats;
mod malformed;
mod mocap;
mod roundtrip;
mod surroundings;
