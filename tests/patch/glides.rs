//! Clips of a body that keeps its pose while its root glides along.

use glam::Quat;
use throng_core::{Contacts, NUM_JOINTS, Planar, Skeleton};
use throng_precompute::clip::FrameId;
use throng_precompute::cluster::PoseGroups;
use throng_precompute::{Clip, ClipSet};

pub const NO_GROUP: u32 = PoseGroups::NO_GROUP;

/// How the root glides.
#[derive(Clone, Copy, Debug)]
pub struct Glide {
    pub start: Planar,
    pub frames: usize,
    pub speed_mps: f32,
    pub turning_radps: f32,
}

impl Default for Glide {
    fn default() -> Self {
        Self { start: Planar::IDENTITY, frames: 100, speed_mps: 1.0, turning_radps: 0.0 }
    }
}

impl Glide {
    /// The clip, 30 frames a second.
    pub fn clip(&self, name: &str) -> Clip {
        let step = Planar::new(0.0, self.speed_mps / 30.0, self.turning_radps / 30.0);
        let mut at = self.start;
        let mut places = Vec::with_capacity(self.frames);
        for _ in 0..self.frames {
            places.push(at);
            at = at.compose(step);
        }
        clip_of(name, &places)
    }
}

/// A clip whose root is at the given places.
pub fn clip_of(name: &str, places: &[Planar]) -> Clip {
    let upright = |p: &Planar| std::iter::once(p.rotation()).chain(std::iter::repeat_n(Quat::IDENTITY, NUM_JOINTS - 1));
    Clip {
        source: "made up".into(),
        contacts: vec![Contacts::NONE; places.len()],
        ..Clip::new(
            name,
            30.0,
            places.iter().map(|p| p.translation() + glam::Vec3::Y * 0.95).collect(),
            places.iter().flat_map(upright).collect(),
        )
    }
}

/// A set of clips on the default skeleton.
pub fn set_of(clips: Vec<Clip>) -> ClipSet {
    ClipSet { skeleton: Skeleton::default(), clips }
}

/// Pose groups by clip and frame.
pub fn groups_of(clips: &ClipSet, group: impl Fn(usize, usize) -> u32) -> PoseGroups {
    let of_clip = |(c, clip): (usize, &Clip)| (0..clip.num_frames()).map(|f| group(c, f)).collect::<Vec<_>>();
    let groups: Vec<u32> = clips.clips.iter().enumerate().flat_map(of_clip).collect();
    let num = groups.iter().filter(|g| **g != NO_GROUP).max().map_or(0, |g| g + 1);
    let first = |g: u32| FrameId(groups.iter().position(|&x| x == g).unwrap_or(0) as u32);
    PoseGroups { medoids: (0..num).map(first).collect(), max_diameter: 0.0, threshold: 0.3, groups }
}
