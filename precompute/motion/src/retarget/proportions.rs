//! Proportions: the database skeleton with a source's own segment lengths.

use super::align::Alignment;
use super::body::{SourceBody, anchor};
use glam::Vec3;
use throng_core::{Joint, NUM_JOINTS, Skeleton};

/// The source's proportions on the database topology.
///
/// Joints that are not in the source lie between their neighbours that are (spine, clavicle, neck), or where the default
/// skeleton scaled by leg length has them (hand, toe, head).
pub fn source_skeleton(body: &SourceBody, a: &Alignment) -> Skeleton {
    let default = Skeleton::default();
    let scale = body.leg_length() / default.leg_length();
    let present = |j: Joint| a[anchor(&body.roles, j).index()].inverse() * body.offsets[j.index()];
    // Positions in the axes of each joint's anchor.
    let mut relative = [Vec3::ZERO; NUM_JOINTS];
    let mut offsets = [Vec3::ZERO; NUM_JOINTS];
    for &j in &Joint::ALL[1..] {
        let Some(parent) = j.parent() else { continue };
        let base = if body.has(parent) { Vec3::ZERO } else { relative[parent.index()] };
        relative[j.index()] = match (body.has(j), next_present(body, j)) {
            (true, _) => present(j),
            (false, Some(next)) => present(next) * share_along(&default, anchor(&body.roles, j), j, next),
            (false, None) => base + default.offsets[j.index()] * scale,
        };
        offsets[j.index()] = relative[j.index()] - base;
    }
    let tip = |i: usize, j: Joint| body.tips[i].map_or_else(|| default.tips[i] * scale, |t| a[j.index()].inverse() * t);
    let tips = [tip(0, Joint::Head), tip(1, Joint::LeftToe), tip(2, Joint::RightToe)];
    let mut skeleton = Skeleton { offsets, tips };
    // Both feet stand: the toe joints are as high above their soles as the default skeleton's, on average.
    let toe_height = default.rest_positions()[Joint::LeftToe.index()].y * scale;
    let p = skeleton.rest_positions();
    let height = toe_height - 0.5 * (p[Joint::LeftToe.index()].y + p[Joint::RightToe.index()].y);
    skeleton.offsets[0] = Vec3::new(0.0, height, 0.0);
    skeleton
}

/// The first descendant the source has.
fn next_present(body: &SourceBody, j: Joint) -> Option<Joint> {
    let descends = |d: Joint| std::iter::successors(d.parent(), |p| p.parent()).any(|p| p == j);
    Joint::ALL.into_iter().find(|&d| d > j && body.has(d) && descends(d))
}

/// Position of `j` along the way from `start` to `end` in the default skeleton (0 to 1).
fn share_along(default: &Skeleton, start: Joint, j: Joint, end: Joint) -> f32 {
    let way = |to: Joint| {
        let up = std::iter::successors(Some(to), |j| j.parent()).take_while(|j| *j != start);
        up.fold(0.0, |length, j| length + default.offsets[j.index()].length())
    };
    way(j) / way(end)
}
