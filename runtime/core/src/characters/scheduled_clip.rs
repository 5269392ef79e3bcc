//! Scheduled clips: stretches of frames that a character plays in place of choosing by a policy.

use super::block::{MotionBlock, NO_STATE, SCHEDULED};
use super::transition::{SegmentChange, StartTransitionsJob, wake_block};
use super::{Characters, motion_set::MotionSet};
use crate::body::{Lanewise, set_lane};
use crate::{patch::Placement, planar::Planar, skeleton::NUM_JOINTS};
use glam::{Vec2, Vec3};
use throng_base::Result;
use throng_base::error::{check_index, check_value};
use throng_base::simd::{LANES, dispatch};

/// A stretch of one clip, placed in the world.
///
/// The planar root of frame k is that of the clip, placed so that frame `from_offset` is at `root`, plus the share (k -
/// from_offset) / (num_frames - from_offset) of `missing`: position and heading each change linearly, nothing is bent
/// (Lee, Choi and Lee 2006, section 6).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScheduledClip {
    /// First frame row.
    pub frame: u32,
    /// Frames up to the last one, which is in the same clip (> 0).
    pub num_frames: u32,
    /// Frame it begins at (< num_frames).
    pub from_offset: u32,
    /// Planar root in the world at that frame.
    pub root: Planar,
    /// Height of the clip's ground in the world at that frame (m).
    pub lift: f32,
    /// Displacement added by the last frame: along the world's axes, and about the vertical; y is added to the lift.
    pub missing: Placement,
}

impl ScheduledClip {
    /// Planar root in the world at the last frame.
    pub fn root_at_end(&self, motion_set: &MotionSet) -> Planar {
        let first = motion_set.planar_root(self.frame + self.from_offset);
        let end = self.root.compose(first.to_local(motion_set.planar_root(self.frame + self.num_frames)));
        let m = self.missing;
        Planar::new(end.x + m.x, end.z + m.z, end.heading + m.heading)
    }

    fn check(&self, motion_set: &MotionSet) -> Result<()> {
        let last = self.frame.saturating_add(self.num_frames);
        check_index("frame", None, last as usize, motion_set.num_frames())?;
        check_index("first frame of a scheduled clip", None, self.from_offset as usize, self.num_frames as usize)?;
        let in_clip = motion_set.clip_of(self.frame) == motion_set.clip_of(last);
        let expected = "a number of frames that the clip has";
        check_value("length of a scheduled clip", None, self.num_frames, in_clip, expected)?;
        let (r, m) = (self.root, self.missing);
        let numbers = [("root x", r.x), ("root z", r.z), ("root heading", r.heading), ("lift", self.lift)];
        let missing = [("missing x", m.x), ("missing y", m.y), ("missing z", m.z), ("missing heading", m.heading)];
        for (what, got) in numbers.into_iter().chain(missing) {
            check_value(what, None, got, got.abs() < 1e6, "a finite number below 1e6")?;
        }
        Ok(())
    }

    /// Writes it into a block; time and age are left as they are.
    fn write_to_block(&self, b: &mut MotionBlock, lane: usize, motion_set: &MotionSet) {
        let (m, share) = (self.missing, 1.0 / (self.num_frames - self.from_offset) as f32);
        b.segment[lane] = SCHEDULED;
        b.first[lane] = self.frame;
        b.length[lane] = self.num_frames;
        b.drift_from[lane] = self.from_offset as f32;
        b.lift[lane] = self.lift;
        set_lane(&mut b.drift, lane, Vec3::new(m.x, m.y, m.z) * share);
        b.turn[lane] = m.heading * share;
        b.bend[lane] = 0.0;
        b.choice_state[lane] = NO_STATE;
        b.set_clip_to_world(lane, self.root.compose(motion_set.planar_root(self.frame + self.from_offset).inverse()));
    }
}

impl Characters {
    /// Adds a character on a scheduled clip after the last one. It chooses nothing: the caller schedules the next clip before
    /// this one ends. Its pose is there after the next step. Allocates nothing.
    ///
    /// # Errors
    /// As [`Characters::schedule_clip`], and [`throng_base::Error::Index`] beyond the capacity; nothing has changed then.
    pub fn enter_scheduled(&mut self, motion_set: &MotionSet, scheduled_clip: &ScheduledClip) -> Result<()> {
        let at = self.num_characters;
        check_index("character", None, at, self.matrices.len() / NUM_JOINTS)?;
        self.clear_row(at);
        self.num_characters += 1;
        let started = self.start_scheduled(motion_set, at, scheduled_clip);
        self.num_characters -= usize::from(started.is_err());
        started
    }

    /// Starts a scheduled clip at once, with free feet and without a transition.
    ///
    /// # Errors
    /// As [`Characters::schedule_clip`].
    pub fn start_scheduled(&mut self, motion_set: &MotionSet, character: usize, clip: &ScheduledClip) -> Result<()> {
        self.check_bundle(motion_set)?;
        check_index("character", None, character, self.num_characters)?;
        clip.check(motion_set)?;
        let (lane, root) = (character % LANES, clip.root);
        self.num_choosers -= usize::from(self.blocks[character / LANES].segment[lane] != SCHEDULED);
        self.bodies[character / LANES].clear(lane);
        let b = &mut self.blocks[character / LANES];
        b.copy_lane(lane, &MotionBlock::ZERO, 0);
        b.name[lane] = character as u64;
        clip.write_to_block(b, lane, motion_set);
        b.time[lane] = clip.from_offset as f32;
        set_lane(&mut b.root, lane, Vec3::new(root.x, root.z, root.heading));
        self.mark_paths_stale();
        Ok(())
    }

    /// Schedules a clip, to which a character changes exactly at the end of what it plays.
    ///
    /// Call it before the step that reaches that end; the rest of the step is spent on the scheduled clip. Where
    /// [`ScheduledClip::root`] is [`Characters::scheduled_end`], nothing jumps: rotations, height and velocities
    /// continue smoothly. A scheduled clip that ends within the same step may be followed by another one at once.
    /// Without another scheduled clip, a character stays at the end of its last one.
    ///
    /// # Errors
    /// [`throng_base::Error::Index`] or [`throng_base::Error::Value`] for a character that does not exist or a
    /// scheduled clip that leaves its clip or is not finite, [`throng_base::Error::OtherBundle`] as
    /// [`Characters::step`]; nothing has changed then.
    pub fn schedule_clip(&mut self, motion_set: &MotionSet, character: usize, clip: &ScheduledClip) -> Result<()> {
        self.check_bundle(motion_set)?;
        check_index("character", None, character, self.num_characters)?;
        clip.check(motion_set)?;
        let (b, lane) = (&mut self.blocks[character / LANES], character % LANES);
        let body = &mut self.bodies[character / LANES];
        self.num_choosers -= usize::from(b.segment[lane] != SCHEDULED);
        let half_life_s = self.config.half_life_s;
        if body.awake == 0 {
            wake_block(b, body, motion_set, half_life_s);
        }
        let left = b.length[lane] as f32 - b.time[lane];
        let left_s = left / motion_set.rate_hz;
        let from = b.first[lane] + b.length[lane];
        let (lift, drift) = (b.lift_at(lane, b.length[lane] as f32), b.drift_per_frame(lane));
        clip.write_to_block(b, lane, motion_set);
        let change = SegmentChange {
            character: lane as u32,
            from,
            to: clip.frame + clip.from_offset,
            age_s: b.age_s[lane] + left_s,
            lift: lift - clip.lift,
            drift: to_root(clip.root, drift - b.drift_per_frame(lane)),
        };
        b.time[lane] = clip.from_offset as f32 - left;
        if change.from != change.to || change.lift != 0.0 || change.drift != Vec3::ZERO {
            b.age_s[lane] = -left_s;
            b.set_change(lane, change.from, change.to);
            let bodies = std::slice::from_mut(body);
            dispatch(StartTransitionsJob { group: &[change], motion_set, half_life_s, bodies });
        }
        Ok(())
    }

    /// Shortens what a character plays, so that it can go on with something else. Characters that are cut with the same
    /// `left_frames` are in step afterwards: less than a frame is skipped for that. Motion with fewer frames left is
    /// not changed.
    ///
    /// - `left_frames`: remaining frames, rounded to 1/1024, so that they are exact (frames, 0 to 1).
    ///
    /// (character < num_characters)
    pub fn shorten_clip(&mut self, character: usize, left_frames: f32) {
        let (b, lane) = (&mut self.blocks[character / LANES], character % LANES);
        let left_frames = (left_frames * 1024.0).round() / 1024.0;
        let end = (b.time[lane] + left_frames).ceil().max(b.drift_from[lane] + 1.0);
        if end < b.length[lane] as f32 {
            b.length[lane] = end as u32;
            b.time[lane] = end - left_frames;
        }
    }

    /// Planar root at the end of what a character plays, unless it is bent. (character < num_characters)
    pub fn scheduled_end(&self, motion_set: &MotionSet, character: usize) -> Planar {
        self.blocks[character / LANES].root_at_end(character % LANES, motion_set)
    }

    /// Frames that a character has left of what it plays (frames, character < num_characters).
    pub fn frames_left(&self, character: usize) -> f32 {
        let (b, lane) = (&self.blocks[character / LANES], character % LANES);
        b.length[lane] as f32 - b.time[lane]
    }

    /// First frame row of what a character plays, and the time since it (frames).
    /// (character < num_characters)
    pub fn scheduled_clip(&self, character: usize) -> (u32, f32) {
        let (b, lane) = (&self.blocks[character / LANES], character % LANES);
        (b.first[lane], b.time[lane])
    }

    /// Height in the world of the ground of what a character plays; its poses contain it (m).
    /// (character < num_characters)
    pub fn ground_height(&self, character: usize) -> f32 {
        let (b, lane) = (&self.blocks[character / LANES], character % LANES);
        b.lift_at(lane, b.time[lane])
    }
}

/// A vector of the world in the frame of a planar root.
pub(super) fn to_root(root: Planar, v: Vec3) -> Vec3 {
    let local = Planar::new(0.0, 0.0, root.heading).inverse_transform_point(Vec2::new(v.x, v.z));
    Vec3::new(local.x, v.y, local.y)
}

#[cfg(test)]
mod tests;
