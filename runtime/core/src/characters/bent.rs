//! Bent paths: the heading of an action changes evenly over it, the linear path editing of Lee, Choi and Lee (2006),
//! section 6.
//!
//! The path consists of short pieces, each turned by the change of heading in its middle, so that it does not depend on
//! the time steps.

use super::block::MotionBlock;
use super::motion_set::MotionSet;
use crate::planar::Planar;
use crate::stops::PIECE_FRAMES;
use glam::Vec2;

/// Piece of a bent path: its start and its turn.
#[derive(Clone, Copy, Debug)]
pub(super) struct BentPiece {
    /// First frame of the piece, and the frame after its last (frames).
    pub frames: [f32; 2],
    /// Start as captured and as bent, relative to the segment's first frame (m).
    captured: Vec2,
    pub begin: Vec2,
    /// End as bent (m).
    pub end: Vec2,
    /// (rad)
    turn: f32,
}

/// The pieces of a segment's path.
///
/// - `bend`: (rad/frame)
pub(super) fn pieces(motion_set: &MotionSet, segment: u32, bend: f32) -> impl Iterator<Item = BentPiece> {
    let mut end = Vec2::ZERO;
    let parts = motion_set.stops.nodes_of(segment).windows(2).flat_map(|w| {
        let frames = w[1].frame - w[0].frame;
        let (from, to) = (Vec2::new(w[0].x, w[0].z), Vec2::new(w[1].x, w[1].z));
        let num = frames.div_ceil(PIECE_FRAMES);
        let (offset, step, first) = ((to - from) / num as f32, frames as f32 / num as f32, w[0].frame as f32);
        (0..num).map(move |k| (first + step * k as f32, step, from + offset * k as f32, offset))
    });
    parts.map(move |(first, step, captured, offset)| {
        let (begin, turn) = (end, bend * (first + 0.5 * step));
        end += Planar::new(0.0, 0.0, turn).transform_point(offset);
        BentPiece { frames: [first, first + step], captured, begin, end, turn }
    })
}

/// Moves the clip of a lane so that the root is on its bent path.
pub(super) fn place_on_path(b: &mut MotionBlock, lane: usize, motion_set: &MotionSet) {
    let frame = b.time[lane].clamp(0.0, b.length[lane] as f32);
    let last = |p: &BentPiece| p.frames[1] >= frame;
    let all = pieces(motion_set, b.segment[lane], b.bend[lane]);
    let mut piece = None;
    for p in all {
        piece = Some(p);
        if last(&p) {
            break;
        }
    }
    let Some(piece) = piece else { return };
    let now = motion_set.planar_at(b.first[lane], frame);
    let local = motion_set.planar_root(b.first[lane]).to_local(now);
    let beside = Planar::new(0.0, 0.0, piece.turn).transform_point(Vec2::new(local.x, local.z) - piece.captured);
    let bent = Planar::new(piece.begin.x + beside.x, piece.begin.y + beside.y, local.heading + b.bend[lane] * frame);
    b.set_clip_to_world(lane, b.choice_root(lane).compose(bent).compose(now.inverse()));
}
