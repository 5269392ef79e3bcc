//! Feet that do not slide: while a part of a foot is planted, its motion over the ground is taken away.
//!
//! Each foot carries a correction in world space. While the foot is planted the correction changes by the opposite of
//! what the planted part moved since the last step; while it is in the air the correction decays. There is no
//! moment at which anything jumps, and the leg reaches the corrected place by analytic inverse kinematics.

use super::hierarchy::ModelPose;
use super::lanes::{Lane, Lane3, load, store};
use super::leg::{Leg, NO_CORRECTION, move_leg};
use super::placement::Placement;
use throng_base::maths;
use throng_base::simd::{LANES, Lanes, V};

/// How feet are locked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FootLockConfig {
    /// False leaves the feet as the clips and transitions move them.
    pub enabled: bool,
    /// Time in which the correction of a foot in the air halves (s, > 0).
    pub half_life_s: f32,
    /// The same for a planted foot, over the ground: slow enough not to be seen, so that a character that stands
    /// for long comes back to how its clips stand (s, > 0).
    pub planted_half_life_s: f32,
    /// Largest horizontal correction; a foot that would need more slides (m).
    pub max_correction_m: f32,
    /// How high over the ground the toe of a foot in the air passes at least where it is fast: transitions would let it
    /// skim the ground. 0 leaves it where it is (m, >= 0).
    pub swing_clearance_m: f32,
}

impl Default for FootLockConfig {
    fn default() -> Self {
        Self {
            enabled: true,
            half_life_s: 0.1,
            planted_half_life_s: 2.0,
            max_correction_m: 0.25,
            swing_clearance_m: 0.02,
        }
    }
}

/// Time in which the vertical correction of a planted foot halves (s).
const PLANTED_HEIGHT_HALF_LIFE_S: f32 = 0.3;

/// Speed over the ground at which a toe begins to clear it, and at which it clears it wholly (m/s).
const SWING_MPS: [f32; 2] = [0.2, 0.5];
/// Fastest that a toe is raised to clear the ground (m/s).
const RAISED_MPS: f32 = 0.8;

/// The lock of one foot of eight characters.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct FootLock {
    /// What is added to the foot's position, in world space (m).
    pub correction: Lane3,
    /// Where ankle and toe were sampled at the last step, in world space (m).
    pub ankle: Lane3,
    pub toe: Lane3,
    /// 1 where heel, toe were planted at the last step, else 0.
    pub heel_down: Lane,
    pub toe_down: Lane,
}

impl FootLock {
    pub const ZERO: Self = Self {
        correction: [[0.0; LANES]; 3],
        ankle: [[0.0; LANES]; 3],
        toe: [[0.0; LANES]; 3],
        heel_down: [0.0; LANES],
        toe_down: [0.0; LANES],
    };
}

/// Updates the lock of one foot and moves the leg. `heel` and `toe` are 1 where that part is planted, else 0.
#[inline(always)]
pub(crate) fn lock_foot<F: Lanes>(
    leg: &Leg,
    config: &FootLockConfig,
    dt_s: f32,
    planted: (Lane, Lane),
    place: &Placement<F>,
    lock: &mut FootLock,
    pose: &mut ModelPose<F>,
) {
    let (ankle, toe) = (place.to_world(pose.positions[leg.foot]), place.to_world(pose.positions[leg.toe]));
    let correction = update_correction(leg, config, dt_s, planted, lock, ankle, toe, place.y);
    store(&mut lock.correction, correction);
    store(&mut lock.ankle, ankle);
    store(&mut lock.toe, toe);
    (lock.heel_down, lock.toe_down) = planted;
    if correction.dot(correction).any_gt(F::splat(NO_CORRECTION)) {
        move_leg(leg, place.vector_to_model(correction), pose);
    }
}

#[inline(always)]
#[expect(
    clippy::too_many_arguments,
    reason = "the parts of one lock; a record of them would be made for this call alone"
)]
fn update_correction<F: Lanes>(
    leg: &Leg,
    config: &FootLockConfig,
    dt_s: f32,
    (heel, toe_planted): (Lane, Lane),
    lock: &FootLock,
    ankle: V<F>,
    toe: V<F>,
    ground: F,
) -> V<F> {
    let (half, one) = (F::splat(0.5), F::splat(1.0));
    let (heel, toe_planted) = (F::load(&heel), F::load(&toe_planted));
    // A part holds where it was planted at both steps; where both parts hold, each counts half.
    let (hold_heel, hold_toe) = (heel * F::load(&lock.heel_down), toe_planted * F::load(&lock.toe_down));
    let sum = hold_heel + hold_toe;
    let weight = one / sum.max(one);
    let slide = (ankle - load(&lock.ankle)) * (hold_heel * weight) + (toe - load(&lock.toe)) * (hold_toe * weight);
    let old = load(&lock.correction);
    let keep = |half_life_s: f32| maths::exp(-std::f32::consts::LN_2 * dt_s / half_life_s);
    let held = (old - slide) * F::splat(keep(config.planted_half_life_s));
    let mut new = V::select_lt(sum, half, old * F::splat(keep(config.half_life_s)), held);

    // Over the ground a planted foot eases to the height its clip has it at.
    let height = (old.y - slide.y) * F::splat(keep(PLANTED_HEIGHT_HALF_LIFE_S));
    new.y = F::select_lt(sum, half, new.y, height);

    // A fast toe passes over the ground, and none goes below it.
    let floor = ground + F::splat(leg.toe_height) - toe.y;
    let moved = toe - load(&lock.toe);
    let way = (moved.x * moved.x + moved.z * moved.z).sqrt();
    let [slow, fast] = SWING_MPS.map(|speed| speed * dt_s);
    let share = ((way - F::splat(slow)) / F::splat((fast - slow).max(1e-6))).max(F::splat(0.0)).min(one);
    let clear = floor + (one - heel.max(toe_planted)) * share * F::splat(config.swing_clearance_m);
    let raised = clear.min(old.y + F::splat(RAISED_MPS * dt_s));
    new.y = new.y.max(raised).max(floor);

    // No further than the largest correction over the ground.
    let length = (new.x * new.x + new.z * new.z).sqrt();
    let limit = F::splat(config.max_correction_m);
    let scale = limit / length.max(limit);
    new.x = new.x * scale;
    new.z = new.z * scale;
    new
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::skeleton::Skeleton;
    use glam::Vec3;
    use throng_base::simd::Array;

    /// Height over that of a flat foot of a toe that moves so fast, step by step (m).
    ///
    /// - `height`: where its clip has it (m).
    fn heights(speed_mps: f32, height: f32, planted: f32) -> Vec<f32> {
        let (leg, config, dt_s) = (Leg::both(&Skeleton::default())[0], FootLockConfig::default(), 1.0 / 60.0);
        let mut lock = FootLock::ZERO;
        let step = |i: i32| {
            let toe = Vec3::new(0.0, leg.toe_height + height, speed_mps * dt_s * i as f32);
            let (ankle, toe) = (V::<Array>::splat(toe + Vec3::Y * 0.1), V::splat(toe));
            let planted = ([0.0; LANES], [planted; LANES]);
            let new = update_correction(&leg, &config, dt_s, planted, &lock, ankle, toe, Array::splat(0.0));
            store(&mut lock.correction, new);
            store(&mut lock.ankle, ankle);
            store(&mut lock.toe, toe);
            (lock.heel_down, lock.toe_down) = planted;
            height + new.y.to_array()[3]
        };
        (0..30).map(step).collect()
    }

    #[test]
    fn fast_toes_in_the_air_clear_the_ground_without_a_jump() {
        let skimming = heights(2.0, 0.005, 0.0);
        assert!((skimming[29] - 0.02).abs() < 1e-4, "{skimming:?}");
        assert!(skimming.windows(2).all(|w| w[1] - w[0] < 0.8 / 60.0 + 1e-4), "{skimming:?}");
        // Slow ones come down, high ones and planted ones stay where they are.
        assert!((heights(0.1, 0.005, 0.0)[29] - 0.005).abs() < 1e-4);
        assert!((heights(2.0, 0.05, 0.0)[29] - 0.05).abs() < 1e-4);
        assert!((heights(2.0, 0.005, 1.0)[29] - 0.005).abs() < 1e-4);
        assert!(heights(0.1, -0.03, 0.0).iter().all(|h| *h > -1e-4), "no toe goes below the ground");
    }
}
