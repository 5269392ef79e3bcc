//! Extents of bodies.

use super::track::PatchTrack;
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use throng_core::patch::{LinkRecord, Placement};
use throng_motion::clip::ClipSet;

/// Extent of the body at each frame of a clip set.
pub(super) struct FrameExtents {
    /// Largest distance of a joint from the root on the ground, lowest and highest joint (m, num_frames).
    reach: Vec<[f32; 3]>,
}

/// A growing axis-aligned box.
#[derive(Clone, Copy)]
pub(super) struct Extent(pub [[f32; 3]; 2]);

impl Extent {
    const EMPTY: Self = Self([[f32::MAX; 3], [f32::MIN; 3]]);

    fn add(mut self, p: Vec3) -> Self {
        for (i, v) in p.to_array().into_iter().enumerate() {
            self.0[0][i] = self.0[0][i].min(v);
            self.0[1][i] = self.0[1][i].max(v);
        }
        self
    }

    fn union(self, other: Self) -> Self {
        self.add(Vec3::from_array(other.0[0])).add(Vec3::from_array(other.0[1]))
    }
}

impl FrameExtents {
    /// Measures all frames.
    pub fn new(clips: &ClipSet) -> Self {
        let of_clip = |clip: &throng_motion::Clip| -> Vec<[f32; 3]> {
            let of_frame = |f: usize| {
                let root = clip.root_positions[f];
                let joints = clip.joint_positions(&clips.skeleton, f);
                joints.iter().fold([0.0, f32::MAX, f32::MIN], |[far, low, high], p| {
                    [far.max(Vec2::new(p.x - root.x, p.z - root.z).length()), low.min(p.y), high.max(p.y)]
                })
            };
            (0..clip.num_frames()).map(of_frame).collect()
        };
        Self { reach: clips.clips.par_iter().map(of_clip).flatten().collect() }
    }

    /// Box around all joints during all links (m).
    pub fn extent_of_links(&self, tracks: &[PatchTrack], links: &[LinkRecord]) -> [[f32; 3]; 2] {
        let all = links.par_iter().map(|l| self.extent_of_link(tracks, l));
        all.reduce(|| Extent::EMPTY, Extent::union).0
    }

    fn extent_of_link(&self, tracks: &[PatchTrack], link: &LinkRecord) -> Extent {
        let track = &tracks[tracks.partition_point(|t| t.first_row <= link.frame) - 1];
        let first = (link.frame - track.first_row) as usize;
        let n = usize::from(link.num_frames);
        let base = link.start.planar().compose(track.places[first].inverse());
        let end = base.compose(track.places[first + n]);
        let frames = (0..=n).map(|k| {
            let ratio = k as f32 / n as f32;
            let p = base.compose(track.places[first + k]);
            let x = p.x + ratio * (link.end.x - end.x);
            let z = p.z + ratio * (link.end.z - end.z);
            let y = link.start.y + ratio * (link.end.y - link.start.y);
            let [far, low, high] = self.reach[link.frame as usize + k];
            (Placement::new(x, y, z, 0.0), far, low, high)
        });
        frames.fold(Extent::EMPTY, |e, (p, far, low, high)| {
            e.add(Vec3::new(p.x - far, p.y + low, p.z - far)).add(Vec3::new(p.x + far, p.y + high, p.z + far))
        })
    }
}
