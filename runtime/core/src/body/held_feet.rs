//! Feet of motion that has contacts: laid onto the ground below them, then held by their locks.

use super::foot_lock::{FootLock, FootLockConfig, LockStep, PlantedParts, lock_foot};
use super::foot_placement::{SolePose, ball_share};
use super::ground::HeightField;
use super::ground_plane::{FootOverGround, PLANE_HALF_LIVES_S, follow_ground};
use super::hierarchy::ModelPose;
use super::lane_body::{LEGS, LaneBody};
use super::lanes::{Lane, load, store};
use super::limbs::move_leg;
use super::placement::PlacementLanes;
use super::reach::{drop_spring, lower_body, slow_knee};
use super::springs::DampedSpring;
use super::step::BodyState;
use crate::contacts::Contacts;
use crate::skeleton::Joint;
use glam::Vec2;
use throng_base::simd::{LANES, Lanes, Q, V};

/// Height of a foot in its clip from which it does not tilt with the ground any more (m, of the database skeleton).
const TILT_FADES_M: f32 = 0.15;
/// Distance of a part of a foot from the ground from which it does not stand there, whatever its clip says (m).
const OFF_GROUND_M: f32 = 0.03;
/// Fastest turn of the knee of a leg in the air on uneven ground: about that of a sprinter (rad/s).
const KNEE_RATE: f32 = 20.0;
/// Lowering of the hips that cannot be seen (m).
const NOT_LOWERED_M: f32 = 1e-5;

/// Effect of a tick on the feet.
pub(crate) struct FeetTick<'a> {
    ground: &'a HeightField,
    /// The lock; none leaves planted feet to their clips.
    lock: Option<LockStep>,
    /// Springs of the ground below feet, in the air and planted.
    planes: [DampedSpring; 2],
    drop: DampedSpring,
    /// Ticks a second; 0 for a tick of no time (1/s).
    rate: f32,
    /// Largest turn of the knee of a leg in the air on uneven ground (rad).
    knee_change: f32,
}

impl<'a> FeetTick<'a> {
    pub fn new(ground: &'a HeightField, config: &FootLockConfig, dt_s: f32) -> Self {
        Self {
            ground,
            lock: config.enabled.then(|| LockStep::new(config, dt_s)),
            planes: PLANE_HALF_LIVES_S.map(|half_life_s| DampedSpring::new(dt_s, half_life_s)),
            drop: drop_spring(ground, dt_s),
            rate: if dt_s > 0.0 { 1.0 / dt_s } else { 0.0 },
            knee_change: KNEE_RATE * dt_s,
        }
    }

    /// Takes both feet to the ground below them, lowers the hips as far as legs and hands need it, and holds what is planted.
    ///
    /// - `locks`: false leaves planted feet to their clips.
    /// - `planted`: left, right.
    /// - `sunk`: how low hips are at least, for what hands reach for; none where no hand reaches (m).
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "the feet of one block, in one call")]
    pub fn hold_feet<F: Lanes>(
        &self,
        body: &LaneBody,
        locks: bool,
        planted: &[PlantedParts; 2],
        place: &PlacementLanes<F>,
        sunk: Option<F>,
        state: &mut BodyState,
        feet: &mut [FootLock; 2],
        pose: &mut ModelPose<F>,
    ) {
        let is_flat = self.ground.is_flat();
        let mut floors = [place.y; 2];
        if !is_flat || sunk.is_some() || state.drop != [0.0; LANES] {
            floors = self.stand(body, place, sunk, state, feet, pose);
        }
        let Some(lock) = self.lock.as_ref().filter(|_| locks) else {
            for foot in feet {
                *foot = FootLock { plane: foot.plane, bent: foot.bent, ..FootLock::ZERO };
            }
            return;
        };
        for (side, foot) in feet.iter_mut().enumerate() {
            lock_foot(body, side, lock, &planted[side], floors[side], place, foot, pose);
        }
    }

    /// Takes the contacts of parts away that hang over an edge, or still come down to the ground.
    ///
    /// - `lift`: ground of the clips over that of the field (m).
    pub fn clear_contacts_off_ground(
        &self,
        body: &LaneBody,
        feet: &[FootLock; 2],
        lift: &Lane,
        contacts: &mut [Contacts; LANES],
    ) {
        if self.ground.is_flat() {
            return;
        }
        for (side, FootLock { plane, .. }) in feet.iter().enumerate() {
            let parts = [(&plane.heel, &[0.0; LANES]), (&plane.ball, &body.legs[side].thickness)];
            for (bit, (part, thickness)) in Contacts::FEET[side].into_iter().zip(parts) {
                for (lane, contacts) in contacts.iter_mut().enumerate() {
                    let ground = self.ground.ground_at(Vec2::new(part[0][lane], part[2][lane])).height;
                    if (part[1][lane] - thickness[lane] - lift[lane] - ground).abs() > OFF_GROUND_M {
                        contacts.remove(bit);
                    }
                }
            }
        }
    }

    /// Lays the feet of a pose onto the ground; returns its heights below the toes (m).
    #[inline(always)]
    fn stand<F: Lanes>(
        &self,
        body: &LaneBody,
        place: &PlacementLanes<F>,
        sunk: Option<F>,
        state: &mut BodyState,
        feet: &mut [FootLock; 2],
        pose: &mut ModelPose<F>,
    ) -> [F; 2] {
        let zero = F::splat(0.0);
        let is_flat = self.ground.is_flat();
        let stood = [0, 1].map(|side: usize| {
            let joints = LEGS[side].map(Joint::index);
            let sole = SolePose {
                ankle: pose.positions[joints[2]],
                foot: pose.rotations[joints[2]],
                toe: pose.rotations[joints[3]],
            };
            match is_flat {
                true => (sole, zero, place.y),
                false => self.lay_sole(body, side, place, state, &mut feet[side], sole),
            }
        });
        // On flat ground the legs reach as their clip has them.
        let matters = if is_flat { [zero; 2] } else { [stood[0].1, stood[1].1] };
        let mut soles = [stood[0].0, stood[1].0];
        let drop = [&mut state.drop, &mut state.drop_rate];
        lower_body(body, &soles, matters, drop, &self.drop, sunk.unwrap_or(zero), pose);
        let still = F::splat(NOT_LOWERED_M);
        let (drop, rate) = (F::load(&state.drop), F::load(&state.drop_rate));
        let size = drop.abs().max(rate.abs());
        state.drop = F::select_lt(size, still, zero, drop).to_array();
        state.drop_rate = F::select_lt(size, still, zero, rate).to_array();
        for (side, sole) in soles.iter_mut().enumerate() {
            let [_, _, foot, toe] = LEGS[side].map(Joint::index);
            if !is_flat {
                let lock = &mut feet[side];
                let is_down = F::load(&lock.heel_down).max(F::load(&lock.toe_down));
                let free = (F::splat(1.0) - is_down) * F::load(&state.seen);
                slow_knee(body, side, &mut lock.bent, free, sole, F::splat(self.knee_change), pose);
            }
            move_leg(body, side, sole.ankle - pose.positions[foot], pose);
            (pose.rotations[foot], pose.rotations[toe]) = (sole.foot, sole.toe);
            pose.positions[toe] = pose.positions[foot] + sole.foot.rotate(load(&body.offsets[toe]));
        }
        [stood[0].2, stood[1].2]
    }

    /// Lays one sole onto the ground: it is as high over the ground below it as its clip has it over the clip's, and tilts with
    /// it where it is near. Returns how near it is, 0 to 1, and the height of the ground below the toe (m).
    #[inline(always)]
    fn lay_sole<F: Lanes>(
        &self,
        body: &LaneBody,
        side: usize,
        place: &PlacementLanes<F>,
        state: &BodyState,
        foot: &mut FootLock,
        sole: SolePose<F>,
    ) -> (SolePose<F>, F, F) {
        let (zero, one) = (F::splat(0.0), F::splat(1.0));
        let (leg, toe) = (&body.legs[side], LEGS[side][3].index());
        // Ground of the clip over that of the field, and whether there was a step before.
        let (lift, seen) = (place.y - F::load(&state.base), F::load(&state.seen));
        let thickness = F::load(&leg.thickness);
        let in_clip = sole.ankle - V::new(zero, place.y, zero);
        let [heel, ball] = [&leg.heel, &body.offsets[toe]].map(|part| sole.foot.rotate(load(part)));
        let lowest = in_clip.y + heel.y.min(ball.y - thickness);
        let share = ball_share(leg, F::load(&body.scale), heel.y, ball.y);
        let offset = load::<F>(&foot.correction);
        let over = FootOverGround {
            leg,
            place,
            ankle: in_clip,
            heel,
            ball,
            share,
            offset: V::new(offset.x, zero, offset.z),
            is_down: F::load(&foot.heel_down).max(F::load(&foot.toe_down)) * seen,
            is_new: one - seen,
            rate: F::splat(self.rate),
        };
        let ground = follow_ground(self.ground, &over, &self.planes, &mut foot.plane);
        let near = (one - lowest.max(zero) * F::splat(1.0 / TILT_FADES_M)).max(zero);
        let [height, x, z] = ground.plane;
        let normal = V::new(-(x * near), one, -(z * near));
        let tilt = Q::shortest_arc(V::new(zero, one, zero), normal);
        let mut laid = SolePose { foot: tilt * sole.foot, toe: tilt * sole.toe, ..sole };
        let [heel, ball] = [heel, ball].map(|part| tilt.rotate(part));
        let height = lift + height;
        laid.ankle.y = height + lowest - over_slope(heel, [x, z]).min(over_slope(ball, [x, z]) - thickness);
        store(&mut foot.plane.heel, place.to_world(laid.ankle + heel) + offset);
        store(&mut foot.plane.ball, place.to_world(laid.ankle + ball) + offset);
        (laid, near, height + x * ball.x + z * ball.z)
    }
}

/// Height of a vector over a slope along x and z.
#[inline(always)]
fn over_slope<F: Lanes>(v: V<F>, [x, z]: [F; 2]) -> F {
    v.y - x * v.x - z * v.z
}
