//! Input of a run: something done to it from outside.

use glam::Vec3;
use serde::{Deserialize, Serialize};
use throng_crowd::Scheme;
use throng_simulation::{Scene, scene::engine};
use throng_world::inhabitants::InhabitantGoal;

/// Farthest from the origin that a target may be moved (m).
pub const MAX_TARGET_M: f32 = 1e4;

/// Something done to a run from outside. Inputs are recorded and repeated when the run is.
#[derive(Clone, Debug, PartialEq)]
pub enum RunInput {
    /// A target is moved; all targets if no character is named (m).
    Target {
        /// Character with the target.
        character: Option<usize>,
        /// New position.
        to: Vec3,
    },
    /// Weights of the behaviours of a group.
    Weights {
        /// Any character of the group.
        member: usize,
        /// Weight of each (number of behaviours).
        weights: Vec<f32>,
    },
    /// A character plays a segment at once.
    Play {
        /// Which character.
        character: usize,
        /// Which segment.
        segment: u32,
    },
    /// An event of the scene happens.
    Event(String),
    /// A character of a world gets an order.
    Goal {
        /// Which character.
        character: usize,
        /// Goal of the order; none lets it decide for itself.
        goal: Option<InhabitantGoal>,
    },
}

impl RunInput {
    /// The input within valid bounds; none for a target that is not a number.
    pub(super) fn limited(self) -> Option<Self> {
        let most = Vec3::splat(MAX_TARGET_M);
        match self {
            Self::Target { to, .. } if to.is_nan() => None,
            Self::Target { character, to } => Some(Self::Target { character, to: to.clamp(-most, most) }),
            other => Some(other),
        }
    }

    /// True if this makes an older input at the same step obsolete.
    pub(super) fn replaces(&self, old: &Self) -> bool {
        match (old, self) {
            (Self::Target { character: a, .. }, Self::Target { character: b, .. }) => a == b,
            (Self::Weights { member: a, .. }, Self::Weights { member: b, .. }) => a == b,
            (Self::Goal { character: a, .. }, Self::Goal { character: b, .. }) => a == b,
            _ => false,
        }
    }
}

/// Settings of a scene that the viewer can change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct SceneChoice {
    /// Number of characters and agents of all groups.
    pub characters: usize,
    /// Seed of places, paths and choices.
    pub seed: u64,
    /// Engine that finds the events of agents.
    #[serde(with = "engine")]
    pub engine: Scheme,
}

impl Default for SceneChoice {
    /// The crowd of a bundle.
    fn default() -> Self {
        Self { characters: 100, seed: 1, engine: Scheme::default() }
    }
}

impl SceneChoice {
    /// Settings in the file of a scene.
    pub fn from_scene(scene: &Scene) -> Self {
        Self { characters: scene.num_characters(), seed: scene.seed, engine: scene.agents.engine }
    }
}
