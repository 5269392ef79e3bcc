//! Carriage: how each person holds trunk, arms and head, a little unlike any other.

use super::{CharactersConfig, block::MotionBlock, control::random_bits};
use crate::body::{LanePose, load};
use crate::skeleton::Joint;
use throng_base::simd::{LANES, Lanes, Q};

/// Middle and largest difference from it of the turns of a joint about its parent's axes: to the left, up and ahead (rad).
const TURNS: [(Joint, [[f32; 2]; 3]); 6] = [
    (Joint::Spine, [[0.0, 0.05], [0.0, 0.08], [0.0, 0.05]]),
    (Joint::Head, [[0.0, 0.08], [0.0, 0.15], [0.0, 0.06]]),
    (Joint::LeftUpperArm, [[0.0, 0.16], [0.0, 0.07], [0.05, 0.08]]),
    (Joint::RightUpperArm, [[0.0, 0.16], [0.0, 0.07], [-0.05, 0.08]]),
    (Joint::LeftForearm, [[-0.04, 0.16], [0.0, 0.07], [0.0, 0.03]]),
    (Joint::RightForearm, [[-0.04, 0.16], [0.0, 0.07], [0.0, 0.03]]),
];
/// Distinguishes these draws from others.
const DRAWS: u64 = 0xCA22;
/// Numbers that a draw gives for an axis.
const DRAWN: u64 = 1 << 20;

/// Turns trunk, arms and head of each character as it holds them.
#[inline(always)]
pub(crate) fn add_carriage<F: Lanes>(pose: &mut LanePose<F>, block: &MotionBlock, config: &CharactersConfig) {
    if config.carriage == 0.0 {
        return;
    }
    for (k, (joint, turns)) in TURNS.iter().enumerate() {
        let mut turn = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let number = config.first_number.wrapping_add(block.name[lane]);
            let mut bits = random_bits(config.seed ^ DRAWS, number, k as u64);
            for (axis, [middle, most]) in turn.iter_mut().zip(turns) {
                let share = (bits % DRAWN) as f32 * (2.0 / DRAWN as f32) - 1.0;
                bits /= DRAWN;
                // Modified Rodrigues parameters of a small turn are a quarter of it.
                axis[lane] = 0.25 * config.carriage * (middle + most * share);
            }
        }
        let q = &mut pose.rotations[joint.index()];
        *q = Q::from_mrp(load::<F>(&turn)) * *q;
    }
}
