//! What a simulation asks of each kind of motion. A new kind implements [`Kind`], and gets one line in `casts.rs`.

use crate::Event;
use glam::Vec3;
use throng_base::ground::Held;
use throng_base::{Error, Hash128, Result, Run};
use throng_core::{Cast, Contacts, Mat3x4, NUM_JOINTS, Planar};

/// One step of time.
pub struct Tick<'a> {
    /// How far time goes on (s, 0 to 1).
    pub dt_s: f32,
    /// The time at its end (s).
    pub until_s: f64,
    /// Number of the first character in the simulation, for events.
    pub first: usize,
    /// Whose threads work.
    pub run: &'a dyn Run,
}

/// Characters of one kind of motion, numbered from 0.
pub trait Kind {
    /// Number of characters at the start.
    fn num_characters(&self) -> usize;

    /// Moves everybody on, and adds what happened.
    ///
    /// # Errors
    /// What could not be done, with the group in the scene file.
    fn step(&mut self, tick: &Tick<'_>, events: &mut Vec<Event>) -> Result<()>;

    /// Adds their bodies on the ground, and the ground that they hold now for what they do and for the stop after it.
    fn hold(&mut self, out: &mut Held);

    /// What all others hold: before the next step, nobody else moves. Kinds that give way to nobody take no notice.
    fn mind<'a>(&mut self, _others: impl Iterator<Item = &'a Held>) {}

    /// Begins anew, before the first step, on ground that nobody else holds, as far as that can be.
    fn settle(&mut self) {}

    /// Appends all that the next steps depend on: versioned, with a checksum.
    fn save(&self, out: &mut Vec<u8>);

    /// Goes back to what characters of the same scene have saved. What follows is the same, bit by bit; poses are there at
    /// once, though a leg may be a centimetre off until the next step.
    ///
    /// - `time_s`: the time then (s).
    ///
    /// # Errors
    /// [`throng_base::Error::Snapshot`]. A part may have been loaded then: [`crate::Simulation::restore`] undoes that.
    fn load(&mut self, bytes: &[u8], time_s: f64) -> Result<()>;

    /// A hash of the state: differs, but for one chance in 2^64, where the motion of anybody differs.
    fn hash(&self) -> u64 {
        let mut bytes = Vec::new();
        self.save(&mut bytes);
        Hash128::of(&bytes) as u64
    }

    /// Where a character stands and looks; `None` where it has left.
    fn root(&self, number: usize) -> Option<Planar>;

    /// Joints in model space, which the root places in the world; `None` for one without a body, or who has left.
    fn pose(&self, number: usize) -> Option<&[Mat3x4; NUM_JOINTS]>;

    /// Planted parts of a character's feet.
    fn contacts(&self, number: usize) -> Contacts;

    /// Bottom of the heel and ball of both feet in the world, where bodies are fitted to skeletons of their own (m).
    fn soles(&self, _member: usize) -> Option<[[Vec3; 2]; 2]> {
        None
    }
}

/// The joints of one character.
pub(crate) fn joints(pose: &[Mat3x4]) -> &[Mat3x4; NUM_JOINTS] {
    &pose.as_chunks().0[0]
}

/// Goes back to what a cast has saved, in which nobody has entered or left since.
pub(crate) fn load_same(cast: &mut impl Cast, bytes: &[u8]) -> Result<()> {
    let ids = cast.bodies().ids.to_vec();
    cast.load(bytes)?;
    if cast.bodies().ids == ids { Ok(()) } else { Err(refused("characters", "they are others")) }
}

/// Bytes that are no snapshot.
pub(crate) fn refused(what: &'static str, why: &str) -> Error {
    Error::Snapshot { what, why: format!("{why}; it is damaged") }
}

/// Characters of one part of a step that is split.
pub(crate) const PART: usize = 256;
