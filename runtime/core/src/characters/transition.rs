//! Transitions: what the old motion and the new one differ by becomes an offset that decays.
//!
//! The planar root is aligned exactly at the joint of two segments, so only what is above it differs: rotations,
//! height, and all velocities (inertialisation after Bollo, *Inertialization: High-Performance Animation
//! Transitions in 'Gears of War'*, 2018, with a critically damped spring in place of its polynomial).

use super::MotionSet;
use super::block::{BodyBlock, MotionBlock, ROTATION_CODES, SCHEDULED, VELOCITY_CODES, decode, encode};
use crate::body::{BodyState, Decay, HALF_LIVES_KEPT, get_lane, load, set_lane, store};
use crate::skeleton::{Joint, NUM_JOINTS};
use crate::{format::FrameRow, planar::Planar};
use glam::Vec3;
use throng_base::simd::{LANES, LaneWork, Lanes, Q, V, dispatch};

/// A change of segment that a character makes within a step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SegmentChange {
    /// The character.
    pub character: u32,
    /// Last frame of the old segment.
    pub from: u32,
    /// First frame of the new segment.
    pub to: u32,
    /// Age of the old offsets at the change (s).
    pub age_s: f32,
    /// Height of the old motion's ground over that of the new one (m).
    pub lift: f32,
    /// Drift of the old motion relative to the new one, in the frame of the root (m/frame).
    pub drift: Vec3,
}

/// Wakes the bodies of a block: feet are free, and the last transition of each is as if it had always been posed.
pub(crate) fn wake_block(block: &MotionBlock, body: &mut BodyBlock, motion_set: &MotionSet, half_life_s: f32) {
    // Feet are found anew.
    let state = BodyState { seen: [0.0; LANES], ..body.state };
    *body = BodyBlock { awake: 1, state, ..BodyBlock::ZERO };
    let mut changes = [SegmentChange::default(); LANES];
    let mut num_changes = 0;
    for lane in 0..LANES {
        if block.segment[lane] != SCHEDULED && block.age_s[lane] < HALF_LIVES_KEPT * half_life_s {
            let [from, to] = [block.change[0][lane], block.change[1][lane]];
            let change =
                SegmentChange { character: lane as u32, from, to, age_s: f32::INFINITY, ..SegmentChange::default() };
            changes[num_changes] = change;
            num_changes += 1;
        }
    }
    if num_changes > 0 {
        let (group, bodies) = (&changes[..num_changes], std::slice::from_mut(body));
        dispatch(StartTransitionsJob { group, motion_set, half_life_s, bodies });
    }
}

/// Replaces the offsets of up to eight characters, whose bodies are awake. A group must not hold a character twice.
pub(crate) struct StartTransitionsJob<'a> {
    pub group: &'a [SegmentChange],
    pub motion_set: &'a MotionSet,
    pub half_life_s: f32,
    pub bodies: &'a mut [BodyBlock],
}

impl LaneWork for StartTransitionsJob<'_> {
    type Output = ();

    #[inline(always)]
    fn run<F: Lanes>(self) {
        start_lanes::<F>(self);
    }
}

#[inline(always)]
fn start_lanes<F: Lanes>(StartTransitionsJob { group, motion_set, half_life_s, bodies }: StartTransitionsJob<'_>) {
    let lane_of = |l: usize| group[l.min(group.len() - 1)];
    let old_end = TransitionKnot::new(&std::array::from_fn(|l| lane_of(l).from), motion_set);
    let new_begin = TransitionKnot::new(&std::array::from_fn(|l| lane_of(l).to), motion_set);
    let age = F::from_array(std::array::from_fn(|l| lane_of(l).age_s));
    let (old, old_rate) = (Decay::new(age, half_life_s), Decay::rate(age, half_life_s));
    for j in 0..NUM_JOINTS {
        let (x, v) = gather(group, bodies, |b, lane| {
            let o = &b.offsets;
            (decode(&o.rotation[j], lane, ROTATION_CODES), decode(&o.rotation_velocity[j], lane, VELOCITY_CODES))
        });
        let last = motion_set.rotation_code.of_rows::<F>(&old_end.at, j);
        let first = motion_set.rotation_code.of_rows::<F>(&new_begin.at, j);
        let shown = Q::from_mrp(old.apply(x, v)) * last;
        let offset = (shown * first.conjugate()).to_mrp();
        let velocity = old_end.turn_rate(motion_set, j) - new_begin.turn_rate(motion_set, j) + old_rate.apply(x, v);
        scatter(group, bodies, offset, velocity, |b, lane, x, v| {
            encode(&mut b.offsets.rotation[j], lane, ROTATION_CODES, x);
            encode(&mut b.offsets.rotation_velocity[j], lane, VELOCITY_CODES, v);
        });
    }
    let (x, v) =
        gather(group, bodies, |b, lane| (get_lane(&b.offsets.root, lane), get_lane(&b.offsets.root_velocity, lane)));
    let zero = F::splat(0.0);
    let lift = F::from_array(std::array::from_fn(|l| lane_of(l).lift));
    let drift = |axis: usize| F::from_array(std::array::from_fn(|l| lane_of(l).drift[axis]));
    let offset = old.apply(x, v) + V::new(zero, old_end.height() - new_begin.height() + lift, zero);
    let drifts = V::new(drift(0), drift(1), drift(2)) * F::splat(motion_set.rate_hz);
    let velocity = old_end.hips_velocity() - new_begin.hips_velocity() + drifts + old_rate.apply(x, v);
    scatter(group, bodies, offset, velocity, |b, lane, x, v| {
        set_lane(&mut b.offsets.root, lane, x);
        set_lane(&mut b.offsets.root_velocity, lane, v);
    });
}

/// A row of each lane, and its neighbours in its clip.
struct TransitionKnot<'a, F> {
    at: [&'a FrameRow; LANES],
    /// The neighbours; the row itself where it is the first or the last one of its clip.
    before: [&'a FrameRow; LANES],
    after: [&'a FrameRow; LANES],
    /// Rate from one neighbour to the other (1/s).
    rate: F,
}

impl<'a, F: Lanes> TransitionKnot<'a, F> {
    #[inline(always)]
    fn new(frames: &[u32; LANES], motion_set: &'a MotionSet) -> Self {
        let around = frames.map(|frame| motion_set.adjacent_frames(frame));
        let rows = |of: &dyn Fn(usize) -> u32| std::array::from_fn(|l| &motion_set.frames[of(l) as usize]);
        let span = |l: usize| (around[l][1] - around[l][0]).max(1) as f32;
        let rate = F::from_array(std::array::from_fn(|l| motion_set.rate_hz / span(l)));
        Self { at: rows(&|l| frames[l]), before: rows(&|l| around[l][0]), after: rows(&|l| around[l][1]), rate }
    }

    /// Rate at which a joint turns, the tangent of the curve through the rows. The hips turn with the planar root, too.
    #[inline(always)]
    fn turn_rate(&self, motion_set: &MotionSet, joint: usize) -> V<F> {
        let before = motion_set.rotation_code.of_rows::<F>(&self.before, joint);
        let after = motion_set.rotation_code.of_rows::<F>(&self.after, joint);
        let mut turn = (after * before.conjugate()).to_mrp();
        if joint == Joint::Hips.index() {
            let heading = std::array::from_fn(|l| self.after[l].planar[2] - self.before[l].planar[2]);
            // Modified Rodrigues parameters of a small turn are a quarter of it.
            turn.y = turn.y + F::splat(0.25) * F::from_array(heading);
        }
        turn * self.rate
    }

    /// Height of the hips (m).
    #[inline(always)]
    fn height(&self) -> F {
        F::load(&self.at.map(|r| r.height))
    }

    /// Velocity of the hips, in the frame of the planar root (m/s).
    #[inline(always)]
    fn hips_velocity(&self) -> V<F> {
        let step: [Vec3; LANES] = std::array::from_fn(|l| {
            let planar = |r: &FrameRow| Planar::new(r.planar[0], r.planar[1], r.planar[2]);
            let [before, after] = [self.before[l], self.after[l]].map(|r| planar(self.at[l]).to_local(planar(r)));
            Vec3::new(after.x - before.x, self.after[l].height - self.before[l].height, after.z - before.z)
        });
        let [x, y, z] = [step.map(|s| s.x), step.map(|s| s.y), step.map(|s| s.z)];
        V::new(F::load(&x), F::load(&y), F::load(&z)) * self.rate
    }
}

#[inline(always)]
fn gather<F: Lanes>(
    group: &[SegmentChange],
    bodies: &[BodyBlock],
    of: impl Fn(&BodyBlock, usize) -> (Vec3, Vec3),
) -> (V<F>, V<F>) {
    let (mut x, mut v) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
    for (l, c) in group.iter().enumerate() {
        let (from_x, from_v) = of(&bodies[c.character as usize / LANES], c.character as usize % LANES);
        set_lane(&mut x, l, from_x);
        set_lane(&mut v, l, from_v);
    }
    (load(&x), load(&v))
}

#[inline(always)]
fn scatter<F: Lanes>(
    group: &[SegmentChange],
    bodies: &mut [BodyBlock],
    value: V<F>,
    rate: V<F>,
    put: impl Fn(&mut BodyBlock, usize, Vec3, Vec3),
) {
    let (mut x, mut v) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
    store(&mut x, value);
    store(&mut v, rate);
    for (l, c) in group.iter().enumerate() {
        put(&mut bodies[c.character as usize / LANES], c.character as usize % LANES, get_lane(&x, l), get_lane(&v, l));
    }
}
