//! Levels of meshes and of plans.
//!
//! `rerecast` finds the ground that somebody with a radius and a height can walk on; heights are those of the mesh itself.

mod bake;
mod ground;
mod source;

pub use bake::bake;
pub use source::{LevelSource, MarkedArea, MarkedLink};

/// Who walks on a level: radius, height, highest step and steepest slope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelSettings {
    /// Radius: paths keep it from walls (m, > 0).
    pub radius_m: f32,
    /// Height that has to be free (m, > 0).
    pub height_m: f32,
    /// Highest step (m, >= 0).
    pub climb_m: f32,
    /// Steepest slope (degrees, 0 to 89).
    pub slope_deg: f32,
}

impl Default for LevelSettings {
    fn default() -> Self {
        Self { radius_m: 0.3, height_m: 1.8, climb_m: 0.3, slope_deg: 40.0 }
    }
}
