//! Actions weighed against something that will happen at a place and time: a blow that comes (evading).
//!
//! The state is where the blow will land, in the character's frame, and how long that takes: the opponent's motion
//! reduced to what matters to the one who is to be hit. An action that is still under way at that time has the reward
//! of where the character's point is then; another one has the value of where it leads, with less time left.

use super::reward::Reward;
use super::table::{PolicyTable, SegmentRecord};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Places of a path.
pub const PATH_POINTS: usize = 9;

/// The way of one point of the body over a segment, in the frame of its start.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PathRecord {
    /// Places at equal times from start to end. [Unit: m]
    pub points: [[f32; 3]; PATH_POINTS],
    /// Time from start to end. [Unit: s] [Limit: > 0]
    pub duration_s: f32,
}
const _: () = assert!(size_of::<PathRecord>() == 112);

impl PathRecord {
    /// The place at a time, linear between points. [Unit: m] [Limit: 0 <= time_s <= duration_s]
    #[inline]
    pub fn at(&self, time_s: f32) -> Vec3 {
        let t = time_s / self.duration_s * (PATH_POINTS - 1) as f32;
        let i = (t as usize).min(PATH_POINTS - 2);
        Vec3::from(self.points[i]).lerp(self.points[i + 1].into(), (t - i as f32).clamp(0.0, 1.0))
    }
}

impl Reward {
    /// What being at a place counts when it happens, before the discount.
    ///
    /// - `target`: where it happens; its third coordinate is not read.
    #[inline]
    pub fn of_moment(&self, place: Vec3, target: Vec3) -> f32 {
        let at = Vec3::new(target.x, self.record().height, target.z);
        self.record().gain * self.kernel(place.distance(at))
    }
}

impl PolicyTable<'_> {
    /// Score of one action for a target in a grid of moments: the right-hand side of 003 eq. 4.
    ///
    /// - `target`: in the grid: x, seconds left, z.
    pub(super) fn score_of_moment(&self, segment: u32, target: Vec3) -> f32 {
        let (motion, path) = (&self.segments[segment as usize], &self.paths[segment as usize]);
        let left_s = target.y - path.duration_s;
        if left_s < 0.0 {
            // Within the segment the discount is that of the share of it that has passed.
            let discount = motion.discount.powf(target.y / path.duration_s);
            return discount * self.reward.of_moment(path.at(target.y), target);
        }
        motion.discount * self.value_in(motion.end, &self.grid, after(motion, target, left_s))
    }
}

/// A target in the grid, after a segment.
fn after(motion: &SegmentRecord, target: Vec3, left_s: f32) -> Vec3 {
    let [x, z, _] = motion.target_after(target);
    Vec3::new(x, left_s, z)
}
