//! Bodies of a crowd's members, blended from the examples of a bundle.

use crate::document::Bundle;
use glam::Vec2;
use self_cell::self_cell;
use std::sync::Arc;
use throng_precompute::BuildError;
use throng_precompute::scene::crowd::{Bodies, CrowdBodiesConfig, CrowdScene, Live};
use throng_runtime::{Contacts, Mat3x4, Planar, Skeleton};

type Followers<'a> = Bodies<'a>;

self_cell!(
    struct BodiesCell {
        owner: Arc<Bundle>,
        #[not_covariant]
        dependent: Followers,
    }
);

/// Bodies of those who are there, at one step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SeenBodies {
    /// Whose they are, in ascending order.
    pub members: Vec<u32>,
    /// Planar roots. [Size: number of `members`]
    pub roots: Vec<Planar>,
    /// Joints in model space. [Size: number of `members` * NUM_JOINTS]
    pub poses: Vec<Mat3x4>,
    /// What is planted. [Size: number of `members`]
    pub contacts: Vec<Contacts>,
}

/// What follows the members of a crowd in a space.
pub(super) trait Follow<V>: Send {
    /// Moves on by `dt_s` to where members are at `time_s`.
    fn step(&mut self, live: &Live<V>, time_s: f64, dt_s: f32) -> Result<(), BuildError>;
    /// As it is now.
    fn see(&self, live: &Live<V>, time_s: f64) -> SeenBodies;
    /// Skeletons, which members take in turn.
    fn skeletons(&self) -> Vec<Skeleton>;
}

/// Bodies on the ground, with the bundle of their examples.
pub(super) struct OnGround(BodiesCell);

impl OnGround {
    /// Bodies of everybody where they are now.
    pub fn new(
        scene: &CrowdScene,
        config: &CrowdBodiesConfig,
        bundle: Arc<Bundle>,
        live: &Live<Vec2>,
    ) -> Result<Self, BuildError> {
        BodiesCell::try_new(bundle, |b| Bodies::new(scene, config, b.tables(), live)).map(Self)
    }
}

impl Follow<Vec2> for OnGround {
    fn step(&mut self, live: &Live<Vec2>, time_s: f64, dt_s: f32) -> Result<(), BuildError> {
        self.0.with_dependent_mut(|_, bodies| bodies.step(live, time_s, dt_s))
    }

    fn see(&self, live: &Live<Vec2>, time_s: f64) -> SeenBodies {
        self.0.with_dependent(|_, bodies| {
            let mut seen = SeenBodies::default();
            for m in (0..live.num_members()).filter(|&m| live.position(m, time_s).is_some()) {
                seen.members.push(m as u32);
                seen.roots.push(bodies.root(m));
                seen.poses.extend_from_slice(bodies.pose(m));
                seen.contacts.push(bodies.feet(m).0);
            }
            seen
        })
    }

    fn skeletons(&self) -> Vec<Skeleton> {
        self.0.with_dependent(|_, bodies| bodies.skeletons().to_vec())
    }
}
