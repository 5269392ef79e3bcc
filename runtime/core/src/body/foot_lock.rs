//! Feet that do not slide: while a part of a foot is planted, its motion over the ground is taken away.
//!
//! Each foot carries two corrections in world space: of its ankle, and of the vector from there to its toe. While heel
//! or toe is planted, corrections change by the opposite of the motion of the planted part since the last step, so that
//! both stay where they are; free corrections decay. There is no moment at which anything jumps. The leg reaches the
//! corrected ankle by analytic inverse kinematics, and the foot turns about it.

use super::ground_plane::FootPlane;
use super::hierarchy::ModelPose;
use super::lane_body::{LEGS, LaneBody};
use super::lanes::{Lane, Lane3, load, store};
use super::lanewise::lanewise_fields;
use super::limbs::{NO_CORRECTION, move_leg, turn_foot};
use super::placement::PlacementLanes;
use crate::skeleton::Joint;
use throng_base::maths;
use throng_base::simd::{LANES, Lanes, V};
use throng_base::thresholds::{FOOT_RELEASED_MPS, TOE_CLEARANCE_M, TOE_RAISED_MPS, TOE_SWING_MPS};

/// Settings of the foot lock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FootLockConfig {
    /// False leaves the feet as the clips and transitions move them.
    pub enabled: bool,
    /// Time in which the correction of a foot in the air halves (s, > 0).
    pub half_life_s: f32,
    /// Half-life of the correction of a planted foot, over the ground: slow enough not to be visible, so that a
    /// character that stands for long returns to the stance of its clips (s, > 0).
    pub planted_half_life_s: f32,
    /// Fastest that a planted foot comes back, over the ground (m/s, > 0).
    pub planted_return_mps: f32,
    /// Largest horizontal correction; a foot that would need more slides (m).
    pub max_correction_m: f32,
    /// Smallest height over the ground of the toe of a foot in the air while it is fast: transitions would let it skim
    /// the ground. 0 leaves it as it is (m, >= 0).
    pub swing_clearance_m: f32,
}

impl Default for FootLockConfig {
    fn default() -> Self {
        Self {
            enabled: true,
            half_life_s: 0.1,
            planted_half_life_s: 2.0,
            planted_return_mps: 0.01,
            max_correction_m: 0.3,
            swing_clearance_m: TOE_CLEARANCE_M,
        }
    }
}

/// Time in which the vertical correction of a planted foot halves, and its turn where heel or toe alone is planted (s).
const PLANTED_HEIGHT_HALF_LIFE_S: f32 = 0.3;

/// Largest correction of the vector from ankle to toe, as a share of it: a foot that would turn by more than about 30
/// degrees slides.
const MAX_TURN: f32 = 0.5;

/// The lock of one foot of eight characters.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct FootLock {
    /// Correction of the foot's position, in world space (m).
    pub correction: Lane3,
    /// Correction of the vector from ankle to toe, in world space (m).
    pub turn: Lane3,
    /// Sampled positions of ankle and toe at the last step, in world space (m).
    pub ankle: Lane3,
    pub toe: Lane3,
    /// 1 where heel, toe were planted at the last step, else 0.
    pub heel_down: Lane,
    pub toe_down: Lane,
    pub plane: FootPlane,
    /// Cosine of half the knee's angle at the last step on uneven ground: 0 for a straight leg.
    pub bent: Lane,
}

lanewise_fields!(FootLock { correction, turn, ankle, toe, heel_down, toe_down, plane, bent });

impl FootLock {
    pub const ZERO: Self = Self {
        correction: [[0.0; LANES]; 3],
        turn: [[0.0; LANES]; 3],
        ankle: [[0.0; LANES]; 3],
        toe: [[0.0; LANES]; 3],
        heel_down: [0.0; LANES],
        toe_down: [0.0; LANES],
        plane: FootPlane::ZERO,
        bent: [0.0; LANES],
    };
}

/// Effect of a tick on every lock.
pub(crate) struct LockStep {
    /// Shares of a correction that are left in the air, of a planted foot, and of its height.
    in_air: f32,
    planted: f32,
    height: f32,
    /// Largest displacements in a tick by which a planted foot and one in the air come back, and a toe is raised (m).
    returned: f32,
    released: f32,
    raised: f32,
    /// Distances over the ground in a tick from which a toe begins to clear it and from which it wholly does (m).
    swing: [f32; 2],
    max_correction: f32,
    clearance: f32,
}

impl LockStep {
    pub fn new(config: &FootLockConfig, dt_s: f32) -> Self {
        let keep = |half_life_s: f32| maths::exp(-std::f32::consts::LN_2 * dt_s / half_life_s);
        Self {
            in_air: keep(config.half_life_s),
            planted: keep(config.planted_half_life_s),
            height: keep(PLANTED_HEIGHT_HALF_LIFE_S),
            returned: config.planted_return_mps * dt_s,
            released: FOOT_RELEASED_MPS * dt_s,
            raised: TOE_RAISED_MPS * dt_s,
            swing: TOE_SWING_MPS.map(|speed| speed * dt_s),
            max_correction: config.max_correction_m,
            clearance: config.swing_clearance_m,
        }
    }

    /// A correction a tick later. Over the ground, that of a planted foot comes back slowly, and a free one fast;
    /// neither exceeds the limit.
    ///
    /// - `free`: share of a free correction that remains.
    ///
    /// A function and no closure: those are compiled without the processor's vectors.
    #[inline(always)]
    fn eased<F: Lanes>(&self, v: V<F>, is_held: F, free: F, limit: F) -> V<F> {
        let half = F::splat(0.5);
        let length = (v.x * v.x + v.z * v.z).sqrt();
        let slow = (length * F::splat(self.planted)).max(length - F::splat(self.returned));
        let fast = (length * free).max(length - F::splat(self.released));
        let scale = F::select_lt(is_held, half, fast, slow).min(limit) / length.max(F::splat(1e-9));
        // A planted foot eases to its height in the clip.
        V { x: v.x * scale, y: v.y * F::select_lt(is_held, half, free, F::splat(self.height)), z: v.z * scale }
    }
}

/// Which parts of a foot the motion plants, in each lane: 1 where it does, else 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlantedParts {
    pub heel: Lane,
    pub toe: Lane,
}

/// Updates the lock of one foot and moves the leg.
///
/// - `floor`: height of the ground below the toe (m).
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "one foot of one block, in one call")]
pub(super) fn lock_foot<F: Lanes>(
    body: &LaneBody,
    side: usize,
    step: &LockStep,
    planted: &PlantedParts,
    floor: F,
    place: &PlacementLanes<F>,
    lock: &mut FootLock,
    pose: &mut ModelPose<F>,
) {
    let [_, _, foot_at, toe_at] = LEGS[side].map(Joint::index);
    let (ankle, toe) = (place.to_world(pose.positions[foot_at]), place.to_world(pose.positions[toe_at]));
    let flat = floor + F::load(&body.legs[side].thickness);
    let (correction, turn) = update(step, planted, lock, ankle, toe, flat);
    store(&mut lock.correction, correction);
    store(&mut lock.turn, turn);
    store(&mut lock.ankle, ankle);
    store(&mut lock.toe, toe);
    (lock.heel_down, lock.toe_down) = (planted.heel, planted.toe);
    if correction.dot(correction).any_gt(F::splat(NO_CORRECTION)) {
        move_leg(body, side, place.vector_to_model(correction), pose);
    }
    if turn.dot(turn).any_gt(F::splat(NO_CORRECTION)) {
        turn_foot(side, place.vector_to_model(turn), pose);
    }
}

/// Corrections of the ankle, and of the vector from there to the toe.
///
/// - `flat`: height of the toe where the foot stands flat (m).
#[inline(always)]
fn update<F: Lanes>(
    step: &LockStep,
    planted: &PlantedParts,
    lock: &FootLock,
    ankle: V<F>,
    toe: V<F>,
    flat: F,
) -> (V<F>, V<F>) {
    let (half, one) = (F::splat(0.5), F::splat(1.0));
    let (heel, toe_planted) = (F::load(&planted.heel), F::load(&planted.toe));
    // A part holds where it was planted at both steps.
    let (hold_heel, hold_toe) = (heel * F::load(&lock.heel_down), toe_planted * F::load(&lock.toe_down));
    let held = hold_heel.max(hold_toe);
    let (ankle_moved, toe_moved) = (ankle - load(&lock.ankle), toe - load(&lock.toe));

    // Where both parts are planted, the vector between them is kept; about a single planted part, the foot turns back
    // gently.
    let both = hold_heel * hold_toe;
    let (was, old_turn) = (load(&lock.correction), load(&lock.turn));
    let (in_air, offset) = (F::splat(step.in_air), toe - ankle);
    let square = offset.dot(offset);
    let free = F::select_lt(held, half, in_air, F::splat(step.height));
    let whole = old_turn - (toe_moved - ankle_moved) * both;
    let turn = step.eased(whole, both, free, square.sqrt() * F::splat(MAX_TURN));
    // No foot grows longer.
    let turned = offset + turn;
    let turn = turned * (square / turned.dot(turned).max(F::splat(1e-9))).sqrt() - offset;

    // A toe that holds without the heel moves the ankle by what the foot turns; what a turn lacks, both share.
    let of_toe = (toe_moved + turn - old_turn) * (hold_toe * (one - hold_heel));
    let slide = ankle_moved * hold_heel + of_toe + (turn - whole) * (both * half);
    let mut new = step.eased(was - slide, held, in_air, F::splat(step.max_correction));

    // A fast toe passes over the ground, and none goes below it.
    let floor = flat - toe.y - turn.y;
    let moved = (toe_moved.x * toe_moved.x + toe_moved.z * toe_moved.z).sqrt();
    let [slow, fast] = step.swing;
    let share = ((moved - F::splat(slow)) * F::splat(1.0 / (fast - slow).max(1e-6))).max(F::splat(0.0)).min(one);
    let clear = floor + (one - heel.max(toe_planted)) * share * F::splat(step.clearance);
    let raised = clear.min(was.y + F::splat(step.raised));
    new.y = new.y.max(raised).max(floor);
    (new, turn)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::skeleton::Skeleton;
    use glam::Vec3;
    use throng_base::simd::ArrayLanes;

    /// Height over that of a flat foot of a toe that moves so fast, step by step (m).
    ///
    /// - `height`: where its clip has it (m).
    fn heights(speed_mps: f32, height: f32, planted: f32) -> Vec<f32> {
        let (flat, dt_s) = (Skeleton::default().rest_positions()[Joint::LeftToe.index()].y, 1.0 / 60.0);
        let lock_step = LockStep::new(&FootLockConfig::default(), dt_s);
        let mut lock = FootLock::ZERO;
        let step = |i: i32| {
            let toe = Vec3::new(0.0, flat + height, speed_mps * dt_s * i as f32);
            let (ankle, toe) = (V::<ArrayLanes>::splat(toe + Vec3::Y * 0.1), V::splat(toe));
            let planted = PlantedParts { heel: [0.0; LANES], toe: [planted; LANES] };
            let (new, turn) = update(&lock_step, &planted, &lock, ankle, toe, ArrayLanes::splat(flat));
            store(&mut lock.correction, new);
            store(&mut lock.turn, turn);
            store(&mut lock.ankle, ankle);
            store(&mut lock.toe, toe);
            (lock.heel_down, lock.toe_down) = (planted.heel, planted.toe);
            height + (new.y + turn.y).to_array()[3]
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

    /// Ankle and toe as they are shown while a planted foot slides and turns in its clip: heel and toe hold by turns (m).
    ///
    /// - `speed_mps`, `rate`: how fast it slides and turns there (m/s, rad/s).
    fn shown(speed_mps: f32, rate: f32, planted: impl Fn(i32) -> (f32, f32)) -> Vec<[Vec3; 2]> {
        let (flat, dt_s) = (Skeleton::default().rest_positions()[Joint::LeftToe.index()].y, 1.0 / 60.0);
        let lock_step = LockStep::new(&FootLockConfig::default(), dt_s);
        let mut lock = FootLock::ZERO;
        let step = |i: i32| {
            let (time, (heel, ball)) = (dt_s * i as f32, planted(i));
            let ankle = Vec3::new(speed_mps * time, 0.1, 0.0);
            let toe = ankle + glam::Quat::from_rotation_y(rate * time) * Vec3::new(0.0, flat - 0.1, 0.14);
            let (a, t) = (V::<ArrayLanes>::splat(ankle), V::splat(toe));
            let planted = PlantedParts { heel: [heel; LANES], toe: [ball; LANES] };
            let (new, turn) = update(&lock_step, &planted, &lock, a, t, ArrayLanes::splat(flat));
            store(&mut lock.correction, new);
            store(&mut lock.turn, turn);
            store(&mut lock.ankle, a);
            store(&mut lock.toe, t);
            (lock.heel_down, lock.toe_down) = (planted.heel, planted.toe);
            let [new, turn] = [new, turn].map(|v| Vec3::from_array([v.x, v.y, v.z].map(|x| x.to_array()[3])));
            [ankle + new, toe + new + turn]
        };
        (0..60).map(step).collect()
    }

    #[test]
    fn heel_and_toe_stay_where_they_are_planted_while_their_clip_turns_them() {
        let most = 1.05 * 0.01 / 60.0;
        // Both parts, the heel alone, the toe alone, and one after the other.
        let [both, heel, toe] = [(1.0, 1.0), (1.0, 0.0), (0.0, 1.0)];
        let by_turns = |i: i32| if i < 20 { heel } else { [both, toe][usize::from(i > 40)] };
        for (name, planted) in [
            ("both", &(|_| both) as &dyn Fn(i32) -> (f32, f32)),
            ("heel", &|_| heel),
            ("toe", &|_| toe),
            ("turns", &by_turns),
        ] {
            for (i, w) in (1..).zip(shown(0.1, 0.4, planted).windows(2)) {
                let held = |part: fn((f32, f32)) -> f32| part(planted(i - 1)) * part(planted(i)) > 0.5;
                // Where both hold, the foot turns back, too.
                let times = if planted(i) == both { 1.5 } else { 1.0 };
                for (k, is_held) in [held(|p| p.0), held(|p| p.1)].into_iter().enumerate() {
                    let moved = w[1][k].distance(w[0][k]);
                    assert!(!is_held || moved < times * most, "{name}: step {i}, part {k}: {moved} m");
                }
                let length = w[1][0].distance(w[1][1]) - w[0][0].distance(w[0][1]);
                assert!(length.abs() < 1e-5, "{name}: a foot grew by {length} m");
            }
        }
    }

    #[test]
    fn a_foot_turns_and_moves_no_further_than_its_limits() {
        let feet = shown(1.0, 3.0, |_| (1.0, 1.0));
        for (i, [ankle, toe]) in feet.iter().enumerate() {
            let time = i as f32 / 60.0;
            let off = (*ankle - Vec3::new(time, 0.1, 0.0)).with_y(0.0);
            assert!(off.length() < 0.3 + 1e-4, "step {i}: {off}");
            let offset = glam::Quat::from_rotation_y(3.0 * time) * Vec3::Z;
            let turned = offset.angle_between((toe - ankle).with_y(0.0));
            assert!(turned < 0.75, "step {i}: {turned} rad");
        }
    }
}
