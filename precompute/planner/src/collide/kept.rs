//! What earlier looks say of a part and a mesh: how far around a place there is nothing, and which triangle was near. Answers are
//! the same with it and without, but mostly cost one distance in place of a search.

use crate::problem::Problem;
use crate::shape::{Mesh, Segment};
use glam::DVec3;

/// Stretches of a problem's time of each of which one look is kept.
const STRETCHES: usize = 64;

/// A look at a part and a mesh.
#[derive(Clone, Copy, Debug)]
struct Look {
    /// The part's core in the mesh's frame (m).
    core: Segment,
    /// Nothing is nearer to it than this (m).
    free_m: f64,
    /// The triangle that was near last.
    near: u32,
}

const NEVER: Look =
    Look { core: Segment { a: DVec3::ZERO, b: DVec3::ZERO }, free_m: f64::NEG_INFINITY, near: u32::MAX };

/// Looks by mesh, part and stretch of time.
#[derive(Clone, Debug, Default)]
pub(super) struct Kept {
    /// Of which problem.
    number: u64,
    looks: Vec<Look>,
}

impl Kept {
    pub fn is_of(&self, problem: &Problem) -> bool {
        self.number == problem.number
    }

    /// Forgets everything.
    pub fn prepare(&mut self, problem: &Problem) {
        self.number = problem.number;
        self.looks.clear();
        self.looks.resize(problem.solids.len() * problem.parts.len() * STRETCHES, NEVER);
    }

    /// True where a core, in the frame of the mesh, is nearer than `limit` (m).
    ///
    /// - `whole`: false asks the triangle alone that was near last; its `false` says nothing.
    pub fn is_nearer(
        &mut self,
        problem: &Problem,
        (solid, part): (usize, usize),
        time_s: f64,
        mesh: &Mesh,
        core: &Segment,
        (limit, whole): (f64, bool),
    ) -> bool {
        let share = (time_s - problem.init.time_s) / (problem.goal.time_s - problem.init.time_s);
        let stretch = ((share * STRETCHES as f64) as usize).min(STRETCHES - 1);
        let look = &mut self.looks[(solid * problem.parts.len() + part) * STRETCHES + stretch];
        // No point of a segment moves farther than its ends.
        let moved = look.core.a.distance(core.a).max(look.core.b.distance(core.b));
        let free_m = look.free_m - moved;
        if free_m >= limit {
            return false;
        }
        if mesh.is_triangle_nearer(look.near, core, limit) {
            return true;
        }
        if !whole {
            return false;
        }
        match mesh.first_nearer(core, limit) {
            Some(near) => {
                look.near = near;
                true
            }
            None => {
                (look.core, look.free_m) = (*core, limit);
                false
            }
        }
    }
}
