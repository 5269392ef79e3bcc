//! One tick, in reading order: advance -> control -> sample -> reaction -> foot lock -> poses.
//!
//! Characters are handled in ranges of whole blocks; nothing in a range depends on another, so results do not
//! depend on how characters are split.

use super::bent;
use super::block::{Block, Body, LAID};
use super::blow::PassedHits;
use super::control;
use super::decay::add_offsets;
use super::detail::{self, Instance, Level};
use super::motion_set::MotionSet;
use super::pace;
use super::reaction;
use super::times::{Clock, Laps, Phase};
use super::{CharactersConfig, Order};
use crate::contacts::Contacts;
use crate::pose::{
    Cursor, LocalTransform, LockStep, Mat3x4, Placement, Spot, lock_foot, sample, shared, to_model, write_locals,
    write_matrices,
};
use crate::skeleton::NUM_JOINTS;
use throng_base::simd::{Functions, LANES, Lanes, Work, dispatch};

/// Blocks of a range: 128 characters, whose state and poses fit the cache of a core.
pub(crate) const RANGE_BLOCKS: usize = 16;

/// Inputs of one tick, shared by all ranges.
pub(crate) struct Tick<'a> {
    pub dt_s: f32,
    pub motion_set: &'a MotionSet,
    pub config: &'a CharactersConfig,
    pub orders: &'a [Order],
    /// Sums of the times of each phase, if they are measured.
    pub clock: Option<&'a Clock>,
}

/// The part of the characters that one call handles.
pub(crate) struct Range<'a> {
    /// Number of the first character.
    pub first: usize,
    /// Characters; the last block may have empty lanes.
    pub count: usize,
    pub blocks: &'a mut [Block],
    /// (blocks)
    pub bodies: &'a mut [Body],
    /// (blocks)
    pub levels: &'a [Level],
    /// Hits that are passed.
    pub passed: &'a mut PassedHits,
    /// (count * NUM_JOINTS)
    pub matrices: &'a mut [Mat3x4],
    /// (count * NUM_JOINTS, or 0 where no local transforms are wanted)
    pub locals: &'a mut [LocalTransform],
    /// (count, or 0 where no records are wanted)
    pub instances: &'a mut [Instance],
}

/// The list.
pub(crate) fn step(range: Range<'_>, tick: &Tick<'_>) {
    advance_all(range.blocks, range.passed, range.first, range.count, tick);
    let mut laps = Laps::start(tick.clock);
    let state = (&mut *range.blocks, &mut *range.bodies);
    control::choose(state, range.passed, range.first, range.count, tick.motion_set, tick.config, tick.orders);
    range.passed.sort();
    laps.end(Phase::Control);
    pose_all(range, tick);
}

/// The first entry of the list, where choices are not made range by range.
pub(crate) fn advance_all(blocks: &mut [Block], passed: &mut PassedHits, first: usize, count: usize, tick: &Tick<'_>) {
    let mut laps = Laps::start(tick.clock);
    passed.clear();
    advance(blocks, passed, first, count, tick);
    laps.end(Phase::Advance);
}

/// The second half of the list: sample -> reaction -> foot lock -> poses, for all blocks of a range.
pub(crate) fn pose_all(range: Range<'_>, tick: &Tick<'_>) {
    let decay = reaction::Step::new(&tick.config.reaction, tick.dt_s);
    let lock = LockStep::new(&tick.config.foot_lock, tick.dt_s);
    dispatch(Pose { range, tick, steps: (decay, lock) });
}

/// The arguments of [`pose_all`].
struct Pose<'a, 't> {
    range: Range<'a>,
    tick: &'a Tick<'t>,
    /// Steps of reactions and of foot locks.
    steps: (reaction::Step, LockStep),
}

impl Work for Pose<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<F: Lanes>(self) {
        let Range { blocks, bodies, levels, count, matrices, locals, instances, .. } = self.range;
        let half_life_s = self.tick.config.half_life_s;
        let mut poses = matrices.chunks_mut(LANES * NUM_JOINTS);
        for (i, (block, body)) in blocks.iter_mut().zip(bodies).enumerate() {
            let Some(matrices) = poses.next() else { break };
            let first = i * LANES;
            let records = instances.get_mut(first..count.min(first + LANES)).unwrap_or_default();
            let to = Shown { level: levels[i], records };
            detail::set_awake(to.level, block, body, self.tick.motion_set, half_life_s);
            let locals = locals.get_mut(first * NUM_JOINTS..).unwrap_or_default();
            let len = locals.len().min(matrices.len());
            pose::<F>((block, body), matrices, &mut locals[..len], to, self.tick, &self.steps);
        }
    }
}

/// Outputs of a block.
struct Shown<'a> {
    level: Level,
    /// (characters, or 0)
    records: &'a mut [Instance],
}

/// Moves time on, turns the path of characters with bent actions, and notes the hits that are passed.
fn advance(blocks: &mut [Block], passed: &mut PassedHits, first: usize, count: usize, tick: &Tick<'_>) {
    let frames = tick.dt_s * tick.motion_set.rate_hz;
    for character in 0..count {
        let (b, lane) = (&mut blocks[character / LANES], character % LANES);
        let from = b.time[lane];
        match b.pace[lane] {
            pace::HELD => b.wait[lane] -= frames,
            pace @ (pace::SLOWING | pace::STARTING) => {
                let length = b.length[lane] as f32;
                b.time[lane] = pace::after(pace, length, from, frames);
            }
            _ => b.time[lane] += frames,
        }
        if b.bend[lane] != 0.0 {
            bent::place(b, lane, tick.motion_set);
        }
        if b.segment[lane] == LAID {
            // Where nothing follows, it stays at the end.
            b.time[lane] = b.time[lane].min(b.length[lane] as f32);
        } else if !passed.is_off() {
            let (span, place) = ((from, b.time[lane]), b.clip_to_world(lane));
            passed.pass(tick.motion_set, (first + character) as u32, b.segment[lane], span, place);
        }
        b.age_s[lane] += tick.dt_s;
    }
}

/// Samples a block, displaces struck characters, locks feet and writes its poses.
#[inline(always)]
fn pose<F: Lanes>(
    (block, body): (&mut Block, &mut Body),
    matrices: &mut [Mat3x4],
    locals: &mut [LocalTransform],
    to: Shown<'_>,
    tick: &Tick<'_>,
    (decay, lock_step): &(reaction::Step, LockStep),
) {
    let r = tick.motion_set;
    let mut laps = Laps::start(tick.clock);
    let mut spots = [Spot::default(); LANES];
    for (lane, spot) in spots.iter_mut().enumerate() {
        // The last frame of a clip has no successor, so it is reached from the one before.
        let time = block.time[lane].max(0.0);
        let whole = (time as u32).min(block.length[lane].saturating_sub(1));
        let frame = block.first[lane] + whole;
        // Within a segment, all neighbours are of its clip.
        let is_within = whole > 0 && whole + 2 <= block.length[lane];
        *spot = r.spot(frame, time - whole as f32, is_within);
        block.contacts[lane] = r.contacts[spot.frame + usize::from(spot.ratio > 0.5)];
    }
    let cursor: Cursor<'_, F> = Cursor::at(&spots, &r.frames, &r.rotation_code);
    let [x, z, heading, height] = cursor.root();
    let place = place(block, [x, z, heading]);
    if !to.records.is_empty() {
        detail::write(to.records, block, &spots, &place, r, tick.config.half_life_s);
    }
    if to.level == Level::Record {
        laps.end(Phase::Sample);
        return;
    }
    let mut local = sample(&cursor, height);
    local.root.y = local.root.y + place.y;
    add_offsets(&mut local, block, body, tick.config.half_life_s);
    let mut model = to_model(shared(&r.skeleton), local);
    laps.end(Phase::Sample);
    if tick.config.reaction.enabled && reaction::any::<F>(&body.reaction) {
        reaction::react(&r.anatomy, &tick.config.reaction, decay, &place, &mut body.reaction, &mut model);
    }
    laps.end(Phase::Reaction);
    if tick.config.foot_lock.enabled && to.level == Level::Full {
        let planted = |c: Contacts| block.contacts.map(|have| f32::from(u8::from(have.any(c))));
        let parts = [
            (planted(Contacts::LEFT_HEEL), planted(Contacts::LEFT_TOE)),
            (planted(Contacts::RIGHT_HEEL), planted(Contacts::RIGHT_TOE)),
        ];
        for (foot, planted) in parts.into_iter().enumerate() {
            let lock = &mut body.feet[foot];
            lock_foot(&r.anatomy.legs[foot], lock_step, planted, &place, lock, &mut model);
        }
    }
    laps.end(Phase::FootLock);
    write_matrices(&model, matrices);
    if !locals.is_empty() {
        write_locals(shared(&r.skeleton), &model, locals.len() / NUM_JOINTS, locals);
    }
    laps.end(Phase::Poses);
}

/// Updates the planar roots.
///
/// - `in_clip`: x, z and heading within the clip.
#[inline(always)]
fn place<F: Lanes>(block: &mut Block, in_clip: [F; 3]) -> Placement<F> {
    let [px, pz, ph] = in_clip;
    let [tx, tz, th] = &block.clip_to_world;
    let (tx, tz, th) = (F::load(tx), F::load(tz), F::load(th));
    let (clip_sin, clip_cos) = th.sin_cos8();
    let x = clip_cos * px + clip_sin * pz + tx;
    let z = clip_cos * pz - clip_sin * px + tz;
    let since = F::load(&block.time).max(F::splat(0.0)) - F::load(&block.drift_from);
    let [dx, dy, dz] = &block.drift;
    let x = x + F::load(dx) * since;
    let z = z + F::load(dz) * since;
    let y = F::load(&block.lift) + F::load(dy) * since;
    let heading = th + ph + F::load(&block.turn) * since;
    x.store(&mut block.root[0]);
    z.store(&mut block.root[1]);
    heading.store(&mut block.root[2]);
    let (sin, cos) = heading.sin_cos8();
    Placement { x, y, z, sin, cos }
}
