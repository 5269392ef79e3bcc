//! The viewer as its users see it, one module for each part. Builds, which keep their cache in the current folder, are in `start.rs`.

mod app;
mod blend;
mod body;
mod common;
mod crowd;
mod picture;
mod snapshots;
mod task;
mod window;
mod world;
