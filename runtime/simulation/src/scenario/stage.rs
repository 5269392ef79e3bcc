//! What minds ask of the crowd that they live in.

use glam::Vec3;
use serde::{Deserialize, Serialize};
use throng_base::Result;

/// What hands do with a thing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Handling {
    /// Its number in the scene.
    pub thing: u16,
    /// It is put down; else it is taken.
    pub puts: bool,
    /// Where it lies, or is to lie (m).
    pub at: Vec3,
}

/// Directions from which a thing is reached.
pub(crate) const SIDES: u32 = 8;

/// Why one stands nowhere to take a thing or to put it down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoStance {
    /// No hand is free.
    NoHand,
    /// It is too high for all motion that there is.
    OutOfReach,
}

/// The world as minds see it, and how they act in it. Agents are numbered as in the scene.
pub trait Stage {
    /// Where an agent is now; `None` where it is not there (m).
    fn position(&self, agent: u32) -> Option<Vec3>;

    /// How it moves (m/s).
    fn velocity(&self, agent: u32) -> Vec3;

    /// Sends an agent somewhere. `leaves`: out of the scene, once there.
    ///
    /// - returns false where no way leads there.
    ///
    /// # Errors
    /// For a place that cannot be.
    fn go(&mut self, agent: u32, at: Vec3, arrival_m: f32, leaves: bool) -> Result<bool>;

    /// Sends an agent along points. `again`: from the first one again.
    ///
    /// # Errors
    /// As [`Stage::go`].
    fn follow(&mut self, agent: u32, points: &[Vec3], again: bool) -> Result<bool>;

    /// Sends an agent to the goal of a happening.
    ///
    /// # Errors
    /// As [`Stage::go`].
    fn follow_happening(&mut self, agent: u32, happening: u16) -> Result<()>;

    /// Sends an agent on the way that it had before behaviours.
    ///
    /// # Errors
    /// As [`Stage::go`].
    fn resume(&mut self, agent: u32) -> Result<()>;

    /// Lets an agent stay where it is.
    ///
    /// # Errors
    /// As [`Stage::go`].
    fn halt(&mut self, agent: u32) -> Result<()>;

    /// Desired speed from now on (m/s).
    ///
    /// # Errors
    /// As [`Stage::go`].
    fn set_speed(&mut self, agent: u32, speed_mps: f32) -> Result<()>;

    /// What the body of an agent does from now on: motion of a tag, facing a place.
    fn show(&mut self, agent: u32, motion: Option<u16>, faces: Option<Vec3>);

    /// Where a thing is (m).
    fn thing_at(&self, thing: u16) -> Vec3;

    /// True where an agent has a thing in hand.
    fn has_in_hand(&self, agent: u32, thing: u16) -> bool;

    /// Where an agent stands to take a thing or to put it down with motion of a tag, and how near is there (m).
    ///
    /// - `side`: from which side: 0 is the one from which the agent comes, others follow it to the left and to the right; from 8
    ///   on the same a little farther off, where the body leans.
    ///
    /// # Errors
    /// Why it stands nowhere.
    fn stance(
        &self,
        agent: u32,
        motion: Option<u16>,
        handling: Handling,
        side: u32,
    ) -> std::result::Result<(Vec3, f32), NoStance>;

    /// Somebody could not reach a thing, or where it was to be put.
    fn missed(&mut self);

    /// Lets hands take a thing or put it down, in the course of motion of a tag.
    fn handle(&mut self, agent: u32, motion: Option<u16>, handling: Handling);

    /// True where an agent has taken a thing, or put it down, and the motion is over.
    fn is_over(&self, agent: u32, thing: u16) -> bool;

    /// What hands do with a thing ends. `is_done`: as it was meant, where no motion shows it; with motion, or else, the thing
    /// stays where it is.
    ///
    /// - returns true where the agent has it in hand.
    fn settle(&mut self, agent: u32, thing: u16, is_done: bool) -> bool;

    /// Who had a claim on a thing has none any more: out of a hand it drops to the ground.
    fn let_go(&mut self, thing: u16);

    /// Opens or closes a door.
    ///
    /// - returns false where somebody stands in it.
    ///
    /// # Errors
    /// For a door that is not there.
    fn set_open(&mut self, door: u16, open: bool) -> Result<bool>;

    /// Lets an agent enter that was not there; false where it finds no room now.
    ///
    /// # Errors
    /// As [`Stage::go`].
    fn enter(&mut self, agent: u32) -> Result<bool>;

    /// What an agent tells and hears: bits of events, and the highest for meetings.
    ///
    /// # Errors
    /// For an agent that is not there.
    fn sense(&mut self, agent: u32, tells: u32, hears: u32) -> Result<()>;

    /// When an agent has to act by itself (s).
    ///
    /// # Errors
    /// For an agent that is not there.
    fn set_timer(&mut self, agent: u32, time_s: Option<f64>) -> Result<()>;

    /// Something that draws an agent near, or drives it away (eq. 17 of Kim, Kim and Shin 2003b), on its way; `None` for nothing
    /// any more.
    ///
    /// - `n`: which of its interests (< 4).
    /// - `interest`: where, how strongly (m/s2), and how far it is felt (m).
    ///
    /// # Errors
    /// As [`Stage::go`].
    fn attract(&mut self, agent: u32, n: usize, interest: Option<(Vec3, f32, f32)>) -> Result<()>;

    /// Everybody within a distance of a place, in the order of their numbers.
    fn within(&self, at: Vec3, radius_m: f32, out: &mut Vec<u32>);
}
