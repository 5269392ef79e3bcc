//! Blending of postures: a small matrix-vector product and an exponential map (Kim, Kim and Shin 2003a, section 4.2.3).

use super::records::{ChannelRow, NUM_CHANNELS, PADDED_JOINTS, ReferenceRow, channel};
use super::space::BlendSpace;
use crate::skeleton::Joint;
use glam::{Quat, Vec3};
use throng_base::simd::{LANES, LaneWork, Lanes, Q, V, dispatch};
use throng_base::{Result, error::check_length};

/// Vectors of a channel row.
const CHUNKS: usize = NUM_CHANNELS / LANES;
/// Vectors of one component of all joints.
const JOINT_CHUNKS: usize = PADDED_JOINTS / LANES;
/// Numbers of a channel row that are not log-displacements.
const REST: usize = NUM_CHANNELS - 3 * PADDED_JOINTS;

/// A blended posture, in the layout of the tables.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(32))]
pub struct BlendedPosture {
    /// Orientations, x, y, z, w, each joint by joint: the hips' in the facing frame, the others' relative to their
    /// parents. Unit.
    pub rotations: [[f32; PADDED_JOINTS]; 4],
    /// The channels from [`channel::HIPS`] on.
    pub channels: [f32; REST],
}

impl Default for BlendedPosture {
    /// Identity for all rotations.
    fn default() -> Self {
        let zero = [0.0; PADDED_JOINTS];
        Self { rotations: [zero, zero, zero, [1.0; PADDED_JOINTS]], channels: [0.0; REST] }
    }
}

impl BlendedPosture {
    /// Rotation of a joint: the hips' in the facing frame, another's relative to its parent.
    pub fn rotation(&self, joint: Joint) -> Quat {
        let [x, y, z, w] = self.rotations.map(|c| c[joint.index()]);
        Quat::from_xyzw(x, y, z, w)
    }

    /// Changes the rotation of a joint (unit).
    pub(crate) fn set_rotation(&mut self, joint: usize, to: Quat) {
        self.rotations.iter_mut().zip(to.to_array()).for_each(|(c, v)| c[joint] = v);
    }

    /// A channel (channel::HIPS <= channel < NUM_CHANNELS).
    pub fn channel(&self, channel: usize) -> f32 {
        self.channels[channel - channel::HIPS]
    }

    /// Three channels that follow each other (as [`Self::channel`]).
    pub fn vector(&self, channel: usize) -> Vec3 {
        Vec3::from_slice(&self.channels[channel - channel::HIPS..][..3])
    }
}

/// The rows of the posture tables around a generic time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PhaseInterval {
    /// Row at or before the time, and the row after it.
    pub rows: [usize; 2],
    /// Ratio between the two rows, 0 to 1.
    pub ratio: f32,
    /// Rows before and after those, and their shares in a posture, which are 0 on a straight line between rows.
    outer: [usize; 2],
    outer_shares: [f32; 2],
    /// Shares of the two rows in a posture.
    shares: [f32; 2],
}

/// Steps between which paths change from cubic ones through rows to straight ones from row to row: rows are about as far
/// apart as the longer (s).
const SMOOTH_S: [f32; 2] = [1.0 / 120.0, 1.0 / 60.0];

/// Share of cubic paths for a time between postures (0 to 1); none where somebody is posed again and no time passes.
pub(crate) fn smooth_share(dt_s: f32) -> f32 {
    if dt_s <= 0.0 { 0.0 } else { ((SMOOTH_S[1] - dt_s) / (SMOOTH_S[1] - SMOOTH_S[0])).clamp(0.0, 1.0) }
}

impl BlendSpace {
    /// Blends a posture for each query. Allocates nothing.
    ///
    /// - `weights`: a row each, as [`BlendSpace::weights`] gives it (phases.len() * stride).
    /// - `phases`: generic time; only the fraction counts.
    /// - `postures`: output (phases.len()).
    ///
    /// # Errors
    /// [`Error::Length`](throng_base::Error::Length) if the lengths of the slices do not match.
    pub fn blend_postures(&self, weights: &[f32], phases: &[f32], postures: &mut [BlendedPosture]) -> Result<()> {
        check_length("weights", weights.len(), phases.len() * self.stride())?;
        check_length("postures", postures.len(), phases.len())?;
        dispatch(BlendPosturesJob { space: self, weights, phases, postures });
        Ok(())
    }

    /// Locates a generic time in the posture tables.
    ///
    /// - `smooth`: share of the cubic path of Catmull and Rom in that from row to row.
    #[inline(always)]
    pub(crate) fn phase_interval(&self, phase: f32, smooth: f32) -> PhaseInterval {
        let n = self.references.len();
        let at = (phase - phase.floor()) * n as f32;
        // NaN becomes 0; a phase that rounds up to the end is at the end of the last row.
        let row = (at as usize).min(n - 1);
        let ratio = if at > row as f32 { (at - row as f32).min(1.0) } else { 0.0 };
        let next = if row + 1 == n { 0 } else { row + 1 };
        let outer = [if row == 0 { n - 1 } else { row - 1 }, if next + 1 == n { 0 } else { next + 1 }];
        let left = 1.0 - ratio;
        let outer_shares = [-0.5 * smooth * ratio * left * left, -0.5 * smooth * ratio * ratio * left];
        let [before, after] = outer_shares;
        // The tangent at a row is that from the row before it to the row after it.
        let shares = [left - 2.0 * before + after, ratio - 2.0 * after + before];
        PhaseInterval { rows: [row, next], ratio, outer, outer_shares, shares }
    }

    /// Blends one posture.
    #[inline(always)]
    pub(crate) fn blend_posture<F: Lanes>(&self, weights: &[f32], place: &PhaseInterval, out: &mut BlendedPosture) {
        let n = self.examples.len();
        let PhaseInterval { rows, shares, outer, outer_shares, .. } = *place;
        let mut sums = [F::splat(0.0); CHUNKS];
        let pairs = [(rows, shares), (outer, outer_shares)];
        let num_pairs = if outer_shares == [0.0; 2] { 1 } else { 2 };
        for (rows, shares) in &pairs[..num_pairs] {
            add_rows::<F>(rows.map(|r| &self.channels[r * n..][..n]), &weights[..n], *shares, &mut sums);
        }
        for c in 0..JOINT_CHUNKS {
            let log = V::new(sums[c], sums[JOINT_CHUNKS + c], sums[2 * JOINT_CHUNKS + c]);
            let q = (self.reference::<F>(place, c) * exp(log)).normalize();
            for (component, value) in out.rotations.iter_mut().zip([q.v.x, q.v.y, q.v.z, q.w]) {
                value.store(&mut component.as_chunks_mut().0[c]);
            }
        }
        for (chunk, value) in out.channels.as_chunks_mut().0.iter_mut().zip(&sums[3 * JOINT_CHUNKS..]) {
            value.store(chunk);
        }
    }
}

/// Adds the channel rows of all examples at two phases, weighted.
#[inline(always)]
fn add_rows<F: Lanes>([from, to]: [&[ChannelRow]; 2], weights: &[f32], [a, b]: [f32; 2], sums: &mut [F; CHUNKS]) {
    for ((from, to), &weight) in from.iter().zip(to).zip(weights) {
        if weight == 0.0 {
            continue;
        }
        let (a, b) = (F::splat(weight * a), F::splat(weight * b));
        let (from, to) = (from.values.as_chunks().0, to.values.as_chunks().0);
        for i in 0..CHUNKS {
            sums[i] = sums[i] + (F::load(&from[i]) * a + F::load(&to[i]) * b);
        }
    }
}

/// The components of the reference orientations of eight joints.
#[inline(always)]
fn components<F: Lanes>(row: &ReferenceRow, chunk: usize) -> [F; 4] {
    let mut c = [F::splat(0.0); 4];
    for i in 0..4 {
        c[i] = F::load(&row.components[i].as_chunks().0[chunk]);
    }
    c
}

impl BlendSpace {
    /// The reference orientations of eight joints at a generic time, not of unit length.
    #[inline(always)]
    fn reference<F: Lanes>(&self, place: &PhaseInterval, chunk: usize) -> Q<F> {
        let first = components::<F>(&self.references[place.rows[0]], chunk);
        let keep = F::splat(place.shares[0]);
        let mut a = [first[0] * keep, first[1] * keep, first[2] * keep, first[3] * keep];
        let rest = [
            (place.rows[1], place.shares[1]),
            (place.outer[0], place.outer_shares[0]),
            (place.outer[1], place.outer_shares[1]),
        ];
        for (row, share) in rest {
            if share == 0.0 {
                continue;
            }
            let b = components::<F>(&self.references[row], chunk);
            let dot = first[0] * b[0] + first[1] * b[1] + first[2] * b[2] + first[3] * b[3];
            // The nearer of the two quaternions that represent the same orientation.
            let share = F::splat(share);
            let share = F::select_lt(dot, F::splat(0.0), -share, share);
            for i in 0..4 {
                a[i] = a[i] + b[i] * share;
            }
        }
        Q::new(V::new(a[0], a[1], a[2]), a[3])
    }
}

/// Largest squared length of a log-displacement, which is pi: a full turn.
const MAX_LOG_2: f32 = std::f32::consts::PI * std::f32::consts::PI;

/// The unit quaternion that turns by 2 |v| about v (|v| <= pi, the direction alone matters beyond).
#[inline(always)]
pub(crate) fn exp<F: Lanes>(v: V<F>) -> Q<F> {
    let x = v.dot(v).min(F::splat(MAX_LOG_2));
    // Taylor series in the square, which needs neither root nor quotient.
    Q::new(v * series(&SINC, x), series(&COS, x))
}

/// A polynomial.
#[inline(always)]
fn series<F: Lanes>(coefficients: &[f32; TERMS], x: F) -> F {
    let mut p = F::splat(coefficients[TERMS - 1]);
    for i in (0..TERMS - 1).rev() {
        p = p * x + F::splat(coefficients[i]);
    }
    p
}

/// Terms of the series, which leave errors below 1e-6.
const TERMS: usize = 9;
/// Coefficients of sin(r) / r in r^2.
const SINC: [f32; TERMS] = taylor(1);
/// Coefficients of cos(r) in r^2.
const COS: [f32; TERMS] = taylor(0);

/// `(-1)^i / (2 i + odd)!`
const fn taylor(odd: usize) -> [f32; TERMS] {
    let mut c = [1.0; TERMS];
    let mut exact = 1.0f64;
    let mut i = 1;
    while i < TERMS {
        let k = 2 * i + odd;
        exact /= -((k * (k - 1)) as f64);
        c[i] = exact as f32;
        i += 1;
    }
    c
}

struct BlendPosturesJob<'a> {
    space: &'a BlendSpace,
    weights: &'a [f32],
    phases: &'a [f32],
    postures: &'a mut [BlendedPosture],
}

impl LaneWork for BlendPosturesJob<'_> {
    type Output = ();

    #[inline(always)]
    fn run<F: Lanes>(self) {
        let rows = self.weights.chunks_exact(self.space.stride());
        for ((weights, &phase), posture) in rows.zip(self.phases).zip(self.postures) {
            self.space.blend_posture::<F>(weights, &self.space.phase_interval(phase, 0.0), posture);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use throng_base::simd::ArrayLanes;

    proptest! {
        #[test]
        fn exponential_agrees_with_glam(v in prop::array::uniform3(-1.8f32..1.8)) {
            let v = Vec3::from_array(v);
            let q = exp(V::<ArrayLanes>::splat(v));
            let got = Quat::from_xyzw(q.v.x.to_array()[0], q.v.y.to_array()[1], q.v.z.to_array()[2], q.w.to_array()[3]);
            prop_assert!(got.abs_diff_eq(Quat::from_scaled_axis(2.0 * v), 4e-6), "{got} {}", v.length());
        }
    }
}
