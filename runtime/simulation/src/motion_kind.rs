//! Interface of all kinds of motion. A new kind implements [`MotionKind`], and gets one line in `character_groups.rs`.

use crate::{CharacterEvent, Order, SimulationEvent};
use glam::Vec3;
use throng_base::{Bytes, Error, Executor, Hash128, Id, Result, error::ensure, ground::ReservedRegion};
use throng_core::{CharacterGroup, Contacts, Mat3x4, NUM_JOINTS, Planar};

/// Inputs of one step of a group.
pub struct GroupStep<'a> {
    /// Duration of the step (s, 0 to 1).
    pub dt_s: f32,
    /// Time at the end of the step (s).
    pub until_s: f64,
    /// Number of the first character in the simulation, for events.
    pub first: usize,
    /// True for each door that is open.
    pub open_doors: &'a [bool],
    /// Threads that run the parts of the step.
    pub run: &'a dyn Executor,
}

impl GroupStep<'_> {
    /// Event of a character at the end of the step.
    pub(crate) fn event(&self, number: usize, kind: CharacterEvent) -> SimulationEvent {
        SimulationEvent { time_s: self.until_s, who: self.first + number, kind }
    }
}

/// Characters of one kind of motion, numbered from 0.
pub trait MotionKind {
    /// Number of characters at the start.
    fn num_characters(&self) -> usize;

    /// Advances all characters, and adds their events.
    ///
    /// # Errors
    /// An action that cannot be done, with the group in the scene file.
    fn step(&mut self, tick: &GroupStep<'_>, events: &mut Vec<SimulationEvent>) -> Result<()>;

    /// Adds their bodies on the ground, and the regions that they reserve for their actions and for the stop after them.
    fn add_reserved_regions(&mut self, out: &mut ReservedRegion);

    /// Sets the bodies and reserved regions of all other groups, valid until the next step. Kinds that give way to nobody ignore them.
    fn set_external_obstacles<'a>(&mut self, _others: impl Iterator<Item = &'a ReservedRegion>) {}

    /// Restarts all characters, before the first step, on ground that no other group has reserved, as far as possible.
    fn restart_on_free_ground(&mut self) {}

    /// Appends a snapshot of all that the next steps depend on, with version and checksum.
    fn save(&self, out: &mut Vec<u8>);

    /// Restores a snapshot of characters of the same scene. All later steps are equal, bit by bit; poses are valid at
    /// once, though a leg may be a centimetre off until the next step.
    ///
    /// - `time_s`: time of the snapshot (s).
    ///
    /// # Errors
    /// [`throng_base::Error::Snapshot`]. A part may have been loaded then: [`crate::Simulation::restore`] undoes that.
    fn load(&mut self, bytes: &[u8], time_s: f64) -> Result<()>;

    /// Hash of the state: differs, but for one chance in 2^64, where the motion of any character differs.
    fn hash(&self) -> u64 {
        let mut bytes = Vec::new();
        self.save(&mut bytes);
        Hash128::hash_bytes(&bytes) as u64
    }

    /// Lets a character go to a goal, with the distance from it at which it has arrived (m), or stop without one.
    ///
    /// # Errors
    /// [`throng_base::Error::NoPath`], [`throng_base::Error::Value`] for what it cannot do; nothing has changed then.
    fn order(&mut self, number: usize, _goal: Option<(Vec3, f32)>, _order: &Order) -> Result<()> {
        Err(Error::Gone(Id::first(number)))
    }

    /// Lets a character that stands turn to a heading (rad).
    fn turn_to(&mut self, _number: usize, _heading: f32) -> Result<()> {
        Ok(())
    }

    /// Position and heading of a character; `None` where it has left.
    fn root(&self, number: usize) -> Option<Planar>;

    /// Joints in model space, which the root places in the world; `None` for a character without a body, or one that has left.
    fn pose(&self, number: usize) -> Option<&[Mat3x4; NUM_JOINTS]>;

    /// Planted parts of a character's feet.
    fn contacts(&self, number: usize) -> Contacts;

    /// Bottom of the heel and ball of both feet in the world, where bodies are fitted to skeletons of their own (m).
    fn soles(&self, _member: usize) -> Option<[[Vec3; 2]; 2]> {
        None
    }
}

/// The joints of one character.
pub(crate) fn single_pose(pose: &[Mat3x4]) -> &[Mat3x4; NUM_JOINTS] {
    &pose.as_chunks().0[0]
}

/// Restores a snapshot of a group into which no character has entered, and that none has left, since.
pub(crate) fn load_same(group: &mut impl CharacterGroup, bytes: &[u8]) -> Result<()> {
    let ids = group.bodies().ids.to_vec();
    group.load(bytes)?;
    check_snapshot(group.bodies().ids == ids, "characters", "they are others")
}

/// Bytes of a part of a snapshot.
pub(crate) fn saved_bytes(save: impl FnOnce(&mut Vec<u8>)) -> Bytes {
    let mut bytes = Bytes::default();
    save(&mut bytes.0);
    bytes
}

/// Fails with [`Error::Snapshot`] unless `good`.
pub(crate) fn check_snapshot(good: bool, what: &'static str, why: &str) -> Result<()> {
    ensure(good, || refused_snapshot(what, why))
}

/// Error for bytes that are no snapshot.
pub(crate) fn refused_snapshot(what: &'static str, why: &str) -> Error {
    Error::Snapshot { what, why: format!("{why}; it is damaged") }
}

/// Characters of one part of a step that is split.
pub(crate) const PART: usize = 256;
