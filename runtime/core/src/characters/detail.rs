//! Level of detail: near characters are posed whole, far ones leave a record of 32 bytes.

use super::block::{BodyBlock, MotionBlock};
use super::motion_set::MotionSet;
use super::transition;
use crate::body::{Decay, FramePosition, HALF_LIVES_KEPT, PlacementLanes};
use bytemuck::{Pod, Zeroable};
use glam::Vec2;
use throng_base::Result;
use throng_base::error::check_value;
use throng_base::simd::{LANES, Lanes};

/// Record from which a GPU poses a character with the frame rows of its bundle (32 bytes).
///
/// The pose is `mix(mix(row_a, row_a + 1, frac), mix(row_b, row_b + 1, frac), blend)`: the motion that is played, and
/// the one that a transition left and fades out. It is placed at (x, y, z) and turned by the heading.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PoseInstance {
    /// Frame row; the next row is of the same clip, or `frac` is 0.
    pub row_a: u32,
    /// Frame row of what fades out; `row_a` where nothing does.
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

    pub(super) fn check(&self) -> Result<()> {
        check_value(
            "eye",
            None,
            self.eye.abs().max_element(),
            self.eye.abs().max_element() < 1e6,
            "finite and below 1e6 (m)",
        )?;
        check_value("full_m", None, self.full_m, self.full_m >= -1.0, "a distance (m)")?;
        check_value("posed_m", None, self.posed_m, self.posed_m >= self.full_m, "at least full_m")
    }

    /// The level of a block (count > 0).
    pub(super) fn level(&self, block: &MotionBlock, count: usize) -> DetailLevel {
        let [x, z, _] = &block.root;
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

/// Wakes a body or lets it sleep, as its block's level requires.
pub(super) fn set_awake(
    level: DetailLevel,
    block: &MotionBlock,
    body: &mut BodyBlock,
    motion_set: &MotionSet,
    half_life_s: f32,
) {
    match (level, body.awake) {
        (DetailLevel::Record, 1) => *body = BodyBlock::ZERO,
        (DetailLevel::Full | DetailLevel::FreeFeet, 0) => transition::wake_block(block, body, motion_set, half_life_s),
        _ => {}
    }
}

/// Writes the records of a block (out.len() <= 8).
#[inline(always)]
pub(super) fn write_instances<F: Lanes>(
    out: &mut [PoseInstance],
    block: &MotionBlock,
    spots: &[FramePosition; LANES],
    place: &PlacementLanes<F>,
    motion_set: &MotionSet,
    half_life_s: f32,
) {
    let kept = F::splat(HALF_LIVES_KEPT * half_life_s);
    let age = F::load(&block.age_s);
    let fading = F::select_lt(kept, age, F::splat(0.0), Decay::new(age, half_life_s).position);
    let (fading, y) = (fading.to_array(), place.y.to_array());
    for (l, out) in out.iter_mut().enumerate() {
        let (spot, [from, to]) = (&spots[l], [block.change[0][l], block.change[1][l]]);
        let (row, blend) = (spot.frame as u32, unorm(fading[l]));
        // What was left goes on beside what is played, as far as its clip goes.
        let since = row.wrapping_sub(to).min(motion_set.frames_after(from).saturating_sub(1));
        *out = PoseInstance {
            row_a: row,
            row_b: if blend > 0 { from + since } else { row },
            frac_blend: [unorm(spot.ratio), blend],
            variant: block.name[l] as u32,
            x: block.root[0][l],
            y: y[l],
            z: block.root[1][l],
            heading: block.root[2][l],
        };
    }
}

/// 0 to 1 as 0 to 65535.
fn unorm(value: f32) -> u16 {
    (value.clamp(0.0, 1.0) * 65535.0 + 0.5) as u16
}

#[cfg(test)]
mod tests;
