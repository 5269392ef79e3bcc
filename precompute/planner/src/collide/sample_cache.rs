//! Cache of collision samples of a part and a mesh: the free distance around the part, and the triangle that was near. Results
//! are the same with and without it, but mostly cost one distance in place of a search.

use crate::problem::Problem;
use glam::DVec3;
use throng_geometry::{Segment, TriangleMesh};

/// Number of time intervals of a problem; one sample is cached for each of them.
const STRETCHES: usize = 64;

/// A cached collision sample of a part and a mesh.
#[derive(Clone, Copy, Debug)]
struct CachedSample {
    /// The part's core in the mesh's frame (m).
    core: Segment,
    /// Lower bound of the distance from the core to the mesh (m).
    free_m: f64,
    /// Triangle that was near last.
    near: u32,
}

const NEVER: CachedSample =
    CachedSample { core: Segment { a: DVec3::ZERO, b: DVec3::ZERO }, free_m: f64::NEG_INFINITY, near: u32::MAX };

/// Cached samples by mesh, part and time interval.
#[derive(Clone, Debug, Default)]
pub(super) struct SampleCache {
    /// Number of the problem that the samples belong to.
    pub problem_number: u64,
    samples: Vec<CachedSample>,
}

impl SampleCache {
    /// Forgets all samples, and makes room for a problem.
    pub fn prepare(&mut self, problem: &Problem) {
        self.problem_number = problem.number;
        self.samples.clear();
        self.samples.resize(problem.solids.len() * problem.parts.len() * STRETCHES, NEVER);
    }

    /// Number of the sample for a part and a solid at a time of the problem.
    pub fn slot(&self, problem: &Problem, solid: usize, part: usize, time_s: f64) -> usize {
        let share = (time_s - problem.init.time_s) / (problem.goal.time_s - problem.init.time_s);
        let stretch = ((share * STRETCHES as f64) as usize).min(STRETCHES - 1);
        (solid * problem.parts.len() + part) * STRETCHES + stretch
    }

    /// True where a core, in the frame of the mesh, is nearer than `limit` (m).
    ///
    /// - `slot`: number of the sample; see [`SampleCache::slot`].
    /// - `whole`: false tests only the triangle that was near last; a result of `false` then proves nothing.
    pub fn is_nearer(&mut self, slot: usize, mesh: &TriangleMesh, core: &Segment, limit: f64, whole: bool) -> bool {
        let sample = &mut self.samples[slot];
        // No point of a segment moves farther than its ends.
        let moved = sample.core.a.distance(core.a).max(sample.core.b.distance(core.b));
        let free_m = sample.free_m - moved;
        if free_m >= limit {
            return false;
        }
        let is_nearer = mesh.is_triangle_nearer(sample.near, core, limit);
        if is_nearer || !whole {
            return is_nearer;
        }
        let found = mesh.first_nearer(core, limit);
        match found {
            Some(near) => sample.near = near,
            None => (sample.core, sample.free_m) = (*core, limit),
        }
        found.is_some()
    }
}
