//! Touch of limbs: arms and legs stop, or slide, where they meet the opponent's body, guard or legs.
//!
//! Each limb stores its displacement from its motion. In a step the displacement fades, then elbow and wrist, or knee and
//! ankle, are moved out of obstacles, as points of a [`LimbSegment`]; fast limbs move in short pieces, so that none tunnels through
//! an obstacle. A leg that steps is displaced along the ground, one that kicks is displaced as arms are, and one that carries
//! weight stays where it came down and is only an obstacle for others. Blows are tested against the motion without these
//! displacements.

use super::body::{NUM_CORE, SparringBody, WorldPose};
use super::config::{TouchConfig, check_within};
use super::limb_segment::{
    BoundingBall, LimbFreedom, LimbSegment, LimbShape, SOFT_ELBOW_M, elbow_angle, separate_segments, shortest_arc,
    solve_two_bones, swing_rotation,
};
use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};
use throng_base::Result;
use throng_base::maths;
use throng_base::thresholds::LEG_RAISED_M;
use throng_core::body::{LocalTransform, Mat3x4};
use throng_core::skeleton::{Joint, Skeleton};
use throng_core::{Contacts, Planar};
use throng_geometry::Capsule;
use throng_geometry::nearest_points;

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
const LIMBS: [[Joint; 3]; NUM_LIMBS] = [
    [Joint::LeftUpperArm, Joint::LeftForearm, Joint::LeftHand],
    [Joint::RightUpperArm, Joint::RightForearm, Joint::RightHand],
    [Joint::LeftThigh, Joint::LeftShin, Joint::LeftFoot],
    [Joint::RightThigh, Joint::RightShin, Joint::RightFoot],
];
pub(crate) const NUM_LIMBS: usize = 4;
/// Number of the first limb that is a leg, and toes and soles of legs.
const LEGS: usize = 2;
const TOES: [Joint; 2] = [Joint::LeftToe, Joint::RightToe];
const SOLES: [Contacts; 2] = [Contacts::LEFT, Contacts::RIGHT];
/// Distance of two ankles from which on their feet cannot meet in a step (m).
const FEET_APART_M: f32 = 0.6;

/// Parent joint of each limb.
const PARENTS: [Joint; NUM_LIMBS] = [Joint::LeftClavicle, Joint::RightClavicle, Joint::Hips, Joint::Hips];

/// Shapes of the limbs of a character.
type LimbShapes = [LimbShape; NUM_LIMBS];

/// Freedoms of the limbs of two characters.
type LimbFreedoms = [[LimbFreedom; NUM_LIMBS]; 2];

/// Root, middle and end of each limb of a character, in the world (m).
type LimbJoints = [[Vec3; 3]; NUM_LIMBS];

/// Root, middle and end of each limb of two characters, in the world (m).
type LimbPositions = [LimbJoints; 2];

impl TouchConfig {
    pub(super) fn check(&self) -> Result<()> {
        check_within("touch.half_life_s", self.half_life_s, 1e-3, 10.0, "between 0.001 and 10")?;
        check_within("touch.elbow_radps", self.elbow_radps, 1.0, 1000.0, "between 1 and 1000")?;
        check_within("touch.give_m", self.give_m, 0.0, 0.1, "between 0 and 0.1")
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

/// State of the touch of the limbs of two opponents.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct LimbTouch {
    /// Limbs of each of the two, in the order of [`LIMBS`].
    limbs: [[LimbOffset; NUM_LIMBS]; 2],
    /// Whether each of the two has a last step.
    seen: [bool; 2],
}

/// Shapes of a skeleton's limbs, in the order of [`LIMBS`].
pub(crate) fn limb_shapes(skeleton: &Skeleton, body: &SparringBody) -> LimbShapes {
    std::array::from_fn(|l| {
        let [root, middle, end] = LIMBS[l];
        let lengths = [middle, end].map(|j| skeleton.offsets[j.index()].length().max(LEAST_M));
        let is_leg = l >= LEGS;
        // An upper arm is tested with the radius of a forearm.
        let upper = if is_leg { root } else { middle };
        let [upper_radius, radius] = [upper, middle].map(|joint| body.radius(joint));
        let fist_m = if is_leg { 0.0 } else { throng_core::hits::striking_offset(skeleton, end).length() };
        LimbShape { lengths, hand_m: (fist_m - radius).max(0.0), radius, upper_radius }
    })
}

impl LimbTouch {
    /// False for a state that no limbs can have.
    pub fn is_valid(&self) -> bool {
        let near = |v: &Vec3, most: f32| v.is_finite() && v.abs().max_element() < most;
        self.limbs.iter().flatten().all(|a| a.off.iter().all(|v| near(v, 100.0)) && a.was.iter().all(|v| near(v, 2e6)))
    }

    /// Resets the touch of one character that was moved to another place, and of the opponent that it touched.
    pub fn forget_character(&mut self, one: usize) {
        self.seen[one] = false;
        self.limbs.iter_mut().flatten().for_each(|limb| limb.off = [Vec3::ZERO; 2]);
    }

    /// Computes the displacements of all limbs in a step.
    ///
    /// - `poses`: poses of the motion; `contacts`: planted parts of their feet.
    pub fn solve_displacements(
        &mut self,
        body: &SparringBody,
        shapes: &LimbShapes,
        poses: &[WorldPose<'_>; 2],
        contacts: [Contacts; 2],
        config: &TouchConfig,
        dt_s: f32,
    ) {
        let now: LimbPositions = [0, 1].map(|k| LIMBS.map(|limb| limb.map(|j| poses[k].point_in_world(j, Vec3::ZERO))));
        let before = self.limbs;
        let ways = [0, 1].map(|k| limb_freedoms(&now[k], contacts[k]));
        let keep = maths::exp(-std::f32::consts::LN_2 * dt_s / config.half_life_s);
        for (k, l) in (0..2).flat_map(|k| (0..NUM_LIMBS).map(move |l| (k, l))) {
            let limb = &mut self.limbs[k][l];
            if !self.seen[k] {
                limb.was = now[k][l];
            }
            // A planted foot stays where it came down.
            let end = if ways[k][l] == LimbFreedom::Stays { 1.0 } else { keep };
            limb.off = [limb.off[0] * keep, limb.off[1] * end];
            if limb.off.iter().all(|o| o.length_squared() < AT_REST_M * AT_REST_M) {
                limb.off = [Vec3::ZERO; 2];
            }
        }
        self.seen = [true; 2];
        let hips = poses.each_ref().map(|p| p.point_in_world(Joint::Hips, Vec3::ZERO));
        let is_near = hips[0].distance_squared(hips[1]) < 4.0 * REACH_M * REACH_M;
        let touches = config.enabled && is_near && self.may_touch(shapes, &now, &ways, &hips);
        let cores = touches.then(|| poses.each_ref().map(|p| body.core_capsules(p)));
        if let Some(cores) = &cores {
            let toes = [0, 1].map(|k| TOES.map(|j| poses[k].point_in_world(j, Vec3::ZERO)));
            let fastest = self.limbs.iter().flatten().zip(now.iter().flatten()).zip(ways.iter().flatten());
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
                now: &now,
                toes: &toes,
                freedoms: &ways,
                give_m: config.give_m,
            };
            for piece in 1..=pieces {
                self.advance_piece(&scene, piece as f32 / pieces as f32);
            }
        }
        for k in 0..2 {
            for (l, out) in bend_directions(&now[k]).into_iter().enumerate() {
                let (limb, now) = (&mut self.limbs[k][l], now[k][l]);
                let was = std::mem::replace(&mut limb.was, now);
                if limb.is_displaced() {
                    let most = (elbow_angle(now) - elbow_angle(was)).abs().max(config.elbow_radps * dt_s);
                    let before = elbow_angle(LimbOffset { was, ..before[k][l] }.displaced_positions());
                    limb.keep_lengths(&shapes[l], before, most, out);
                    if let Some(cores) = cores.as_ref().filter(|_| l < LEGS) {
                        limb.swing_out(&shapes[l], &cores[k ^ 1], config.give_m);
                    }
                }
            }
        }
    }

    /// True where any limb is displaced, or so near to the opponent's trunk or limbs that it could overlap them.
    fn may_touch(&self, shapes: &LimbShapes, now: &LimbPositions, ways: &LimbFreedoms, hips: &[Vec3; 2]) -> bool {
        /// Largest distance of a core, an arm with its fist there, or a thigh from the vertical axis over the hips (m).
        const WIDE: f32 = 0.45;
        let kicks = |ways: &[LimbFreedom; NUM_LIMBS]| ways[LEGS..].contains(&LimbFreedom::Free);
        if self.limbs.iter().flatten().any(LimbOffset::is_displaced) || ways.iter().any(kicks) {
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
    fn advance_piece(&mut self, scene: &TouchScene<'_>, share: f32) {
        let &TouchScene { shapes, obstacles, now, freedoms: ways, give_m, .. } = scene;
        let free = |k: usize| (0..NUM_LIMBS).filter(move |l| ways[k][*l] == LimbFreedom::Free);
        let base: LimbPositions = std::array::from_fn(|k| {
            std::array::from_fn(|l| std::array::from_fn(|i| self.limbs[k][l].was[i].lerp(now[k][l][i], share)))
        });
        let out = base.each_ref().map(bend_directions);
        let mut segments: [[LimbSegment; NUM_LIMBS]; 2] = std::array::from_fn(|k| {
            std::array::from_fn(|l| {
                let (b, limb) = (&base[k][l], &self.limbs[k][l]);
                let mut ends = [0, 1].map(|i| b[i + 1] + limb.off[i]);
                if limb.is_displaced() {
                    // A fading displacement does not keep the lengths of bones: the elbow has to be found again.
                    ends = solve_two_bones([b[0], ends[0], ends[1]], &shapes[l], out[k][l], limb.bend_share());
                }
                let foot = if l < LEGS { Vec3::ZERO } else { scene.toes[k][l - LEGS] - now[k][l][2] };
                LimbSegment { ends, foot, freedom: ways[k][l], moved: false }
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
            let are_alike = a.min(b) >= LEGS || [ways[0][a], ways[1][b]] == [LimbFreedom::Free; 2];
            are_alike && balls[0][a].is_near(&balls[1][b])
        };
        for _ in 0..ROUNDS {
            let mut any = false;
            for (a, b) in (0..NUM_LIMBS).flat_map(|a| (0..NUM_LIMBS).map(move |b| (a, b))).filter(|(a, b)| meet(*a, *b))
            {
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
                    self.limbs[k][l].off = [0, 1].map(|i| segments[k][l].ends[i] - base[k][l][i + 1]);
                }
            }
        }
    }

    /// Applies the displacements to the pose of one of the two.
    ///
    /// - `model`: pose of the motion in model space.
    /// - `locals`: pose relative to parents, or empty.
    pub fn apply_to_pose(&self, one: usize, root: Planar, model: &mut [Mat3x4], locals: &mut [LocalTransform]) {
        let to_model = root.rotation().conjugate();
        for (l, limb) in self.limbs[one].iter().enumerate().filter(|(_, limb)| limb.is_displaced()) {
            let joints = LIMBS[l].map(Joint::index);
            let [root, middle, end] = joints.map(|j| model[j].translation());
            let off = limb.off.map(|o| maths::rotate(to_model, o));
            let [to_middle, to_end] = [middle + off[0], end + off[1]];
            let upper = shortest_arc(middle - root, to_middle - root);
            let lower = shortest_arc(end - middle, to_end - to_middle);
            let mut turn = |j: usize, turn: Quat, at: Vec3| {
                model[j] = Mat3x4::from_rotation_translation(turn, Vec3::ZERO) * model[j];
                model[j].rows.iter_mut().zip(at.to_array()).for_each(|(row, v)| row[3] = v);
            };
            turn(joints[0], upper, root);
            turn(joints[1], lower, to_middle);
            if l < LEGS {
                // A hand follows the forearm; a foot keeps its turn.
                turn(joints[2], lower, to_end);
            } else {
                for j in [joints[2], TOES[l - LEGS].index()] {
                    model[j].rows.iter_mut().zip(off[1].to_array()).for_each(|(row, v)| row[3] += v);
                }
            }
            if !locals.is_empty() {
                let chain = [(PARENTS[l].index(), joints[0]), (joints[0], joints[1]), (joints[1], joints[2])];
                for (parent, j) in chain.into_iter().take(if l < LEGS { 2 } else { 3 }) {
                    let local = maths::compose(model[parent].rotation().conjugate(), model[j].rotation());
                    locals[j].rotation = local.to_array();
                }
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

/// Number of obstacles of a limb: the opponent's thighs, for legs alone, upper arms, then the core, for upper arms and thighs too.
const NUM_OBSTACLES: usize = FOR_UPPER + NUM_CORE;
const FOR_ARMS: usize = 2;
const FOR_UPPER: usize = FOR_ARMS + LEGS;

fn limb_obstacles(now: &LimbJoints, shapes: &LimbShapes, core: &[Capsule; NUM_CORE]) -> [Capsule; NUM_OBSTACLES] {
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
