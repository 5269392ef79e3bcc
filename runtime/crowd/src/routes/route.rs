//! Where agents go.

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// What an agent does at the end of its route.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AtEnd {
    /// Stays at the last subgoal, and comes back to it when it is pushed away.
    #[default]
    Stay,
    /// Leaves the crowd.
    Leave,
    /// Goes to the first subgoal and begins again.
    Again,
}

/// A way through subgoals: a spline with continuous tangents (Kim, Kim and Shin 2003b, section 2.2, driving force).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Route<V = Vec3> {
    /// Where it leads, in order; an agent begins at the nearest place of the spline. A single one is a goal that is
    /// gone to straight (m, >= 1).
    pub subgoals: Vec<V>,
    /// How near to the last subgoal is there (m, > 0).
    pub arrival_radius: f32,
    /// What is done then.
    pub at_end: AtEnd,
}

impl<V> Route<V> {
    /// The same in another space.
    pub fn map<W>(self, f: impl Fn(V) -> W) -> Route<W> {
        let Self { subgoals, arrival_radius, at_end } = self;
        Route { subgoals: subgoals.into_iter().map(f).collect(), arrival_radius, at_end }
    }
}
