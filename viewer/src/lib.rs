//! The viewer: everything that is baked, seen and tried.
//!
//! [`app::Viewer`] is the whole program without its [`window`], or its picture on a machine without a screen
//! ([`headless`]). In reading order of a frame: [`model::Model::apply`] carries out the commands of the panels,
//! [`model::Model::advance`] advances time, [`stage`] lays out the 3-D scene, [`render`] draws it, [`panels`] show the
//! model and give new commands.

// In this order: none uses one that comes after it.
pub mod render;
pub mod theme;
pub mod volume;

pub mod bundle;
#[cfg(test)]
#[path = "../tests/common/fixtures.rs"]
mod fixtures;
pub mod run;
pub mod settings;

pub mod document;

pub mod command;
pub mod model;

pub mod stage;

pub mod panels;

pub mod args;

pub mod app;
pub mod headless;
pub mod window;
