//! What walkers remember of eight characters.

use super::super::records::MAX_AXES;
use crate::contacts::Contacts;
use crate::lanes::LANES;
use crate::planar::Planar;
use crate::troupe::block::{Lane, Lane3};

/// One foot of eight characters.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Foot {
    /// What is added to where the examples have the ankle, in world space. [Unit: m]
    pub offset: Lane3,
    /// How fast that changes. [Unit: m/s]
    pub offset_rate: Lane3,
    /// Sine and cosine of what the foot is turned by about the vertical.
    pub turn: [Lane; 2],
    /// Where the bottom of the heel and the ball were at the last step, in world space. [Unit: m]
    pub heel: Lane3,
    pub ball: Lane3,
    /// 1 where it was planted at the last step, else 0.
    pub down: Lane,
    /// How much higher it is than where the examples have it. [Unit: m]
    pub rise: Lane,
    /// How fast that changes. [Unit: m/s]
    pub rise_rate: Lane,
    /// How high over the ground the examples had it at the last step. [Unit: m]
    pub height: Lane,
    /// Cosine of half the angle at the knee at the last step: 0 where the leg is straight; -1 until the first one.
    pub bent: Lane,
    /// How far a step to where it belongs has gone, 0 to 1; 1 where none is being taken.
    pub step: Lane,
}

impl Foot {
    const ZERO: Self = Self {
        offset: [[0.0; LANES]; 3],
        offset_rate: [[0.0; LANES]; 3],
        turn: [[0.0; LANES], [1.0; LANES]],
        heel: [[0.0; LANES]; 3],
        ball: [[0.0; LANES]; 3],
        down: [0.0; LANES],
        rise: [0.0; LANES],
        rise_rate: [0.0; LANES],
        height: [0.0; LANES],
        bent: [-1.0; LANES],
        step: [1.0; LANES],
    };
}

/// Everything that walkers remember of eight characters.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Block {
    /// Planar root (x, z, heading) in the world at the last step.
    pub root: Lane3,
    /// Heading that was aimed at, at the last step. [Unit: rad]
    pub aim: Lane,
    /// Speed along the trajectory. [Unit: m/s]
    pub speed: Lane,
    /// Turning rate of the root. [Unit: rad/s]
    pub turning: Lane,
    /// How the blend travels in the facing frame: left, ahead. [Unit: m/s, of the database skeleton]
    pub travel: [Lane; 2],
    /// Place in the parameter box, eased.
    pub parameters: [[f32; MAX_AXES]; LANES],
    /// How fast it moves. [Unit: 1/s]
    pub parameter_rates: [[f32; MAX_AXES]; LANES],
    /// Place in the parameter box that was asked for at the last step.
    pub asked: [[f32; MAX_AXES]; LANES],
    /// Generic time, in [0, 1).
    pub phase: Lane,
    /// How far the hips are lowered so that both legs reach. [Unit: m]
    pub drop: Lane,
    /// How fast that changes. [Unit: m/s]
    pub drop_rate: Lane,
    /// 0 until the first step.
    pub placed: Lane,
    pub contacts: [Contacts; LANES],
    /// Left, right.
    pub feet: [Foot; 2],
}

impl Block {
    pub const ZERO: Self = Self {
        root: [[0.0; LANES]; 3],
        aim: [0.0; LANES],
        speed: [0.0; LANES],
        turning: [0.0; LANES],
        travel: [[0.0; LANES]; 2],
        parameters: [[0.0; MAX_AXES]; LANES],
        parameter_rates: [[0.0; MAX_AXES]; LANES],
        asked: [[0.0; MAX_AXES]; LANES],
        phase: [0.0; LANES],
        drop: [0.0; LANES],
        drop_rate: [0.0; LANES],
        placed: [0.0; LANES],
        contacts: [Contacts::NONE; LANES],
        feet: [Foot::ZERO; 2],
    };

    /// Planar root of one lane at the last step.
    pub fn root(&self, lane: usize) -> Planar {
        Planar::new(self.root[0][lane], self.root[1][lane], self.root[2][lane])
    }
}
