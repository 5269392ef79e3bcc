//! Routes of agents.

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// Action of an agent at the end of its route.
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

/// Route through subgoals. Agents pass the line across the path at each, anywhere between the walls. Differs from Kim,
/// Kim and Shin (2003b, section 2.2, driving force), whose agents follow a spline: a crowd on one would not use the
/// width of the path.
///
/// ```
/// use throng_crowd::{AtEnd, Route};
/// use throng_base::glam::Vec3;
///
/// // There and back for ever.
/// let subgoals = vec![Vec3::new(20.0, 0.0, 0.0), Vec3::ZERO];
/// let rounds = Route { subgoals, arrival_radius: 0.5, at_end: AtEnd::Again };
/// assert_eq!(rounds.subgoals.len(), 2);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Route<V = Vec3> {
    /// Subgoals, in order; an agent begins with the first one, or on the leg of a round that it is nearest to. A single one is a goal that is reached
    /// straight, or round obstacles where the crowd knows its streets (m, >= 1).
    pub subgoals: Vec<V>,
    /// Distance from the last subgoal within which an agent has arrived (m, > 0).
    pub arrival_radius: f32,
    /// Action at the end.
    pub at_end: AtEnd,
}

impl<V> Route<V> {
    /// Converts it to another space.
    pub fn map<W>(self, f: impl Fn(V) -> W) -> Route<W> {
        let Self { subgoals, arrival_radius, at_end } = self;
        Route { subgoals: subgoals.into_iter().map(f).collect(), arrival_radius, at_end }
    }
}
