//! Extents of bodies.

use super::track::PatchTrack;
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use throng_core::patch::LinkRecord;
use throng_geometry::BoundingBox;
use throng_motion::clip::ClipSet;

/// Extent of the body at each frame of a clip set.
pub(super) struct FrameExtents {
    /// Largest distance of a joint from the root on the ground, lowest and highest joint (m, num_frames).
    reach: Vec<[f32; 3]>,
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
        let all = all.reduce(|| BoundingBox::EMPTY, BoundingBox::union);
        // Finite numbers, even where there are no links.
        [all.min.min(Vec3::MAX), all.max.max(Vec3::MIN)].map(|corner| corner.to_array())
    }

    fn extent_of_link(&self, tracks: &[PatchTrack], link: &LinkRecord) -> BoundingBox {
        let track = &tracks[tracks.partition_point(|t| t.first_row <= link.frame) - 1];
        let first = (link.frame - track.first_row) as usize;
        let n = usize::from(link.num_frames);
        let base = link.start.planar().compose(track.places[first].inverse());
        let end = base.compose(track.places[first + n]);
        BoundingBox::around_points((0..=n).flat_map(|k| {
            let ratio = k as f32 / n as f32;
            let p = base.compose(track.places[first + k]);
            let x = p.x + ratio * (link.end.x - end.x);
            let z = p.z + ratio * (link.end.z - end.z);
            let y = link.start.y + ratio * (link.end.y - link.start.y);
            let [far, low, high] = self.reach[link.frame as usize + k];
            [Vec3::new(x - far, y + low, z - far), Vec3::new(x + far, y + high, z + far)]
        }))
    }
}
