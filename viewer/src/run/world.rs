//! Characters that live in a world: played, stopped, and rewound as far as is kept.
//!
//! Poses are recorded, not steps: what a planner remembers is too large to be kept every second. What was seen can be
//! looked at again; wishes are told in the present alone.

use super::STEP_HZ;
use super::reel::Reel;
use crate::document::Bundle;
use glam::{Vec2, Vec3};
use std::ops::RangeInclusive;
use std::time::Instant;
use throng_precompute::scene::world::Life;
use throng_runtime::world::WorldGraph;
use throng_runtime::world::inhabitants::{InhabitantsError, Status, Wish};
use throng_runtime::{Contacts, Mat3x4, NUM_JOINTS, Planar};

/// Steps between two points of a trail.
const TRAIL_EVERY: u32 = 6;

/// Everybody at one step.
#[derive(Clone, Debug, Default)]
pub struct Moment {
    /// Planar roots. [Size: number of characters]
    pub roots: Vec<Planar>,
    /// Joints in model space. [Size: number of characters * num_joints]
    pub poses: Vec<Mat3x4>,
    /// What is planted. [Size: number of characters]
    pub contacts: Vec<Contacts>,
    /// What everybody is about. [Size: number of characters]
    pub minds: Vec<Status>,
}

/// Characters in a world, with the record of what was seen.
#[derive(Clone, Debug)]
pub struct WorldRun {
    life: Life,
    reel: Reel<Moment>,
    /// Wall time of the last step. [Unit: s]
    step_s: f64,
}

impl WorldRun {
    /// Everybody at rest where they begin.
    ///
    /// # Errors
    /// [`InhabitantsError`] where the first step cannot be taken.
    pub fn new(mut life: Life, bundle: &Bundle, graph: &WorldGraph<'_>) -> Result<Self, InhabitantsError> {
        let begin = Instant::now();
        life.step(bundle.repertoire(), graph, 0.0)?;
        let step_s = begin.elapsed().as_secs_f64();
        let each = NUM_JOINTS * size_of::<Mat3x4>() + size_of::<(Planar, Contacts, Status)>();
        let reel = Reel::new(life.inhabitants().num_characters() * each, Moment::of(&life));
        Ok(Self { life, reel, step_s })
    }

    /// Takes a step that nobody has seen, and shows it.
    fn live(&mut self, bundle: &Bundle, graph: &WorldGraph<'_>) -> Result<(), InhabitantsError> {
        let begin = Instant::now();
        self.life.step(bundle.repertoire(), graph, 1.0 / STEP_HZ)?;
        self.step_s = begin.elapsed().as_secs_f64();
        self.reel.push(Moment::of(&self.life));
        Ok(())
    }

    /// One step on: a recorded one, or a new one.
    ///
    /// # Errors
    /// [`InhabitantsError`] where a step cannot be taken.
    pub fn step(&mut self, bundle: &Bundle, graph: &WorldGraph<'_>) -> Result<(), InhabitantsError> {
        if self.reel.head.on() { Ok(()) } else { self.live(bundle, graph) }
    }

    /// Moves time on by wall time, as far as the time budget allows; returns the steps taken.
    ///
    /// # Errors
    /// [`InhabitantsError`] where a step cannot be taken.
    pub fn advance(&mut self, bundle: &Bundle, graph: &WorldGraph<'_>, wall_s: f32) -> Result<u32, InhabitantsError> {
        self.reel.head.owe(wall_s);
        let (begin, mut steps) = (Instant::now(), 0);
        while self.reel.head.is_due(steps, begin) {
            self.step(bundle, graph)?;
            steps += 1;
        }
        Ok(steps)
    }

    /// Shows a recorded step, the nearest one there is.
    pub fn seek(&mut self, step: u32) {
        self.reel.head.seek(step);
    }

    /// Tells a character what to do, in the present; none lets it wish by itself.
    ///
    /// # Errors
    /// [`InhabitantsError`] for a place or a tag that is not there. [Limit: character < num_characters]
    pub fn tell(
        &mut self,
        graph: &WorldGraph<'_>,
        character: usize,
        wish: Option<Wish>,
    ) -> Result<(), InhabitantsError> {
        self.life.tell(graph, character, wish)?;
        self.reel.head.seek(u32::MAX);
        let mut last = self.reel.moment().clone();
        last.minds[character] = self.life.inhabitants().status(character);
        self.reel.replace(last);
        Ok(())
    }

    /// What a character was told to do. [Limit: character < num_characters]
    pub fn told(&self, character: usize) -> Option<Wish> {
        self.life.is_told(character).then(|| self.life.inhabitants().status(character).wish)
    }

    /// Everybody at the step that is shown.
    pub fn moment(&self) -> &Moment {
        self.reel.moment()
    }

    /// Hips of a character at the step that is shown. [Unit: m] [Limit: character < num_characters]
    pub fn hips(&self, character: usize) -> Vec3 {
        let m = self.moment();
        let hips = m.poses[character * NUM_JOINTS].translation();
        let p = m.roots[character].transform_point(Vec2::new(hips.x, hips.z));
        Vec3::new(p.x, hips.y, p.y)
    }

    /// The characters in the present, with their paths and what they hold.
    pub fn life(&self) -> &Life {
        &self.life
    }

    /// Number of characters.
    pub fn num_characters(&self) -> usize {
        self.life.inhabitants().num_characters()
    }

    /// Where hips have been during the last `seconds`, now and then. [Unit: m]
    pub fn trail(&self, character: usize, seconds: f32) -> impl Iterator<Item = Vec3> {
        self.reel.before(seconds, TRAIL_EVERY).map(move |m| m.place(character))
    }

    /// Number of the step that is shown, from 0.
    pub fn now(&self) -> u32 {
        self.reel.head.now()
    }

    /// Steps that can be shown.
    pub fn recorded(&self) -> RangeInclusive<u32> {
        self.reel.head.recorded()
    }

    /// True where the step that is shown is the last one so far.
    pub fn is_live(&self) -> bool {
        self.reel.head.is_live()
    }

    /// True where time moves on.
    pub fn is_playing(&self) -> bool {
        self.reel.head.is_playing()
    }

    /// How many simulated seconds pass in one.
    pub fn speed(&self) -> f32 {
        self.reel.head.speed()
    }

    /// Wall time of the last step of everybody. [Unit: s]
    pub fn step_s(&self) -> f64 {
        self.step_s
    }

    /// Lets time move on, or stops it.
    pub fn play(&mut self, playing: bool) {
        self.reel.head.play(playing);
    }

    /// Sets how many simulated seconds pass in one. [Limit: 0.05 to 8, clamped]
    pub fn set_speed(&mut self, speed: f32) {
        self.reel.head.set_speed(speed);
    }
}

impl Moment {
    /// Where a character's hips are above the ground that it is on. [Unit: m]
    fn place(&self, character: usize) -> Vec3 {
        let hips = self.poses[character * NUM_JOINTS].translation();
        self.roots[character].translation().with_y(hips.y)
    }

    fn of(life: &Life) -> Self {
        let inhabitants = life.inhabitants();
        let (troupe, all) = (inhabitants.troupe(), 0..inhabitants.num_characters());
        Self {
            roots: all.clone().map(|c| troupe.root(c)).collect(),
            poses: troupe.model_matrices().to_vec(),
            contacts: all.clone().map(|c| troupe.contacts(c)).collect(),
            minds: all.map(|c| inhabitants.status(c)).collect(),
        }
    }
}
