//! Class of motion: posture, gait, and how a body carries itself, for every frame of a clip.

use serde::{Deserialize, Serialize};
use std::{fmt, ops::Range};
use throng_base::thresholds::JOG_BELOW_MPS;

/// How high a body holds its trunk.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Posture {
    /// On its feet, legs about straight.
    #[default]
    Upright,
    /// On its feet, hips low or trunk bent far.
    Crouched,
    /// The seat carries the weight.
    Seated,
    /// The trunk is about level: lying, crawling, on all fours.
    Lying,
}

/// How feet carry a body over the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Gait {
    /// Stays where it is, turns on the spot included.
    #[default]
    Stand,
    /// Walks ahead: a foot is always on the ground.
    Walk,
    /// Runs or jogs ahead: both feet leave the ground.
    #[serde(alias = "jog")]
    Run,
    /// Walks ahead, crouched or by stealth.
    Sneak,
    /// Goes to its side.
    Strafe,
    /// Goes backwards.
    Backwards,
    /// Feet leave the ground otherwise: jumps, climbing, falls.
    Other,
}

/// Class of motion.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct MotionClass {
    /// How high the trunk is held.
    pub posture: Posture,
    /// How feet carry it.
    pub gait: Gait,
    /// True for standing at ease: arms and trunk at rest, no gesture. False for all that goes.
    pub neutral: bool,
    /// True where hands hold a load.
    pub carrying: bool,
    /// Manner, such as `angry`; empty where nothing sets it apart.
    pub manner: String,
}

/// Frames of one class.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ClassSpan {
    /// The frames within their clip.
    pub frames: Range<u32>,
    /// Their class.
    pub class: MotionClass,
    /// Mean speed of the hips over the ground (m/s).
    pub speed_mps: f32,
    /// Direction of travel relative to that in which the body faces: left is positive, 0 where it stays (degrees).
    pub travel_deg: f32,
}

impl Posture {
    /// The name, as configs and reports write it.
    pub fn name(self) -> &'static str {
        ["upright", "crouched", "seated", "lying"][self as usize]
    }
}

impl Gait {
    /// The name, as configs and reports write it.
    pub fn name(self) -> &'static str {
        ["stand", "walk", "run", "sneak", "strafe", "backwards", "other"][self as usize]
    }
}

impl ClassSpan {
    /// Name of the gait: `jog` for a slow run.
    pub fn gait_name(&self) -> &'static str {
        if self.class.gait == Gait::Run && self.speed_mps < JOG_BELOW_MPS { "jog" } else { self.class.gait.name() }
    }
}

impl fmt::Display for MotionClass {
    /// Writes the words that set the class apart, such as `crouched walk, angry`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let posture = if self.posture == Posture::Upright { "" } else { self.posture.name() };
        let neutral = if self.neutral { "neutral" } else { "" };
        let carrying = if self.carrying { "carrying" } else { "" };
        let words = [neutral, posture, self.gait.name(), carrying];
        f.write_str(&words.iter().filter(|w| !w.is_empty()).copied().collect::<Vec<_>>().join(" "))?;
        if self.manner.is_empty() { Ok(()) } else { write!(f, ", {}", self.manner) }
    }
}
