//! Characters that live in a world: played, stopped, and rewound as far as they are recorded.
//!
//! Poses are recorded, not steps: the state of a planner is too large to be kept every second. Recorded moments can be
//! shown again; orders are given at the last step only.

use super::{STEP_HZ, reel::Reel};
use crate::render::picking::world_position;
use glam::Vec3;
use std::time::Instant;
use throng_core::{CharacterGroup, Id, Inline, Mat3x4, NUM_JOINTS, Planar, Result, characters::CharactersConfig};
use throng_world::inhabitants::{InhabitantGoal, InhabitantState, Inhabitants, InhabitantsConfig};
use throng_world::{World, WorldNode};

/// Steps between two points of a trail.
const TRAIL_EVERY: u32 = 6;

/// All of them at one step.
#[derive(Clone, Debug, Default)]
pub struct InhabitantsMoment {
    /// Planar roots (number of characters).
    pub roots: Vec<Planar>,
    /// Joints in model space (number of characters * num_joints).
    pub poses: Vec<Mat3x4>,
    /// State of each character (number of characters).
    pub states: Vec<InhabitantState>,
}

/// Characters in a world, with a record of their poses.
#[derive(Clone, Debug)]
pub struct WorldRun {
    /// The present characters, with their paths and reservations.
    pub inhabitants: Inhabitants,
    /// Order of each character; all others roam.
    orders: Vec<Option<InhabitantGoal>>,
    /// All of them at the recorded steps.
    pub reel: Reel<InhabitantsMoment>,
    /// Wall time of the last step (s).
    pub step_s: f64,
}

impl WorldRun {
    /// All inhabitants at rest where they start; they roam.
    ///
    /// # Errors
    /// [`throng_core::Error`] for a start without a rest cell, or where two would share a unit.
    pub fn new(world: &World, seed: u64, starts: &[WorldNode]) -> Result<Self> {
        let characters = CharactersConfig { seed, ..CharactersConfig::default() };
        let config = InhabitantsConfig { characters, ..InhabitantsConfig::default() };
        let mut inhabitants = Inhabitants::new(world, starts.len(), config)?;
        starts.iter().try_for_each(|&start| inhabitants.spawn(start).map(|_| ()))?;
        let begin = Instant::now();
        inhabitants.step(0.0, &Inline)?;
        let step_s = begin.elapsed().as_secs_f64();
        let each = NUM_JOINTS * size_of::<Mat3x4>() + size_of::<(Planar, InhabitantState)>();
        let reel = Reel::new(starts.len() * each, InhabitantsMoment::capture(&inhabitants));
        Ok(Self { inhabitants, orders: vec![None; starts.len()], reel, step_s })
    }

    /// One step forward: a recorded one, or a new one.
    ///
    /// # Errors
    /// [`throng_core::Error`] where a step cannot be taken.
    pub fn step(&mut self) -> Result<()> {
        if !self.reel.head.advance_recorded() {
            let begin = Instant::now();
            self.inhabitants.step(1.0 / STEP_HZ, &Inline)?;
            self.step_s = begin.elapsed().as_secs_f64();
            self.reel.push(InhabitantsMoment::capture(&self.inhabitants));
        }
        Ok(())
    }

    /// Gives a character an order, at the last step; none lets it decide for itself.
    ///
    /// # Errors
    /// [`throng_core::Error`] for a place or a tag that is not there (character < num_characters).
    pub fn give_order(&mut self, character: usize, goal: Option<InhabitantGoal>) -> Result<()> {
        self.inhabitants.order(self.id(character), goal.unwrap_or_default())?;
        self.orders[character] = goal;
        self.reel.head.seek(u32::MAX);
        let mut last = self.reel.moment().clone();
        last.states[character] = self.inhabitants.state(self.id(character))?;
        self.reel.replace(last);
        Ok(())
    }

    /// The order of a character (character < num_characters).
    pub fn order_of(&self, character: usize) -> Option<InhabitantGoal> {
        self.orders[character]
    }

    /// Hips of a character at the step shown (m, character < num_characters).
    pub fn hips(&self, character: usize) -> Vec3 {
        let m = self.reel.moment();
        world_position(m.roots[character], m.poses[character * NUM_JOINTS].translation())
    }

    /// Name of a character; none leaves (character < num_characters).
    pub fn id(&self, character: usize) -> Id {
        self.inhabitants.ids()[character]
    }

    /// Number of characters.
    pub fn num_characters(&self) -> usize {
        self.inhabitants.ids().len()
    }

    /// Past positions of the hips during the last `seconds`, at intervals (m).
    pub fn trail(&self, character: usize, seconds: f32) -> impl Iterator<Item = Vec3> {
        self.reel.moments_before(seconds, TRAIL_EVERY).map(move |m| m.place(character))
    }
}

impl InhabitantsMoment {
    /// Position of a character's hips above its ground (m).
    fn place(&self, character: usize) -> Vec3 {
        let hips = self.poses[character * NUM_JOINTS].translation();
        self.roots[character].translation().with_y(hips.y)
    }

    fn capture(inhabitants: &Inhabitants) -> Self {
        let characters = inhabitants.characters();
        Self {
            roots: (0..inhabitants.ids().len()).map(|c| characters.root(c)).collect(),
            poses: characters.model_matrices().to_vec(),
            states: inhabitants.ids().iter().filter_map(|&id| inhabitants.state(id).ok()).collect(),
        }
    }
}
