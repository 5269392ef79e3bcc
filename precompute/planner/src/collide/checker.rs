//! Collision samples: one pose of a limb at one time, against everything around it.

use crate::linkage::{LIMB_JOINTS, LimbPose};
use crate::problem::{CollisionHit, CollisionPair, CollisionTarget, LimbState, Problem};
use crate::rotation::Rigid;
use glam::DVec3;
use throng_base::maths;
use throng_geometry::{Segment, SolidShape, TriangleMesh};

/// Tolerated excess of limits on an edge between two poses that are within them (rad).
pub(super) const LIMIT_TOLERANCE: f64 = 1e-3;

/// Checks linkages for collisions. Buffers are kept from sample to sample, so that nothing is allocated after the first ones.
#[derive(Clone, Debug, Default)]
pub struct Checker {
    /// Number of collision samples so far: one pose at one time against everything.
    pub checks: u64,
    /// World cores of the parts, and their midpoints.
    cores: Vec<(Segment, DVec3)>,
    /// World cores of driven bodies and their midpoints, with the number of the sample for which they were computed.
    bodies: Vec<(u64, Segment, DVec3)>,
    solids: Vec<(u64, Rigid)>,
    /// Cached results of earlier samples, by part and mesh.
    sample_cache: SampleCache,
    /// Intervals still to be proved, breadth first, and the pairs that are open in each.
    pub(super) intervals: Vec<super::edge::EdgeInterval>,
    pub(super) open: Vec<u16>,
    /// Bound on the travel of each part on half a piece (m).
    pub(super) travels: Vec<f64>,
}

impl Checker {
    /// Makes room for a problem.
    pub(crate) fn prepare(&mut self, problem: &Problem) {
        let nowhere = Segment::new(DVec3::ZERO, DVec3::ZERO);
        self.cores.resize(problem.parts.len(), (nowhere, DVec3::ZERO));
        self.bodies.clear();
        self.bodies.resize(problem.bodies.len(), (0, nowhere, DVec3::ZERO));
        self.solids.clear();
        self.solids.resize(problem.solids.len(), (0, Rigid::IDENTITY));
        self.sample_cache.prepare(problem);
    }

    /// Computes where the parts of the limb are for a pose at a time.
    pub(super) fn place_parts(&mut self, problem: &Problem, pose: &LimbPose, time_s: f64) {
        self.checks += 1;
        let placed = problem.chain.place_joints(&problem.base.sample_at(time_s), pose);
        for (core, part) in self.cores.iter_mut().zip(&problem.parts) {
            let placed = part.core.map(|p| placed[part.link].transform_point(p));
            *core = (placed, placed.middle());
        }
    }

    /// Distance between the surfaces of a pair where it is below `limit`, else infinite; needs [`Checker::place_parts`] first (m).
    pub(super) fn pair_gap(&mut self, problem: &Problem, pair: &CollisionPair, time_s: f64, limit: f64) -> f64 {
        let part = &problem.parts[pair.part];
        let (core, middle) = self.cores[pair.part];
        let gap = match pair.target {
            CollisionTarget::Body(b) => {
                let (body, kept) = (&problem.bodies[b], &mut self.bodies[b]);
                if kept.0 != self.checks {
                    let core = body.track.sample_at(time_s);
                    *kept = (self.checks, core, core.middle());
                }
                let (_, other, other_middle) = *kept;
                let radii = part.radius + body.radius;
                // The bounding balls are mostly farther apart than that.
                let apart = middle.distance_squared(other_middle);
                let far = limit + radii + part.half_length + body.half_length;
                if far <= 0.0 || apart >= far * far { f64::INFINITY } else { core.distance(&other) - radii }
            }
            CollisionTarget::Tether => problem.tether.as_ref().map_or(f64::INFINITY, |tether| {
                let [nearest, farthest] = tether.distances_m;
                let apart = middle.distance(tether.from.sample_at(time_s).position);
                (farthest - apart).min(apart - nearest)
            }),
            CollisionTarget::Upright => problem.upright.map_or(f64::INFINITY, |level| {
                let up = core.b - core.a;
                level.within_rad - maths::atan2(maths::hypot(up.x, up.z), up.y)
            }),
            CollisionTarget::Solid(s) => {
                let local = self.core_in_reach(problem, s, pair.part, time_s, limit);
                let distance = |core| problem.solids[s].solid.shape.distance(&core, limit + part.radius) - part.radius;
                return local.map_or(f64::INFINITY, distance);
            }
        };
        if gap < limit { gap } else { f64::INFINITY }
    }

    /// True where the surfaces of a pair are nearer than `limit`; needs `place_parts` first (m).
    ///
    /// - `whole`: false tests only the mesh triangle that was near last; a result of `false` then proves nothing.
    pub fn is_nearer(&mut self, problem: &Problem, pair: &CollisionPair, time_s: f64, limit: f64, whole: bool) -> bool {
        let CollisionTarget::Solid(s) = pair.target else { return self.pair_gap(problem, pair, time_s, limit) < limit };
        let radius = problem.parts[pair.part].radius;
        let Some(local) = self.core_in_reach(problem, s, pair.part, time_s, limit) else { return false };
        match &problem.solids[s].solid.shape {
            SolidShape::Mesh(mesh) => {
                let slot = self.sample_cache.slot(problem, s, pair.part, time_s);
                self.sample_cache.is_nearer(slot, mesh, &local, limit + radius, whole)
            }
            shape => shape.is_nearer(&local, limit + radius),
        }
    }

    /// Core of a part in the frame of a solid, `None` where the bounding balls are too far apart.
    fn core_in_reach(&mut self, problem: &Problem, s: usize, part: usize, time_s: f64, limit: f64) -> Option<Segment> {
        let (core, middle) = self.cores[part];
        let (part, solid, kept) = (&problem.parts[part], &problem.solids[s], &mut self.solids[s]);
        if kept.0 != self.checks {
            *kept = (self.checks, solid.solid.path.place_at(time_s));
        }
        let place = kept.1;
        let far = limit + part.radius + solid.radius + part.half_length;
        let apart = middle.distance_squared(place.transform_point(solid.middle));
        (far > 0.0 && apart < far * far).then(|| core.map(|p| place.local_point(p)))
    }

    /// True where nothing is too near at a state, and limits hold.
    pub fn is_free(&mut self, problem: &Problem, state: &LimbState) -> bool {
        self.prepare_if_other(problem);
        let within = |i: usize| problem.limits[i].excess(state.pose.0[i]) <= LIMIT_TOLERANCE;
        if !(0..LIMB_JOINTS).all(within) {
            return false;
        }
        self.place_parts(problem, &state.pose, state.time_s);
        let mut open = problem.pairs.iter().filter(|p| !p.may_touch_at(state.time_s));
        !open.any(|pair| self.is_nearer(problem, pair, state.time_s, pair.gap, true))
    }

    /// The pair whose penetration is deepest.
    pub fn deepest_hit(&mut self, problem: &Problem, state: &LimbState) -> Option<CollisionHit> {
        self.prepare_if_other(problem);
        self.place_parts(problem, &state.pose, state.time_s);
        let mut worst: Option<CollisionHit> = None;
        for (p, pair) in problem.pairs.iter().enumerate().filter(|(_, pair)| !pair.may_touch_at(state.time_s)) {
            let depth_m = pair.gap - self.pair_gap(problem, pair, state.time_s, pair.gap);
            if depth_m > 0.0 && worst.is_none_or(|w| depth_m > w.depth_m) {
                worst = Some(CollisionHit { pair: p, depth_m });
            }
        }
        worst
    }

    /// Least distance from solids and other characters that may not be touched, if it is below `limit` (m).
    pub fn clearance(&mut self, problem: &Problem, state: &LimbState, limit: f64) -> f64 {
        self.prepare_if_other(problem);
        self.place_parts(problem, &state.pose, state.time_s);
        let own = |target| match target {
            CollisionTarget::Body(b) => problem.bodies[b].character.is_none(),
            CollisionTarget::Tether | CollisionTarget::Upright => true,
            CollisionTarget::Solid(_) => false,
        };
        let open = problem.pairs.iter().filter(|p| !own(p.target) && !p.may_touch_at(state.time_s));
        open.fold(limit, |least, pair| least.min(self.pair_gap(problem, pair, state.time_s, least)))
    }

    /// Prepares anew where the problem is another one than before.
    pub(super) fn prepare_if_other(&mut self, problem: &Problem) {
        if self.sample_cache.problem_number != problem.number {
            self.prepare(problem);
        }
    }
}

impl CollisionPair {
    /// True where they may touch at a time.
    pub(super) fn may_touch_at(&self, time_s: f64) -> bool {
        self.allowed.is_some_and(|[from, to]| (from..=to).contains(&time_s))
    }
}

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

/// Cached samples by mesh, part and time interval: the free distance around the part, and the triangle that was near.
///
/// Results are the same with and without it, but mostly cost one distance in place of a search.
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
