//! The viewer as its users see it, one module for each part.

mod app;
mod blend;
mod body;
mod common;
mod crowd;
mod picture;
mod snapshots;
mod start;
mod task;
mod window;
mod world;
