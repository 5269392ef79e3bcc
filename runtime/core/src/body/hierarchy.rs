//! Transform hierarchy: from local rotations to model space, for eight characters, and on to matrices.

use super::matrix::{LocalTransform, Mat3x4};
use super::sample::LanePose;
use crate::skeleton::{Joint, NUM_JOINTS, Skeleton};
use throng_base::simd::{LANES, Lanes, Q, V};

/// Offsets of a skeleton that all lanes share, for [`to_model`] and [`write_locals`].
#[inline(always)]
pub(crate) fn shared<F: Lanes>(skeleton: &Skeleton) -> impl Fn(usize) -> V<F> {
    |j| V::splat(skeleton.offsets[j])
}

/// Parent index of every joint; the hips' own index stands for none.
pub(crate) const PARENTS: [usize; NUM_JOINTS] = {
    let mut p = [0; NUM_JOINTS];
    let mut i = 1;
    while i < NUM_JOINTS {
        p[i] = match Joint::ALL[i].parent() {
            Some(j) => j.index(),
            None => 0,
        };
        i += 1;
    }
    p
};

/// Rotation and position of every joint in model space.
pub(crate) struct ModelPose<F> {
    pub rotations: [Q<F>; NUM_JOINTS],
    pub positions: [V<F>; NUM_JOINTS],
}

impl<F: Lanes> ModelPose<F> {
    /// A pose to be filled. One that is returned filled would be copied.
    #[inline(always)]
    pub fn unposed(zero: F) -> Self {
        let (rotation, position) = (Q { v: V { x: zero, y: zero, z: zero }, w: zero }, V { x: zero, y: zero, z: zero });
        Self { rotations: [rotation; NUM_JOINTS], positions: [position; NUM_JOINTS] }
    }

    /// Applies the hierarchy; `offset` returns the position of each joint relative to its parent in rest pose.
    #[inline(always)]
    pub fn set_local(&mut self, offset: impl Fn(usize) -> V<F>, pose: &LanePose<F>) {
        (self.rotations[0], self.positions[0]) = (pose.rotations[0], pose.root);
        for j in 1..NUM_JOINTS {
            let (r, p) = (self.rotations[PARENTS[j]], self.positions[PARENTS[j]]);
            self.rotations[j] = r * pose.rotations[j];
            self.positions[j] = p + r.rotate(offset(j));
        }
    }
}

/// The pose in model space, see [`ModelPose::set_local`].
#[inline(always)]
pub(crate) fn to_model<F: Lanes>(offset: impl Fn(usize) -> V<F>, pose: &LanePose<F>) -> ModelPose<F> {
    let mut model = ModelPose::unposed(F::splat(0.0));
    model.set_local(offset, pose);
    model
}

/// Writes the matrices of the first lanes (at most LANES * NUM_JOINTS).
#[inline(always)]
pub(crate) fn write_matrices<F: Lanes>(pose: &ModelPose<F>, out: &mut [Mat3x4]) {
    // A full block, as nearly all are: where all goes is known beforehand.
    if let Some(all) = out.first_chunk_mut::<{ LANES * NUM_JOINTS }>() {
        return write_rows(pose, all);
    }
    let mut all = [Mat3x4::default(); LANES * NUM_JOINTS];
    write_rows(pose, &mut all);
    out.copy_from_slice(&all[..out.len()]);
}

/// Writes the matrices of all lanes.
#[inline(always)]
fn write_rows<F: Lanes>(pose: &ModelPose<F>, out: &mut [Mat3x4; LANES * NUM_JOINTS]) {
    for j in 0..NUM_JOINTS {
        let m = pose.rotations[j].matrix();
        let t = [pose.positions[j].x, pose.positions[j].y, pose.positions[j].z];
        for row in 0..3 {
            let rows = F::rows([m[row][0], m[row][1], m[row][2], t[row]]);
            for lane in 0..LANES {
                out[lane * NUM_JOINTS + j].rows[row] = rows[lane];
            }
        }
    }
}

/// Writes the local transforms of the first `count` lanes (count * NUM_JOINTS).
///
/// Foot locking moves joints in model space, so the local rotations are taken back from there.
#[inline(always)]
pub(crate) fn write_locals<F: Lanes>(
    offset: impl Fn(usize) -> V<F>,
    pose: &ModelPose<F>,
    count: usize,
    out: &mut [LocalTransform],
) {
    for j in 0..NUM_JOINTS {
        let parent = PARENTS[j];
        let q = if j == 0 { pose.rotations[0] } else { pose.rotations[parent].conjugate() * pose.rotations[j] };
        let rotations = F::rows([q.v.x, q.v.y, q.v.z, q.w]);
        let p = if j == 0 { pose.positions[0] } else { offset(j) };
        let positions = F::rows([p.x, p.y, p.z, F::splat(0.0)]);
        for lane in 0..count.min(LANES) {
            let [x, y, z, padding] = positions[lane];
            out[lane * NUM_JOINTS + j] = LocalTransform { rotation: rotations[lane], translation: [x, y, z], padding };
        }
    }
}
