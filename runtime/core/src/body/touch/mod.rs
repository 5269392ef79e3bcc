//! Touch of limbs, a layer of the body: arms and legs stop, or slide, where they meet a partner's body, guard or legs.
//!
//! Each limb stores its displacement from its motion. In a step the displacement fades, then elbow and wrist, or knee and
//! ankle, are moved out of obstacles, as points of a [`LimbSegment`]; fast limbs move in short pieces, so that none tunnels through
//! an obstacle. A leg that steps is displaced along the ground, one that kicks is displaced as arms are, and one that carries
//! weight stays where it came down and is only an obstacle for others. Blows are tested against the motion without these
//! displacements.

mod segment;
#[cfg(test)]
mod tests;

use super::lanes::{Lane3, get_lane, load, set_lane, store};
use super::limbs::{chosen_q, chosen_v};
use super::{hierarchy::ModelPose, placement::PlacementLanes, volume::BodyVolume};
use crate::skeleton::{ARMS, Joint, Skeleton};
use crate::{contacts::Contacts, hits::striking_offset};
use glam::Vec3;
use segment::{
    BoundingBall, LimbFreedom, LimbSegment, LimbShape, SOFT_ELBOW_M, elbow_angle, separate_segments, solve_two_bones,
    swing_rotation,
};
use serde::{Deserialize, Serialize};
use throng_base::simd::{LANES, Lanes, Q, V};
use throng_base::thresholds::{FLESH_GIVES_M, LEG_RAISED_M};
use throng_base::{Result, error::check_value, maths};
use throng_geometry::{Capsule, nearest_points};

/// Approximate length of a piece of a limb's path, except for very fast arms (m).
const PIECE_M: f32 = 0.06;
/// Most pieces of a path in a step.
const MOST_PIECES: usize = 4;
/// Number of rounds in which limbs are moved out of obstacles.
const ROUNDS: usize = 6;
/// Number of rounds in which a whole arm is turned out of remaining obstacles.
const SWINGS: usize = 4;
/// Largest distance of a limb from the hips (m).
const REACH_M: f32 = 1.3;
/// Displacement below which a limb counts as not displaced (m).
const AT_REST_M: f32 = 5e-4;
/// Least length of a bone of a limb (m).
const LEAST_M: f32 = 1e-3;

/// Root, middle and end of each limb: shoulder, elbow and wrist, then hip, knee and ankle.
const LIMBS: [[Joint; 3]; NUM_LIMBS] = {
    let [[a, b, c, _], [d, e, f, _]] = crate::skeleton::LEGS;
    [ARMS[0], ARMS[1], [a, b, c], [d, e, f]]
};
const NUM_LIMBS: usize = 4;
/// Number of the first limb that is a leg, and toes and soles of legs.
const LEGS: usize = 2;
const TOES: [Joint; 2] = [Joint::LeftToe, Joint::RightToe];
const SOLES: [Contacts; 2] = [Contacts::LEFT, Contacts::RIGHT];
/// Distance of two ankles from which on their feet cannot meet in a step (m).
const FEET_APART_M: f32 = 0.6;

/// Shapes of the limbs of a character.
type LimbShapes = [LimbShape; NUM_LIMBS];

/// Freedoms of the limbs of two characters.
type LimbFreedoms = [[LimbFreedom; NUM_LIMBS]; 2];

/// Root, middle and end of each limb of a character, in the world (m).
type LimbJoints = [[Vec3; 3]; NUM_LIMBS];

/// Root, middle and end of each limb of two characters, in the world (m).
type LimbPositions = [LimbJoints; 2];

/// Core capsules of a body.
type BodyCore = [Capsule; BodyVolume::CORE.len()];

/// Settings of limbs that stop at a partner's body and guard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TouchConfig {
    /// False lets arms pass through the partner's body.
    pub enabled: bool,
    /// Half-life of the displacement of an arm that is free again (s, 0.001 to 10).
    pub half_life_s: f32,
    /// Depth to which flesh gives way (m, 0 to 0.1).
    pub give_m: f32,
    /// Largest angular speed of an elbow by touch, where its motion does not turn it faster (rad/s, 1 to 1000).
    pub elbow_radps: f32,
}

impl Default for TouchConfig {
    fn default() -> Self {
        Self { enabled: true, half_life_s: 0.1, give_m: FLESH_GIVES_M, elbow_radps: 33.0 }
    }
}

impl TouchConfig {
    /// # Errors
    /// [`throng_base::Error::Value`] for a setting out of its range.
    pub fn check(&self) -> Result<()> {
        let Self { enabled: _, half_life_s, give_m, elbow_radps } = *self;
        let is_good = (1e-3..=10.0).contains(&half_life_s);
        check_value("touch.half_life_s", None, half_life_s, is_good, "between 0.001 and 10")?;
        let is_good = (1.0..=1000.0).contains(&elbow_radps);
        check_value("touch.elbow_radps", None, elbow_radps, is_good, "between 1 and 1000")?;
        check_value("touch.give_m", None, give_m, (0.0..=0.1).contains(&give_m), "between 0 and 0.1")
    }
}

/// What stops limbs: characters in rows 2i and 2i + 1 are partners, of one body.
#[derive(Clone, Debug)]
pub(crate) struct PartnerTouch {
    config: TouchConfig,
    volume: BodyVolume,
    shapes: LimbShapes,
}

impl PartnerTouch {
    /// - `volume`: of the skeleton's body, with the radii that stop limbs.
    pub fn new(skeleton: &Skeleton, volume: BodyVolume, config: TouchConfig) -> Self {
        Self { config, shapes: limb_shapes(skeleton, &volume), volume }
    }
}

/// State of the touch of one limb.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct LimbOffset {
    /// Displacements of its middle and its end from the motion (m).
    off: [Vec3; 2],
    /// Root, middle and end in the motion at the last step (m).
    was: [Vec3; 3],
}

impl LimbOffset {
    fn is_displaced(&self) -> bool {
        self.off != [Vec3::ZERO; 2]
    }

    /// Displaced root, middle and end (m).
    fn displaced_positions(&self) -> [Vec3; 3] {
        let [shoulder, elbow, wrist] = self.was;
        [shoulder, elbow + self.off[0], wrist + self.off[1]]
    }

    /// Share of the least bend that a displaced limb keeps: a limb that is hardly displaced may become straight again (0 to 1).
    fn bend_share(&self) -> f32 {
        (self.off[0].length().max(self.off[1].length()) / SOFT_ELBOW_M).min(1.0)
    }

    /// Restores the lengths of the limb, and limits the turn of its elbow or knee to `most`: the end gives way along its
    /// direction from the root (rad).
    ///
    /// - `before`: angle at the elbow or knee at the last step (rad).
    /// - `out`: see [`solve_two_bones`].
    fn keep_lengths(&mut self, shape: &LimbShape, before: f32, most: f32, out: Vec3) {
        let (joints, soft) = (self.displaced_positions(), self.bend_share());
        let (shoulder, mut ends) = (joints[0], solve_two_bones(joints, shape, out, soft));
        let angle = elbow_angle([shoulder, ends[0], ends[1]]);
        let slow = angle.clamp(before - most, before + most);
        if slow != angle {
            let [l1, l2] = shape.lengths;
            let distance = (l1 * l1 + l2 * l2 - 2.0 * l1 * l2 * maths::cos(slow)).max(0.0).sqrt();
            let wrist = shoulder + (ends[1] - shoulder).normalize_or_zero() * distance;
            ends = solve_two_bones([shoulder, ends[0], wrist], shape, out, soft);
        }
        self.off = [ends[0] - self.was[1], ends[1] - self.was[2]];
    }

    /// Turns the whole limb about its root out of remaining obstacles, which turns no elbow.
    fn swing_out(&mut self, shape: &LimbShape, core: &[Capsule], give_m: f32) {
        let mut num_clear = 0;
        for capsule in core.iter().cycle().take(SWINGS * core.len()) {
            let [root, middle, end] = self.displaced_positions();
            let Some(turn) = swing_rotation([root, middle, end], shape, capsule, give_m) else {
                num_clear += 1;
                // A limb that has left all capsules where it is now leaves them in later rounds too.
                if num_clear == core.len() {
                    break;
                }
                continue;
            };
            num_clear = 0;
            let turned = [middle, end].map(|p| root + maths::rotate(turn, p - root));
            self.off = [turned[0] - self.was[1], turned[1] - self.was[2]];
        }
    }
}

/// State of the touch of a character's limbs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct LimbTouch {
    /// In the order of [`LIMBS`].
    limbs: [LimbOffset; NUM_LIMBS],
    /// Whether it has a last step.
    seen: bool,
}

/// Bodies of two partners in the world, as a step begins.
struct PartnerBodies {
    joints: LimbPositions,
    toes: [[Vec3; 2]; 2],
    hips: [Vec3; 2],
    cores: [BodyCore; 2],
    /// Planted parts of their feet.
    contacts: [Contacts; 2],
}

/// Shapes of a skeleton's limbs, in the order of [`LIMBS`].
fn limb_shapes(skeleton: &Skeleton, volume: &BodyVolume) -> LimbShapes {
    std::array::from_fn(|l| {
        let [root, middle, end] = LIMBS[l];
        let lengths = [middle, end].map(|j| skeleton.offsets[j.index()].length().max(LEAST_M));
        let is_leg = l >= LEGS;
        // An upper arm is tested with the radius of a forearm.
        let upper = if is_leg { root } else { middle };
        let [upper_radius, radius] = [upper, middle].map(|joint| volume.capsules[joint.index()].radius);
        let fist_m = if is_leg { 0.0 } else { striking_offset(skeleton, end).length() };
        LimbShape { lengths, hand_m: (fist_m - radius).max(0.0), radius, upper_radius }
    })
}

impl LimbTouch {
    /// False for a state that no limbs can have.
    pub fn is_valid(&self) -> bool {
        let near = |v: &Vec3, most: f32| v.is_finite() && v.abs().max_element() < most;
        self.limbs.iter().all(|a| a.off.iter().all(|v| near(v, 100.0)) && a.was.iter().all(|v| near(v, 2e6)))
    }

    /// Ends all displacements, of one that was moved to another place or whose partner was.
    pub fn reset(&mut self, was_moved: bool) {
        self.seen &= !was_moved;
        self.limbs.iter_mut().for_each(|limb| limb.off = [Vec3::ZERO; 2]);
    }
}

/// Touch of the characters of a block: those in lanes 2i and 2i + 1 are partners.
pub(crate) struct BlockTouch<'a> {
    pub partners: &'a PartnerTouch,
    /// (characters, an even number)
    pub touches: &'a mut [LimbTouch],
    pub contacts: [Contacts; LANES],
    /// Time since the last step; none applies the displacements of the last step again (s).
    pub dt_s: Option<f32>,
}

impl BlockTouch<'_> {
    /// Moves the limbs of all out of their partners.
    #[inline(always)]
    pub fn stop_limbs<F: Lanes>(&mut self, place: &PlacementLanes<F>, pose: &mut ModelPose<F>) {
        if let Some(dt_s) = self.dt_s {
            let mut joints = [[[[0.0; LANES]; 3]; 3]; NUM_LIMBS];
            for (limb, to) in LIMBS.iter().zip(&mut joints) {
                for (joint, to) in limb.iter().zip(to) {
                    store(to, place.to_world(pose.positions[joint.index()]));
                }
            }
            let mut others = [[[0.0; LANES]; 3]; 3];
            for (joint, to) in [Joint::Hips, TOES[0], TOES[1]].into_iter().zip(&mut others) {
                store(to, place.to_world(pose.positions[joint.index()]));
            }
            let mut cores = [[[[0.0; LANES]; 3]; 2]; BodyVolume::CORE.len()];
            for (joint, to) in BodyVolume::CORE.into_iter().zip(&mut cores) {
                let j = joint.index();
                for (end, to) in self.partners.volume.capsules[j].ends.into_iter().zip(to) {
                    store(to, place.to_world(pose.positions[j] + pose.rotations[j].rotate(V::splat(end))));
                }
            }
            self.solve_displacements(&joints, &others, &cores, dt_s);
        }
        for (limb, joints) in LIMBS.iter().enumerate() {
            let mut offsets: [Lane3; 2] = [[[0.0; LANES]; 3]; 2];
            let mut is_displaced = false;
            for (lane, touch) in self.touches.iter().enumerate() {
                is_displaced |= touch.limbs[limb].is_displaced();
                for (to, off) in offsets.iter_mut().zip(touch.limbs[limb].off) {
                    set_lane(to, lane, off);
                }
            }
            if is_displaced {
                displace_limb(limb, joints.map(Joint::index), &offsets.each_ref().map(load), place, pose);
            }
        }
    }

    /// Computes the displacements of all limbs, from joints, hips and toes, and ends of core capsules in the world (m).
    fn solve_displacements(
        &mut self,
        joints: &[[Lane3; 3]; NUM_LIMBS],
        others: &[Lane3; 3],
        cores: &[[Lane3; 2]; BodyVolume::CORE.len()],
        dt_s: f32,
    ) {
        let PartnerTouch { config, volume, shapes } = self.partners;
        for (i, pair) in self.touches.as_chunks_mut::<2>().0.iter_mut().enumerate() {
            let lanes = [2 * i, 2 * i + 1];
            let bodies = PartnerBodies {
                joints: lanes.map(|lane| joints.each_ref().map(|limb| limb.each_ref().map(|at| get_lane(at, lane)))),
                toes: lanes.map(|lane| [1, 2].map(|toe| get_lane(&others[toe], lane))),
                hips: lanes.map(|lane| get_lane(&others[0], lane)),
                cores: lanes.map(|lane| {
                    std::array::from_fn(|c| Capsule {
                        ends: cores[c].each_ref().map(|end| get_lane(end, lane)),
                        radius: volume.capsules[BodyVolume::CORE[c].index()].radius,
                    })
                }),
                contacts: lanes.map(|lane| self.contacts[lane]),
            };
            solve_pair(pair, shapes, &bodies, config, dt_s);
        }
    }
}

/// Displaces middle and end of a limb of all lanes, and turns its bones with them. Lanes without a displacement keep the limb to
/// the last bit.
///
/// - `offsets`: of middle and end in the world (m).
#[inline(always)]
fn displace_limb<F: Lanes>(
    limb: usize,
    [root, middle, end]: [usize; 3],
    offsets: &[V<F>; 2],
    place: &PlacementLanes<F>,
    pose: &mut ModelPose<F>,
) {
    let amount = offsets[0].dot(offsets[0]) + offsets[1].dot(offsets[1]);
    let [to_middle, to_end] = offsets.map(|off| place.vector_to_model(off));
    let [at_root, at_middle, at_end] = [root, middle, end].map(|j| pose.positions[j]);
    let (to_middle, moved_end) = (at_middle + to_middle, at_end + to_end);
    let upper = Q::shortest_arc(at_middle - at_root, to_middle - at_root);
    let lower = Q::shortest_arc(at_end - at_middle, moved_end - to_middle);
    pose.rotations[root] = chosen_q(amount, pose.rotations[root], upper * pose.rotations[root]);
    pose.rotations[middle] = chosen_q(amount, pose.rotations[middle], lower * pose.rotations[middle]);
    pose.positions[middle] = chosen_v(amount, at_middle, to_middle);
    pose.positions[end] = chosen_v(amount, at_end, moved_end);
    if limb < LEGS {
        // A hand follows the forearm; a foot keeps its turn.
        pose.rotations[end] = chosen_q(amount, pose.rotations[end], lower * pose.rotations[end]);
    } else {
        let toe = TOES[limb - LEGS].index();
        pose.positions[toe] = chosen_v(amount, pose.positions[toe], pose.positions[toe] + to_end);
    }
}

/// Computes the displacements of all limbs of two partners in a step.
fn solve_pair(pair: &mut [LimbTouch; 2], shapes: &LimbShapes, bodies: &PartnerBodies, config: &TouchConfig, dt_s: f32) {
    let PartnerBodies { joints: now, toes, hips, cores, contacts } = bodies;
    let before = pair.each_ref().map(|one| one.limbs);
    let freedoms = [0, 1].map(|k| limb_freedoms(&now[k], contacts[k]));
    let keep = maths::exp(-std::f32::consts::LN_2 * dt_s / config.half_life_s);
    for (k, l) in (0..2).flat_map(|k| (0..NUM_LIMBS).map(move |l| (k, l))) {
        let LimbTouch { limbs, seen } = &mut pair[k];
        let limb = &mut limbs[l];
        if !*seen {
            limb.was = now[k][l];
        }
        // A planted foot stays where it came down.
        let end = if freedoms[k][l] == LimbFreedom::Stays { 1.0 } else { keep };
        limb.off = [limb.off[0] * keep, limb.off[1] * end];
        if limb.off.iter().all(|o| o.length_squared() < AT_REST_M * AT_REST_M) {
            limb.off = [Vec3::ZERO; 2];
        }
    }
    pair.iter_mut().for_each(|one| one.seen = true);
    let is_near = hips[0].distance_squared(hips[1]) < 4.0 * REACH_M * REACH_M;
    let touches = config.enabled && is_near && may_touch(pair, shapes, now, &freedoms, hips);
    if touches {
        let fastest = pair.iter().flat_map(|one| &one.limbs).zip(now.iter().flatten()).zip(freedoms.iter().flatten());
        let fastest = fastest
            .filter(|(_, freedom)| **freedom == LimbFreedom::Free)
            .map(|((limb, now), _)| now[2].distance(limb.was[2]));
        let pieces = ((fastest.fold(0.0, f32::max) / PIECE_M).ceil() as usize).clamp(1, MOST_PIECES);
        let obstacles = [0, 1].map(|k| limb_obstacles(&now[k], shapes, &cores[k]));
        let obstacle_balls =
            obstacles.map(|all| all.map(|capsule| BoundingBall::around_segment(capsule.ends, capsule.radius)));
        let scene = TouchScene {
            shapes,
            obstacles: &obstacles,
            obstacle_balls: &obstacle_balls,
            now,
            toes,
            freedoms: &freedoms,
            give_m: config.give_m,
        };
        for piece in 1..=pieces {
            advance_piece(pair, &scene, piece as f32 / pieces as f32);
        }
    }
    for k in 0..2 {
        for (l, out) in bend_directions(&now[k]).into_iter().enumerate() {
            let (limb, now) = (&mut pair[k].limbs[l], now[k][l]);
            let was = std::mem::replace(&mut limb.was, now);
            if limb.is_displaced() {
                let most = (elbow_angle(now) - elbow_angle(was)).abs().max(config.elbow_radps * dt_s);
                let before = elbow_angle(LimbOffset { was, ..before[k][l] }.displaced_positions());
                limb.keep_lengths(&shapes[l], before, most, out);
                if touches && l < LEGS {
                    limb.swing_out(&shapes[l], &cores[k ^ 1], config.give_m);
                }
            }
        }
    }
}

/// True where any limb is displaced, or so near to the partner's trunk or limbs that it could overlap them.
fn may_touch(
    pair: &[LimbTouch; 2],
    shapes: &LimbShapes,
    now: &LimbPositions,
    freedoms: &LimbFreedoms,
    hips: &[Vec3; 2],
) -> bool {
    /// Largest distance of a core, an arm with its fist there, or a thigh from the vertical axis over the hips (m).
    const WIDE: f32 = 0.45;
    let kicks = |freedoms: &[LimbFreedom; NUM_LIMBS]| freedoms[LEGS..].contains(&LimbFreedom::Free);
    if pair.iter().flat_map(|one| &one.limbs).any(LimbOffset::is_displaced) || freedoms.iter().any(kicks) {
        return true;
    }
    let ankles = |k: usize| now[k][LEGS..].iter().map(|leg| leg[2]);
    if ankles(0).any(|a| ankles(1).any(|b| a.distance_squared(b) < FEET_APART_M * FEET_APART_M)) {
        return true;
    }
    let axis = |k: usize| [hips[k], hips[k] + Vec3::Y * 0.8];
    (0..2).any(|k| {
        (0..LEGS).any(|a| {
            let [_, elbow, wrist] = now[k][a];
            let tip = wrist + (wrist - elbow) * (shapes[a].hand_m / shapes[a].lengths[1]);
            let [p, q] = nearest_points([elbow, tip], axis(k ^ 1));
            p.distance_squared(q) < WIDE * WIDE
                || now[k ^ 1][..LEGS].iter().any(|o| {
                    let [p, q] = nearest_points([elbow, tip], [o[1], o[2]]);
                    p.distance_squared(q) < 0.3 * 0.3
                })
        })
    })
}

/// Advances the motion by a piece of the step, and moves limbs out of obstacles.
fn advance_piece(pair: &mut [LimbTouch; 2], scene: &TouchScene<'_>, share: f32) {
    let &TouchScene { shapes, obstacles, now, freedoms, give_m, .. } = scene;
    let free = |k: usize| (0..NUM_LIMBS).filter(move |l| freedoms[k][*l] == LimbFreedom::Free);
    let base: LimbPositions = std::array::from_fn(|k| {
        std::array::from_fn(|l| std::array::from_fn(|i| pair[k].limbs[l].was[i].lerp(now[k][l][i], share)))
    });
    let out = base.each_ref().map(bend_directions);
    let mut segments: [[LimbSegment; NUM_LIMBS]; 2] = std::array::from_fn(|k| {
        std::array::from_fn(|l| {
            let (b, limb) = (&base[k][l], &pair[k].limbs[l]);
            let mut ends = [0, 1].map(|i| b[i + 1] + limb.off[i]);
            if limb.is_displaced() {
                // A fading displacement does not keep the lengths of bones: the elbow has to be found again.
                ends = solve_two_bones([b[0], ends[0], ends[1]], &shapes[l], out[k][l], limb.bend_share());
            }
            let foot = if l < LEGS { Vec3::ZERO } else { scene.toes[k][l - LEGS] - now[k][l][2] };
            LimbSegment { ends, foot, freedom: freedoms[k][l], moved: false }
        })
    });
    let balls = segments.each_ref().map(|segments| [0, 1, 2, 3].map(|l| segments[l].bounding_ball(&shapes[l])));
    let mut near = [[NearObstacles::default(); NUM_LIMBS]; 2];
    for (k, l) in [0, 1].into_iter().flat_map(|k| free(k).map(move |l| (k, l))) {
        let first = if l < LEGS { FOR_ARMS } else { 0 };
        let upper = BoundingBall::around_segment([base[k][l][0], segments[k][l].ends[0]], shapes[l].upper_radius);
        for (i, ball) in scene.obstacle_balls[k ^ 1].iter().enumerate().skip(first) {
            near[k][l].fore |= u32::from(balls[k][l].is_near(ball)) << i;
            near[k][l].upper |= u32::from(upper.is_near(ball)) << i;
        }
    }
    // Arms and kicking legs can touch each other; legs that step or carry weight can touch legs alone.
    let meet = |a: usize, b: usize| {
        let are_alike = a.min(b) >= LEGS || [freedoms[0][a], freedoms[1][b]] == [LimbFreedom::Free; 2];
        are_alike && balls[0][a].is_near(&balls[1][b])
    };
    for _ in 0..ROUNDS {
        let mut any = false;
        for (a, b) in (0..NUM_LIMBS).flat_map(|a| (0..NUM_LIMBS).map(move |b| (a, b))).filter(|(a, b)| meet(*a, *b)) {
            let [first, second] = &mut segments;
            any |= separate_segments(&mut first[a], &shapes[a], &mut second[b], &shapes[b], give_m);
        }
        for k in 0..2 {
            for l in free(k) {
                let (segment, shape, near) = (&mut segments[k][l], &shapes[l], near[k][l]);
                // The order is legs, upper arms, core: the last one counts most.
                for (i, capsule) in obstacles[k ^ 1].iter().enumerate() {
                    if i >= FOR_UPPER && near.upper >> i & 1 == 1 {
                        any |= segment.lift_out_of(base[k][l][0], shape, capsule, give_m);
                    }
                    if near.fore >> i & 1 == 1 {
                        any |= segment.leave_capsule(shape, capsule, give_m);
                    }
                }
            }
        }
        if !any {
            break;
        }
        for k in 0..2 {
            for (l, segment) in segments[k].iter_mut().enumerate().filter(|(_, segment)| segment.moved) {
                let joints = [base[k][l][0], segment.ends[0], segment.ends[1]];
                segment.ends = solve_two_bones(joints, &shapes[l], out[k][l], 1.0);
            }
        }
    }
    for k in 0..2 {
        for l in 0..NUM_LIMBS {
            if segments[k][l].moved {
                pair[k].limbs[l].off = [0, 1].map(|i| segments[k][l].ends[i] - base[k][l][i + 1]);
            }
        }
    }
}

/// Inputs of the displacement of two characters' limbs.
struct TouchScene<'a> {
    shapes: &'a LimbShapes,
    /// Obstacles that each of the two is for the other one, and balls around them.
    obstacles: &'a [[Capsule; NUM_OBSTACLES]; 2],
    obstacle_balls: &'a [[BoundingBall; NUM_OBSTACLES]; 2],
    now: &'a LimbPositions,
    toes: &'a [[Vec3; 2]; 2],
    freedoms: &'a LimbFreedoms,
    /// Depth to which flesh gives way (m).
    give_m: f32,
}

/// Freedom of each limb of a character, by its contacts and the heights of its ankles.
fn limb_freedoms(now: &LimbJoints, contacts: Contacts) -> [LimbFreedom; NUM_LIMBS] {
    let ankles = [0, 1].map(|k| now[LEGS + k][2].y);
    std::array::from_fn(|l| match l {
        0..LEGS => LimbFreedom::Free,
        _ if ankles[l - LEGS] > ankles[LEGS + 1 - l] + LEG_RAISED_M => LimbFreedom::Free,
        _ if contacts.any(SOLES[l - LEGS]) => LimbFreedom::Stays,
        _ => LimbFreedom::Level,
    })
}

/// Directions in which straight limbs bend: elbows outwards and down, knees ahead.
fn bend_directions(limbs: &LimbJoints) -> [Vec3; NUM_LIMBS] {
    let across = |l: usize| (limbs[l][0] - limbs[l + 1][0]).normalize_or_zero();
    let (shoulders, ahead) = (across(0), across(LEGS).cross(Vec3::Y));
    [shoulders - Vec3::Y, -shoulders - Vec3::Y, ahead, ahead]
}

/// Number of obstacles of a limb: the partner's thighs, for legs alone, upper arms, then the core, for upper arms and thighs too.
const NUM_OBSTACLES: usize = FOR_UPPER + BodyVolume::CORE.len();
const FOR_ARMS: usize = 2;
const FOR_UPPER: usize = FOR_ARMS + LEGS;

fn limb_obstacles(now: &LimbJoints, shapes: &LimbShapes, core: &BodyCore) -> [Capsule; NUM_OBSTACLES] {
    let upper = |l: usize| Capsule { ends: [now[l][0], now[l][1]], radius: shapes[l].upper_radius };
    std::array::from_fn(|i| match i {
        0..FOR_ARMS => upper(LEGS + i),
        FOR_ARMS..FOR_UPPER => upper(i - FOR_ARMS),
        _ => core[i - FOR_UPPER],
    })
}

/// Obstacles that the two bones of a limb might meet, a bit for each.
#[derive(Clone, Copy, Debug, Default)]
struct NearObstacles {
    fore: u32,
    upper: u32,
}
