//! Feet: laid onto the ground below them, held by their locks while they stand, and reached by their legs.

use super::foot_lock::{Bearing, FootLock, FootLockInputs, SolePose, about_y, ball_share, lock_foot};
use super::ground_plane::{FootGround, FootOverGround, PLANE_HALF_LIVES_S, follow_ground, keep_planted};
use super::lanes::{Lane, load};
use super::placement::PlacementLanes;
use super::reach::{drop_spring, is_stretched, limit_leg_length, lower_body, raise_heel, reach_foot};
use super::{ground::HeightField, hierarchy::ModelPose, lane_body::LaneBody, springs::DampedSpring, step::BodyState};
use crate::contacts::Contacts;
use glam::Vec2;
use throng_base::simd::{LANES, Lanes};
use throng_base::{Result, error::check_range, maths};

/// Time of a step that a foot takes by itself (s, of the database skeleton).
const STEP_S: f32 = 0.35;
/// Time in which a planted foot's height over the ground halves (s).
const LANDING_HALF_LIFE_S: f32 = 0.02;

/// Distance of a part of a foot from the ground from which it does not stand there, whatever its motion says (m).
const OFF_GROUND_M: f32 = 0.03;

/// Settings of the foot lock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FootLockConfig {
    /// False leaves the feet as the motion has them.
    pub enabled: bool,
    /// Half-life of the offset of a foot that was planted, once it is in the air (s, > 0).
    pub half_life_s: f32,
    /// Largest distances of a planted foot from its position in the motion, before it takes a step, of a body that stands and of
    /// one that moves (m, of the database skeleton, > 0).
    pub reach_m: [f32; 2],
}

impl Default for FootLockConfig {
    fn default() -> Self {
        Self { enabled: true, half_life_s: 0.08, reach_m: [0.12, 0.3] }
    }
}

impl FootLockConfig {
    /// Checks all numbers.
    ///
    /// # Errors
    /// [`throng_base::Error::Value`] for the first that is out of its range.
    pub(crate) fn check(&self) -> Result<()> {
        let Self { enabled: _, half_life_s, reach_m } = *self;
        check_range("foot_lock.half_life_s", half_life_s, 1e-3..10.0, "between 0.001 and 10")?;
        for reach_m in reach_m {
            check_range("foot_lock.reach_m", reach_m, 0.01..10.0, "between 0.01 and 10")?;
        }
        Ok(())
    }
}

/// Effect of a tick on the feet.
pub(crate) struct FeetTick<'a> {
    ground: &'a HeightField,
    config: &'a FootLockConfig,
    dt_s: f32,
    /// Ticks a second; 0 for a tick of no time (1/s).
    rate: f32,
    /// Share of a foot's turn in the air that remains after the tick.
    turn_left: f32,
    /// Spring by which a foot's offset fades in the air.
    air: DampedSpring,
    /// Spring by which a foot comes down to the ground.
    landing: DampedSpring,
    /// Spring that lowers the hips.
    drop: DampedSpring,
    /// Springs of the ground below feet, in the air and planted.
    planes: [DampedSpring; 2],
}

/// One foot of eight bodies as their motion has it.
pub(crate) struct FootMotion<F> {
    /// In model space; the ankle's height is that over the ground of the motion.
    pub sole: SolePose<F>,
    /// 1 where heel, ball are on the ground.
    pub contacts: [F; 2],
    /// Importance of its position, 0 to 1.
    pub importance: F,
    /// Length up to which its leg is as the motion has it, however straight (m).
    pub leg: F,
}

/// What both feet of eight bodies have in common.
pub(crate) struct FeetMotion<'a, F> {
    /// Left, right.
    pub feet: [FootMotion<F>; 2],
    pub speed: &'a Lane,
    /// Fastest turn of the knee of a leg in the air (rad/s).
    pub knee_rate: F,
    /// Distance by which the hips are lowered at least (m).
    pub sunk: F,
    /// Ground of the motion over that of the field (m).
    pub lift: F,
}

impl<'a> FeetTick<'a> {
    pub fn new(ground: &'a HeightField, config: &'a FootLockConfig, dt_s: f32) -> Self {
        let spring = |half_life_s| DampedSpring::new(dt_s, half_life_s);
        Self {
            ground,
            config,
            dt_s,
            rate: if dt_s > 0.0 { 1.0 / dt_s } else { 0.0 },
            turn_left: maths::exp2(-dt_s / config.half_life_s),
            air: spring(config.half_life_s),
            landing: spring(LANDING_HALF_LIFE_S),
            drop: drop_spring(dt_s),
            planes: PLANE_HALF_LIVES_S.map(spring),
        }
    }

    /// True where the ground is level everywhere.
    pub fn is_flat(&self) -> bool {
        self.ground.is_flat()
    }

    /// Takes both feet to the ground below them and holds what is planted, lowers the hips as far as legs and hands need it, and
    /// bends the legs. Returns the parts that bear.
    #[inline(always)]
    pub fn plant_feet<F: Lanes>(
        &self,
        body: &LaneBody,
        motion: &FeetMotion<'_, F>,
        place: &PlacementLanes<F>,
        state: &mut BodyState,
        feet: &mut [FootLock; 2],
        pose: &mut ModelPose<F>,
    ) -> [Bearing; 2] {
        let (left, left_bears) = self.lock(0, body, motion, place, feet);
        let (right, right_bears) = self.lock(1, body, motion, place, feet);
        let (mut soles, mut bearing) = ([left, right], [left_bears, right_bears]);
        let legs = [motion.feet[0].leg, motion.feet[1].leg];
        for (side, sole) in soles.iter_mut().enumerate() {
            raise_heel(body, side, legs[side], sole, &mut bearing[side], pose);
        }
        lower_body(body, &soles, motion, state, &self.drop, pose);
        let change = motion.knee_rate * F::splat(self.dt_s);
        for (side, sole) in soles.iter().enumerate() {
            let foot = &mut feet[side];
            let distance = limit_leg_length(body, side, legs[side], foot, sole, change, pose);
            foot.seen = [1.0; LANES];
            release_foot(foot, &mut bearing[side], is_stretched(body, side, legs[side], sole, pose));
            reach_foot(body, side, legs[side], distance, sole, pose);
        }
        bearing
    }

    /// Pose and bearing parts of one foot.
    #[inline(always)]
    fn lock<F: Lanes>(
        &self,
        side: usize,
        body: &LaneBody,
        motion: &FeetMotion<'_, F>,
        place: &PlacementLanes<F>,
        feet: &mut [FootLock; 2],
    ) -> (SolePose<F>, Bearing) {
        let (zero, one) = (F::splat(0.0), F::splat(1.0));
        let (leg, scale) = (&body.legs[side], F::load(&body.scale));
        let other = &feet[1 - side];
        let other_stands = F::select_lt(F::load(&other.step), one, zero, F::load(&other.down));
        let (foot, wanted) = (&mut feet[side], &motion.feet[side]);
        foot.begin_unseen::<F>();
        let mut sole = wanted.sole;
        let ground = match self.ground.is_flat() {
            true => FootGround::level(),
            false => {
                let (heel, ball) = (sole.foot.rotate(load(&leg.heel)), sole.foot.rotate(load(&leg.ball)));
                let share = ball_share(leg, scale, heel.y, ball.y);
                let spin = about_y([F::load(&foot.turn[0]), F::load(&foot.turn[1])]);
                let over = FootOverGround {
                    leg,
                    place,
                    ankle: sole.ankle,
                    heel: spin.rotate(heel),
                    ball: spin.rotate(ball),
                    share,
                    offset: load(&foot.offset),
                    is_down: F::load(&foot.down),
                    is_new: one - F::load(&foot.seen),
                    rate: F::splat(self.rate),
                };
                follow_ground(self.ground, &over, &self.planes, &mut foot.plane)
            }
        };
        // Clips may stand higher than the field.
        let mut ground = ground;
        ground.plane[0] = ground.plane[0] + motion.lift;
        sole.ankle.y = sole.ankle.y + ground.plane[0];
        // A standing body brings back a foot that is only a little off.
        let going = (F::load(motion.speed) * F::splat(2.0)).min(one);
        let [standing, moving] = self.config.reach_m;
        let reach = F::splat(standing) + going * F::splat(moving - standing);
        let inputs = FootLockInputs {
            leg,
            place,
            scale,
            ground,
            contacts: wanted.contacts,
            importance: wanted.importance,
            dt_s: F::splat(self.dt_s),
            rate: F::splat(self.rate),
            turn_left: F::splat(self.turn_left),
            air: &self.air,
            landing: &self.landing,
            step_s: F::splat(STEP_S) * F::load(&body.pace),
            reach: reach * scale,
            other_stands,
        };
        let (sole, mut bearing) = lock_foot(&inputs, foot, sole);
        keep_planted(self.ground, leg, &foot.plane, &mut bearing);
        (sole, bearing)
    }

    /// Takes the contacts of feet away that take a step of their own, and of parts that hang over an edge, or still come down to
    /// the ground.
    ///
    /// - `lift`: ground of the motion over that of the field (m).
    #[inline(always)]
    pub fn clear_contacts_in_air<F: Lanes>(
        &self,
        body: &LaneBody,
        feet: &[FootLock; 2],
        lift: &Lane,
        contacts: &mut [Contacts; LANES],
    ) {
        let (is_flat, one) = (self.ground.is_flat(), F::splat(1.0));
        if is_flat && !feet.iter().any(|foot| one.any_gt(F::load(&foot.step))) {
            return;
        }
        for (side, FootLock { plane, step, .. }) in feet.iter().enumerate() {
            let parts = [(&plane.heel, &[0.0; LANES]), (&plane.ball, &body.legs[side].thickness)];
            for (bit, (part, thickness)) in Contacts::FEET[side].into_iter().zip(parts) {
                for (lane, contacts) in contacts.iter_mut().enumerate() {
                    let height = |ground: f32| part[1][lane] - thickness[lane] - lift[lane] - ground;
                    let ground =
                        || self.ground.ground_at(Vec2::new(part[0][lane], part[2][lane]), part[1][lane]).height;
                    let hangs = !is_flat && height(ground()).abs() > OFF_GROUND_M;
                    if hangs || step[lane] < 1.0 {
                        contacts.remove(bit);
                    }
                }
            }
        }
    }
}

/// Releases a planted foot that the leg does not reach, so that it takes a step to where it belongs.
#[inline(always)]
fn release_foot<F: Lanes>(foot: &mut FootLock, bearing: &mut Bearing, stretched: F) {
    let (zero, half) = (F::splat(0.0), F::splat(0.5));
    let let_go = stretched * F::load(&foot.down);
    foot.step = F::select_lt(half, let_go, zero, F::load(&foot.step)).to_array();
    for part in bearing {
        *part = F::select_lt(half, let_go, zero, F::load(part)).to_array();
    }
}
