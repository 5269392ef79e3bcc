//! Distance of two frames: the six features of Lee, Choi and Lee (2006), section 3.
//!
//! Joint angles, root height, root orientation, and the velocities of joints and root are weighted, squared and summed.
//! The distance is unaffected by moving or turning a clip on the ground.

mod config;
pub(crate) mod projection;
mod row;
#[cfg(test)]
mod tests;

pub use config::FeaturesConfig;

use crate::share::{clip_owners, sort_by_owner};
use config::PreparedWeights;
use glam::{Mat3, Quat, Vec3};
use rayon::prelude::*;
use row::{FeatureRow, FrameMeasurements, LANES, LINEAR};
use serde::{Deserialize, Serialize};
use throng_base::{Comm, maths};
use throng_core::{NUM_JOINTS, Planar};
use throng_motion::clip::{Clip, ClipSet, FrameId, FrameRange};
use throng_motion::error::Result;

/// The features of every frame of a [`ClipSet`], excluded frames included, or of some of them.
///
/// A [`FrameId`] is the index of a frame among the measured ones.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Features {
    rows: Vec<FeatureRow>,
    joint_weights: [f32; LANES],
    orientation_weight: f32,
}

/// Measures the features of every frame.
///
/// - `clips`: resampled; each clip's own rate makes its velocities.
/// - returns a row for every [`FrameId`].
///
/// Velocities are differences between the next and the previous frame, and one-sided where a clip or a run of
/// usable frames begins or ends, so that a calibration pose next door does not count. The root's height is the one
/// above what holds the character up ([`Clip::support`]); its velocity is the one in the world.
///
/// # Errors
/// [`throng_motion::error::BuildError::Config`] for a weight out of range or an unknown joint.
///
/// # Source
/// Lee, Choi and Lee 2006, section 3. Differs: angles are full rotation angles, twice the norm of the
/// quaternion logarithm, and velocities are per second instead of per frame; the weights take up both.
pub fn extract(clips: &ClipSet, config: &FeaturesConfig) -> Result<Features> {
    let weights = config.weights()?;
    let of_clip = |c: &Clip| rows(c, 0..c.num_frames(), &weights);
    let rows = clips.clips.par_iter().map(of_clip).flatten().collect();
    Ok(Features::new(rows, &weights))
}

/// Measures the features of some frames only; see [`extract`].
///
/// - `frames`: ascending.
///
/// # Errors
/// As [`extract`].
///
/// - `comm`: processes that hold the other poses.
pub(crate) fn extract_at(
    clips: &ClipSet,
    frames: &[FrameId],
    config: &FeaturesConfig,
    comm: &dyn Comm,
) -> Result<Features> {
    let weights = config.weights()?;
    let starts = clips.frame_starts();
    let of_clip = |c: usize| {
        let (clip, start) = (&clips.clips[c], starts[c]);
        let place = |frame: u32| frames.partition_point(|f| f.0 < frame);
        let within = &frames[place(start)..place(start + clip.num_frames() as u32)];
        FeatureRows(rows(clip, within.iter().map(|f| (f.0 - start) as usize), &weights))
    };
    let rows = sort_by_owner(comm, &clip_owners(clips, comm.num_ranks()), of_clip)?;
    Ok(Features::new(rows.into_iter().flat_map(|rows: FeatureRows| rows.0).collect(), &weights))
}

/// Feature rows, serialized between ranks.
#[derive(Serialize, Deserialize)]
struct FeatureRows(#[serde(with = "throng_motion::pod")] Vec<FeatureRow>);

impl Features {
    fn new(rows: Vec<FeatureRow>, weights: &PreparedWeights) -> Self {
        let mut joint_weights = [0.0; LANES];
        for j in 1..NUM_JOINTS {
            joint_weights[j - 1] = weights.joints[j] as f32;
        }
        Self { rows, joint_weights, orientation_weight: weights.orientation as f32 }
    }

    /// The features of some frames.
    pub(crate) fn select(&self, frames: &[usize]) -> Self {
        Self { rows: frames.iter().map(|&f| self.rows[f]).collect(), ..*self }
    }

    /// Number of frames.
    pub fn num_frames(&self) -> usize {
        self.rows.len()
    }

    /// Distance between two frames (rad, as [`FeaturesConfig`] explains).
    pub fn distance(&self, i: FrameId, j: FrameId) -> f32 {
        self.squared_distance(i, j).sqrt()
    }

    /// Square of [`distance`](Self::distance); the same for `(j, i)`, bit for bit.
    pub fn squared_distance(&self, i: FrameId, j: FrameId) -> f32 {
        let (a, b) = (&self.rows[i.0 as usize], &self.rows[j.0 as usize]);
        a.squared_linear(b)
            + self.orientation_weight * a.squared_orientation(b)
            + a.squared_joints(b, &self.joint_weights)
    }

    /// Squared distance if at most `limit`; the velocities alone reject most unlike frames.
    pub fn squared_distance_within(&self, i: FrameId, j: FrameId, limit: f32) -> Option<f32> {
        let (a, b) = (&self.rows[i.0 as usize], &self.rows[j.0 as usize]);
        if a.squared_linear(b) > limit { None } else { Some(self.squared_distance(i, j)).filter(|&d| d <= limit) }
    }
}

/// - `frames`: ascending.
fn rows(clip: &Clip, frames: impl Iterator<Item = usize>, weights: &PreparedWeights) -> Vec<FeatureRow> {
    let runs = contiguous_runs(clip);
    let run_of = |f: usize| &runs[runs.partition_point(|run| run.end <= f)];
    frames.map(|f| FeatureRow::new(&measure(clip, run_of(f), f), weights)).collect()
}

/// All frames, as runs that are either usable or excluded, in order.
fn contiguous_runs(clip: &Clip) -> Vec<FrameRange> {
    let mut cuts = vec![0, clip.num_frames()];
    cuts.extend(clip.usable_ranges().iter().flat_map(|r| [r.start, r.end]));
    cuts.sort_unstable();
    cuts.dedup();
    cuts.windows(2).map(|w| w[0]..w[1]).collect()
}

fn measure<'a>(clip: &'a Clip, run: &FrameRange, frame: usize) -> FrameMeasurements<'a> {
    let prev = frame.saturating_sub(1).max(run.start);
    let next = (frame + 1).min(run.end - 1);
    let per_second = if next > prev { (clip.rate_hz / (next - prev) as f64) as f32 } else { 0.0 };
    let (before, after) = (clip.frame_rotations(prev), clip.frame_rotations(next));
    let mut joint_velocities = [Vec3::ZERO; NUM_JOINTS];
    for j in 1..NUM_JOINTS {
        joint_velocities[j] = rotation_vector(maths::compose(before[j].conjugate(), after[j])) * per_second;
    }
    let rotations = clip.frame_rotations(frame);
    let to_local = Planar::split(clip.root_positions[frame], rotations[0]).0.rotation().conjugate();
    FrameMeasurements {
        rotations,
        joint_velocities,
        root_height: clip.root_positions[frame].y - clip.support.get(frame).copied().unwrap_or(0.0),
        root_velocity: to_local * ((clip.root_positions[next] - clip.root_positions[prev]) * per_second),
        root_angular_velocity: to_local
            * (rotation_vector(maths::compose(after[0], before[0].conjugate())) * per_second),
    }
}

/// Axis times angle of the shorter rotation (rad).
fn rotation_vector(q: Quat) -> Vec3 {
    let v = Vec3::new(q.x, q.y, q.z) * if q.w < 0.0 { -1.0 } else { 1.0 };
    let sine = v.length();
    if sine < 1e-9 { v * 2.0 } else { v * (2.0 * sine.atan2(q.w.abs()) / sine) }
}

/// Dimensions of the embedding: a rotation matrix a joint, the Euclidean features, the vertical in the root's frame.
const EMBEDDING: usize = 9 * (NUM_JOINTS - 1) + LINEAR + 3;

impl Features {
    /// The point of a frame.
    ///
    /// Rotations count as the chord `2 sin(a / 2)` instead of the angle `a`: of rotation matrices for the joints,
    /// which do not tell `q` from `-q`, and of the vertical in the root's frame, which a turn about it leaves alone.
    fn embed(&self, frame: FrameId) -> [f32; EMBEDDING] {
        let row = &self.rows[frame.0 as usize];
        let mut out = [0.0; EMBEDDING];
        let (joints, rest) = out.split_at_mut(9 * (NUM_JOINTS - 1));
        for (j, place) in joints.chunks_exact_mut(9).enumerate() {
            let matrix = Mat3::from_quat(Quat::from_xyzw(row.x[j], row.y[j], row.z[j], row.w[j]));
            // The entries of two matrices an angle `a` apart differ by sqrt(8) sin(a / 2).
            place.copy_from_slice(&(matrix * (0.5 * self.joint_weights[j]).sqrt()).to_cols_array());
        }
        rest[..LINEAR].copy_from_slice(&row.linear);
        let vertical = row.root.conjugate() * Vec3::Y * self.orientation_weight.sqrt();
        rest[LINEAR..].copy_from_slice(&vertical.to_array());
        out
    }
}
