//! Promises of the workspace's structure: which crates need which, and that no folders need each other.

mod cycles;
mod dependencies;
mod workspace;
