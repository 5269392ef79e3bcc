//! Promises of the workspace's structure: which crates need which, that no folders need each other, whose mathematics is used.

mod cycles;
mod dependencies;
mod facade;
mod maths;
mod programs;
mod workspace;
