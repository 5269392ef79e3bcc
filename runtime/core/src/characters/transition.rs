//! Transitions: what the old motion and the new one differ by becomes an offset that decays.
//!
//! The planar root is aligned exactly at the joint of two segments, so only what is above it differs: rotations,
//! height, and all velocities (inertialisation after Bollo, *Inertialization: High-Performance Animation
//! Transitions in 'Gears of War'*, 2018, with a critically damped spring in place of its polynomial).

use super::MotionSet;
use super::block::{Block, ROTATION_CODES, VELOCITY_CODES, decode, encode};
use super::decay::Decay;
use crate::format::FrameRow;
use crate::planar::Planar;
use crate::pose::{get, load, set, store};
use crate::skeleton::NUM_JOINTS;
use glam::Vec3;
use throng_base::simd::{LANES, Lanes, Q, V, Work, dispatch};

/// A change of segment that a character makes within a step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Change {
    /// The character.
    pub character: u32,
    /// Last frame of the old segment; the one before it is in the same clip.
    pub from: u32,
    /// First frame of the new segment; the one after it is in the same clip.
    pub to: u32,
    /// Age of the old offsets at the change (s).
    pub age_s: f32,
    /// How much higher the ground of the old motion is (m).
    pub lift: f32,
    /// How much faster the old motion drifts, in the frame of the root (m/frame).
    pub drift: Vec3,
}

/// Replaces the offsets of up to eight characters. Equal characters must not stand in one group.
pub(crate) fn start(group: &[Change], motion_set: &MotionSet, half_life_s: f32, blocks: &mut [Block]) {
    dispatch(Start { group, motion_set, half_life_s, blocks });
}

struct Start<'a> {
    group: &'a [Change],
    motion_set: &'a MotionSet,
    half_life_s: f32,
    blocks: &'a mut [Block],
}

impl Work for Start<'_> {
    type Output = ();

    #[inline(always)]
    fn run<F: Lanes>(self) {
        start_lanes::<F>(self);
    }
}

#[inline(always)]
fn start_lanes<F: Lanes>(Start { group, motion_set, half_life_s, blocks }: Start<'_>) {
    let lane_of = |l: usize| group[l.min(group.len() - 1)];
    let rows = |offset: i64, from: bool| -> [&FrameRow; LANES] {
        std::array::from_fn(|l| {
            let c = lane_of(l);
            &motion_set.frames[(i64::from(if from { c.from } else { c.to }) + offset) as usize]
        })
    };
    let (before, last) = (rows(-1, true), rows(0, true));
    let (first, after) = (rows(0, false), rows(1, false));
    let age = F::from_array(std::array::from_fn(|l| lane_of(l).age_s));
    let (old, old_rate) = (Decay::new(age, half_life_s), Decay::rate(age, half_life_s));
    let rate = F::splat(motion_set.rate_hz);

    for j in 0..NUM_JOINTS {
        let (x, v) = gather(group, blocks, |b, lane| {
            let o = &b.offsets;
            (decode(&o.rotation[j], lane, ROTATION_CODES), decode(&o.rotation_velocity[j], lane, VELOCITY_CODES))
        });
        let [q_before, q_last, q_first, q_after] =
            [before, last, first, after].map(|rows| motion_set.rotation_code.of_rows::<F>(&rows, j));
        let shown = Q::from_mrp(old.apply(x, v)) * q_last;
        let offset = (shown * q_first.conjugate()).to_mrp();
        let old_velocity = (q_last * q_before.conjugate()).to_mrp();
        let new_velocity = (q_after * q_first.conjugate()).to_mrp();
        let velocity = (old_velocity - new_velocity) * rate + old_rate.apply(x, v);
        scatter(group, blocks, offset, velocity, |b, lane, x, v| {
            encode(&mut b.offsets.rotation[j], lane, ROTATION_CODES, x);
            encode(&mut b.offsets.rotation_velocity[j], lane, VELOCITY_CODES, v);
        });
    }
    let (x, v) = gather(group, blocks, |b, lane| (get(&b.offsets.root, lane), get(&b.offsets.root_velocity, lane)));
    let zero = F::splat(0.0);
    let height = |r: &[&FrameRow; LANES]| r.map(|r| r.height);
    let lift = F::from_array(std::array::from_fn(|l| lane_of(l).lift));
    let drift = |axis: usize| F::from_array(std::array::from_fn(|l| lane_of(l).drift[axis]));
    let offset = old.apply(x, v) + V::new(zero, F::load(&height(&last)) - F::load(&height(&first)) + lift, zero);
    let step = root_step(&before, &last) - root_step(&first, &after) + V::new(drift(0), drift(1), drift(2));
    let velocity = step * rate + old_rate.apply(x, v);
    scatter(group, blocks, offset, velocity, |b, lane, x, v| {
        set(&mut b.offsets.root, lane, x);
        set(&mut b.offsets.root_velocity, lane, v);
    });
}

/// How far the hips move from one row to the next, in the frame of the planar root (m).
#[inline(always)]
fn root_step<F: Lanes>(from: &[&FrameRow; LANES], to: &[&FrameRow; LANES]) -> V<F> {
    let step: [Vec3; LANES] = std::array::from_fn(|l| {
        let planar = |r: &FrameRow| Planar::new(r.planar[0], r.planar[1], r.planar[2]);
        let d = planar(from[l]).to_local(planar(to[l]));
        Vec3::new(d.x, to[l].height - from[l].height, d.z)
    });
    V::new(F::from_array(step.map(|s| s.x)), F::from_array(step.map(|s| s.y)), F::from_array(step.map(|s| s.z)))
}

#[inline(always)]
fn gather<F: Lanes>(group: &[Change], blocks: &[Block], of: impl Fn(&Block, usize) -> (Vec3, Vec3)) -> (V<F>, V<F>) {
    let (mut x, mut v) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
    for (l, c) in group.iter().enumerate() {
        let (from_x, from_v) = of(&blocks[c.character as usize / LANES], c.character as usize % LANES);
        set(&mut x, l, from_x);
        set(&mut v, l, from_v);
    }
    (load(&x), load(&v))
}

#[inline(always)]
fn scatter<F: Lanes>(
    group: &[Change],
    blocks: &mut [Block],
    value: V<F>,
    rate: V<F>,
    put: impl Fn(&mut Block, usize, Vec3, Vec3),
) {
    let (mut x, mut v) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
    store(&mut x, value);
    store(&mut v, rate);
    for (l, c) in group.iter().enumerate() {
        put(&mut blocks[c.character as usize / LANES], c.character as usize % LANES, get(&x, l), get(&v, l));
    }
}
