//! The picture of the hits of a clip or bundle, with the body at the most forceful one.

use crate::picture::{BodyFigure, HitView, Picture, hit_views};
use glam::Vec3;
use throng_core::{Bundle, Planar, Skeleton};
use throng_motion::annotate::hits::HitPoint;
use throng_motion::clip::{ClipSet, joint_transforms};

/// Width of the picture (px).
const WIDTH: u32 = 1600;

/// Effective hitting points of clips from the front, from above and from the side.
pub fn clip_hit_picture(set: &ClipSet, title: &str) -> Picture {
    let points = HitPoint::from_clip_set(set);
    let strongest = points.iter().max_by(|a, b| a.force.total_cmp(&b.force));
    let body = strongest.and_then(|h| {
        let clip = set.clips.iter().find(|c| c.name == h.clip)?;
        let (position, local) = (clip.root_positions[h.frame], clip.frame_rotations(h.frame));
        let tilt = Planar::split(position, local[0]).1;
        let local = |j: usize| if j == 0 { tilt } else { local[j] };
        Some(BodyFigure::from_transforms(&set.skeleton, &joint_transforms(&set.skeleton, Vec3::Y * position.y, local)))
    });
    draw_hits(&points, body, &set.skeleton, title)
}

/// Picture of the effective hitting points of a bundle.
pub fn bundle_hit_picture(tables: &Bundle, title: &str) -> Picture {
    let points = HitPoint::from_bundle(tables);
    let skeleton = tables.skeleton();
    let strongest = tables.hits().iter().max_by(|a, b| a.force.total_cmp(&b.force));
    let body = strongest.map(|h| {
        let (row, code) = (&tables.frames()[h.frame as usize], tables.rotation_code());
        let transforms = joint_transforms(skeleton, Vec3::Y * row.height, |j| code.rotation(row, j));
        BodyFigure::from_transforms(skeleton, &transforms)
    });
    draw_hits(&points, body, skeleton, title)
}

/// Draws hits around a body, which is at rest where none is given.
fn draw_hits(points: &[HitPoint], body: Option<BodyFigure>, skeleton: &Skeleton, title: &str) -> Picture {
    let body = body.unwrap_or_else(|| BodyFigure::from_positions(&skeleton.rest_positions()));
    hit_views(&HitView { title, points, body: Some(&body), width: WIDTH })
}
