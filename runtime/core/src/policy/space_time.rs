//! Scores on a space-time grid: the target is an event at a place and time, such as an incoming blow (evading).
//!
//! The target is where the blow will land, in the character's frame, and the time left until then. An action that is
//! still playing at that time is rewarded by the distance of the guarded point from the event; an action that has ended
//! has the value of its successor, with less time left.

use super::reward::Reward;
use super::table::{PolicyTable, SegmentRecord};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use throng_base::maths;

/// Positions of a path.
pub const PATH_POINTS: usize = 9;

/// Path of one point of the body over a segment, in the frame of the segment's start.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PathRecord {
    /// Positions at equal intervals from start to end (m).
    pub points: [[f32; 3]; PATH_POINTS],
    /// Time from start to end (s, > 0).
    pub duration_s: f32,
}
const _: () = assert!(size_of::<PathRecord>() == 112);

impl PathRecord {
    /// Position at a time, linear between points (m, 0 <= time_s <= duration_s).
    #[inline]
    pub fn position_at(&self, time_s: f32) -> Vec3 {
        let t = time_s / self.duration_s * (PATH_POINTS - 1) as f32;
        let i = (t as usize).min(PATH_POINTS - 2);
        Vec3::from(self.points[i]).lerp(self.points[i + 1].into(), (t - i as f32).clamp(0.0, 1.0))
    }
}

impl Reward {
    /// Reward of being at `place` when the event happens, before the discount.
    ///
    /// - `target`: where it happens; its Y, the time left, is not read.
    #[inline]
    pub fn of_event(&self, place: Vec3, target: Vec3) -> f32 {
        let at = Vec3::new(target.x, self.record().height, target.z);
        self.record().gain * self.kernel(place.distance(at))
    }
}

impl PolicyTable {
    /// Score of one action for a target in a space-time grid: the right-hand side of Lee and Lee (2004), equation 4.
    ///
    /// - `target`: in the grid: x, time left (s), z.
    pub(super) fn score_in_space_time(&self, segment: u32, target: Vec3) -> f32 {
        let (motion, path) = (&self.rows.segments[segment as usize], &self.rows.paths[segment as usize]);
        let left_s = target.y - path.duration_s;
        if left_s < 0.0 {
            // Within a segment, the discount is that of the time that has passed.
            let discount = maths::pow(motion.discount, target.y / path.duration_s);
            return discount * self.reward.of_event(path.position_at(target.y), target);
        }
        motion.discount * self.value_in(motion.end, &self.grid, target_after(motion, target, left_s))
    }
}

/// The target in the grid after a segment.
fn target_after(motion: &SegmentRecord, target: Vec3, left_s: f32) -> Vec3 {
    let [x, z, _] = motion.target_after(target);
    Vec3::new(x, left_s, z)
}
