//! Problems as applications say them.

use crate::body::BodyShape;
use crate::driven::Driven;
use crate::limits::BodyLimits;
use crate::linkage::Linkage;
use crate::problem::{Level, Solid, State};
use crate::shape::Segment;
use glam::DVec3;
use throng_core::{Joint, Skeleton};

/// Another character.
#[derive(Clone, Copy, Debug)]
pub struct Other<'a> {
    /// How messages and allowances call it.
    pub name: &'a str,
    /// How it moves.
    pub motion: &'a Driven,
    /// How thick it is.
    pub shape: &'a BodyShape,
}

/// A capsule that hand or foot carries: a stick, a rib of an umbrella.
#[derive(Clone, Debug, PartialEq)]
pub struct Held {
    /// How messages and allowances call it.
    pub name: String,
    /// In the frame of the linkage's last joint (m).
    pub core: Segment,
    /// (m, > 0)
    pub radius: f64,
}

/// Two things that may touch.
#[derive(Clone, Debug, PartialEq)]
pub struct Allowed {
    /// A joint by its name, or something held; `None` for all of the own body and what it holds.
    pub part: Option<String>,
    /// A solid, another character, or a joint of the own body.
    pub with: String,
    /// From when to when (s); `None` for always.
    pub window_s: Option<[f64; 2]>,
}

/// The other hand at what is held: a place on the hand or foot that stays within reach of another joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tether {
    /// The joint from which it is reached: the other shoulder.
    pub from: Joint,
    /// The other wrist, in the frame of the linkage's last joint (m).
    pub at: DVec3,
    /// Least and greatest distance between both (m).
    pub distances_m: [f64; 2],
}

/// A problem before it is checked.
#[derive(Clone, Debug)]
pub struct ProblemSpec<'a> {
    /// Proportions of the character.
    pub skeleton: &'a Skeleton,
    /// Which joints are planned.
    pub linkage: Linkage,
    /// How far and how fast they turn.
    pub limits: &'a BodyLimits,
    /// What the other joints do, and the planned ones did.
    pub motion: &'a Driven,
    /// How thick the body is.
    pub shape: &'a BodyShape,
    /// Where it begins.
    pub init: State,
    /// Where it ends.
    pub goal: State,
    /// What is around.
    pub solids: &'a [Solid],
    /// Who is around.
    pub others: &'a [Other<'a>],
    /// What hand or foot carries.
    pub held: &'a [Held],
    /// What may touch.
    pub allowed: &'a [Allowed],
    /// Where the other hand is at what is held.
    pub tether: Option<Tether>,
    /// What is held stays upright.
    pub level: Option<Level>,
    /// How far everything stays from solids and from others (m, >= 0).
    pub clearance_m: f64,
    /// How deep parts of the own body may press into each other, as flesh does (m, >= 0).
    pub self_press_m: f64,
    /// True widens limits so far that both ends are within them: performers bend farther than books say.
    pub admit_ends: bool,
    /// True plans although what is not planned collides by itself: the limb gives way all the same.
    pub admit_driven: bool,
}

impl<'a> ProblemSpec<'a> {
    /// Of the usual clearances, in an empty world.
    pub fn new(
        skeleton: &'a Skeleton,
        linkage: Linkage,
        limits: &'a BodyLimits,
        motion: &'a Driven,
        shape: &'a BodyShape,
        [init, goal]: [State; 2],
    ) -> Self {
        Self {
            skeleton,
            linkage,
            limits,
            motion,
            shape,
            init,
            goal,
            solids: &[],
            others: &[],
            held: &[],
            allowed: &[],
            tether: None,
            level: None,
            clearance_m: 0.005,
            self_press_m: 0.02,
            admit_ends: false,
            admit_driven: false,
        }
    }
}
