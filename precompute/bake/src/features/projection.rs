//! Frames in a few dimensions, to recognise distant pairs at little cost.

use super::{EMBEDDING, Features};
use rayon::prelude::*;
use throng_motion::clip::FrameId;

/// Dimensions of the projection.
pub(crate) const DIMS: usize = 16;

/// Projection of a frame; the distance of two points never exceeds that of their frames.
pub(crate) type ProjectedPoint = [f32; DIMS];

/// Number of frames from which the directions are computed.
const SAMPLE: usize = 2048;
/// Iterations that compute the directions. They need not be exact: any orthonormal ones keep the bound.
const ROUNDS: usize = 8;

type ProjectionDirection = [f32; EMBEDDING];

/// Amount by which rounding may let the squared distance of points exceed that of frames.
pub(crate) const SLACK: f32 = 1e-3;

/// Projects frames on the directions of largest variance, in falling order.
///
/// - returns the points (features.num_frames()).
pub(crate) fn project(features: &Features) -> Vec<ProjectedPoint> {
    let num_frames = features.num_frames() as u32;
    let sample = (0..num_frames).step_by(features.num_frames().div_ceil(SAMPLE).max(1));
    let directions = principal_directions(sample.map(|f| features.embed(FrameId(f))).collect());
    let point = |f: u32| {
        let x = features.embed(FrameId(f));
        directions.each_ref().map(|d| dot(d, &x))
    };
    (0..num_frames).into_par_iter().map(point).collect()
}

/// Squared distance of two points.
pub(crate) fn squared_gap(a: &ProjectedPoint, b: &ProjectedPoint) -> f32 {
    let mut sums = [0.0f32; 4];
    for (a, b) in a.chunks_exact(4).zip(b.chunks_exact(4)) {
        for l in 0..4 {
            sums[l] += (a[l] - b[l]) * (a[l] - b[l]);
        }
    }
    sums.iter().sum()
}

/// Squared distance of two points if at most `limit`; the first dimensions reject most others.
pub(crate) fn squared_gap_within(a: &ProjectedPoint, b: &ProjectedPoint, limit: f32) -> Option<f32> {
    let half = |from: usize| {
        let mut sums = [0.0f32; 4];
        for d in (from..from + DIMS / 2).step_by(4) {
            for l in 0..4 {
                sums[l] += (a[d + l] - b[d + l]) * (a[d + l] - b[d + l]);
            }
        }
        sums.iter().sum::<f32>()
    };
    let first = half(0);
    if first > limit { None } else { Some(first + half(DIMS / 2)).filter(|&gap| gap <= limit) }
}

/// Largest squared distance of the points of frames at most `limit` apart.
pub(crate) fn squared_reach(limit: f32) -> f32 {
    limit * limit * (1.0 + SLACK) + 1e-7
}

/// Leading eigenvectors of the covariance, by subspace iteration.
fn principal_directions(mut sample: Vec<ProjectionDirection>) -> [ProjectionDirection; DIMS] {
    let mean: ProjectionDirection =
        std::array::from_fn(|d| sample.iter().map(|x| x[d]).sum::<f32>() / sample.len() as f32);
    for x in &mut sample {
        x.iter_mut().zip(&mean).for_each(|(x, m)| *x -= m);
    }
    let variance: ProjectionDirection = std::array::from_fn(|d| sample.iter().map(|x| x[d] * x[d]).sum());
    let mut widest: Vec<usize> = (0..EMBEDDING).collect();
    widest.sort_by(|&a, &b| variance[b].total_cmp(&variance[a]));
    let mut directions = [[0.0; EMBEDDING]; DIMS];
    directions.iter_mut().zip(widest).for_each(|(d, axis)| d[axis] = 1.0);
    for _ in 0..ROUNDS {
        directions.par_iter_mut().for_each(|d| {
            let mut turned = [0.0; EMBEDDING];
            sample.iter().for_each(|x| add(&mut turned, x, dot(d, x)));
            *d = turned;
        });
        make_orthonormal(&mut directions);
    }
    directions
}

/// Makes directions orthogonal to those before them and of unit length; a dependent one becomes zero.
fn make_orthonormal(directions: &mut [ProjectionDirection; DIMS]) {
    for k in 0..DIMS {
        let (done, rest) = directions.split_at_mut(k);
        let whole = dot(&rest[0], &rest[0]).sqrt();
        // Two passes suffice against rounding.
        for d in done.iter().chain(done.iter()) {
            let part = dot(d, &rest[0]);
            add(&mut rest[0], d, -part);
        }
        let length = dot(&rest[0], &rest[0]).sqrt();
        let scale = if length > 1e-4 * whole { 1.0 / length } else { 0.0 };
        rest[0].iter_mut().for_each(|v| *v *= scale);
    }
}

fn dot(a: &ProjectionDirection, b: &ProjectionDirection) -> f32 {
    let mut sums = [0.0f32; 8];
    let (a, b) = (a.chunks(8), b.chunks(8));
    for (a, b) in a.zip(b) {
        for (s, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *s += a * b;
        }
    }
    sums.iter().sum()
}

fn add(to: &mut ProjectionDirection, d: &ProjectionDirection, times: f32) {
    to.iter_mut().zip(d).for_each(|(t, d)| *t += times * d);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_orthonormal_and_the_widest_come_first() {
        let sample: Vec<ProjectionDirection> = (0..400)
            .map(|k| std::array::from_fn(|d| ((k * (d + 3)) as f32 * 0.7).sin() * 0.7f32.powi(d as i32)))
            .collect();
        let directions = principal_directions(sample.clone());
        let variance = |d: &ProjectionDirection| sample.iter().map(|x| dot(d, x).powi(2)).sum::<f32>();
        for (i, a) in directions.iter().enumerate() {
            for b in &directions[..i] {
                assert!(dot(a, b).abs() < 1e-5);
                assert!(variance(a) < 1.1 * variance(b));
            }
            assert!((dot(a, a) - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn frames_that_are_all_the_same_have_no_directions() {
        let directions = principal_directions(vec![[0.5; EMBEDDING]; 3]);
        assert!(directions.iter().flatten().all(|&v| v == 0.0));
    }
}
