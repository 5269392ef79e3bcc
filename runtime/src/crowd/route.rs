//! Where members go.

use serde::{Deserialize, Serialize};

/// What a member does at the end of its route.
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

/// A way through subgoals: a spline with continuous tangents (001 section 2.2, driving force).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Route<V> {
    /// Where it leads, in order; a member begins at the nearest place of the spline. A single one is a goal that is
    /// gone to straight. [Unit: m] [Size: >= 1]
    pub subgoals: Vec<V>,
    /// How near to the last subgoal is there. [Unit: m] [Limit: > 0]
    pub arrival_radius: f32,
    /// What is done then.
    pub at_end: AtEnd,
}
