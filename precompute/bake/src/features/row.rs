//! The features of one frame, laid out so that a compiler turns the distance into vector instructions.

use super::config::PreparedWeights;
use bytemuck::{Pod, Zeroable};
use glam::{Quat, Vec3};
use throng_base::maths;
use throng_core::{Joint, NUM_JOINTS};

/// Joints of a row, padded to a multiple of 8; the hips are not among them, the padding has weight 0.
pub(super) const LANES: usize = 24;
/// Joint velocities, root linear and angular velocity, root height, padded to a multiple of 8.
pub(super) const LINEAR: usize = 72;

/// Unweighted features of a frame, as [`super::extract`] measures them.
pub(super) struct FrameMeasurements<'a> {
    /// Local rotations (NUM_JOINTS).
    pub rotations: &'a [Quat],
    /// Angular velocities of the joints (rad/s, NUM_JOINTS).
    pub joint_velocities: [Vec3; NUM_JOINTS],
    /// Height of the root above the support (m).
    pub root_height: f32,
    /// Velocity of the root, in its planar frame (m/s).
    pub root_velocity: Vec3,
    /// Angular velocity of the root, in its planar frame (rad/s).
    pub root_angular_velocity: Vec3,
}

/// Features of one frame: quaternions by component, and Euclidean features times the root of their weights.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(super) struct FeatureRow {
    pub(super) x: [f32; LANES],
    pub(super) y: [f32; LANES],
    pub(super) z: [f32; LANES],
    pub(super) w: [f32; LANES],
    pub(super) linear: [f32; LINEAR],
    pub(super) root: Quat,
}

impl FeatureRow {
    pub fn new(m: &FrameMeasurements, weights: &PreparedWeights) -> Self {
        let zero = [0.0; LANES];
        let w = [1.0; LANES];
        let mut row = Self { x: zero, y: zero, z: zero, w, linear: [0.0; LINEAR], root: m.rotations[0] };
        let mut linear = Vec::with_capacity(LINEAR);
        for j in &Joint::ALL[1..] {
            let (q, lane) = (m.rotations[j.index()], j.index() - 1);
            (row.x[lane], row.y[lane], row.z[lane], row.w[lane]) = (q.x, q.y, q.z, q.w);
            let scale = (weights.joints[j.index()] * weights.joint_velocity).sqrt() as f32;
            linear.extend((m.joint_velocities[j.index()] * scale).to_array());
        }
        linear.extend((m.root_velocity * weights.linear_velocity.sqrt() as f32).to_array());
        linear.extend((m.root_angular_velocity * weights.angular_velocity.sqrt() as f32).to_array());
        linear.push(m.root_height * weights.height.sqrt() as f32);
        row.linear[..linear.len()].copy_from_slice(&linear);
        row
    }

    /// Weighted squared distance of the Euclidean features.
    pub fn squared_linear(&self, other: &Self) -> f32 {
        let mut acc = [0.0f32; 8];
        for (a, b) in self.linear.chunks_exact(8).zip(other.linear.chunks_exact(8)) {
            for l in 0..8 {
                acc[l] += (a[l] - b[l]) * (a[l] - b[l]);
            }
        }
        acc.iter().sum()
    }

    /// Weighted squared geodesic distance of the joints' rotations, the same for `q` and `-q`.
    pub fn squared_joints(&self, other: &Self, weights: &[f32; LANES]) -> f32 {
        let mut acc = [0.0f32; LANES];
        for l in 0..LANES {
            let minus = square(self.x[l] - other.x[l])
                + square(self.y[l] - other.y[l])
                + square(self.z[l] - other.z[l])
                + square(self.w[l] - other.w[l]);
            let plus = square(self.x[l] + other.x[l])
                + square(self.y[l] + other.y[l])
                + square(self.z[l] + other.z[l])
                + square(self.w[l] + other.w[l]);
            acc[l] = weights[l] * squared_angle(minus.min(plus));
        }
        acc.iter().sum()
    }

    /// Squared angle between the roots after the best rotation of either about the vertical.
    ///
    /// `exp(y t) a` with `a = q_j q_i^-1 = (w, v)` is nearest to the identity where the rotation cancels the
    /// twist of `a` about y, which leaves `2 asin(sqrt(v_x^2 + v_z^2))`.
    pub fn squared_orientation(&self, other: &Self) -> f32 {
        let a = maths::compose(other.root, self.root.conjugate());
        let half = (a.x * a.x + a.z * a.z).sqrt().atan2((a.w * a.w + a.y * a.y).sqrt());
        square(2.0 * half)
    }
}

fn square(x: f32) -> f32 {
    x * x
}

/// Squared rotation angle from the squared chord `c` between two unit quaternions of the same sign.
/// (0 <= c <= 2)
///
/// The angle is `4 asin(sqrt(c) / 2)`; its square over `c` is smooth and given by a least-squares polynomial
/// whose largest relative error is below 2e-7.
fn squared_angle(c: f32) -> f32 {
    const G: [f32; 8] = [
        1.0,
        0.083_335_73,
        0.011_086_965,
        0.001_877_167_3,
        0.000_150_606_84,
        0.000_220_111_7,
        -6.779_33e-5,
        1.991_689e-5,
    ];
    let mut g = G[7];
    for k in (0..7).rev() {
        g = g * c + G[k];
    }
    4.0 * c * g
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squared_angle_is_exact_to_single_precision() {
        for k in 0..=1000 {
            let angle = std::f64::consts::PI * f64::from(k) / 1000.0;
            let chord = 2.0 * (angle / 4.0).sin();
            let got = f64::from(squared_angle((chord * chord) as f32));
            assert!((got - angle * angle).abs() <= 1e-6 * angle * angle, "{angle}: {got}");
        }
    }
}
