//! One tick, in reading order: steer -> weigh -> advance -> blend -> body ([`crate::body`]).
//!
//! Characters are handled in ranges of whole blocks; nothing in a range depends on another, so results do not depend
//! on how walkers are split. Postures are blended one by one, with a lane for each joint, and retargeted by eights,
//! with a lane for each character.

use super::{Control, WalkerActivity, WalkersConfig};
use super::{block::WalkerBlock, perform::PerformanceInputs, steer::WalkerSteering};
use crate::blend::{BlendSpace, BlendedPosture, channel, smooth_share};
use crate::body::{
    Bearing, BodyState, BodyTick, DetailLevel, FeetMotion, FeetTick, FootLock, FootMotion, HeightField, LEGS, Lane,
    LaneBody, LanePose, LayerLanes, LocalTransform, Mat3x4, ModelPose, PlacementLanes, PlantFeet, PoseInstance,
    PoseOutput, SolePose, load, planar_of_lane, pose_block, reach_hand, unorm,
};
use crate::{contacts::Contacts, planar::Planar, skeleton::NUM_JOINTS};
use throng_base::simd::{Functions, LANES, LaneWork, Lanes, Q, V, dispatch};
use throng_base::thresholds::{STEP_TIME_MPS, WALKER_KNEE_RADPM, WALKER_KNEE_RADPS};

/// Share of the blend that has a foot on the ground from which it is planted, and down to which it stays.
const PLANTED: [f32; 2] = [0.65, 0.35];

/// Inputs of one step, shared by all ranges.
pub(crate) struct WalkersTick<'a> {
    space: &'a BlendSpace,
    config: &'a WalkersConfig,
    steering: WalkerSteering<'a>,
    body: BodyTick<'a>,
    feet: FeetTick<'a>,
    dt_s: f32,
    /// Share of cubic paths between the rows of the posture tables.
    smooth: f32,
    stage: PerformanceInputs<'a>,
}

impl<'a> WalkersTick<'a> {
    pub fn new(space: &'a BlendSpace, config: &'a WalkersConfig, dt_s: f32, ground: &'a HeightField) -> Self {
        Self {
            space,
            config,
            steering: WalkerSteering::new(space, config, dt_s),
            body: BodyTick::new(ground, &config.reaction, &space.activities().rows, dt_s),
            feet: FeetTick::new(ground, &config.foot_lock, dt_s),
            dt_s,
            smooth: smooth_share(dt_s),
            stage: PerformanceInputs::new(space.activities(), space.axes(), dt_s),
        }
    }
}

/// The walkers that one call handles.
pub(crate) struct WalkerRange<'a> {
    pub blocks: &'a mut [WalkerBlock],
    pub bodies: &'a [LaneBody],
    /// (blocks)
    pub levels: &'a [DetailLevel],
    /// Order of each walker; the last block may have empty lanes.
    pub controls: &'a mut [Control],
    /// (controls.len())
    pub acts: &'a mut [WalkerActivity],
    /// (controls.len() * stride)
    pub weights: &'a mut [f32],
    /// (controls.len())
    pub roots: &'a mut [Planar],
    /// (controls.len())
    pub model: &'a mut [[Mat3x4; NUM_JOINTS]],
    /// (controls.len() * NUM_JOINTS, or 0 without local transforms)
    pub locals: &'a mut [LocalTransform],
    /// (controls.len(), or 0 without records)
    pub instances: &'a mut [PoseInstance],
}

/// Moves a range on.
pub(crate) fn step(range: WalkerRange<'_>, tick: &WalkersTick<'_>) {
    for (c, (control, act)) in range.controls.iter_mut().zip(&mut *range.acts).enumerate() {
        let (block, body, lane) = (&mut range.blocks[c / LANES], &range.bodies[c / LANES], c % LANES);
        act.has_ended = false;
        if act.acting.is_idle() {
            tick.steering.steer(block, body, lane, control);
        } else {
            let mut led = act.acting.steering_order(control, &tick.stage);
            tick.steering.steer(block, body, lane, &mut led);
            control.position = None;
            act.has_ended = act.acting.advance(&tick.stage, control, block, lane);
        }
        range.roots[c] = block.root(lane);
    }
    dispatch(BlendWalkersJob { range, tick });
}

/// Work after steering, for all blocks of a range.
struct BlendWalkersJob<'a, 't> {
    range: WalkerRange<'a>,
    tick: &'a WalkersTick<'t>,
}

impl LaneWork for BlendWalkersJob<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<F: Lanes>(self) {
        let WalkerRange { blocks, bodies, levels, controls, acts, weights, model: matrices, locals, instances, .. } =
            self.range;
        let matrices = matrices.as_flattened_mut();
        let space = self.tick.space;
        let mut from = 0;
        for ((block, body), level) in blocks.iter_mut().zip(bodies).zip(levels) {
            let count = LANES.min(controls.len() - from);
            let weights = &mut weights[from * space.stride()..][..count * space.stride()];
            space.weigh_batch::<F>(&block.parameters[..count], weights);
            for (lane, weights) in weights.chunks_exact(space.stride()).enumerate() {
                advance_phase::<F>(block, body, lane, weights, self.tick);
            }
            let place = update_placement::<F>(block, self.tick);
            if let Some(records) = instances.get_mut(from..from + count) {
                write_instances(records, block, weights, space);
            }
            if *level != DetailLevel::Full {
                // Whoever is posed whole later finds its feet anew.
                block.feet = [FootLock::ZERO; 2];
                (block.body.drop, block.body.drop_rate) = ([0.0; LANES], [0.0; LANES]);
            }
            if *level == DetailLevel::Record {
                let BodyState { base, base_rate, .. } = block.body;
                block.body = BodyState { base, base_rate, ..BodyState::ZERO };
                block.contacts = [Contacts::NONE; LANES];
                from += count;
                continue;
            }
            let mut postures = [BlendedPosture::default(); LANES];
            let (mut importance, mut still) = ([[0.0; LANES]; 2], [0.0; LANES]);
            for (lane, weights) in weights.chunks_exact(space.stride()).enumerate() {
                let place = space.phase_interval(block.phase[lane], self.tick.smooth);
                space.blend_posture::<F>(weights, &place, &mut postures[lane]);
                let both = space.timing.importance::<F>(weights, place.rows, place.ratio);
                let share = acts[from + lane].overlay_posture(self.tick, &mut postures[lane]);
                still[lane] = share;
                [importance[0][lane], importance[1][lane]] = both.map(|of| of + (1.0 - of) * share);
            }
            let mut motion = LanePose::unposed(F::splat(0.0));
            let postures = transpose(&postures, &mut motion);
            motion.root = postures.hips * F::load(&body.scale);
            motion.root.y = motion.root.y + F::load(&body.lift) + place.y;
            let seen = block.body.seen;
            let WalkerBlock { root, body: state, feet, speed, contacts, .. } = block;
            let root = |lane: usize| planar_of_lane(root, lane);
            let orders = controls[from..from + count].iter().map(|control| &control.layers);
            let mut layers = LayerLanes::new(orders, still, root, &state.base);
            let has_feet = self.tick.config.foot_lock.enabled && *level == DetailLevel::Full;
            let (stands, postures, tick) = (&mut *contacts, &postures, self.tick);
            let mut walking = WalkingFeet { has_feet, feet, contacts: stands, speed, body, postures, importance, tick };
            let joints = from * NUM_JOINTS..(from + count) * NUM_JOINTS;
            let to = PoseOutput {
                matrices: &mut matrices[joints.clone()],
                locals: locals.get_mut(joints).unwrap_or_default(),
            };
            let balls = pose_block(body, &mut motion, &place, &mut layers, &self.tick.body, state, &mut walking, to);
            state.swing.follow(balls, contacts, &seen, speed, self.tick.dt_s);
            from += count;
        }
    }
}

impl WalkerActivity {
    /// Mixes the performance into a blended posture; returns its share.
    #[inline(always)]
    fn overlay_posture(&mut self, tick: &WalkersTick<'_>, posture: &mut BlendedPosture) -> f32 {
        if self.acting.is_idle() { 0.0 } else { self.acting.overlay_posture(tick.stage.activities, posture) }
    }
}

/// Writes the records of a block (at most 8).
fn write_instances(out: &mut [PoseInstance], block: &WalkerBlock, weights: &[f32], space: &BlendSpace) {
    for (lane, (out, weights)) in out.iter_mut().zip(weights.chunks_exact(space.stride())).enumerate() {
        let ([a, b], share) = space.heaviest_rows(weights, block.phase[lane]).unwrap_or_default();
        let Planar { x, z, heading } = block.root(lane);
        // Both rows share the ratio of the first.
        let row_b = b.row + u32::from(b.has_next && b.ratio - a.ratio > 0.5);
        let frac_blend = [unorm(a.ratio), unorm(share)];
        *out = PoseInstance { row_a: a.row, row_b, frac_blend, x, y: block.body.base[lane], z, heading, ..*out };
    }
}

/// Moves the generic time of one lane on, a little faster or slower where that makes strides fit the speed.
#[inline(always)]
fn advance_phase<F: Lanes>(b: &mut WalkerBlock, body: &LaneBody, lane: usize, weights: &[f32], tick: &WalkersTick<'_>) {
    let timing = &tick.space.timing;
    let [cycle_s, left, ahead] = timing.cycle::<F>(weights);
    let pace = body.pace[lane];
    let seconds = cycle_s.max(1e-3);
    b.travel[0][lane] = left / seconds;
    b.travel[1][lane] = ahead / seconds;
    let stride_mps = (left * left + ahead * ahead).sqrt() / seconds;
    let [slow, fast] = tick.config.tempo;
    let fitting = (b.speed[lane] / pace / stride_mps.max(1e-3)).clamp(slow, fast);
    let share = (stride_mps / STEP_TIME_MPS).min(1.0);
    let tempo = 1.0 + (fitting - 1.0) * share * share;
    b.phase[lane] = timing.advance::<F>(weights, b.phase[lane], tick.dt_s * tempo / pace);
}

/// Eight postures as one lane each.
struct PostureLanes<F> {
    hips: V<F>,
    ankles: [V<F>; 2],
    hands: [V<F>; 2],
    contacts: [F; 2],
    touches: [F; 2],
}

/// Takes eight postures as lanes; the rotations of joints become those of a pose.
#[inline(always)]
fn transpose<F: Lanes>(postures: &[BlendedPosture; LANES], pose: &mut LanePose<F>) -> PostureLanes<F> {
    let zero = F::splat(0.0);
    for quad in 0..NUM_JOINTS.div_ceil(4) {
        let mut c = [[zero; 4]; 4];
        for (component, c) in c.iter_mut().enumerate() {
            *c = F::columns(postures.each_ref().map(|p| &p.rotations[component].as_chunks().0[quad]));
        }
        for k in 0..4.min(NUM_JOINTS - 4 * quad) {
            pose.rotations[4 * quad + k] = Q::new(V::new(c[0][k], c[1][k], c[2][k]), c[3][k]);
        }
    }
    let mut c = [zero; 20];
    for quad in 0..5 {
        let four = F::columns(postures.each_ref().map(|p| &p.channels.as_chunks().0[quad]));
        c[4 * quad..][..4].copy_from_slice(&four);
    }
    let at = |channel: usize| c[channel - channel::HIPS];
    let vector = |channel: usize| V::new(at(channel), at(channel + 1), at(channel + 2));
    PostureLanes {
        hips: vector(channel::HIPS),
        ankles: [vector(channel::LEFT_ANKLE), vector(channel::RIGHT_ANKLE)],
        hands: [vector(channel::LEFT_HAND), vector(channel::RIGHT_HAND)],
        contacts: [at(channel::LEFT_CONTACT), at(channel::RIGHT_CONTACT)],
        touches: [at(channel::LEFT_TOUCH), at(channel::RIGHT_TOUCH)],
    }
}

/// The feet of a block, which the postures are retargeted with.
struct WalkingFeet<'a, 't, F> {
    /// False leaves the feet to the joint angles.
    has_feet: bool,
    feet: &'a mut [FootLock; 2],
    contacts: &'a mut [Contacts; LANES],
    /// (m/s)
    speed: &'a Lane,
    body: &'a LaneBody,
    postures: &'a PostureLanes<F>,
    importance: [Lane; 2],
    tick: &'a WalkersTick<'t>,
}

impl<F: Lanes> PlantFeet<F> for WalkingFeet<'_, '_, F> {
    /// Retargets a pose to the bodies and to the ground (Kim, Kim and Shin 2003a, sections 4.2.3 and 4.2.4).
    #[inline(always)]
    fn plant(&mut self, layers: &LayerLanes<'_>, at: &PlacementLanes<F>, own: &mut BodyState, pose: &mut ModelPose<F>) {
        let (body, t, tick) = (self.body, self.postures, self.tick);
        if !self.has_feet {
            *self.contacts = contacts(t.contacts.map(|c| [standing(c).to_array(); 2]));
            return;
        }
        let pace = F::load(&body.pace);
        let motion = FeetMotion {
            feet: [self.foot_motion(0, at, pose), self.foot_motion(1, at, pose)],
            speed: self.speed,
            knee_rate: F::splat(WALKER_KNEE_RADPS) / pace
                + F::load(self.speed) * F::splat(WALKER_KNEE_RADPM) / (pace * pace),
            sunk: layers.hips_sink(body, pose).unwrap_or(F::splat(0.0)),
            lift: F::splat(0.0),
        };
        let bearing = tick.feet.plant_feet(body, &motion, at, own, self.feet, pose);
        for (side, &touch) in t.touches.iter().enumerate() {
            if touch.any_gt(F::splat(0.0)) {
                let to = pose.positions[0] + t.hands[side] * F::load(&body.arm_scale);
                reach_hand(body, side, to, touch.max(F::splat(0.0)).min(F::splat(1.0)), pose);
            }
        }
        *self.contacts = contacts(bearing);
    }
}

impl<F: Lanes> WalkingFeet<'_, '_, F> {
    /// One foot: the examples' ankle is scaled to the body, and taken in proportion to the importance of its position; the
    /// joint angles give the rest.
    #[inline(always)]
    fn foot_motion(&self, side: usize, place: &PlacementLanes<F>, model: &ModelPose<F>) -> FootMotion<F> {
        let (body, t, zero, one) = (self.body, self.postures, F::splat(0.0), F::splat(1.0));
        let [_, _, foot, toe] = LEGS[side].map(|j| j.index());
        let importance = F::load(&self.importance[side]);
        let by_angles = model.positions[foot] - V::new(zero, place.y, zero);
        let scaled = (t.hips + t.ankles[side]) * F::load(&body.scale) + load(&body.legs[side].ankle);
        let ankle = by_angles + (scaled - by_angles) * importance;
        let [plants, stays] = PLANTED.map(F::splat);
        let threshold = plants + (stays - plants) * F::load(&self.feet[side].down);
        FootMotion {
            sole: SolePose { ankle, foot: model.rotations[foot], toe: model.rotations[toe] },
            contacts: [F::select_lt(threshold, t.contacts[side], one, zero); 2],
            importance,
            leg: zero,
        }
    }
}

/// Placement of eight characters in the world. The hips follow the ground smoothly.
#[inline(always)]
fn update_placement<F: Lanes>(block: &mut WalkerBlock, tick: &WalkersTick<'_>) -> PlacementLanes<F> {
    let WalkerBlock { root, speed, body: state, .. } = block;
    let near = state.base;
    state.follow_base(tick.body.ground, &tick.body.base, |lane| planar_of_lane(root, lane), speed, &near);
    let [x, z, heading] = root;
    let (sin, cos) = F::load(heading).sin_cos8();
    PlacementLanes { x: F::load(x), y: F::load(&state.base), z: F::load(z), sin, cos }
}

/// 1 where more than half of the blend has a foot on the ground.
#[inline(always)]
fn standing<F: Lanes>(contact: F) -> F {
    F::select_lt(F::splat(0.5), contact, F::splat(1.0), F::splat(0.0))
}

/// Bits of the parts that bear: heel and ball of the left foot, then of the right.
fn contacts(bearing: [Bearing; 2]) -> [Contacts; LANES] {
    let mut all = [Contacts::NONE; LANES];
    for (parts, bearing) in Contacts::FEET.iter().zip(&bearing) {
        for (&part, bears) in parts.iter().zip(bearing) {
            for (contacts, &bears) in all.iter_mut().zip(bears) {
                if bears > 0.5 {
                    contacts.insert(part);
                }
            }
        }
    }
    all
}
