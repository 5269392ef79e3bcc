//! Ground below a foot: a plane through the ground below its heel and below its ball.
//!
//! A plane at the ankle alone flips where the ankle passes a crease. Heel and ball find their own ground, and so does
//! the slope to the side. In the air the plane follows the ground that the foot passes next, so that a foot rises
//! before a step and never jumps. A planted foot keeps its position, and so its plane comes to rest.

use super::foot_lock::{Bearing, ratio_or};
use super::lanes::{Lane3, load};
use super::placement::PlacementLanes;
use super::{ground::HeightField, lane_body::LaneLeg, lanewise::lanewise_fields, springs::DampedSpring};
use crate::planar::Planar;
use bytemuck::Zeroable;
use glam::Vec2;
use serde::{Deserialize, Serialize};
use throng_base::simd::{LANES, Lanes, V};
use throng_base::thresholds::{FOOT_SETTLED_M, FOOT_STANDS_M};

/// Steepest plane along a foot, and to its side. Over an edge a foot stands on the higher side.
const STEEPEST: [f32; 2] = [0.35, 0.35];
/// Times ahead at which the ground before a foot in the air is sampled (s).
const AHEAD_S: [f32; 2] = [0.05, 0.1];
/// Distance of the two points whose heights give the slope to the side (m).
const WIDTH_M: f32 = 0.1;
/// Points along the heading over whose mean height the hips are held, from the root (m).
const BASE_M: [f32; 5] = [-0.3, -0.15, 0.0, 0.15, 0.3];
/// Time in which a difference to the ground below a foot halves, in the air and planted (s).
pub(crate) const PLANE_HALF_LIVES_S: [f32; 2] = [0.03, 0.015];
/// Time in which a difference to the ground below the hips halves (s).
pub(crate) const BASE_HALF_LIFE_S: f32 = 0.08;
/// Lag of the hips behind the ground by that half-life (s).
const BASE_LAG_S: f32 = BASE_HALF_LIFE_S / std::f32::consts::LN_2;

/// The plane below the feet of eight characters.
#[derive(Clone, Copy)]
pub(crate) struct FootGround<F> {
    /// Height below the ankle (m), and slope along x and z of model space.
    pub plane: [F; 3],
    /// 1 where the plane has come to rest on the ground, else 0.
    pub at_rest: F,
}

impl<F: Lanes> FootGround<F> {
    /// Level ground at height 0.
    #[inline(always)]
    pub fn level() -> Self {
        Self { plane: [F::splat(0.0); 3], at_rest: F::splat(1.0) }
    }
}

/// The plane that the feet of eight characters on one side are held over, and where they were.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, Zeroable)]
#[repr(C)]
pub(crate) struct FootPlane {
    /// Bottom of the heel, and the ball, at the last step, in world space (m).
    pub heel: Lane3,
    pub ball: Lane3,
    /// Height below the heel and below the ball (m), rise to the left a metre; and how fast they change (1/s).
    pub below: Lane3,
    pub below_rate: Lane3,
}

impl FootPlane {
    pub const ZERO: Self = {
        let zero = [[0.0; LANES]; 3];
        Self { heel: zero, ball: zero, below: zero, below_rate: zero }
    };
}

lanewise_fields!(FootPlane { heel, ball, below, below_rate });

/// Position of a foot, as far as its ground depends on it.
pub(crate) struct FootOverGround<'a, F> {
    pub leg: &'a LaneLeg,
    pub place: &'a PlacementLanes<F>,
    /// Ankle, heel and ball where the examples have them, in model space.
    pub ankle: V<F>,
    pub heel: V<F>,
    pub ball: V<F>,
    /// Share of the weight that the ball bears.
    pub share: F,
    /// Offset of the foot from there, in world space (m).
    pub offset: V<F>,
    /// 1 where the foot was planted at the last step, else 0.
    pub is_down: F,
    /// 1 where the foot is seen for the first time, else 0.
    pub is_new: F,
    /// Ticks a second; 0 for a tick of no time (1/s).
    pub rate: F,
}

/// Moves the plane of a foot on; on flat ground it is [`FootGround::level`].
///
/// - `springs`: how a difference to the ground fades in the air, and where the foot is planted.
#[inline(always)]
pub(crate) fn follow_ground<F: Lanes>(
    ground: &HeightField,
    over: &FootOverGround<'_, F>,
    springs: &[DampedSpring; 2],
    foot: &mut FootPlane,
) -> FootGround<F> {
    let (zero, half, one) = (F::splat(0.0), F::splat(0.5), F::splat(1.0));
    let share = over.share;
    let offset = over.offset;
    let (was_heel, was_ball) = (load::<F>(&foot.heel), load::<F>(&foot.ball));
    let was = was_heel.mix(was_ball, share);
    let (is_down, is_new) = (over.is_down, over.is_new);
    let at = over.place.to_world(over.ankle + over.heel.mix(over.ball, share)) + offset;
    let at = V::select_lt(half, is_down, was, at);
    let along = V::select_lt(half, is_down, was_ball - was_heel, over.place.vector_to_world(over.ball - over.heel));
    let [dx, dz] = level_direction(along);
    let length = level_length(&over.leg.heel, &over.leg.ball);

    // A foot that is seen for the first time has not moved, nor has one that stands.
    let moves = (one - is_down) * (one - is_new) * over.rate;
    let velocity = [(at.x - was.x) * moves, (at.z - was.z) * moves];
    let heel = [at.x - dx * length * share, at.z - dz * length * share];
    let ball = [heel[0] + dx * length, heel[1] + dz * length];
    let near = over.place.y;
    let below = [heel, ball].map(|[x, z]| heights_at(ground, x, z, near));
    let mut wanted = below;
    for ahead in AHEAD_S.map(F::splat) {
        let [dx, dz] = [velocity[0] * ahead, velocity[1] * ahead];
        for (wanted, [x, z]) in wanted.iter_mut().zip([heel, ball]) {
            *wanted = wanted.max(heights_at(ground, x + dx, z + dz, near));
        }
    }
    // To the left of the foot's direction.
    let side = F::splat(0.5 * WIDTH_M);
    let (mx, mz) = ((heel[0] + ball[0]) * half, (heel[1] + ball[1]) * half);
    let left = heights_at(ground, mx + dz * side, mz - dx * side, near);
    let right = heights_at(ground, mx - dz * side, mz + dx * side, near);
    let [steepest, steepest_aside] = STEEPEST.map(F::splat);
    let aside = ((left - right) / F::splat(WIDTH_M)).min(steepest_aside).max(-steepest_aside);
    let drop = steepest * length;
    let wanted = [wanted[0].max(wanted[1] - drop), wanted[1].max(wanted[0] - drop), aside];

    let mut plane = [zero; 3];
    for (k, &wanted) in wanted.iter().enumerate() {
        let (off, rate) = (F::load(&foot.below[k]) - wanted, F::load(&foot.below_rate[k]));
        let [air, planted] = [0, 1].map(|k: usize| springs[k].pull_lanes(off, rate));
        let off = F::select_lt(half, is_down, planted.0, air.0);
        let rate = F::select_lt(half, is_down, planted.1, air.1);
        plane[k] = F::select_lt(half, is_new, wanted, wanted + off);
        foot.below[k] = plane[k].to_array();
        foot.below_rate[k] = F::select_lt(half, is_new, zero, rate).to_array();
    }
    let [height, height_ball, aside] = plane;
    let slope = (height_ball - height) / length;
    let world = V::new(slope * dx + aside * dz, zero, slope * dz - aside * dx);
    let ankle = over.place.to_world(over.ankle) + offset;
    let height = height + world.x * (ankle.x - heel[0]) + world.z * (ankle.z - heel[1]);
    let slopes = over.place.vector_to_model(world);
    let left = [0, 1].map(|k: usize| (plane[k] - wanted[k]).abs());
    // The part that does not bear has time.
    let left = (left[0] * (one - share)).max(left[1] * share);
    let settled = F::select_lt(left, F::splat(FOOT_SETTLED_M), one, zero);
    FootGround { plane: [height, slopes.x, slopes.z], at_rest: settled }
}

/// Height of the ground over which hips are held (m): the mean along a stride, a little ahead.
///
/// - `speed`: (m/s)
/// - `near_m`: height to which the floor is the nearest one (m).
pub(crate) fn hips_ground_height(ground: &HeightField, root: Planar, speed: f32, near_m: f32) -> f32 {
    let at = |along: f32| {
        let p = root.transform_point(Vec2::new(0.0, along + speed * BASE_LAG_S));
        ground.ground_at(p, near_m).height
    };
    BASE_M.iter().map(|&along| at(along)).sum::<f32>() / BASE_M.len() as f32
}

/// Keeps those parts of a foot that are on the ground, of heel and ball.
#[inline(always)]
pub(crate) fn keep_planted(ground: &HeightField, leg: &LaneLeg, foot: &FootPlane, bearing: &mut Bearing) {
    if ground.is_flat() {
        return;
    }
    let parts = [(&foot.heel, &[0.0; LANES]), (&foot.ball, &leg.thickness)];
    for ((part, thickness), bearing) in parts.into_iter().zip(bearing) {
        for (lane, bears) in bearing.iter_mut().enumerate() {
            let at = Vec2::new(part[0][lane], part[2][lane]);
            let height = ground.ground_at(at, part[1][lane]).height + thickness[lane];
            if *bears > 0.5 && (part[1][lane] - height).abs() > FOOT_STANDS_M {
                *bears = 0.0;
            }
        }
    }
}

/// Horizontal unit vector along another: x, z; along z where it has no direction.
#[inline(always)]
fn level_direction<F: Lanes>(along: V<F>) -> [F; 2] {
    let length = (along.x * along.x + along.z * along.z).sqrt();
    [ratio_or(along.x, length, 1e-4, 0.0), ratio_or(along.z, length, 1e-4, 1.0)]
}

/// Horizontal distance of heel and ball of a flat foot (m).
#[inline(always)]
fn level_length<F: Lanes>(heel: &Lane3, ball: &Lane3) -> F {
    let along = load::<F>(ball) - load(heel);
    (along.x * along.x + along.z * along.z).sqrt().max(F::splat(1e-3))
}

/// Heights of the ground at eight places, of the floors that are nearest to other heights (m).
#[inline(always)]
fn heights_at<F: Lanes>(ground: &HeightField, x: F, z: F, near: F) -> F {
    let (x, z, near) = (x.to_array(), z.to_array(), near.to_array());
    let height = |lane: usize| ground.ground_at(Vec2::new(x[lane], z[lane]), near[lane]).height;
    let heights: [f32; LANES] = std::array::from_fn(height);
    F::from_array(heights)
}
