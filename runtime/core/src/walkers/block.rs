//! The state of eight walkers.

use crate::body::{BodyState, FootLock, Lane, Lane3, Lanewise, is_share, lanewise_fields, planar_of_lane, set_lane};
use crate::{blend::MAX_AXES, contacts::Contacts, planar::Planar};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use throng_base::simd::LANES;

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
    /// Direction of the trajectory (rad).
    pub course: Lane,
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
    /// 0 until the first step.
    pub placed: Lane,
    pub contacts: [Contacts; LANES],
    /// Left, right.
    pub feet: [FootLock; 2],
    pub body: BodyState,
}

lanewise_fields!(WalkerBlock {
    root, aim, speed, course, turning, travel, phase, placed, contacts, feet, body;
    parameters, parameter_rates, asked
});

impl WalkerBlock {
    pub const ZERO: Self = Self {
        root: [[0.0; LANES]; 3],
        aim: [0.0; LANES],
        speed: [0.0; LANES],
        course: [0.0; LANES],
        turning: [0.0; LANES],
        travel: [[0.0; LANES]; 2],
        parameters: [[0.0; MAX_AXES]; LANES],
        parameter_rates: [[0.0; MAX_AXES]; LANES],
        asked: [[0.0; MAX_AXES]; LANES],
        phase: [0.0; LANES],
        placed: [0.0; LANES],
        contacts: [Contacts::NONE; LANES],
        feet: [FootLock::ZERO; 2],
        body: BodyState::ZERO,
    };

    /// Planar root of one lane at the last step.
    pub fn root(&self, lane: usize) -> Planar {
        planar_of_lane(&self.root, lane)
    }

    /// True where a walker's numbers can be: shares and cosines within their ranges, everything finite and below 1e7.
    pub fn is_sound(&self, lane: usize) -> bool {
        self.is_near(lane)
            && is_share(self.phase[lane])
            && is_share(self.placed[lane])
            && self.feet.iter().all(|foot| foot.is_sound(lane))
    }

    /// Moves the root of a lane elsewhere and clears the state of its feet. Its speed stays, and turns with it.
    pub fn place_root(&mut self, lane: usize, root: Planar) {
        self.course[lane] += root.heading - self.root[2][lane];
        set_lane(&mut self.root, lane, Vec3::new(root.x, root.z, root.heading));
        self.aim[lane] = root.heading;
        self.turning[lane] = 0.0;
        self.contacts[lane] = Contacts::NONE;
        self.feet.copy_lane(lane, &[FootLock::ZERO; 2], lane);
        self.body.copy_lane(lane, &BodyState::ZERO, lane);
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
