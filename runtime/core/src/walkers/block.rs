//! The state of eight walkers.

use crate::blend::MAX_AXES;
use crate::contacts::Contacts;
use crate::planar::Planar;
use crate::pose::{Lane, Lane3};
use serde::{Deserialize, Serialize};
use throng_base::simd::LANES;

/// One foot of eight walkers.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Foot {
    /// Offset of the ankle from its position in the examples, in world space (m).
    pub offset: Lane3,
    /// How fast that changes (m/s).
    pub offset_rate: Lane3,
    /// Sine and cosine of the foot's turn about the vertical.
    pub turn: [Lane; 2],
    /// Bottom of the heel, and the ball, at the last step, in world space (m).
    pub heel: Lane3,
    pub ball: Lane3,
    /// 1 where it was planted at the last step, else 0.
    pub down: Lane,
    /// Height above its position in the examples (m).
    pub rise: Lane,
    /// How fast that changes (m/s).
    pub rise_rate: Lane,
    /// Height over the ground in the examples, at the last step (m).
    pub height: Lane,
    /// Cosine of half the knee's angle at the last step: 0 for a straight leg; -1 until the first step.
    pub bent: Lane,
    /// Progress of a corrective step, 0 to 1; 1 if none is taken.
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

    /// Every number of the lanes.
    fn lanes(&mut self) -> impl Iterator<Item = &mut Lane> {
        let one =
            [&mut self.down, &mut self.rise, &mut self.rise_rate, &mut self.height, &mut self.bent, &mut self.step];
        let three = [&mut self.offset, &mut self.offset_rate, &mut self.heel, &mut self.ball];
        one.into_iter().chain(&mut self.turn).chain(three.into_iter().flatten())
    }
}

/// The state of eight walkers.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[repr(C, align(64))]
pub(crate) struct Block {
    /// Planar root (x, z, heading) in the world at the last step.
    pub root: Lane3,
    /// Heading that was aimed at, at the last step (rad).
    pub aim: Lane,
    /// Speed along the trajectory (m/s).
    pub speed: Lane,
    /// Turning rate of the root (rad/s).
    pub turning: Lane,
    /// Velocity of the blend in the facing frame: left, ahead (m/s, of the database skeleton).
    pub travel: [Lane; 2],
    /// Position in the parameter box, eased.
    pub parameters: [[f32; MAX_AXES]; LANES],
    /// How fast it moves (1/s).
    pub parameter_rates: [[f32; MAX_AXES]; LANES],
    /// Position in the parameter box that was asked for at the last step.
    pub asked: [[f32; MAX_AXES]; LANES],
    /// Generic time, in [0, 1).
    pub phase: Lane,
    /// Lowering of the hips so that both legs reach (m).
    pub drop: Lane,
    /// How fast that changes (m/s).
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

    /// Every number of the lanes, foot by foot.
    fn lanes(&mut self) -> impl Iterator<Item = &mut Lane> {
        let own = [&mut self.aim, &mut self.speed, &mut self.turning, &mut self.phase, &mut self.drop];
        let own = own.into_iter().chain([&mut self.drop_rate, &mut self.placed]);
        own.chain(&mut self.root).chain(&mut self.travel).chain(self.feet.iter_mut().flat_map(Foot::lanes))
    }

    /// Copies a lane of a block.
    pub fn put(&mut self, lane: usize, from: &Self, from_lane: usize) {
        let mut from = *from;
        for (to, from) in self.lanes().zip(from.lanes()) {
            to[lane] = from[from_lane];
        }
        self.parameters[lane] = from.parameters[from_lane];
        self.parameter_rates[lane] = from.parameter_rates[from_lane];
        self.asked[lane] = from.asked[from_lane];
        self.contacts[lane] = from.contacts[from_lane];
    }

    /// True where every number of a lane is finite and below 1e7.
    pub fn is_near(&self, lane: usize) -> bool {
        let points = [self.parameters[lane], self.parameter_rates[lane], self.asked[lane]];
        let mut own = *self;
        points.iter().flatten().copied().chain(own.lanes().map(|of| of[lane])).all(|v| v.abs() < 1e7)
    }

    /// Puts the root of a lane elsewhere; its feet forget where they stood.
    pub fn place(&mut self, lane: usize, root: Planar) {
        for (axis, value) in self.root.iter_mut().zip([root.x, root.z, root.heading]) {
            axis[lane] = value;
        }
        self.aim[lane] = root.heading;
        self.turning[lane] = 0.0;
        self.contacts[lane] = Contacts::NONE;
        for (foot, mut free) in self.feet.iter_mut().zip([Foot::ZERO; 2]) {
            foot.lanes().zip(free.lanes()).for_each(|(to, from)| to[lane] = from[lane]);
        }
    }
}
