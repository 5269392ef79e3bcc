//! Bakes clips into Throng tables. [`pipeline`] lists the stages in order.

pub mod activities;
pub mod cache;
pub mod cluster;
mod components;
pub mod config;
pub mod environment;
pub mod examples;
pub mod features;
pub mod graph;
pub mod make;
mod motion;
pub mod parts;
pub mod patch;
pub mod pipeline;
pub mod policy;
pub mod provenance;
mod replaced;
pub mod report;
pub mod select;
mod share;
mod stages;
pub mod stitch;
pub mod stops;
pub mod write;
