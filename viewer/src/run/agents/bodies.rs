//! Bodies of a crowd's agents, blended from the examples of a bundle.

use crate::bundle::OpenBundle;
use glam::Vec2;
use throng_precompute::BuildError;
use throng_precompute::scene::crowd::{Bodies, CrowdBodiesConfig, CrowdScene, Live};
use throng_runtime::{Contacts, Mat3x4, Planar, Skeleton};

/// Bodies of the agents present, at one step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SeenBodies {
    /// Their agents, in ascending order.
    pub agents: Vec<u32>,
    /// Planar roots (number of `agents`).
    pub roots: Vec<Planar>,
    /// Joints in model space (number of `agents` * NUM_JOINTS).
    pub poses: Vec<Mat3x4>,
    /// What is planted (number of `agents`).
    pub contacts: Vec<Contacts>,
}

/// What follows the agents of a crowd in a space.
pub(super) trait Follow<V>: Send {
    /// Moves on by `dt_s` to where agents are at `time_s`.
    fn step(&mut self, live: &Live<V>, time_s: f64, dt_s: f32) -> Result<(), BuildError>;
    /// As it is now.
    fn see(&self, live: &Live<V>, time_s: f64) -> SeenBodies;
    /// Skeletons, which agents take in turn.
    fn skeletons(&self) -> Vec<Skeleton>;
}

/// Bodies on the ground.
pub(super) struct OnGround(Bodies);

impl OnGround {
    /// All bodies where they are now.
    pub fn new(
        scene: &CrowdScene,
        config: &CrowdBodiesConfig,
        bundle: &OpenBundle,
        live: &Live<Vec2>,
    ) -> Result<Self, BuildError> {
        Bodies::new(scene, config, bundle.tables(), live).map(Self)
    }
}

impl Follow<Vec2> for OnGround {
    fn step(&mut self, live: &Live<Vec2>, time_s: f64, dt_s: f32) -> Result<(), BuildError> {
        self.0.step(live, time_s, dt_s)
    }

    fn see(&self, live: &Live<Vec2>, time_s: f64) -> SeenBodies {
        let mut seen = SeenBodies::default();
        for m in (0..live.num_agents()).filter(|&m| live.position(m, time_s).is_some()) {
            seen.agents.push(m as u32);
            seen.roots.push(self.0.root(m));
            seen.poses.extend_from_slice(self.0.pose(m));
            seen.contacts.push(self.0.feet(m).0);
        }
        seen
    }

    fn skeletons(&self) -> Vec<Skeleton> {
        self.0.skeletons().to_vec()
    }
}
