//! Blends both ends of a motion into the motion before and after it, in velocity as well as in position.

use super::Smoother;
use super::ease::smoothstep;
use crate::linkage::LimbPose;

impl Smoother<'_> {
    /// Blends the first and the last frames with the external motion's poses, where the plan begins or ends in its pose, or
    /// with the end's own pose, where it does not: a reach comes to rest in the trunk's frame. Halves the length of a blend
    /// until it is free.
    ///
    /// - `eased`: ends that are not in the external motion come to rest already.
    /// - `spare`: scratch.
    /// - returns the number of frames over which each end was blended.
    pub fn blend_ends(
        &mut self,
        frames: &mut Vec<LimbPose>,
        spare: &mut Vec<LimbPose>,
        blend: usize,
        eased: bool,
    ) -> [usize; 2] {
        [false, true].map(|at_goal| {
            let come_to_rest = eased && !self.path_end(at_goal).follows;
            let mut length = if come_to_rest { 0 } else { blend.min((frames.len() - 1) / 2) };
            while length > 1 && !self.blend_end(frames, spare, length, at_goal) {
                length /= 2;
            }
            if length > 1 { length } else { 0 }
        })
    }

    /// Blends one end over some frames; returns false, and changes nothing, where that is not free.
    fn blend_end(
        &mut self,
        frames: &mut Vec<LimbPose>,
        spare: &mut Vec<LimbPose>,
        length: usize,
        at_goal: bool,
    ) -> bool {
        let problem = self.problem;
        let end = if at_goal { &problem.goal } else { &problem.init };
        let follows = self.path_end(at_goal).follows;
        let last = frames.len() - 1;
        spare.clear();
        spare.extend_from_slice(frames);
        for k in 1..length {
            let f = if at_goal { last - k } else { k };
            let there = if follows { problem.external_pose_at(self.grid.time_at(f)) } else { end.pose };
            let share = smoothstep(k as f64 / length as f64);
            spare[f] = there.slerp(&frames[f], share);
        }
        let first = if at_goal { last - length } else { 0 };
        let free = (first..first + length).all(|f| self.is_edge_free(spare, f));
        if free {
            std::mem::swap(frames, spare);
        }
        free
    }
}
