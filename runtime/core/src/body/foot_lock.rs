//! Foot placement: feet go where the examples have them, except while they are planted (Kim, Kim and Shin 2003a,
//! section 4.2.4).
//!
//! Each foot carries an offset and a turn about the vertical. While it is planted they undo any motion over the ground
//! of the part that bears the weight, which rolls from the heel to the ball; in the air they fade. A foot that is left
//! too far behind takes a step. Nothing jumps at any of these moments.

use super::ground_plane::{FootGround, FootPlane};
use super::lanes::{Lane, Lane3, load, store};
use super::{lane_body::LaneLeg, lanewise::lanewise_fields, placement::PlacementLanes, springs::DampedSpring};
use serde::{Deserialize, Serialize};
use throng_base::simd::{LANES, Lanes, Q, V};
use throng_base::thresholds::{FOOT_NEAR_M, FOOT_SETTLED_M, TOE_CLEARANCE_M, TOE_RAISED_MPS, TOE_SWING_MPS};

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

/// Feet of eight characters on one side, as [`lock_foot`] left them.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct FootLock {
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
    /// Cosine of half the knee's angle at the last step: 0 for a straight leg.
    pub bent: Lane,
    /// Progress of a corrective step, 0 to 1; 1 if none is taken.
    pub step: Lane,
    /// 1 from the first step on; before, all is 0.
    pub seen: Lane,
}

impl FootLock {
    pub const ZERO: Self = Self {
        offset: [[0.0; LANES]; 3],
        offset_rate: [[0.0; LANES]; 3],
        turn: [[0.0; LANES]; 2],
        down: [0.0; LANES],
        rise: [0.0; LANES],
        rise_rate: [0.0; LANES],
        height: [0.0; LANES],
        plane: FootPlane::ZERO,
        bent: [0.0; LANES],
        step: [0.0; LANES],
        seen: [0.0; LANES],
    };

    /// Feet that are seen for the first time have no turn, and take no step.
    #[inline(always)]
    pub fn begin_unseen<F: Lanes>(&mut self) {
        let (half, one, seen) = (F::splat(0.5), F::splat(1.0), F::load(&self.seen));
        for lane in [&mut self.turn[1], &mut self.step] {
            *lane = F::select_lt(half, seen, F::load(lane), one).to_array();
        }
    }

    /// True where shares and cosines of a lane are within their ranges.
    pub fn is_sound(&self, lane: usize) -> bool {
        let is_cosine = |of: &Lane| of[lane].abs() <= 1.0 + ROUNDING;
        is_share(self.step[lane])
            && is_share(self.seen[lane])
            && is_share(self.down[lane])
            && is_cosine(&self.bent)
            && self.turn.iter().all(is_cosine)
    }
}

lanewise_fields!(FootLock { offset, offset_rate, turn, down, rise, rise_rate, height, plane, bent, step, seen });

/// Inputs of the placement of one foot.
pub(crate) struct FootLockInputs<'a, F> {
    pub leg: &'a LaneLeg,
    pub place: &'a PlacementLanes<F>,
    /// Length of the legs over those of the database skeleton.
    pub scale: F,
    /// The ground below the foot.
    pub ground: FootGround<F>,
    /// 1 where the motion has the heel, the ball on the ground.
    pub contacts: [F; 2],
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
pub fn lock_foot<F: Lanes>(t: &FootLockInputs<'_, F>, foot: &mut FootLock, to: SolePose<F>) -> (SolePose<F>, Bearing) {
    let (zero, one) = (F::splat(0.0), F::splat(1.0));
    let to = tilt_sole(t, to);
    let (heel, ball) = (to.foot.rotate(load(&t.leg.heel)), to.foot.rotate(load(&t.leg.ball)));
    let share = ball_share(t.leg, t.scale, over_ground(t, heel), over_ground(t, ball));
    // A part that alone is on the ground bears all.
    let half = F::splat(0.5);
    let [heel_down, ball_down] = t.contacts;
    let share = F::select_lt(heel_down, half, F::select_lt(ball_down, half, share, one), share);
    let share = F::select_lt(ball_down, half, F::select_lt(heel_down, half, share, zero), share);
    advance_step(t, foot);
    let stepping = F::select_lt(F::load(&foot.step), one, one, zero);
    let down = heel_down.max(ball_down) * (one - stepping);
    let held = down * F::load(&foot.down);

    let turn = turn_of(t, foot, held, ball - heel);
    let spin = about_y(turn);
    let (heel, ball) = (spin.rotate(heel), spin.rotate(ball));
    let offset = offset_of(t, foot, held, to.ankle, [heel, ball], share);
    let mut sole = SolePose {
        ankle: V::new(to.ankle.x + offset.x, to.ankle.y, to.ankle.z + offset.z),
        foot: spin * to.foot,
        toe: spin * to.toe,
    };
    // A foot that is far from the ground stands on something else.
    let near = F::select_lt(F::load(&foot.height) + F::load(&foot.rise), F::splat(FOOT_NEAR_M) * t.scale, one, zero);
    let [rise, left] = foot_rise(t, foot, down * near, sole.ankle, [heel, ball]);
    sole.ankle.y = sole.ankle.y + rise;
    sole.toe = bend_toe(t, &sole, ball);

    [foot.turn[0], foot.turn[1]] = turn.map(F::to_array);
    store(&mut foot.plane.heel, t.place.to_world(sole.ankle + heel));
    store(&mut foot.plane.ball, t.place.to_world(sole.ankle + ball));
    foot.down = down.to_array();
    begin_step(t, foot, down, offset, turn[1]);
    // What still comes down does not stand yet.
    let standing = F::select_lt(left, F::splat(FOOT_SETTLED_M), held * t.ground.at_rest, zero);
    let heel = F::select_lt(share, F::splat(0.7), standing, zero);
    let ball = F::select_lt(share, F::splat(0.3), zero, standing);
    (sole, [heel.to_array(), ball.to_array()])
}

/// Tilts the sole along the slope of the ground, in proportion to the importance of the foot's position.
#[inline(always)]
fn tilt_sole<F: Lanes>(t: &FootLockInputs<'_, F>, sole: SolePose<F>) -> SolePose<F> {
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
fn over_ground<F: Lanes>(t: &FootLockInputs<'_, F>, v: V<F>) -> F {
    v.y - t.ground.plane[1] * v.x - t.ground.plane[2] * v.z
}

/// Sine and cosine of the turn about the vertical: it keeps a planted foot's direction, and fades in the air.
#[inline(always)]
fn turn_of<F: Lanes>(t: &FootLockInputs<'_, F>, foot: &FootLock, held: F, along: V<F>) -> [F; 2] {
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
    t: &FootLockInputs<'_, F>,
    foot: &mut FootLock,
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
    let holding = t.place.vector_to_world(holding);
    let offset = V::select_lt(half, held, holding, V::new(x, zero, z));
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
    t: &FootLockInputs<'_, F>,
    foot: &mut FootLock,
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
    // A fast ball passes over the ground, and nothing goes below it.
    let moved = t.place.to_world(ankle + ball) - load(&foot.plane.ball);
    let speed = (moved.x * moved.x + moved.z * moved.z).sqrt() * t.rate * F::load(&foot.seen);
    let [slow, fast] = TOE_SWING_MPS;
    let share = ((speed - F::splat(slow)) * F::splat(1.0 / (fast - slow))).max(zero).min(one);
    let clear = share * F::splat(TOE_CLEARANCE_M) * t.scale - height - (below_ball - lowest);
    let clear = clear.min(before + F::splat(TOE_RAISED_MPS) * t.dt_s).max(-height);
    let rise = F::select_lt(half, down, above.max(zero) - height, fading.max(clear));
    let changed = (rise - before) * t.rate;
    let free = F::select_lt(rise, fading + F::splat(1e-6), fading_rate, changed);
    foot.rise = rise.to_array();
    foot.rise_rate = F::select_lt(half, down, changed, free).to_array();
    foot.height = height.to_array();
    [height + rise - (ankle.y + lowest - t.ground.plane[0]), height + rise]
}

/// Bends the toe up where its tip would go below the ground.
#[inline(always)]
fn bend_toe<F: Lanes>(t: &FootLockInputs<'_, F>, sole: &SolePose<F>, ball: V<F>) -> Q<F> {
    let (zero, tip) = (F::splat(0.0), sole.toe.rotate(load(&t.leg.tip)));
    let height = sole.ankle.y + over_ground(t, ball + tip) - t.ground.plane[0];
    let bent = V::new(tip.x, tip.y - height.min(zero), tip.z);
    Q::shortest_arc(tip, bent) * sole.toe
}

/// Advances a corrective step.
#[inline(always)]
fn advance_step<F: Lanes>(t: &FootLockInputs<'_, F>, foot: &mut FootLock) {
    let (one, step) = (F::splat(1.0), F::load(&foot.step));
    foot.step = F::select_lt(step, one, (step + t.dt_s / t.step_s).min(one), one).to_array();
}

/// Begins a corrective step where a planted foot has been left too far behind.
#[inline(always)]
fn begin_step<F: Lanes>(t: &FootLockInputs<'_, F>, foot: &mut FootLock, down: F, offset: V<F>, turn_cos: F) {
    let (zero, half, one) = (F::splat(0.0), F::splat(0.5), F::splat(1.0));
    let distance = (offset.x * offset.x + offset.z * offset.z).sqrt();
    let turned = F::select_lt(turn_cos, F::splat(LARGEST_TURN_COS), one, zero);
    let far = F::select_lt(t.reach, distance, one, turned);
    // One foot at a time, unless it is much too far.
    let very_far = F::select_lt(t.reach + t.reach, distance, one, zero);
    let begins = far * down * t.other_stands.max(very_far);
    foot.step = F::select_lt(half, begins, zero, F::load(&foot.step)).to_array();
}

#[cfg(test)]
mod tests {
    use super::super::lane_body::LaneBody;
    use super::*;
    use crate::skeleton::{Joint, Skeleton};
    use glam::{Quat, Vec3};
    use throng_base::simd::ArrayLanes;

    const DT_S: f32 = 1.0 / 60.0;
    const REACH_M: f32 = 0.1;

    /// A left foot in its motion.
    struct Wanted {
        /// Of the ankle, from where it is over the origin while the foot is flat on the ground (m).
        place: Vec3,
        turn: Quat,
        /// Of heel and ball.
        contacts: [f32; 2],
    }

    /// A foot as it is shown.
    struct Shown {
        /// Bottoms of heel and ball (m).
        parts: [Vec3; 2],
        ankle: Vec3,
        step: f32,
    }

    /// - `wanted`: the motion, by time (s).
    /// - `other_stands`: 1 where the other foot stands.
    fn show(steps: i32, other_stands: f32, wanted: impl Fn(f32) -> Wanted) -> Vec<Shown> {
        let skeleton = Skeleton::default();
        let body = LaneBody::from_skeleton(&skeleton);
        let leg = &body.legs[0];
        let number = ArrayLanes::splat;
        let place =
            PlacementLanes { x: number(0.0), y: number(0.0), z: number(0.0), sin: number(0.0), cos: number(1.0) };
        let spring = |half_life_s| DampedSpring::new(DT_S, half_life_s);
        let mut foot = FootLock::ZERO;
        let show = |step: i32| {
            let Wanted { place: at, turn, contacts } = wanted(DT_S * step as f32);
            let ankle = at + skeleton.rest_positions()[Joint::LeftFoot.index()].with_x(0.0).with_z(0.0);
            foot.begin_unseen::<ArrayLanes>();
            let inputs = FootLockInputs {
                leg,
                place: &place,
                scale: number(1.0),
                ground: FootGround::level(),
                contacts: contacts.map(number),
                importance: number(1.0),
                dt_s: number(DT_S),
                rate: number(1.0 / DT_S),
                turn_left: number(0.8),
                air: &spring(0.08),
                landing: &spring(0.02),
                step_s: number(0.35),
                reach: number(REACH_M),
                other_stands: number(other_stands),
            };
            let turn = Q::new(V::splat(turn.xyz()), number(turn.w));
            let (sole, _) = lock_foot(&inputs, &mut foot, SolePose { ankle: V::splat(ankle), foot: turn, toe: turn });
            foot.seen = [1.0; LANES];
            let vector = |v: V<ArrayLanes>| Vec3::from_array([v.x, v.y, v.z].map(|x| x.to_array()[3]));
            let [heel, ball] = [&leg.heel, &leg.ball].map(|part| vector(sole.ankle + sole.foot.rotate(load(part))));
            let parts = [heel, ball - Vec3::Y * leg.thickness[3]];
            Shown { parts, ankle: vector(sole.ankle), step: foot.step[3] }
        };
        (0..steps).map(show).collect()
    }

    #[test]
    fn parts_stay_where_they_are_planted_while_their_motion_slides_and_turns_them() {
        let [both, heel, ball] = [[1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
        for (name, contacts, slide, turn) in [
            ("flat, sliding", both, Vec3::new(0.08, 0.0, -0.03), 0.0),
            ("flat, turning", both, Vec3::ZERO, 0.4),
            ("heel alone", heel, Vec3::new(0.05, 0.0, 0.05), 0.4),
            ("ball alone", ball, Vec3::new(0.05, 0.0, 0.05), 0.4),
        ] {
            let at = |t: f32| Wanted { place: slide * t, turn: Quat::from_rotation_y(turn * t), contacts };
            let feet = show(60, 1.0, at);
            for (k, is_held) in contacts.iter().enumerate().filter(|(_, c)| **c > 0.5) {
                for (step, foot) in feet.iter().enumerate() {
                    let moved = foot.parts[k].distance(feet[0].parts[k]);
                    assert!(moved < 1e-4, "{name}: part {k} ({is_held}) has moved by {moved} m at step {step}");
                }
            }
        }
    }

    #[test]
    fn a_planted_foot_stays_for_minutes_beside_its_motion() {
        let at = |t: f32| Wanted { place: Vec3::X * 0.05 * t.min(1.0), turn: Quat::IDENTITY, contacts: [1.0; 2] };
        let feet = show(60 * 60, 1.0, at);
        for part in 0..2 {
            let moved = feet[3599].parts[part].distance(feet[0].parts[part]);
            assert!(moved < 1e-3, "part {part} has moved by {moved} m in a minute");
        }
    }

    #[test]
    fn a_foot_rolls_from_heel_to_ball_without_moving_the_part_that_bears() {
        let at = |t: f32| {
            // On the heel, then flat, then on the ball, while it slides.
            let pitch = if t < 0.3 { t - 0.3 } else { (t - 0.6).max(0.0) };
            let contacts = [f32::from(u8::from(t < 0.6)), f32::from(u8::from(t > 0.3))];
            Wanted { place: Vec3::new(0.0, 0.0, 0.06 * t), turn: Quat::from_rotation_x(pitch), contacts }
        };
        let feet = show(54, 1.0, at);
        for (k, steps) in [(0, 1..18), (1, 37..54)] {
            for step in steps {
                let moved = (feet[step].parts[k] - feet[step - 1].parts[k]).with_y(0.0).length();
                assert!(moved < 5e-4, "part {k} slips by {moved} m at step {step}");
            }
        }
        assert!(feet.iter().flat_map(|f| f.parts).all(|p| p.y > -1e-4), "no part goes below the ground");
    }

    #[test]
    fn fast_toes_in_the_air_clear_the_ground_without_a_jump() {
        let heights = |speed: f32, height: f32, contacts: [f32; 2]| -> Vec<f32> {
            let at = |t: f32| Wanted { place: Vec3::new(0.0, height, speed * t), turn: Quat::IDENTITY, contacts };
            show(30, 1.0, at).iter().map(|foot| foot.parts[1].y).collect()
        };
        let skimming = heights(2.0, 0.005, [0.0; 2]);
        assert!((skimming[29] - TOE_CLEARANCE_M).abs() < 1e-3, "{skimming:?}");
        assert!(skimming.windows(2).all(|w| w[1] - w[0] < TOE_RAISED_MPS * DT_S + 1e-4), "{skimming:?}");
        // Slow ones and high ones stay where they are.
        assert!((heights(0.1, 0.005, [0.0; 2])[29] - 0.005).abs() < 1e-4);
        assert!((heights(2.0, 0.05, [0.0; 2])[29] - 0.05).abs() < 1e-4);
        assert!(heights(0.1, -0.03, [0.0; 2]).iter().all(|h| *h > -1e-4), "no toe goes below the ground");
        // A planted one comes down.
        assert!(heights(0.0, 0.02, [1.0; 2])[29] < 1e-3);
    }

    #[test]
    fn a_foot_that_is_left_behind_takes_a_step_of_its_own_to_its_motion() {
        let slide = |t: f32| Vec3::new(0.0, 0.0, 0.3 * t.min(0.5));
        let at = |t: f32| Wanted { place: slide(t), turn: Quat::IDENTITY, contacts: [1.0; 2] };
        let feet = show(90, 1.0, at);
        let begins = feet.iter().position(|foot| foot.step < 1.0).expect("a step");
        let behind = slide(DT_S * begins as f32).z - (feet[begins].ankle.z - feet[0].ankle.z);
        assert!((behind - REACH_M).abs() < 0.01, "it begins {behind} m behind");
        let highest = feet.iter().map(|foot| foot.parts[1].y).fold(0.0, f32::max);
        assert!((0.02..0.08).contains(&highest), "it is lifted by {highest} m");
        let off = feet[89].ankle.z - feet[0].ankle.z - slide(1.5).z;
        assert!(off.abs() < 0.03, "it ends {off} m from its motion");
        for w in feet.windows(2) {
            let moved = (w[1].ankle - w[0].ankle).length() / DT_S;
            assert!(moved < 1.5, "it moves at {moved} m/s");
        }
        // While the other foot is in the air, it stays, until it is much too far behind.
        assert!(show(35, 0.0, at).iter().all(|foot| foot.step >= 1.0));
    }
}
