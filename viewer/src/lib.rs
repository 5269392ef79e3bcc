//! The viewer: everything that is baked, seen and tried.
//!
//! [`app::Viewer`] is the whole program but for its [`window`], or its picture where there is none ([`headless`]). In
//! reading order of a frame: [`model::Model::apply`] carries out what the panels asked for, [`model::Model::advance`]
//! moves time on, [`stage`] lays out what is to be drawn, [`render`] draws it, [`panels`] show the model and ask for
//! more.

// In this order: none uses one that comes after it.
pub mod render;
pub mod theme;
pub mod volume;

pub mod bundle;
#[cfg(test)]
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
