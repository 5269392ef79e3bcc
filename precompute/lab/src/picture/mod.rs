//! Pictures of motion as PNG files: figures with bodies, crowds, strips of poses. Plain data in, pixels out.
//!
//! The same input gives the same bytes. The painters take joint positions, contacts and ground
//! positions; [`trial`] and [`scene`] alone know where those of a trial and a scene come from.

pub mod blends;
pub mod camera;
pub mod canvas;
pub mod colour;
pub mod figure;
pub mod hits;
pub mod level;
pub mod scene;
pub mod sheet;
pub mod trial;
pub mod world;

mod crowd_bodies;
mod discs;
mod fights;
mod furniture;
mod inhabited;
mod obstacle;
mod paint;
mod piece;
mod solid;
mod text;
mod visible;
mod walkers;

pub use blends::blend_sheet;
pub use camera::PictureCamera;
pub use canvas::Picture;
pub use colour::Colour;
pub use figure::{BodyColours, BodyFigure};
pub use furniture::step_up;
pub use hits::{HitView, hit_views};
pub use level::{level_floors, level_sheet};
pub use obstacle::obstacle_solid;
pub use scene::scene_sheet;
pub use sheet::sheet;
pub use trial::trial_sheet;
pub use world::{WorldCamera, WorldFigure, WorldMoment, WorldSheet, WorldStrip, WorldUnit, unit_colour, world_sheet};
pub use world::{world_strip, world_units};
