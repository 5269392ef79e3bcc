//! One tick, in reading order: advance -> control -> sample -> body ([`crate::body`]).
//!
//! Characters are handled in ranges of whole blocks; nothing in a range depends on another, so results do not
//! depend on how characters are split.

use super::block::{BodyBlock, MotionBlock, SCHEDULED};
use super::{CharactersConfig, PolicyOrder, carriage::add_carriage, motion_set::MotionSet};
use super::{bent, blow::PassedHits, control, decay::add_offsets, detail, idle::idle_rate, pace};
use crate::body::{
    BlockTouch, BodyState, BodyTick, DetailLevel, FeetMotion, FeetTick, FootLock, FootMotion, FrameCursor,
    FramePosition, HeightField, LEGS, Lane, Lane3, LaneBody, LanePose, LayerLanes, LimbTouch, LocalTransform, Mat3x4,
    ModelPose, PartnerTouch, PlacementLanes, PlantFeet, PoseInstance, PoseOutput, SolePose, hips_ground_height, load,
    pose_block, sample_pose,
};
use crate::contacts::Contacts;
use crate::skeleton::{Joint, NUM_JOINTS};
use throng_base::simd::{Functions, LANES, LaneWork, Lanes, V, dispatch};
use throng_base::thresholds::KNEE_RADPS;

/// Height of a foot in its clip from which its place on the ground does not matter any more (m, of the database skeleton).
const MATTERS_BELOW_M: f32 = 0.15;
/// Lowering of the hips that cannot be seen (m).
const NOT_LOWERED_M: f32 = 1e-5;

/// Longest time that a held character is late, which counts for no more (frames).
const LONGEST_WAIT: f32 = 500.0;

/// Inputs of one tick, shared by all ranges.
pub(crate) struct CharactersTick<'a> {
    pub dt_s: f32,
    pub motion_set: &'a MotionSet,
    pub config: &'a CharactersConfig,
    pub ground: &'a HeightField,
    pub orders: &'a [PolicyOrder],
    /// What stops limbs at the body of a partner, if anything does.
    pub touch: Option<&'a PartnerTouch>,
    /// False applies the displacements of the last step's touch again.
    pub moves: bool,
}

/// The part of the characters that one call handles.
pub(crate) struct CharacterRange<'a> {
    /// Number of the first character.
    pub first: usize,
    /// Characters; the last block may have empty lanes.
    pub count: usize,
    pub blocks: &'a mut [MotionBlock],
    /// (blocks)
    pub bodies: &'a mut [BodyBlock],
    /// (blocks)
    pub levels: &'a [DetailLevel],
    /// Hits that are passed.
    pub passed: &'a mut PassedHits,
    /// (count * NUM_JOINTS)
    pub matrices: &'a mut [Mat3x4],
    /// (count * NUM_JOINTS, or 0 where no local transforms are wanted)
    pub locals: &'a mut [LocalTransform],
    /// (count, or 0 where no records are wanted)
    pub instances: &'a mut [PoseInstance],
    /// Displacements of limbs (count, or 0 where nothing stops them).
    pub touches: &'a mut [LimbTouch],
}

/// Moves a range on, by the list above: everybody advances and chooses before anybody is posed.
pub(crate) fn step(range: CharacterRange<'_>, tick: &CharactersTick<'_>) {
    advance_all(range.blocks, range.passed, range.first, range.count, tick);
    control::choose_all(range.blocks, range.bodies, range.passed, range.first, range.count, tick);
    range.passed.sort();
    pose_all(range, tick);
}

/// The second half of the list: sample -> body, for all blocks of a range.
pub(crate) fn pose_all(range: CharacterRange<'_>, tick: &CharactersTick<'_>) {
    let body = BodyTick::new(tick.ground, &tick.config.reaction, &tick.motion_set.rows, tick.dt_s);
    let feet = FeetTick::new(tick.ground, &tick.config.foot_lock, tick.dt_s);
    dispatch(PoseAllJob { range, tick, body, feet });
}

/// The arguments of [`pose_all`].
struct PoseAllJob<'a, 't> {
    range: CharacterRange<'a>,
    tick: &'a CharactersTick<'t>,
    body: BodyTick<'a>,
    feet: FeetTick<'a>,
}

impl LaneWork for PoseAllJob<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<F: Lanes>(self) {
        let CharacterRange { blocks, bodies, levels, first, count, matrices, locals, instances, touches, .. } =
            self.range;
        let half_life_s = self.tick.config.half_life_s;
        let mut poses = matrices.chunks_mut(LANES * NUM_JOINTS);
        for (i, (block, body)) in blocks.iter_mut().zip(bodies).enumerate() {
            let Some(matrices) = poses.next() else { break };
            let at = i * LANES;
            let records = instances.get_mut(at..count.min(at + LANES)).unwrap_or_default();
            detail::set_awake(levels[i], block, body, self.tick.motion_set, half_life_s);
            let locals = locals.get_mut(at * NUM_JOINTS..).unwrap_or_default();
            let len = locals.len().min(matrices.len());
            let to = PoseOutput { matrices, locals: &mut locals[..len] };
            let orders = self.tick.orders.get(first + at..first + count.min(at + LANES)).unwrap_or_default();
            let touches = touches.get_mut(at..count.min(at + LANES)).unwrap_or_default();
            let block = CharacterBlock { block, body, level: levels[i], records, orders, touches };
            block.pose::<F>(to, self.tick, &self.body, &self.feet);
        }
    }
}

/// A block of eight characters that is posed.
struct CharacterBlock<'a> {
    block: &'a mut MotionBlock,
    body: &'a mut BodyBlock,
    level: DetailLevel,
    /// (characters, or 0)
    records: &'a mut [PoseInstance],
    /// (characters, or 0 where all play scheduled clips)
    orders: &'a [PolicyOrder],
    /// (characters, or 0)
    touches: &'a mut [LimbTouch],
}

/// The first entry of the list: moves time on, turns the path of characters with bent actions, and notes the hits that are
/// passed.
pub(crate) fn advance_all(
    blocks: &mut [MotionBlock],
    passed: &mut PassedHits,
    first: usize,
    count: usize,
    tick: &CharactersTick<'_>,
) {
    passed.clear();
    let frames = tick.dt_s * tick.motion_set.rate_hz;
    for character in 0..count {
        let (b, lane) = (&mut blocks[character / LANES], character % LANES);
        let from = b.time[lane];
        match b.pace[lane] {
            pace::HELD_STILL => b.wait[lane] = (b.wait[lane] - frames).max(-LONGEST_WAIT),
            pace @ (pace::SLOWING | pace::STARTING) => {
                let length = b.length[lane] as f32;
                b.time[lane] = pace::frame_after(pace, length, from, frames);
            }
            pace::IDLING => b.time[lane] += frames * idle_rate(b.name[lane], tick.config),
            _ => b.time[lane] += frames,
        }
        if b.bend[lane] != 0.0 {
            bent::place_on_path(b, lane, tick.motion_set);
        }
        if b.segment[lane] == SCHEDULED {
            // Where nothing follows, it stays at the end.
            b.time[lane] = b.time[lane].min(b.length[lane] as f32);
        } else if !passed.is_off() {
            let (to, place) = (b.time[lane], b.clip_to_world(lane));
            passed.add_passed(tick.motion_set, (first + character) as u32, b.segment[lane], from, to, place);
        }
        b.age_s[lane] += tick.dt_s;
    }
}

impl CharacterBlock<'_> {
    /// Samples a block and takes it through the list of bodies.
    #[inline(always)]
    fn pose<F: Lanes>(
        self,
        to: PoseOutput<'_>,
        tick: &CharactersTick<'_>,
        body_tick: &BodyTick<'_>,
        feet_tick: &FeetTick<'_>,
    ) {
        let Self { block, body, level, records, orders, touches } = self;
        let r = tick.motion_set;
        let mut spots = [FramePosition::default(); LANES];
        for (lane, spot) in spots.iter_mut().enumerate() {
            // The last frame of a clip has no successor, so it is reached from the one before.
            let time = block.time[lane].max(0.0);
            let whole = (time as u32).min(block.length[lane].saturating_sub(1));
            let frame = block.first[lane] + whole;
            // Within a segment, all neighbours are of its clip.
            let is_within = whole > 0 && whole + 2 <= block.length[lane];
            *spot = r.frame_position(frame, time - whole as f32, is_within);
            block.contacts[lane] = r.contacts[spot.frame + usize::from(spot.ratio > 0.5)];
        }
        let cursor: FrameCursor<'_, F> = FrameCursor::at_positions(&spots, &r.frames, &r.rotation_code);
        let [x, z, heading, height] = cursor.root();
        let was = block.root;
        let mut place = update_roots(block, [x, z, heading]);
        let lift = place.y;
        if tick.ground.has_floors() {
            for lane in 0..LANES {
                let at = glam::Vec2::new(block.root[0][lane], block.root[1][lane]);
                block.floor[lane] = tick.ground.ground_at(at, block.floor[lane]).height;
            }
        }
        let speed = forward_speed(&was, block, &place, &body.state.seen, tick.dt_s);
        if tick.ground.is_flat() {
            if body.state.base != [0.0; LANES] {
                (body.state.base, body.state.base_rate) = ([0.0; LANES], [0.0; LANES]);
            }
        } else if level == DetailLevel::Record {
            // Bodies that are never posed are never written.
            let height = |lane| hips_ground_height(tick.ground, block.root(lane), 0.0, block.floor[lane]);
            let height = std::array::from_fn(height);
            place.y = place.y + F::from_array(height);
        } else {
            body.state.follow_base(tick.ground, &body_tick.base, |lane| block.root(lane), &speed, &block.floor);
            place.y = place.y + F::load(&body.state.base);
        }
        if !records.is_empty() {
            detail::write_instances(records, block, &spots, &place, r, tick.config.half_life_s);
        }
        if level == DetailLevel::Record {
            return;
        }
        let mut motion = LanePose::unposed(F::splat(0.0));
        sample_pose(&cursor, height + place.y, &mut motion);
        add_offsets(&mut motion, block, body, tick.config.half_life_s);
        add_carriage(&mut motion, block, tick.config);
        let orders = orders.iter().map(|order| &order.layers);
        let mut layers = LayerLanes::new(orders, [0.0; LANES], |lane| block.root(lane), &place.y.to_array());
        let (contacts, dt_s) = (block.contacts, tick.moves.then_some(tick.dt_s));
        layers.touch = tick.touch.map(|partners| BlockTouch { partners, touches, contacts, dt_s });
        let BodyBlock { state, feet, .. } = body;
        let seen = state.seen;
        let (contacts, locks) = (&block.contacts, level == DetailLevel::Full && tick.config.foot_lock.enabled);
        let mut planted = CapturedFeet { tick: feet_tick, body: &r.body, contacts, locks, speed: &speed, feet };
        let balls = pose_block(&r.body, &mut motion, &place, &mut layers, body_tick, state, &mut planted, to);
        feet_tick.clear_contacts_in_air::<F>(&r.body, &body.feet, &lift.to_array(), &mut block.contacts);
        body.state.swing.follow(balls, &block.contacts, &seen, &speed, tick.dt_s);
    }
}

/// The feet of a block, which clips move.
struct CapturedFeet<'a, 't> {
    tick: &'a FeetTick<'t>,
    body: &'a LaneBody,
    contacts: &'a [Contacts; LANES],
    /// False leaves planted feet to their clips.
    locks: bool,
    /// (m/s)
    speed: &'a Lane,
    feet: &'a mut [FootLock; 2],
}

impl<F: Lanes> PlantFeet<F> for CapturedFeet<'_, '_> {
    #[inline(always)]
    fn plant(&mut self, layers: &LayerLanes<'_>, at: &PlacementLanes<F>, own: &mut BodyState, pose: &mut ModelPose<F>) {
        let sunk = layers.hips_sink(self.body, pose);
        let is_raised = own.drop.iter().all(|drop| drop.abs() < NOT_LOWERED_M);
        if !self.locks && self.tick.is_flat() && sunk.is_none() && is_raised {
            (own.drop, own.drop_rate) = ([0.0; LANES], [0.0; LANES]);
            *self.feet = [FootLock::ZERO; 2];
            return;
        }
        let motion = FeetMotion {
            feet: [self.foot_motion(0, at, pose), self.foot_motion(1, at, pose)],
            speed: self.speed,
            knee_rate: F::splat(KNEE_RADPS),
            sunk: sunk.unwrap_or(F::splat(0.0)),
            lift: at.y - F::load(&own.base),
        };
        self.tick.plant_feet(self.body, &motion, at, own, self.feet, pose);
    }
}

impl CapturedFeet<'_, '_> {
    /// One foot as the clip has it. Its position matters as much as the foot is near the ground.
    #[inline(always)]
    fn foot_motion<F: Lanes>(&self, side: usize, place: &PlacementLanes<F>, pose: &ModelPose<F>) -> FootMotion<F> {
        let (zero, one, leg) = (F::splat(0.0), F::splat(1.0), &self.body.legs[side]);
        let [thigh, _, foot, toe] = LEGS[side].map(Joint::index);
        let sole = SolePose {
            ankle: pose.positions[foot] - V::new(zero, place.y, zero),
            foot: pose.rotations[foot],
            toe: pose.rotations[toe],
        };
        let (heel, ball) = (sole.foot.rotate(load(&leg.heel)).y, sole.foot.rotate(load(&leg.ball)).y);
        let lowest = sole.ankle.y + heel.min(ball - F::load(&leg.thickness));
        let [heel, ball] = Contacts::FEET[side];
        let is_down = |part| self.contacts.map(|c| f32::from(u8::from(self.locks && c.any(part))));
        FootMotion {
            sole,
            contacts: [F::load(&is_down(heel)), F::load(&is_down(ball))],
            importance: (one - lowest.max(zero) * F::splat(1.0 / MATTERS_BELOW_M)).max(zero),
            leg: (pose.positions[foot] - pose.positions[thigh]).length(),
        }
    }
}

/// Speed along where bodies face since they were last posed; 0 for new ones (m/s).
#[inline(always)]
fn forward_speed<F: Lanes>(was: &Lane3, block: &MotionBlock, at: &PlacementLanes<F>, seen: &Lane, dt_s: f32) -> Lane {
    if dt_s == 0.0 {
        return [0.0; LANES];
    }
    let (x, z) = (F::load(&block.root[0]) - F::load(&was[0]), F::load(&block.root[1]) - F::load(&was[1]));
    let speed = (at.sin * x + at.cos * z) / F::splat(dt_s);
    F::select_lt(F::splat(0.5), F::load(seen), speed, F::splat(0.0)).to_array()
}

/// Updates the planar roots.
///
/// - `in_clip`: x, z and heading within the clip.
#[inline(always)]
fn update_roots<F: Lanes>(block: &mut MotionBlock, in_clip: [F; 3]) -> PlacementLanes<F> {
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
    PlacementLanes { x, y, z, sin, cos }
}
