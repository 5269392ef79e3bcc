//! Matrices of the characters that wear a mesh of the user's own.

use super::StageLayout;
use super::body::body_of_pose;
use crate::document::UserOutfit;
use crate::model::Model;
use glam::{Quat, Vec3};
use rayon::prelude::*;
use throng_core::{Mat3x4, NUM_JOINTS, Skeleton};

/// Share by which legs may differ from those of the database and still count as the same: a foot lock stretches legs a
/// little.
const SAME_LEGS: f32 = 0.03;

impl StageLayout {
    /// Computes the matrices of the user's mesh for all instances, if there is one.
    pub(super) fn wear(&mut self, model: &Model) {
        let mut worn = std::mem::take(&mut self.worn);
        worn.clear();
        if let Some(outfit) = model.worn_outfit() {
            let num_frames = outfit.figure.num_frames();
            worn.resize(self.instances.len() * num_frames, Mat3x4::default());
            let (poses, instances) = (self.poses(model), worn.par_chunks_exact_mut(num_frames).enumerate());
            instances.for_each(|(i, out)| match self.dressed.get(i) {
                Some(Some(d)) => outfit.figure.pose_matrices(&d.skeleton, &d.joints, out),
                _ => put_on(outfit, &self.skeleton, &poses[i * NUM_JOINTS..][..NUM_JOINTS], out),
            });
        }
        self.worn = worn;
    }
}

fn put_on(outfit: &UserOutfit, database: &Skeleton, pose: &[Mat3x4], out: &mut [Mat3x4]) {
    let own = body_of_pose(database, pose);
    let is_same = (own.leg_length() / database.leg_length() - 1.0).abs() < SAME_LEGS;
    let turned: [(Vec3, Quat); NUM_JOINTS] = std::array::from_fn(|j| (pose[j].translation(), rotation(&pose[j])));
    outfit.figure.pose_matrices(if is_same { database } else { &own }, &turned, out);
}

/// Rotation of a joint; its axes may be scaled, as in bodies of other sizes.
fn rotation(m: &Mat3x4) -> Quat {
    let axis = |i: usize| Vec3::from(m.rows.map(|row| row[i])).normalize_or_zero();
    Quat::from_mat3(&glam::Mat3::from_cols(axis(0), axis(1), axis(2))).normalize()
}
