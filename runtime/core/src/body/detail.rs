//! Level of detail: near characters are posed whole, far ones leave a record of 32 bytes.

use super::lanes::Lane3;
use bytemuck::{Pod, Zeroable};
use glam::Vec2;
use throng_base::{Result, error::check_value};

/// Record from which a GPU poses a character with the frame rows of its bundle (32 bytes).
///
/// The pose is `mix(mix(row_a, row_a + 1, frac), mix(row_b, row_b + 1, frac), blend)`: the motion that is played, and
/// the one that a transition left and fades out (of a blend: the two examples that weigh most). It is placed at (x, y, z) and turned by the heading.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PoseInstance {
    /// Frame row; the next row is of the same clip, or `frac` is 0.
    pub row_a: u32,
    /// Frame row of what fades out, or of the second example; `row_a` where there is none.
    pub row_b: u32,
    /// Ratio to the next rows, and the weight of `row_b` (65535 is 1).
    pub frac_blend: [u16; 2],
    /// Number of the character's place, for looks; below the capacity.
    pub variant: u32,
    /// X in the world (m).
    pub x: f32,
    /// Height of the ground there (m).
    pub y: f32,
    /// Z in the world (m).
    pub z: f32,
    /// About +Y from +Z (rad).
    pub heading: f32,
}

const _: () = assert!(size_of::<PoseInstance>() == 32);

/// Extent to which a character is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum DetailLevel {
    /// Pose, transitions, reactions, feet that stay in place.
    #[default]
    Full,
    /// Feet follow the clips.
    FreeFeet,
    /// Place and [`PoseInstance`] alone; matrices are those of the last pose.
    Record,
}

/// Viewpoint and distances that decide the level of each character. Levels do not change where characters go.
///
/// Eight characters that are neighbours in memory have one level: that of the nearest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detail {
    /// x and z of the eye (m).
    pub eye: Vec2,
    /// Feet are locked up to this distance (m, >= 0).
    pub full_m: f32,
    /// Poses are computed up to this distance (m, >= `full_m`).
    pub posed_m: f32,
}

impl Detail {
    /// Records alone for all characters.
    pub const RECORDS: Self = Self { eye: Vec2::ZERO, full_m: -1.0, posed_m: -1.0 };

    pub(crate) fn check(&self) -> Result<()> {
        let largest = if self.eye.is_nan() { f32::NAN } else { self.eye.abs().max_element() };
        check_value("eye", None, largest, largest < 1e6, "finite and below 1e6 (m)")?;
        check_value("full_m", None, self.full_m, self.full_m >= -1.0, "a distance (m)")?;
        check_value("posed_m", None, self.posed_m, self.posed_m >= self.full_m, "at least full_m")
    }

    /// The level of a block.
    ///
    /// - `roots`: planar roots: x, z, heading (m, m, rad).
    /// - `count`: characters in the block (> 0).
    pub(crate) fn level(&self, roots: &Lane3, count: usize) -> DetailLevel {
        let [x, z, _] = roots;
        let squares = (0..count).map(|l| (Vec2::new(x[l], z[l]) - self.eye).length_squared());
        let square = squares.fold(f32::INFINITY, f32::min);
        let within = |distance: f32| distance >= 0.0 && square <= distance * distance;
        match () {
            () if within(self.full_m) => DetailLevel::Full,
            () if within(self.posed_m) => DetailLevel::FreeFeet,
            () => DetailLevel::Record,
        }
    }
}

/// 0 to 1 as 0 to 65535.
pub(crate) fn unorm(value: f32) -> u16 {
    (value.clamp(0.0, 1.0) * 65535.0 + 0.5) as u16
}
