//! Characters that live in a world: played, stopped, and rewound as far as is kept.
//!
//! Poses are recorded, not steps: what a planner remembers is too large to be kept every second. What was seen can be
//! looked at again; wishes are told in the present alone.

use super::STEP_HZ;
use crate::document::Bundle;
use glam::{Vec2, Vec3};
use std::collections::VecDeque;
use std::ops::RangeInclusive;
use std::time::{Duration, Instant};
use throng_precompute::scene::world::Life;
use throng_runtime::world::WorldGraph;
use throng_runtime::world::inhabitants::{InhabitantsError, Status, Wish};
use throng_runtime::{Contacts, Mat3x4, NUM_JOINTS, Planar};

/// Longest time that one call of [`WorldRun::advance`] spends on steps, at least one step apart.
const BUDGET: Duration = Duration::from_millis(50);
/// Steps that are kept at most.
const MAX_STEPS: usize = 60 * STEP_HZ as usize;
/// Memory that the record may take. [Unit: bytes]
const MAX_BYTES: usize = 192 << 20;
/// Steps between two points of a trail.
const TRAIL_EVERY: usize = 6;

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
    moments: VecDeque<Moment>,
    /// Steps that are kept.
    most: usize,
    /// Step of the first moment.
    first: u32,
    /// Step that is shown.
    now: u32,
    playing: bool,
    speed: f32,
    owed_s: f32,
    /// Wall time of the last step. [Unit: s]
    step_s: f64,
}

impl WorldRun {
    /// Everybody at rest where they begin.
    ///
    /// # Errors
    /// [`InhabitantsError`] where the first step cannot be taken.
    pub fn new(life: Life, bundle: &Bundle, graph: &WorldGraph<'_>) -> Result<Self, InhabitantsError> {
        let n = life.inhabitants().num_characters();
        let each = NUM_JOINTS * size_of::<Mat3x4>() + size_of::<(Planar, Contacts, Status)>();
        let most = (MAX_BYTES / (n * each).max(1)).clamp(2, MAX_STEPS);
        let mut run = Self {
            life,
            moments: VecDeque::new(),
            most,
            first: 0,
            now: 0,
            playing: false,
            speed: 1.0,
            owed_s: 0.0,
            step_s: 0.0,
        };
        run.live(bundle, graph, 0.0)?;
        run.now = 0;
        Ok(run)
    }

    /// Takes a step that nobody has seen, and shows it.
    fn live(&mut self, bundle: &Bundle, graph: &WorldGraph<'_>, dt_s: f32) -> Result<(), InhabitantsError> {
        let begin = Instant::now();
        self.life.step(bundle.repertoire(), graph, dt_s)?;
        self.step_s = begin.elapsed().as_secs_f64();
        let mut moment = match self.moments.len() < self.most {
            true => Moment::default(),
            false => {
                self.first += 1;
                self.moments.pop_front().unwrap_or_default()
            }
        };
        moment.take(&self.life);
        self.moments.push_back(moment);
        self.now = *self.recorded().end();
        Ok(())
    }

    /// One step on: a recorded one, or a new one.
    ///
    /// # Errors
    /// [`InhabitantsError`] where a step cannot be taken.
    pub fn step(&mut self, bundle: &Bundle, graph: &WorldGraph<'_>) -> Result<(), InhabitantsError> {
        if self.is_live() {
            return self.live(bundle, graph, 1.0 / STEP_HZ);
        }
        self.now += 1;
        Ok(())
    }

    /// Moves time on by wall time, as far as the time budget allows; returns the steps taken.
    ///
    /// # Errors
    /// [`InhabitantsError`] where a step cannot be taken.
    pub fn advance(&mut self, bundle: &Bundle, graph: &WorldGraph<'_>, wall_s: f32) -> Result<u32, InhabitantsError> {
        if !self.playing {
            return Ok(0);
        }
        self.owed_s += wall_s.clamp(0.0, 0.25) * self.speed;
        let begin = Instant::now();
        let mut steps = 0;
        while self.owed_s >= 1.0 / STEP_HZ {
            if steps > 0 && begin.elapsed() > BUDGET {
                self.owed_s = 0.0;
                break;
            }
            self.owed_s -= 1.0 / STEP_HZ;
            self.step(bundle, graph)?;
            steps += 1;
        }
        Ok(steps)
    }

    /// Shows a recorded step, the nearest one there is.
    pub fn seek(&mut self, step: u32) {
        self.now = step.clamp(*self.recorded().start(), *self.recorded().end());
        self.owed_s = 0.0;
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
        self.now = *self.recorded().end();
        if let Some(last) = self.moments.back_mut() {
            last.minds[character] = self.life.inhabitants().status(character);
        }
        Ok(())
    }

    /// What a character was told to do. [Limit: character < num_characters]
    pub fn told(&self, character: usize) -> Option<Wish> {
        self.life.is_told(character).then(|| self.life.inhabitants().status(character).wish)
    }

    /// Everybody at the step that is shown.
    pub fn moment(&self) -> &Moment {
        &self.moments[((self.now - self.first) as usize).min(self.moments.len() - 1)]
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
        let end = (self.now - self.first) as usize;
        let begin = end.saturating_sub((seconds * STEP_HZ) as usize).next_multiple_of(TRAIL_EVERY);
        let at = move |k: usize| self.moments.get(k).map(|m| m.place(character));
        (begin..end).step_by(TRAIL_EVERY).chain([end]).filter_map(at)
    }

    /// Number of the step that is shown, from 0.
    pub fn now(&self) -> u32 {
        self.now
    }

    /// Steps that can be shown.
    pub fn recorded(&self) -> RangeInclusive<u32> {
        self.first..=self.first + self.moments.len().saturating_sub(1) as u32
    }

    /// True where the step that is shown is the last one so far.
    pub fn is_live(&self) -> bool {
        self.now == *self.recorded().end()
    }

    /// True where time moves on.
    pub fn is_playing(&self) -> bool {
        self.playing
    }

    /// How many simulated seconds pass in one.
    pub fn speed(&self) -> f32 {
        self.speed
    }

    /// Wall time of the last step of everybody. [Unit: s]
    pub fn step_s(&self) -> f64 {
        self.step_s
    }

    /// Lets time move on, or stops it.
    pub fn play(&mut self, playing: bool) {
        self.playing = playing;
        self.owed_s = 0.0;
    }

    /// Sets how many simulated seconds pass in one. [Limit: 0.05 to 8, clamped]
    pub fn set_speed(&mut self, speed: f32) {
        self.speed = if speed.is_finite() { speed.clamp(0.05, 8.0) } else { 1.0 };
    }
}

impl Moment {
    /// Where a character's hips are above the ground that it is on. [Unit: m]
    fn place(&self, character: usize) -> Vec3 {
        let hips = self.poses[character * NUM_JOINTS].translation();
        self.roots[character].translation().with_y(hips.y)
    }

    fn take(&mut self, life: &Life) {
        let inhabitants = life.inhabitants();
        let (troupe, all) = (inhabitants.troupe(), 0..inhabitants.num_characters());
        self.roots.clear();
        self.roots.extend(all.clone().map(|c| troupe.root(c)));
        self.contacts.clear();
        self.contacts.extend(all.clone().map(|c| troupe.contacts(c)));
        self.minds.clear();
        self.minds.extend(all.map(|c| inhabitants.status(c)));
        self.poses.clear();
        self.poses.extend_from_slice(troupe.model_matrices());
    }
}
