//! Bakes motion capture into Throng tables. [`pipeline`] lists the stages in order.

pub mod annotate;
pub mod cache;
pub mod clip;
pub mod cluster;
pub mod config;
pub mod environment;
pub mod error;
pub mod examples;
pub mod features;
pub mod files;
pub mod graph;
pub mod import;
pub mod inspect;
pub mod matching;
pub mod measure;
pub mod mirror;
pub mod patch;
pub mod picture;
pub mod pipeline;
mod pod;
pub mod policy;
pub mod progress;
pub mod provenance;
pub mod raw;
pub mod report;
pub mod resample;
pub mod retarget;
pub mod scene;
pub mod slip;
mod stages;
pub mod stitch;
pub mod synth;
pub mod trial;
pub mod write;

pub use clip::{Clip, ClipSet};
pub use error::{BuildError, ImportError, Warnings};
