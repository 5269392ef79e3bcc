//! Who is in the crowd.

use super::Space;

/// Names a member. Stays the same while the member is in the crowd; nobody else ever has it in the same crowd.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Id {
    pub(super) index: u32,
    pub(super) generation: u32,
}

impl Id {
    /// Place in the tables of the crowd: members of [`super::Setup`] have 0, 1, 2... in their order. One who enters
    /// takes that of one who left, or the next one. [Limit: < capacity]
    pub fn index(self) -> usize {
        self.index as usize
    }
}

/// How one enters the crowd.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Member<V> {
    /// Centre. [Unit: m]
    pub position: V,
    /// At the start. [Unit: m/s] [Limit: no longer than the largest speed]
    pub velocity: V,
    /// Of the disc or ball that nobody else enters. [Unit: m] [Limit: > 0]
    pub radius: f32,
    /// Largest acceleration, A in 001 eq. 1: how fast it can speed up, turn and brake. [Unit: m/s2] [Limit: > 0]
    pub acceleration: f32,
    /// Desired speed, v_des in 001 eq. 17. [Unit: m/s] [Limit: >= 0]
    pub speed: f32,
    /// Where it goes: number in [`super::Setup::routes`].
    pub route: usize,
    /// How it feels: number in [`super::Setup::fields`].
    pub field: usize,
}

impl<V: Space> Default for Member<V> {
    /// A pedestrian of average size at the origin, at rest.
    fn default() -> Self {
        Self {
            position: V::default(),
            velocity: V::default(),
            radius: 0.3,
            acceleration: 5.0,
            speed: 1.3,
            route: 0,
            field: 0,
        }
    }
}
