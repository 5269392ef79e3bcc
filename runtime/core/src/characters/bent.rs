//! Bent paths: the heading of an action changes evenly over it, the linear path editing of Lee, Choi and Lee (2006),
//! section 6.
//!
//! The place at a frame, seen from the first one, is turned by half of the change of heading until then: an arc where a straight path is
//! walked evenly. It depends on nothing but the frame, and its end is where policies expect it.

use super::{block::MotionBlock, motion_set::MotionSet};
use crate::{planar::Planar, stops::PIECE_FRAMES};
use glam::Vec2;

/// Furthest that a bent path is beside the straight lines between its nodes (m).
const BESIDE_M: f32 = 0.002;

/// A place as captured, seen from the first frame, bent until a frame (m).
///
/// - `bend`: (rad/frame)
fn bend_place(captured: Vec2, bend: f32, frame: f32) -> Vec2 {
    Planar::new(0.0, 0.0, 0.5 * bend * frame).transform_point(captured)
}

/// Frames and places of a segment's bent path, relative to its first frame, which is left out (m).
///
/// - `bend`: (rad/frame)
pub(super) fn nodes(motion_set: &MotionSet, segment: u32, bend: f32) -> impl Iterator<Item = (f32, Vec2)> {
    motion_set.stops.nodes_of(segment).windows(2).flat_map(move |w| {
        let frames = w[1].frame - w[0].frame;
        let (from, to) = (Vec2::new(w[0].x, w[0].z), Vec2::new(w[1].x, w[1].z));
        // An eighth of the largest second derivative bounds the distance from a chord.
        let turn = 0.5 * bend.abs() * frames as f32;
        let beside = turn * (2.0 * from.distance(to) + turn * from.length().max(to.length())) / 8.0;
        let num = ((beside / BESIDE_M).sqrt() as u32 + 1).min(frames.div_ceil(PIECE_FRAMES));
        let step = 1.0 / num as f32;
        (1..=num).map(move |k| {
            let frame = w[0].frame as f32 + frames as f32 * step * k as f32;
            (frame, bend_place(from.lerp(to, step * k as f32), bend, frame))
        })
    })
}

/// Moves the clip of a lane so that the root is on its bent path.
pub(super) fn place_on_path(b: &mut MotionBlock, lane: usize, motion_set: &MotionSet) {
    let frame = b.time[lane].clamp(0.0, b.length[lane] as f32);
    let (first, begin) = (motion_set.planar_root(b.first[lane]), b.choice_root(lane));
    let (now, turn) = (motion_set.planar_at(b.first[lane], frame), begin.heading - first.heading);
    let [now, first] = [now, first].map(|p| Vec2::new(p.x, p.z));
    let at = Planar { heading: turn + 0.5 * b.bend[lane] * frame, ..begin }.transform_point(now - first);
    let turned = Planar::new(0.0, 0.0, turn + b.bend[lane] * frame);
    let to = at - turned.transform_point(now);
    b.set_clip_to_world(lane, Planar { x: to.x, z: to.y, ..turned });
}
