//! A scene of walkers: played, stopped, and rewound as far as it is recorded.

use super::STEP_HZ;
use super::reel::Reel;
use glam::Vec3;
use throng_precompute::BuildError;
use throng_precompute::scene::walkers::Walk;
use throng_runtime::{Contacts, Mat3x4, NUM_JOINTS, Planar};

/// Steps between two points of a trail.
const TRAIL_EVERY: u32 = 6;

/// All of them at one step.
#[derive(Clone, Debug, Default)]
pub struct WalkMoment {
    /// Planar roots (number of characters).
    pub roots: Vec<Planar>,
    /// Joints in model space, heights with that of the ground (number of characters * NUM_JOINTS).
    pub poses: Vec<Mat3x4>,
    /// What is planted (number of characters).
    pub contacts: Vec<Contacts>,
    /// How fast the paths lead on (m/s, number of characters).
    pub speeds: Vec<f32>,
}

/// The record of a scene of walkers.
#[derive(Clone, Debug)]
pub struct WalkRun {
    /// All of them at the recorded steps.
    pub reel: Reel<WalkMoment>,
}

impl WalkRun {
    /// All of them where they start; `walk` takes its first step.
    ///
    /// # Errors
    /// [`BuildError::Stage`] where the step cannot be taken.
    pub fn new(walk: &mut Walk) -> Result<Self, BuildError> {
        walk.step(0.0)?;
        let each = NUM_JOINTS * size_of::<Mat3x4>() + size_of::<(Planar, Contacts, f32)>();
        Ok(Self { reel: Reel::new(walk.num_characters() * each, seen(walk)) })
    }

    /// One step forward: a recorded one, or a new one.
    ///
    /// # Errors
    /// As [`WalkRun::new`].
    pub fn step(&mut self, walk: &mut Walk) -> Result<(), BuildError> {
        if !self.reel.head.on() {
            walk.step(1.0 / STEP_HZ)?;
            self.reel.push(seen(walk));
        }
        Ok(())
    }

    /// All of them at the step shown.
    pub fn moment(&self) -> &WalkMoment {
        self.reel.moment()
    }

    /// Number of characters.
    pub fn num_characters(&self) -> usize {
        self.moment().roots.len()
    }

    /// Where a character has been during the last `seconds`, now and then, on the ground (m).
    pub fn trail(&self, character: usize, seconds: f32) -> impl Iterator<Item = Vec3> {
        self.reel.before(seconds, TRAIL_EVERY).filter_map(move |m| m.place(character))
    }
}

impl WalkMoment {
    /// Where a character is, as high as the lower one of its ankles (m).
    pub fn place(&self, character: usize) -> Option<Vec3> {
        use throng_runtime::Joint::{LeftFoot, RightFoot};
        let pose = self.poses.get(character * NUM_JOINTS..(character + 1) * NUM_JOINTS)?;
        let foot = [LeftFoot, RightFoot].map(|j| pose[j.index()].translation().y);
        Some(self.roots.get(character)?.translation().with_y(foot[0].min(foot[1])))
    }
}

fn seen(walk: &Walk) -> WalkMoment {
    let all = 0..walk.num_characters();
    WalkMoment {
        roots: all.clone().map(|c| walk.root(c)).collect(),
        poses: all.clone().flat_map(|c| walk.pose(c)).copied().collect(),
        contacts: all.clone().map(|c| walk.contacts(c)).collect(),
        speeds: all.map(|c| walk.speed(c)).collect(),
    }
}
