//! Interface between agent brains and the crowd that they live in.

use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use throng_base::Result;
use throng_core::body::ArmLayer;

/// Handling of a thing by hands.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Handling {
    /// Number of the thing in the scene.
    pub thing: u16,
    /// Whether the thing is put down; else it is taken.
    pub puts: bool,
    /// Position at which it lies, or is to lie (m).
    pub at: Vec3,
}

/// Gesture of the arms of an agent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShownGesture {
    /// What the arms do; a point that is aimed at is given by the next two.
    pub arm: ArmLayer,
    /// Position at which it is aimed (m).
    pub at: Option<Vec3>,
    /// Number of the agent at which it is aimed, in place of the position.
    pub other: Option<u32>,
    /// End; infinite where it never ends (s).
    pub until_s: f64,
}

/// Number of directions from which a thing can be reached.
pub(crate) const SIDES: u32 = 8;

/// Position of a stand from which a thing is taken or put down, and distance from it at which an agent has arrived (m).
pub type Stance = (Vec3, f32);

/// Reason why there is no stand from which to take a thing or to put it down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StanceError {
    /// No hand is free.
    NoHand,
    /// The thing is too high for all grasps of the motion.
    OutOfReach,
}

/// World of agent brains: what they see of it, and how they act in it. Agents are numbered as in the scene.
pub trait ScenarioStage {
    /// Position of an agent now; `None` where it is not there (m).
    fn position(&self, agent: u32) -> Option<Vec3>;

    /// Agents that walk together with one, itself included.
    fn companions(&self, agent: u32) -> Range<u32>;

    /// Velocity of an agent (m/s).
    fn velocity(&self, agent: u32) -> Vec3;

    /// Sends an agent to a place. `leaves`: it leaves the scene there.
    ///
    /// - returns false where no path leads there.
    ///
    /// # Errors
    /// For a place that cannot be.
    fn order_walk(&mut self, agent: u32, at: Vec3, arrival_m: f32, leaves: bool) -> Result<bool>;

    /// Sends an agent along points. `again`: from the first one again. `begin`: number of the first point to go to; the end of the nearest
    /// leg of a round where absent.
    ///
    /// # Errors
    /// As [`ScenarioStage::order_walk`].
    fn order_route(&mut self, agent: u32, points: &[Vec3], again: bool, begin: Option<u32>) -> Result<bool>;

    /// Number of the point of its way that an agent goes to.
    fn route_leg(&self, agent: u32) -> u32;

    /// Sends an agent to the goal of a happening.
    ///
    /// # Errors
    /// As [`ScenarioStage::order_walk`].
    fn follow_happening(&mut self, agent: u32, happening: u16) -> Result<()>;

    /// Sends an agent on the route that it had before behaviours.
    ///
    /// # Errors
    /// As [`ScenarioStage::order_walk`].
    fn resume_route(&mut self, agent: u32) -> Result<()>;

    /// Stops an agent where it is.
    ///
    /// # Errors
    /// As [`ScenarioStage::order_walk`].
    fn order_halt(&mut self, agent: u32) -> Result<()>;

    /// Sets the desired speed from now on (m/s).
    ///
    /// # Errors
    /// As [`ScenarioStage::order_walk`].
    fn set_speed(&mut self, agent: u32, speed_mps: f32) -> Result<()>;

    /// Orders what the body of an agent does from now on: motion of a tag, facing a place.
    fn show_activity(&mut self, agent: u32, motion: Option<u16>, faces: Option<Vec3>);

    /// Orders a gesture of the arms of an agent's body beside all else, or none.
    fn show_gesture(&mut self, agent: u32, gesture: Option<ShownGesture>);

    /// Lets the body of an agent face another agent from now on, wherever that goes.
    fn face_agent(&mut self, agent: u32, other: u32);

    /// True where a straight line keeps a clearance from all walls, and from closed doors or from all doors (m).
    fn sees(&self, from: Vec3, to: Vec3, clearance_m: f32, through_doors: bool) -> bool;

    /// Position of a thing (m).
    fn thing_position(&self, thing: u16) -> Vec3;

    /// True where an agent has a thing in hand.
    fn has_in_hand(&self, agent: u32, thing: u16) -> bool;

    /// Stand from which an agent takes a thing or puts it down with motion of a tag, and distance from it at which it has arrived (m).
    ///
    /// - `side`: number of the side of the thing: 0 is the one from which the agent comes, others follow to the left and to the right;
    ///   from 8 on the same sides at a larger distance, where the body leans.
    ///
    /// # Errors
    /// The reason why there is no stand.
    fn stance(&self, agent: u32, motion: Option<u16>, handling: Handling, side: u32) -> Result<Stance, StanceError>;

    /// Counts a thing, or a place for it, that an agent could not reach.
    fn count_miss(&mut self);

    /// Begins motion of a tag in which hands take a thing or put it down.
    fn begin_handling(&mut self, agent: u32, motion: Option<u16>, handling: Handling);

    /// True where an agent has taken a thing, or put it down, and the motion is over.
    fn is_handling_over(&self, agent: u32, thing: u16) -> bool;

    /// Ends the handling of a thing. `is_done`: it is complete where no motion shows it; with motion, or where `is_done` is false, the
    /// thing stays where it is.
    ///
    /// - returns true where the agent has the thing in hand.
    fn end_handling(&mut self, agent: u32, thing: u16, is_done: bool) -> bool;

    /// Ends the claim of an agent on a thing: a thing in hand drops to the ground.
    fn drop_thing(&mut self, thing: u16);

    /// Opens or closes a door.
    ///
    /// - returns false where an agent stands in the door.
    ///
    /// # Errors
    /// For a door that is not there.
    fn set_door_open(&mut self, door: u16, open: bool) -> Result<bool>;

    /// Lets an agent enter the scene; false where it finds no room now.
    ///
    /// # Errors
    /// As [`ScenarioStage::order_walk`].
    fn enter_agent(&mut self, agent: u32) -> Result<bool>;

    /// Sets the events that an agent tells and hears of: a bit for each, and the highest bit for meetings.
    ///
    /// # Errors
    /// For an agent that is not there.
    fn set_senses(&mut self, agent: u32, sends: u32, receives: u32) -> Result<()>;

    /// Sets the time at which an agent has to act by itself (s).
    ///
    /// # Errors
    /// For an agent that is not there.
    fn set_timer(&mut self, agent: u32, time_s: Option<f64>) -> Result<()>;

    /// Sets a place that attracts or repels an agent on its path (eq. 17 of Kim, Kim and Shin 2003b); `None` removes it.
    ///
    /// - `n`: number of the interest (< 4).
    /// - `interest`: position (m), strength (m/s2) and range (m).
    ///
    /// # Errors
    /// As [`ScenarioStage::order_walk`].
    fn set_interest(&mut self, agent: u32, n: usize, interest: Option<(Vec3, f32, f32)>) -> Result<()>;

    /// Adds all agents within a distance of a position to `out`, in the order of their numbers.
    fn agents_within(&self, at: Vec3, radius_m: f32, out: &mut Vec<u32>);
}
