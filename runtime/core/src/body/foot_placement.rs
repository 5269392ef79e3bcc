//! Foot placement: feet go where the examples have them, except while they are planted (Kim, Kim and Shin 2003a,
//! section 4.2.4).
//!
//! Each foot carries an offset and a turn about the vertical. While it is planted they undo any motion over the ground
//! of the part that bears the weight, which rolls from the heel to the ball; in the air they fade. A foot that is left
//! too far behind takes a step. Nothing jumps at any of these moments.

use super::ground_plane::{FootGround, FootPlane};
use super::lane_body::LaneLeg;
use super::lanes::{Lane, Lane3, load, store};
use super::lanewise::lanewise_fields;
use super::placement::PlacementLanes;
use super::springs::DampedSpring;
use serde::{Deserialize, Serialize};
use throng_base::simd::{LANES, Lanes, Q, V};
use throng_base::thresholds::{FOOT_NEAR_M, FOOT_SETTLED_M};

/// Height of the heel over the ball, as a share of the leg's scale, from which the ball alone bears (m).
const FLAT_M: f32 = 0.005;
/// Height that a foot is lifted to in a step of its own (m).
const STEP_HEIGHT_M: f32 = 0.06;
/// Offset beyond which a foot is reset, not brought back: the character was moved elsewhere (m).
const LOST_M: f32 = 1.2;
/// Cosine of the turn of a planted foot from which it takes a step.
const LARGEST_TURN_COS: f32 = 0.75;

/// Tolerance of the ranges of shares and cosines.
const ROUNDING: f32 = 1e-3;

/// True for a number from 0 to 1, up to rounding.
pub(crate) fn is_share(of: f32) -> bool {
    (-ROUNDING..=1.0 + ROUNDING).contains(&of)
}

/// Feet of eight characters on one side, as [`place_foot`] left them.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct PlacedFoot {
    /// Offset of the ankle from its position in the examples, in world space (m).
    pub offset: Lane3,
    /// Rate of the offset (m/s).
    pub offset_rate: Lane3,
    /// Sine and cosine of the foot's turn about the vertical.
    pub turn: [Lane; 2],
    /// 1 where it was planted at the last step, else 0.
    pub down: Lane,
    /// Height above its position in the examples (m).
    pub rise: Lane,
    /// Rate of the rise (m/s).
    pub rise_rate: Lane,
    /// Height over the ground in the examples, at the last step (m).
    pub height: Lane,
    pub plane: FootPlane,
    /// Cosine of half the knee's angle at the last step: 0 for a straight leg; -1 until the first step.
    pub bent: Lane,
    /// Progress of a corrective step, 0 to 1; 1 if none is taken.
    pub step: Lane,
}

impl PlacedFoot {
    pub const ZERO: Self = Self {
        offset: [[0.0; LANES]; 3],
        offset_rate: [[0.0; LANES]; 3],
        turn: [[0.0; LANES], [1.0; LANES]],
        down: [0.0; LANES],
        rise: [0.0; LANES],
        rise_rate: [0.0; LANES],
        height: [0.0; LANES],
        plane: FootPlane::ZERO,
        bent: [-1.0; LANES],
        step: [1.0; LANES],
    };

    /// True where shares and cosines of a lane are within their ranges.
    pub fn is_sound(&self, lane: usize) -> bool {
        let is_cosine = |of: &Lane| of[lane].abs() <= 1.0 + ROUNDING;
        is_share(self.step[lane])
            && is_share(self.down[lane])
            && is_cosine(&self.bent)
            && self.turn.iter().all(is_cosine)
    }
}

lanewise_fields!(PlacedFoot { offset, offset_rate, turn, down, rise, rise_rate, height, plane, bent, step });

/// Inputs of the placement of one foot.
pub(crate) struct FootPlacement<'a, F> {
    pub leg: &'a LaneLeg,
    pub place: &'a PlacementLanes<F>,
    /// Length of the legs over those of the database skeleton.
    pub scale: F,
    /// The ground below the foot.
    pub ground: FootGround<F>,
    /// 1 where the examples have the foot on the ground.
    pub contact: F,
    /// Importance of the foot's position, 0 to 1.
    pub importance: F,
    /// Time of the tick (s).
    pub dt_s: F,
    /// Ticks a second; 0 for a tick of no time (1/s).
    pub rate: F,
    /// Share of a turn in the air that remains after the tick.
    pub turn_left: F,
    /// Spring by which an offset fades in the air.
    pub air: &'a DampedSpring,
    /// Spring by which a foot comes down to the ground.
    pub landing: &'a DampedSpring,
    /// Time of a step (s).
    pub step_s: F,
    /// Offset of a planted foot from which it takes a step (m).
    pub reach: F,
    /// 1 where the other foot stands.
    pub other_stands: F,
}

/// A foot in model space.
#[derive(Clone, Copy)]
pub(crate) struct SolePose<F> {
    pub ankle: V<F>,
    pub foot: Q<F>,
    pub toe: Q<F>,
}

/// Bearing parts of a foot: heel, ball; 1 or 0.
pub(crate) type Bearing = [Lane; 2];

/// Moves a foot from where the examples have it to where it goes.
#[inline(always)]
pub(crate) fn place_foot<F: Lanes>(
    t: &FootPlacement<'_, F>,
    foot: &mut PlacedFoot,
    wanted: SolePose<F>,
) -> (SolePose<F>, Bearing) {
    let (zero, one) = (F::splat(0.0), F::splat(1.0));
    let wanted = tilt_sole(t, wanted);
    let (heel, ball) = (wanted.foot.rotate(load(&t.leg.heel)), wanted.foot.rotate(load(&t.leg.ball)));
    let share = ball_share(t.leg, t.scale, over_ground(t, heel), over_ground(t, ball));
    let stepping = F::select_lt(F::load(&foot.step), one, one, zero);
    // A foot that is far from the ground does not bear.
    let near = F::select_lt(F::load(&foot.height) + F::load(&foot.rise), F::splat(FOOT_NEAR_M) * t.scale, one, zero);
    let down = t.contact * (one - stepping) * near;
    let held = down * F::load(&foot.down);

    let turn = turn_of(t, foot, held, ball - heel);
    let spin = about_y(turn);
    let (heel, ball) = (spin.rotate(heel), spin.rotate(ball));
    let offset = offset_of(t, foot, held, wanted.ankle, [heel, ball], share);
    let mut sole = SolePose {
        ankle: V::new(wanted.ankle.x + offset.x, wanted.ankle.y, wanted.ankle.z + offset.z),
        foot: spin * wanted.foot,
        toe: spin * wanted.toe,
    };
    let [rise, left] = foot_rise(t, foot, down, sole.ankle, [heel, ball]);
    sole.ankle.y = sole.ankle.y + rise;
    sole.toe = bend_toe(t, &sole, ball);

    [foot.turn[0], foot.turn[1]] = turn.map(F::to_array);
    store(&mut foot.plane.heel, t.place.to_world(sole.ankle + heel));
    store(&mut foot.plane.ball, t.place.to_world(sole.ankle + ball));
    foot.down = down.to_array();
    progress_step(t, foot, down, offset, turn[1]);
    // What still comes down does not stand yet.
    let standing = F::select_lt(left, F::splat(FOOT_SETTLED_M), held * t.ground.at_rest, zero);
    let heel = F::select_lt(share, F::splat(0.7), standing, zero);
    let ball = F::select_lt(share, F::splat(0.3), zero, standing);
    (sole, [heel.to_array(), ball.to_array()])
}

/// Tilts the sole along the slope of the ground, in proportion to the importance of the foot's position.
#[inline(always)]
fn tilt_sole<F: Lanes>(t: &FootPlacement<'_, F>, sole: SolePose<F>) -> SolePose<F> {
    let [_, x, z] = t.ground.plane;
    let up = V::new(F::splat(0.0), F::splat(1.0), F::splat(0.0));
    let normal = V::new(-(x * t.importance), F::splat(1.0), -(z * t.importance));
    let q = Q::shortest_arc(up, normal);
    SolePose { foot: q * sole.foot, toe: q * sole.toe, ..sole }
}

/// Share of the weight that the ball bears: 0 on the heel, a half where the foot is flat, 1 on the ball.
///
/// - `heel`, `ball`: heights of these parts over the ground, from any common height (m).
#[inline(always)]
pub(crate) fn ball_share<F: Lanes>(leg: &LaneLeg, scale: F, heel: F, ball: F) -> F {
    let higher = heel - (ball - F::load(&leg.thickness));
    let share = F::splat(0.5) + higher / (scale * F::splat(2.0 * FLAT_M));
    share.max(F::splat(0.0)).min(F::splat(1.0))
}

/// Rise of a vector along the slope of the ground.
#[inline(always)]
fn over_ground<F: Lanes>(t: &FootPlacement<'_, F>, v: V<F>) -> F {
    v.y - t.ground.plane[1] * v.x - t.ground.plane[2] * v.z
}

/// Sine and cosine of the turn about the vertical: it keeps a planted foot's direction, and fades in the air.
#[inline(always)]
fn turn_of<F: Lanes>(t: &FootPlacement<'_, F>, foot: &PlacedFoot, held: F, along: V<F>) -> [F; 2] {
    let (one, tiny) = (F::splat(1.0), F::splat(1e-6));
    let was = t.place.vector_to_model(load::<F>(&foot.plane.ball) - load(&foot.plane.heel));
    let lengths = ((along.x * along.x + along.z * along.z) * (was.x * was.x + was.z * was.z)).sqrt().max(tiny);
    let sin = (was.x * along.z - was.z * along.x) / lengths;
    let cos = (was.x * along.x + was.z * along.z) / lengths;
    let fading = [F::load(&foot.turn[0]) * t.turn_left, one + (F::load(&foot.turn[1]) - one) * t.turn_left];
    let half = F::splat(0.5);
    let [sin, cos] = [F::select_lt(half, held, sin, fading[0]), F::select_lt(half, held, cos, fading[1])];
    let length = (sin * sin + cos * cos).sqrt();
    // Where nothing is left of the direction, there is no turn.
    [ratio_or(sin, length, 1e-3, 0.0), ratio_or(cos, length, 1e-3, 1.0)]
}

/// `v / length`, or something else where the length is not above `least`.
#[inline(always)]
pub(super) fn ratio_or<F: Lanes>(v: F, length: F, least: f32, otherwise: f32) -> F {
    F::select_lt(F::splat(least), length, v / length.max(F::splat(1e-6)), F::splat(otherwise))
}

/// The rotation about the vertical of that sine and cosine.
#[inline(always)]
pub(crate) fn about_y<F: Lanes>([sin, cos]: [F; 2]) -> Q<F> {
    let (zero, half) = (F::splat(0.0), F::splat(0.5));
    let w = ((F::splat(1.0) + cos) * half).max(F::splat(1e-6)).sqrt();
    Q::new(V::new(zero, sin * half / w, zero), w).normalize()
}

/// The offset over the ground: it keeps the part that bears in its place, and fades in the air, where it goes on as
/// fast as it changed before: a foot that is let go begins to move slowly.
#[inline(always)]
fn offset_of<F: Lanes>(
    t: &FootPlacement<'_, F>,
    foot: &mut PlacedFoot,
    held: F,
    ankle: V<F>,
    [heel, ball]: [V<F>; 2],
    share: F,
) -> V<F> {
    let (zero, half) = (F::splat(0.0), F::splat(0.5));
    let was = t.place.point_to_model(load(&foot.plane.heel)).mix(t.place.point_to_model(load(&foot.plane.ball)), share);
    let holding = was - (ankle + heel.mix(ball, share));
    let (before, rate) = (load::<F>(&foot.offset), load::<F>(&foot.offset_rate));
    let ((x, rate_x), (z, rate_z)) = (t.air.pull_lanes(before.x, rate.x), t.air.pull_lanes(before.z, rate.z));
    let offset = V::select_lt(half, held, t.place.vector_to_world(holding), V::new(x, zero, z));
    let rate = V::select_lt(half, held, (offset - before) * t.rate, V::new(rate_x, zero, rate_z));
    let (none, lost) = (V::new(zero, zero, zero), F::splat(LOST_M) * t.scale);
    let flat = V::new(offset.x, zero, offset.z);
    let far = flat.dot(flat);
    let offset = V::select_lt(lost * lost, far, none, flat);
    store(&mut foot.offset, offset);
    store(&mut foot.offset_rate, V::select_lt(lost * lost, far, none, V::new(rate.x, zero, rate.z)));
    t.place.vector_to_model(offset)
}

/// Rise of the foot: onto the ground where it is planted, out of it anywhere, and up in a step of its own; and its
/// height over the ground then. The rise fades in the air, so that a released foot moves up as slowly as it began.
#[inline(always)]
fn foot_rise<F: Lanes>(
    t: &FootPlacement<'_, F>,
    foot: &mut PlacedFoot,
    down: F,
    ankle: V<F>,
    [heel, ball]: [V<F>; 2],
) -> [F; 2] {
    let (zero, half, one) = (F::splat(0.0), F::splat(0.5), F::splat(1.0));
    let below_ball = over_ground(t, ball) - F::load(&t.leg.thickness);
    let lowest = over_ground(t, heel).min(below_ball);
    let step = F::load(&foot.step).min(one);
    let arc = step * (one - step);
    let height = ankle.y + lowest - t.ground.plane[0] + arc * arc * F::splat(16.0 * STEP_HEIGHT_M) * t.scale;
    let (before, rate, was) = (F::load(&foot.rise), F::load(&foot.rise_rate), F::load(&foot.height));
    let (above, _) = t.landing.pull_lanes(before + was, rate + (height - was) * t.rate);
    let (fading, fading_rate) = t.air.pull_lanes(before, rate);
    let rise = F::select_lt(half, down, above.max(zero) - height, fading.max(-height));
    let changed = (rise - before) * t.rate;
    let free = F::select_lt(rise, fading + F::splat(1e-6), fading_rate, changed);
    foot.rise = rise.to_array();
    foot.rise_rate = F::select_lt(half, down, changed, free).to_array();
    foot.height = height.to_array();
    [height + rise - (ankle.y + lowest - t.ground.plane[0]), height + rise]
}

/// Bends the toe up where its tip would go below the ground.
#[inline(always)]
fn bend_toe<F: Lanes>(t: &FootPlacement<'_, F>, sole: &SolePose<F>, ball: V<F>) -> Q<F> {
    let (zero, tip) = (F::splat(0.0), sole.toe.rotate(load(&t.leg.tip)));
    let height = sole.ankle.y + over_ground(t, ball + tip) - t.ground.plane[0];
    let bent = V::new(tip.x, tip.y - height.min(zero), tip.z);
    Q::shortest_arc(tip, bent) * sole.toe
}

/// Begins a corrective step where a planted foot has been left too far behind, or advances one.
#[inline(always)]
fn progress_step<F: Lanes>(t: &FootPlacement<'_, F>, foot: &mut PlacedFoot, down: F, offset: V<F>, turn_cos: F) {
    let (zero, half, one) = (F::splat(0.0), F::splat(0.5), F::splat(1.0));
    let step = F::load(&foot.step);
    let moved = F::select_lt(step, one, (step + t.dt_s / t.step_s).min(one), one);
    let distance = (offset.x * offset.x + offset.z * offset.z).sqrt();
    let turned = F::select_lt(turn_cos, F::splat(LARGEST_TURN_COS), one, zero);
    let far = F::select_lt(t.reach, distance, one, turned);
    // One foot at a time, unless it is much too far.
    let very_far = F::select_lt(t.reach + t.reach, distance, one, zero);
    let begins = far * down * t.other_stands.max(very_far);
    foot.step = F::select_lt(half, begins, zero, moved).to_array();
}
