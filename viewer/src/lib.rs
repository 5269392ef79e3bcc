//! The viewer: everything that is baked, seen and tried.

pub mod render;
