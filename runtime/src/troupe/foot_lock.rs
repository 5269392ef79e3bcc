//! Feet that do not slide: while a part of a foot is planted, its motion over the ground is taken away.
//!
//! Each foot carries a correction in world space. While the foot is planted the correction changes by the opposite of
//! what the planted part moved since the last step; while it is in the air the correction decays. There is no
//! moment at which anything jumps, and the leg reaches the corrected place by analytic inverse kinematics.

use super::block::{FootLock, Lane, load, store};
use super::hierarchy::ModelPose;
use crate::lanes::{Lanes, Q, V};
use crate::skeleton::{Joint, Skeleton};

/// How feet are locked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FootLockConfig {
    /// False leaves the feet as the clips and transitions move them.
    pub enabled: bool,
    /// Time in which the correction of a foot in the air halves. [Unit: s] [Limit: > 0]
    pub half_life_s: f32,
    /// The same for a planted foot, over the ground: slow enough not to be seen, so that a character that stands
    /// for long comes back to how its clips stand. [Unit: s] [Limit: > 0]
    pub planted_half_life_s: f32,
    /// Largest horizontal correction; a foot that would need more slides. [Unit: m]
    pub max_correction_m: f32,
}

impl Default for FootLockConfig {
    fn default() -> Self {
        Self { enabled: true, half_life_s: 0.1, planted_half_life_s: 2.0, max_correction_m: 0.25 }
    }
}

/// Share of the leg's length past which a corrected leg is not stretched, so that the knee stays soft.
const SOFT_REACH: f32 = 0.995;

/// Time in which the vertical correction of a planted foot halves. [Unit: s]
const PLANTED_HEIGHT_HALF_LIFE_S: f32 = 0.3;

/// Squared length of a correction that is none. [Unit: m^2]
const NO_CORRECTION: f32 = 1e-10;

/// The joints of one leg and their lengths.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leg {
    pub thigh: usize,
    pub shin: usize,
    pub foot: usize,
    pub toe: usize,
    thigh_length: f32,
    shin_length: f32,
    /// Height of the toe over the ground when the foot stands flat. [Unit: m]
    toe_height: f32,
}

impl Leg {
    /// Left and right leg of a skeleton.
    pub fn both(skeleton: &Skeleton) -> [Self; 2] {
        use Joint::*;
        let rest = skeleton.rest_positions();
        [[LeftThigh, LeftShin, LeftFoot, LeftToe], [RightThigh, RightShin, RightFoot, RightToe]].map(|leg| {
            let [thigh, shin, foot, toe] = leg.map(Joint::index);
            Self {
                thigh,
                shin,
                foot,
                toe,
                thigh_length: skeleton.offsets[shin].length(),
                shin_length: skeleton.offsets[foot].length(),
                toe_height: rest[toe].y,
            }
        })
    }
}

/// The planar roots of eight characters, as what turns model space into world space and back.
pub(crate) struct Placement<F> {
    pub x: F,
    /// Height of the ground that the clip stands on, which model space contains. [Unit: m]
    pub y: F,
    pub z: F,
    pub sin: F,
    pub cos: F,
}

impl<F: Lanes> Placement<F> {
    #[inline(always)]
    pub fn to_world(&self, p: V<F>) -> V<F> {
        V::new(self.cos * p.x + self.sin * p.z + self.x, p.y, self.cos * p.z - self.sin * p.x + self.z)
    }

    #[inline(always)]
    pub fn point_to_model(&self, p: V<F>) -> V<F> {
        self.vector_to_model(V::new(p.x - self.x, p.y, p.z - self.z))
    }

    #[inline(always)]
    pub fn vector_to_world(&self, v: V<F>) -> V<F> {
        V::new(self.cos * v.x + self.sin * v.z, v.y, self.cos * v.z - self.sin * v.x)
    }

    #[inline(always)]
    pub fn vector_to_model(&self, v: V<F>) -> V<F> {
        V::new(self.cos * v.x - self.sin * v.z, v.y, self.sin * v.x + self.cos * v.z)
    }
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
    let keep = |half_life_s: f32| (-std::f32::consts::LN_2 * dt_s / half_life_s).exp();
    let held = (old - slide) * F::splat(keep(config.planted_half_life_s));
    let mut new = V::select_lt(sum, half, old * F::splat(keep(config.half_life_s)), held);

    // Over the ground a planted foot eases to the height its clip has it at.
    let height = (old.y - slide.y) * F::splat(keep(PLANTED_HEIGHT_HALF_LIFE_S));
    new.y = F::select_lt(sum, half, new.y, height);

    // No toe goes below the ground.
    new.y = new.y.max(ground + F::splat(leg.toe_height) - toe.y);

    // No further than the largest correction over the ground.
    let length = (new.x * new.x + new.z * new.z).sqrt();
    let limit = F::splat(config.max_correction_m);
    let scale = limit / length.max(limit);
    new.x = new.x * scale;
    new.z = new.z * scale;
    new
}

/// Where the knee of a leg (or the elbow of an arm) lies that begins at `start` and ends `d` away in a direction.
///
/// - `lengths`: of the upper and the lower part. [Unit: m]
/// - `pole`: where the knee points; along the direction it is free.
#[inline(always)]
pub(crate) fn bend<F: Lanes>(start: V<F>, direction: V<F>, d: F, [l1, l2]: [F; 2], pole: V<F>) -> V<F> {
    let pole = pole - direction * pole.dot(direction);
    let pole = pole * (F::splat(1.0) / pole.length().max(F::splat(1e-6)));
    let along = (l1 * l1 - l2 * l2 + d * d) / (d + d);
    let across = (l1 * l1 - along * along).max(F::splat(0.0)).sqrt();
    start + direction * along + pole * across
}

/// Moves the ankle by `correction` (model space) and bends the leg to reach; the foot keeps its orientation.
#[inline(always)]
pub(crate) fn move_leg<F: Lanes>(leg: &Leg, correction: V<F>, pose: &mut ModelPose<F>) {
    let one = F::splat(1.0);
    let (hip, knee, ankle) = (pose.positions[leg.thigh], pose.positions[leg.shin], pose.positions[leg.foot]);
    let (l1, l2) = (F::splat(leg.thigh_length), F::splat(leg.shin_length));
    let before = ankle - hip;
    let aim = before + correction;
    let reach = (F::splat(leg.thigh_length + leg.shin_length) * F::splat(SOFT_REACH)).max(before.length());
    let distance = aim.length().max(F::splat(1e-4));
    let d = distance.min(reach).max((l1 - l2).abs() + F::splat(1e-3));
    let direction = aim * (one / distance);

    // The knee stays in the plane it bends in; where the leg is straight, it bends towards the toes.
    let forward = pose.rotations[leg.thigh].rotate(V::splat(glam::Vec3::Z));
    let new_knee = bend(hip, direction, d, [l1, l2], (knee - hip) + forward * F::splat(0.02));
    let new_ankle = hip + direction * d;

    // Lanes that need no correction keep their leg to the last bit, whatever their neighbours do.
    let amount = correction.dot(correction);
    let chosen_v = |old: V<F>, new: V<F>| V::select_lt(F::splat(NO_CORRECTION), amount, new, old);
    let chosen_q = |old: Q<F>, new: Q<F>| {
        Q::new(chosen_v(old.v, new.v), F::select_lt(F::splat(NO_CORRECTION), amount, new.w, old.w))
    };
    let (thigh, shin) = (pose.rotations[leg.thigh], pose.rotations[leg.shin]);
    pose.rotations[leg.thigh] = chosen_q(thigh, Q::between(knee - hip, new_knee - hip) * thigh);
    pose.rotations[leg.shin] = chosen_q(shin, Q::between(ankle - knee, new_ankle - new_knee) * shin);
    let toe = pose.positions[leg.toe];
    pose.positions[leg.toe] = chosen_v(toe, toe + (new_ankle - ankle));
    pose.positions[leg.shin] = chosen_v(knee, new_knee);
    pose.positions[leg.foot] = chosen_v(ankle, new_ankle);
}
