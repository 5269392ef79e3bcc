//! Settings, goals and activities of inhabitants.

use crate::{RestPlace, WorldNode};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use throng_base::limits::{CAPACITY, PATH_STEPS};
use throng_base::{Result, error::check_value};
use throng_core::characters::CharactersConfig;

/// Settings of inhabitants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InhabitantsConfig {
    /// Settings of their motion, whose seed is also that of random paths.
    pub characters: CharactersConfig,
    /// Time that a character waits for a reserved place before it makes a detour (s, > 0).
    pub patience_s: f32,
    /// Most paths that are planned in one step; further requests wait for the next one (> 0).
    pub plans_per_step: usize,
    /// Steps of a planned path that are kept; the rest is planned again on the way (8 to 65536).
    pub max_path: usize,
}

impl Default for InhabitantsConfig {
    fn default() -> Self {
        Self { characters: CharactersConfig::default(), patience_s: 4.0, plans_per_step: 4, max_path: 256 }
    }
}

impl InhabitantsConfig {
    pub(super) fn check(&self, capacity: usize) -> Result<()> {
        CAPACITY.check_count("capacity", capacity)?;
        PATH_STEPS.check_count("capacity times max_path", capacity.saturating_mul(self.max_path))?;
        let patience = self.patience_s;
        check_value("patience_s", None, patience, patience > 0.0 && patience < 1e6, "more than 0 and below 1e6")?;
        check_value("plans_per_step", None, self.plans_per_step as f64, self.plans_per_step > 0, "at least 1")?;
        let max = self.max_path;
        check_value("max_path", None, max as f64, (8..=65536).contains(&max), "between 8 and 65536")
    }
}

/// Goal of an inhabitant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum InhabitantGoal {
    /// Wander about.
    #[default]
    Roam,
    /// Go to where one can stay in an instance, and stay.
    GoTo {
        /// The instance.
        instance: u32,
    },
    /// Go to a place, and stay.
    GoToPlace {
        /// See [`crate::World::nearest_place`].
        place: RestPlace,
    },
    /// Go to the free place nearest to a point, and stay there; go to another one if it is taken first.
    GoNear {
        /// The point in the world (m).
        place: Vec3,
        /// Largest distance of the hips from the point (m).
        within_m: f32,
    },
    /// Go to the nearest free instance whose motion shows a tag, perform that again and again, then stay.
    Perform {
        /// See [`throng_core::patch::LinkRecord::tag`] (1 to the number of tags).
        tag: u16,
        /// Duration (s, >= 0).
        seconds: f32,
    },
    /// Perform an action with a partner, again and again, then stay; set by [`super::Inhabitants::order_meeting`] alone.
    Meet {
        /// Tag of the action, as for [`InhabitantGoal::Perform`].
        tag: u16,
        /// Duration (s, >= 0).
        seconds: f32,
    },
}

impl InhabitantGoal {
    /// True where it leads nowhere.
    pub(super) fn is_roaming(&self) -> bool {
        *self == Self::Roam
    }
}

/// Current activity of an inhabitant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum InhabitantActivity {
    /// Wanders.
    #[default]
    Roaming,
    /// Has requested a path, and is at rest or goes there.
    Planning,
    /// Follows its path.
    Walking,
    /// Waits for what others hold.
    Waiting,
    /// Moves out of the way of others, or tries another path.
    Detour,
    /// Waits at the meeting place for a partner on the way.
    Meeting,
    /// Performs the action of its goal.
    Performing,
    /// Has reached its goal, and stays.
    Arrived,
    /// No path leads there; stays where it can.
    Unreachable,
    /// Waits, since another character stays in its place, or in its path for good, until that one leaves.
    Blocked,
}

/// Public state of an inhabitant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InhabitantState {
    /// Node that its motion leads to.
    pub node: WorldNode,
    /// Goal.
    pub goal: InhabitantGoal,
    /// Current activity.
    pub activity: InhabitantActivity,
    /// Number of goals reached so far.
    pub num_fulfilled: u32,
    /// Time that it has waited for units that others hold (s).
    pub waited_s: f32,
}
