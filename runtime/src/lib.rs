//! Facade for applications: re-exports the crates of the runtime under one name.
//!
//! A bundle (`*.throng`) is opened as [`Bundle`]; [`characters::PolicyCharacters`] and [`walkers::Walkers`] are
//! [`CharacterGroup`]s that move and pose people. [`policy`] answers single queries without characters. Features add [`crowd`]
//! (agents without bodies), [`world`] (patch worlds) and [`sparring`].

pub use throng_core::*;
#[cfg(feature = "crowd")]
pub use throng_crowd as crowd;
pub use throng_geometry as geometry;
#[cfg(feature = "simulation")]
pub use throng_simulation::{self as simulation, sparring};
#[cfg(feature = "world")]
pub use throng_world as world;

/// The program in the README compiles.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;
