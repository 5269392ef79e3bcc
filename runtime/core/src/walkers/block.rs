//! The state of eight walkers.

use crate::blend::MAX_AXES;
use crate::contacts::Contacts;
use crate::planar::Planar;
use crate::pose::{Lane, Lane3, Lanewise, lanewise_fields, planar_of_lane, set_lane};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use throng_base::simd::LANES;

/// Tolerance of the ranges of shares and cosines.
const ROUNDING: f32 = 1e-3;

/// Feet of eight walkers on one side.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct WalkerFoot {
    /// Offset of the ankle from its position in the examples, in world space (m).
    pub offset: Lane3,
    /// Rate of the offset (m/s).
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
    /// Rate of the rise (m/s).
    pub rise_rate: Lane,
    /// Height over the ground in the examples, at the last step (m).
    pub height: Lane,
    /// The plane that it is held over: height below the heel and below the ball (m), rise to the left a metre; and how fast they
    /// change (1/s).
    pub below: Lane3,
    pub below_rate: Lane3,
    /// Cosine of half the knee's angle at the last step: 0 for a straight leg; -1 until the first step.
    pub bent: Lane,
    /// Progress of a corrective step, 0 to 1; 1 if none is taken.
    pub step: Lane,
}

impl WalkerFoot {
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
        below: [[0.0; LANES]; 3],
        below_rate: [[0.0; LANES]; 3],
        bent: [-1.0; LANES],
        step: [1.0; LANES],
    };

    /// True where shares and cosines of a lane are within their ranges.
    fn is_sound(&self, lane: usize) -> bool {
        let is_share = |of: &Lane| (-ROUNDING..=1.0 + ROUNDING).contains(&of[lane]);
        let is_cosine = |of: &Lane| of[lane].abs() <= 1.0 + ROUNDING;
        is_share(&self.step) && is_share(&self.down) && is_cosine(&self.bent) && self.turn.iter().all(is_cosine)
    }
}

/// The state of eight walkers.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[repr(C, align(64))]
pub(crate) struct WalkerBlock {
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
    /// Rate of the parameters (1/s).
    pub parameter_rates: [[f32; MAX_AXES]; LANES],
    /// Position in the parameter box that was asked for at the last step.
    pub asked: [[f32; MAX_AXES]; LANES],
    /// Generic time, in [0, 1).
    pub phase: Lane,
    /// Height of the ground that the hips are held over (m), and how fast it changes (m/s).
    pub base: Lane,
    pub base_rate: Lane,
    /// Lowering of the hips so that both legs reach (m).
    pub drop: Lane,
    /// Rate of the lowering (m/s).
    pub drop_rate: Lane,
    /// 0 until the first step.
    pub placed: Lane,
    pub contacts: [Contacts; LANES],
    /// Left, right.
    pub feet: [WalkerFoot; 2],
}

lanewise_fields!(WalkerFoot {
    offset,
    offset_rate,
    turn,
    heel,
    ball,
    down,
    rise,
    rise_rate,
    height,
    below,
    below_rate,
    bent,
    step
});
lanewise_fields!(WalkerBlock {
    root, aim, speed, turning, travel, phase, base, base_rate, drop, drop_rate, placed, contacts, feet;
    parameters, parameter_rates, asked
});

impl WalkerBlock {
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
        base: [0.0; LANES],
        base_rate: [0.0; LANES],
        drop: [0.0; LANES],
        drop_rate: [0.0; LANES],
        placed: [0.0; LANES],
        contacts: [Contacts::NONE; LANES],
        feet: [WalkerFoot::ZERO; 2],
    };

    /// Planar root of one lane at the last step.
    pub fn root(&self, lane: usize) -> Planar {
        planar_of_lane(&self.root, lane)
    }

    /// True where a walker's numbers can be: shares and cosines within their ranges, everything finite and below 1e7.
    pub fn is_sound(&self, lane: usize) -> bool {
        let is_share = |of: &Lane| (-ROUNDING..=1.0 + ROUNDING).contains(&of[lane]);
        self.is_near(lane)
            && is_share(&self.phase)
            && is_share(&self.placed)
            && self.feet.iter().all(|foot| foot.is_sound(lane))
    }

    /// Moves the root of a lane elsewhere and clears the state of its feet.
    pub fn place_root(&mut self, lane: usize, root: Planar) {
        set_lane(&mut self.root, lane, Vec3::new(root.x, root.z, root.heading));
        self.aim[lane] = root.heading;
        self.turning[lane] = 0.0;
        self.contacts[lane] = Contacts::NONE;
        self.feet.copy_lane(lane, &[WalkerFoot::ZERO; 2], lane);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A step of a foot at -4096 lifts it by a power of four of that, and poses are infinite.
    #[test]
    fn shares_and_cosines_out_of_their_ranges_cannot_be() {
        let of = |change: &dyn Fn(&mut WalkerBlock)| {
            let mut block = WalkerBlock::ZERO;
            change(&mut block);
            [0, 2].map(|lane| block.is_sound(lane))
        };
        assert_eq!(of(&|_| ()), [true, true]);
        assert_eq!(of(&|b| b.feet[0].step[2] = -4096.0), [true, false]);
        assert_eq!(of(&|b| b.feet[1].down[2] = 1.5), [true, false]);
        assert_eq!(of(&|b| b.feet[0].turn[1][2] = -4.0), [true, false]);
        assert_eq!(of(&|b| b.feet[1].bent[2] = 2.0), [true, false]);
        assert_eq!(of(&|b| b.phase[2] = -0.1), [true, false]);
        assert_eq!(of(&|b| b.placed[2] = 3.0), [true, false]);
        assert_eq!(of(&|b| b.root[0][2] = f32::NAN), [true, false]);
        assert_eq!(of(&|b| b.asked[2][5] = 1e8), [true, false]);
        assert_eq!(of(&|b| (b.phase[2], b.feet[0].turn[0][2]) = (1.0, -1.0001)), [true, true]);
    }
}
