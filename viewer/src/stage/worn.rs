//! The matrices of everybody who wears a mesh of the user's own.

use super::Layout;
use super::body::body_of_pose;
use crate::document::Outfit;
use crate::model::Model;
use glam::{Quat, Vec3};
use rayon::prelude::*;
use throng_runtime::{Mat3x4, NUM_JOINTS, Skeleton};

/// Legs that differ by less than this share of those of the database are theirs: a foot lock stretches legs a little.
const SAME_LEGS: f32 = 0.03;

impl Layout {
    /// Puts the mesh of the user's own on all instances, where there is one.
    pub(super) fn wear(&mut self, model: &Model) {
        let mut worn = std::mem::take(&mut self.worn);
        worn.clear();
        if let Some(outfit) = model.worn_outfit() {
            let num_frames = outfit.figure.num_frames();
            worn.resize(self.instances.len() * num_frames, Mat3x4::default());
            let (poses, instances) = (self.poses(model), worn.par_chunks_exact_mut(num_frames).enumerate());
            instances.for_each(|(i, out)| match self.dressed.get(i) {
                Some(Some(d)) => outfit.figure.wear(&d.skeleton, &d.joints, out),
                _ => put_on(outfit, &self.skeleton, &poses[i * NUM_JOINTS..][..NUM_JOINTS], out),
            });
        }
        self.worn = worn;
    }
}

fn put_on(outfit: &Outfit, database: &Skeleton, pose: &[Mat3x4], out: &mut [Mat3x4]) {
    let own = body_of_pose(database, pose);
    let is_same = (own.leg_length() / database.leg_length() - 1.0).abs() < SAME_LEGS;
    let turned: [(Vec3, Quat); NUM_JOINTS] = std::array::from_fn(|j| (pose[j].translation(), rotation(&pose[j])));
    outfit.figure.wear(if is_same { database } else { &own }, &turned, out);
}

/// How a joint is turned; its axes may be longer or shorter, as bodies of other sizes have them.
fn rotation(m: &Mat3x4) -> Quat {
    let axis = |i: usize| Vec3::from(m.rows.map(|row| row[i])).normalize_or_zero();
    Quat::from_mat3(&glam::Mat3::from_cols(axis(0), axis(1), axis(2))).normalize()
}
