//! Promises, one module each: `cargo test --test all golden` tries one of them.

mod architecture;
mod blend;
mod bodies;
mod cli;
mod common;
mod crowd;
mod determinism;
mod examples;
mod format;
mod golden;
mod graph;
mod guides;
mod hits;
mod import;
mod levels;
mod meetings;
mod patch;
mod pipeline;
mod policy;
mod retarget;
mod scenes;
mod things;
