//! Arms and kicking legs that stop where they meet the other's body or guard, or slide there.
//!
//! Each limb remembers how far it is displaced from where its motion has it. In a step the displacement fades, then elbow
//! and wrist, or knee and ankle, are moved out of what they are in, as points of a rod that keeps its length (Müller et al.
//! 2007, position based dynamics); fast limbs go their way in short pieces, so that none comes out on the other side. Legs are
//! moved while they are raised; those that stand are only in the way of others. What a blow meets is told by the motion and
//! not by this.

use super::body::{Body, Capsule, NUM_CORE, Posed};
use super::config::{TouchConfig, within};
use super::distance::nearest_points;
use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};
use throng_base::Result;
use throng_base::maths;
use throng_core::Planar;
use throng_core::pose::{LocalTransform, Mat3x4};
use throng_core::skeleton::{Joint, Skeleton};

/// Pieces of a way are about as long as this, but for very fast arms (m).
const PIECE_M: f32 = 0.06;
/// Most pieces of a way.
const MOST_PIECES: usize = 4;
/// Limbs that are in something by less are out of it (m).
const ENOUGH_M: f32 = 1e-3;
/// How far a limb may be moved in a piece, for what it might come into (m).
const ROOM_M: f32 = 0.08;
/// Rounds in which limbs are moved out of what they are in.
const ROUNDS: usize = 6;
/// Nobody's limbs reach farther than this from the hips (m).
const REACH_M: f32 = 1.3;
/// Limbs that are displaced by less are where their motion has them (m).
const AT_REST_M: f32 = 5e-4;
/// Bones of limbs are taken to be at least this long (m).
const LEAST_M: f32 = 1e-3;
/// Elbows and knees that are less off the straight line bend outwards and down, or ahead (m).
const SOFT_ELBOW_M: f32 = 0.02;
/// Limbs keep this share of their length from being straight.
const STRETCH: f32 = 5e-4;
/// A leg whose ankle is so much higher than the other one is raised: it kicks (m).
const RAISED_M: f32 = 0.25;

/// Root, middle and end of each limb: shoulder, elbow and wrist, then hip, knee and ankle.
const LIMBS: [[Joint; 3]; NUM_LIMBS] = [
    [Joint::LeftUpperArm, Joint::LeftForearm, Joint::LeftHand],
    [Joint::RightUpperArm, Joint::RightForearm, Joint::RightHand],
    [Joint::LeftThigh, Joint::LeftShin, Joint::LeftFoot],
    [Joint::RightThigh, Joint::RightShin, Joint::RightFoot],
];
pub(crate) const NUM_LIMBS: usize = 4;
/// The first limb that is a leg, and the toes of legs.
const LEGS: usize = 2;
const TOES: [Joint; 2] = [Joint::LeftToe, Joint::RightToe];

/// What they hang from.
const PARENTS: [Joint; NUM_LIMBS] = [Joint::LeftClavicle, Joint::RightClavicle, Joint::Hips, Joint::Hips];

/// Root, middle and end of each limb of two, in the world (m).
type Places = [[[Vec3; 3]; NUM_LIMBS]; 2];

impl TouchConfig {
    pub(super) fn check(&self) -> Result<()> {
        within("touch.half_life_s", self.half_life_s, 1e-3, 10.0, "between 0.001 and 10")?;
        within("touch.elbow_radps", self.elbow_radps, 1.0, 1000.0, "between 1 and 1000")?;
        within("touch.give_m", self.give_m, 0.0, 0.1, "between 0 and 0.1")
    }
}

/// What is remembered of a limb.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Limb {
    /// How far its middle and its end are from where the motion has them (m).
    off: [Vec3; 2],
    /// Where the motion had root, middle and end at the last step (m).
    was: [Vec3; 3],
}

impl Limb {
    fn is_displaced(&self) -> bool {
        self.off != [Vec3::ZERO; 2]
    }

    /// Where root, middle and end are (m).
    fn displaced(&self) -> [Vec3; 3] {
        let [shoulder, elbow, wrist] = self.was;
        [shoulder, elbow + self.off[0], wrist + self.off[1]]
    }

    /// Gives the limb its lengths, and its elbow or knee as slow a turn as `most`: the end gives way along its way from the
    /// root (rad).
    ///
    /// - `before`: the angle at the elbow or knee at the last step (rad).
    /// - `out`: see [`reach`].
    fn keep_lengths(&mut self, shape: &LimbShape, before: f32, most: f32, out: Vec3) {
        let [shoulder, elbow, wrist] = self.displaced();
        // A straight limb comes back to where it is straight.
        let off_m = self.off[0].length().max(self.off[1].length());
        let soft = (off_m / SOFT_ELBOW_M).min(1.0);
        let mut ends = reach(shoulder, [elbow, wrist], shape, (out, soft));
        let angle = elbow_angle([shoulder, ends[0], ends[1]]);
        let slow = angle.clamp(before - most, before + most);
        if slow != angle {
            let [l1, l2] = shape.lengths;
            let distance = (l1 * l1 + l2 * l2 - 2.0 * l1 * l2 * maths::cos(slow)).max(0.0).sqrt();
            let wrist = shoulder + (ends[1] - shoulder).normalize_or_zero() * distance;
            ends = reach(shoulder, [ends[0], wrist], shape, (out, soft));
        }
        self.off = [ends[0] - self.was[1], ends[1] - self.was[2]];
    }
}

/// What is remembered of the limbs of two opponents.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Touch {
    /// Of each, in the order of [`LIMBS`].
    limbs: [[Limb; NUM_LIMBS]; 2],
    /// False where one has no step behind it.
    seen: [bool; 2],
}

/// What of a limb does not change.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LimbShape {
    /// Lengths of its two bones (m).
    lengths: [f32; 2],
    /// How far the axis goes on beyond its end, into the fist; 0 for legs (m).
    hand_m: f32,
    /// Of the forearm or shin (m).
    radius: f32,
    /// Of the upper arm or thigh (m).
    upper_radius: f32,
}

/// The limbs of a skeleton, in the order of [`LIMBS`].
pub(crate) fn limb_shapes(skeleton: &Skeleton, body: &Body) -> [LimbShape; NUM_LIMBS] {
    std::array::from_fn(|l| {
        let [_, middle, end] = LIMBS[l];
        let lengths = [middle, end].map(|j| skeleton.offsets[j.index()].length().max(LEAST_M));
        let is_leg = l >= LEGS;
        // An upper arm is in something where a forearm of its place would be.
        let [upper_radius, radius] = if is_leg { body.leg_radii() } else { [body.forearm_radius(); 2] };
        let fist_m = if is_leg { 0.0 } else { throng_core::hits::striking_offset(skeleton, end).length() };
        LimbShape { lengths, hand_m: (fist_m - radius).max(0.0), radius, upper_radius }
    })
}

impl Touch {
    /// False for numbers that no limbs have.
    pub fn may_be(&self) -> bool {
        let near = |v: &Vec3, most: f32| v.is_finite() && v.abs().max_element() < most;
        self.limbs.iter().flatten().all(|a| a.off.iter().all(|v| near(v, 3.0)) && a.was.iter().all(|v| near(v, 2e6)))
    }

    /// Forgets one who was put elsewhere, and whom it touched.
    pub fn forget(&mut self, one: usize) {
        self.seen[one] = false;
        self.limbs.iter_mut().flatten().for_each(|limb| limb.off = [Vec3::ZERO; 2]);
    }

    /// Finds how far all limbs have to be displaced.
    ///
    /// - `poses`: as the motion has them.
    pub fn settle(
        &mut self,
        body: &Body,
        shapes: &[LimbShape; NUM_LIMBS],
        poses: &[Posed<'_>; 2],
        config: &TouchConfig,
        dt_s: f32,
    ) {
        let now: Places = [0, 1].map(|k| LIMBS.map(|limb| limb.map(|j| poses[k].point(j, Vec3::ZERO))));
        let before = self.limbs;
        let keep = maths::exp(-std::f32::consts::LN_2 * dt_s / config.half_life_s);
        for (limb, now) in self
            .limbs
            .iter_mut()
            .zip(&now)
            .zip(self.seen)
            .flat_map(|((limbs, now), seen)| limbs.iter_mut().zip(now.iter().map(move |now| (*now, seen))))
        {
            if !now.1 {
                limb.was = now.0;
            }
            limb.off = limb.off.map(|o| o * keep);
            if limb.off.iter().all(|o| o.length_squared() < AT_REST_M * AT_REST_M) {
                limb.off = [Vec3::ZERO; 2];
            }
        }
        self.seen = [true; 2];
        let hips = poses.each_ref().map(|p| p.point(Joint::Hips, Vec3::ZERO));
        let is_near = hips[0].distance_squared(hips[1]) < 4.0 * REACH_M * REACH_M;
        let moves = now.each_ref().map(moving);
        if config.enabled && is_near && self.may_touch(shapes, &now, &moves, &hips) {
            let cores = poses.each_ref().map(|p| body.obstacles(p));
            let toes = [0, 1].map(|k| TOES.map(|j| poses[k].point(j, Vec3::ZERO)));
            let fastest = self.limbs.iter().flatten().zip(now.iter().flatten()).zip(moves.iter().flatten());
            let fastest = fastest.filter(|(_, moves)| **moves).map(|((limb, now), _)| now[2].distance(limb.was[2]));
            let pieces = ((fastest.fold(0.0, f32::max) / PIECE_M).ceil() as usize).clamp(1, MOST_PIECES);
            let scene = Scene { shapes, cores: &cores, now: &now, toes: &toes, moves: &moves, give_m: config.give_m };
            for piece in 1..=pieces {
                self.piece(&scene, piece as f32 / pieces as f32);
            }
        }
        for k in 0..2 {
            for (l, out) in outwards(&now[k]).into_iter().enumerate() {
                let (limb, now) = (&mut self.limbs[k][l], now[k][l]);
                let was = std::mem::replace(&mut limb.was, now);
                if limb.is_displaced() {
                    let most = (elbow_angle(now) - elbow_angle(was)).abs().max(config.elbow_radps * dt_s);
                    let before = elbow_angle(Limb { was, ..before[k][l] }.displaced());
                    limb.keep_lengths(&shapes[l], before, most, out);
                }
            }
        }
    }

    /// Whether any limb is displaced, or near enough to the other's trunk or limbs that it could be in them.
    fn may_touch(
        &self,
        shapes: &[LimbShape; NUM_LIMBS],
        now: &Places,
        moves: &[[bool; NUM_LIMBS]; 2],
        hips: &[Vec3; 2],
    ) -> bool {
        /// No core, no arm whose fist is there and no thigh reaches farther from the axis over the hips than this (m).
        const WIDE: f32 = 0.45;
        if self.limbs.iter().flatten().any(Limb::is_displaced) || moves.iter().any(|m| m[LEGS..].contains(&true)) {
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

    /// Goes a piece of the way since the last step, and moves limbs out of what they are in.
    fn piece(&mut self, scene: &Scene<'_>, share: f32) {
        let &Scene { shapes, now, moves, give_m, .. } = scene;
        let each = |k: usize| (0..NUM_LIMBS).filter(move |l| moves[k][*l]);
        let base: Places = std::array::from_fn(|k| {
            std::array::from_fn(|l| std::array::from_fn(|i| self.limbs[k][l].was[i].lerp(now[k][l][i], share)))
        });
        let mut rods: [[Rod; NUM_LIMBS]; 2] = std::array::from_fn(|k| {
            std::array::from_fn(|l| {
                let (b, off) = (&base[k][l], &self.limbs[k][l].off);
                let foot = if l < LEGS { Vec3::ZERO } else { scene.toes[k][l - LEGS] - now[k][l][2] };
                Rod { ends: [b[1] + off[0], b[2] + off[1]], foot, moved: false }
            })
        });
        let obstacles = [0, 1].map(|k| obstacles(&now[k], shapes, &scene.cores[k]));
        let mut near = [[Near::default(); NUM_LIMBS]; 2];
        let mut balls = [[None; NUM_LIMBS]; 2];
        for k in 0..2 {
            for l in each(k) {
                let first = if l < LEGS { FOR_ARMS } else { 0 };
                near[k][l] = Near::of(&rods[k][l], base[k][l][0], &shapes[l], (&obstacles[k ^ 1], first));
                balls[k][l] = Some(Ball::about(rods[k][l].axis(&shapes[l]), shapes[l].radius));
            }
        }
        let are_near = |a: usize, b: usize| balls[0][a].zip(balls[1][b]).is_some_and(|(a, b)| a.is_near(&b));
        for _ in 0..ROUNDS {
            let mut any = false;
            for (a, b) in each(0).flat_map(|a| each(1).map(move |b| (a, b))).filter(|(a, b)| are_near(*a, *b)) {
                let [first, second] = &mut rods;
                any |= part(&mut first[a], &shapes[a], &mut second[b], &shapes[b], give_m);
            }
            for k in 0..2 {
                for l in each(k) {
                    let (rod, shape, near) = (&mut rods[k][l], &shapes[l], near[k][l]);
                    // Legs, upper arms, then the core: what comes last counts most.
                    for (i, capsule) in obstacles[k ^ 1].iter().enumerate() {
                        if i >= FOR_UPPER && near.upper >> i & 1 == 1 {
                            any |= rod.lift(base[k][l][0], shape, capsule, give_m);
                        }
                        if near.fore >> i & 1 == 1 {
                            any |= rod.leave(shape, capsule, give_m);
                        }
                    }
                }
            }
            if !any {
                break;
            }
            for k in 0..2 {
                let out = outwards(&base[k]);
                for (l, rod) in rods[k].iter_mut().enumerate().filter(|(_, rod)| rod.moved) {
                    rod.ends = reach(base[k][l][0], rod.ends, &shapes[l], (out[l], 1.0));
                }
            }
        }
        for k in 0..2 {
            for l in 0..NUM_LIMBS {
                if rods[k][l].moved {
                    self.limbs[k][l].off = [0, 1].map(|i| rods[k][l].ends[i] - base[k][l][i + 1]);
                }
            }
        }
    }

    /// Displaces the limbs of one of the two in its pose.
    ///
    /// - `model`: in model space, as the motion has it.
    /// - `locals`: the same relative to parents, or empty.
    pub fn apply(&self, one: usize, root: Planar, model: &mut [Mat3x4], locals: &mut [LocalTransform]) {
        let to_model = root.rotation().conjugate();
        for (l, limb) in self.limbs[one].iter().enumerate().filter(|(_, limb)| limb.is_displaced()) {
            let joints = LIMBS[l].map(Joint::index);
            let [root, middle, end] = joints.map(|j| model[j].translation());
            let off = limb.off.map(|o| maths::rotate(to_model, o));
            let [to_middle, to_end] = [middle + off[0], end + off[1]];
            let upper = arc(middle - root, to_middle - root);
            let lower = arc(end - middle, to_end - to_middle);
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

/// What limbs of two are moved in.
struct Scene<'a> {
    shapes: &'a [LimbShape; NUM_LIMBS],
    cores: &'a [[Capsule; NUM_CORE + 1]; 2],
    now: &'a Places,
    toes: &'a [[Vec3; 2]; 2],
    moves: &'a [[bool; NUM_LIMBS]; 2],
    /// How far flesh gives (m).
    give_m: f32,
}

/// Which limbs are moved where they are in something: arms, and a leg that is raised.
fn moving(now: &[[Vec3; 3]; NUM_LIMBS]) -> [bool; NUM_LIMBS] {
    let [left, right] = [now[LEGS][2].y, now[LEGS + 1][2].y];
    [true, true, left > right + RAISED_M, right > left + RAISED_M]
}

/// Where straight limbs bend to: elbows outwards and down, knees ahead.
fn outwards(limbs: &[[Vec3; 3]; NUM_LIMBS]) -> [Vec3; NUM_LIMBS] {
    let across = |l: usize| (limbs[l][0] - limbs[l + 1][0]).normalize_or_zero();
    let (shoulders, ahead) = (across(0), across(LEGS).cross(Vec3::Y));
    [shoulders - Vec3::Y, -shoulders - Vec3::Y, ahead, ahead]
}

/// The angle at an elbow or a knee (rad).
fn elbow_angle([shoulder, elbow, wrist]: [Vec3; 3]) -> f32 {
    let (upper, lower) = (shoulder - elbow, wrist - elbow);
    maths::atan2(upper.cross(lower).length(), upper.dot(lower))
}

/// The turn from one direction to another; none where either has no length. Small turns are exact, other than glam's,
/// which leaves out those below 0.7 mrad.
fn arc(from: Vec3, to: Vec3) -> Quat {
    let (Some(from), Some(to)) = (from.try_normalize(), to.try_normalize()) else { return Quat::IDENTITY };
    let w = 1.0 + from.dot(to);
    if w < 1e-6 {
        // Any axis does.
        let axis = from.any_orthonormal_vector();
        return Quat::from_xyzw(axis.x, axis.y, axis.z, 0.0);
    }
    let axis = from.cross(to);
    maths::unit(Quat::from_xyzw(axis.x, axis.y, axis.z, w))
}

/// What limbs stop at: the other's thighs and shins, for legs alone, upper arms, then the core, for upper arms and thighs too.
const NUM_OBSTACLES: usize = FOR_UPPER + NUM_CORE + 1;
const FOR_ARMS: usize = 4;
const FOR_UPPER: usize = FOR_ARMS + LEGS;

fn obstacles(
    limbs: &[[Vec3; 3]; NUM_LIMBS],
    shapes: &[LimbShape; NUM_LIMBS],
    core: &[Capsule; NUM_CORE + 1],
) -> [Capsule; NUM_OBSTACLES] {
    let bone = |l: usize, from: usize, radius: f32| Capsule { ends: [limbs[l][from], limbs[l][from + 1]], radius };
    std::array::from_fn(|i| match i {
        0..2 => bone(LEGS + i, 0, shapes[LEGS + i].upper_radius),
        2..FOR_ARMS => bone(i, 1, shapes[i].radius),
        FOR_ARMS..FOR_UPPER => bone(i - FOR_ARMS, 0, shapes[i - FOR_ARMS].upper_radius),
        _ => core[i - FOR_UPPER],
    })
}

/// A ball around a capsule.
#[derive(Clone, Copy, Debug)]
struct Ball {
    centre: Vec3,
    radius: f32,
}

impl Ball {
    fn about(ends: [Vec3; 2], radius: f32) -> Self {
        Self { centre: (ends[0] + ends[1]) * 0.5, radius: 0.5 * ends[0].distance(ends[1]) + radius }
    }

    fn is_near(&self, other: &Self) -> bool {
        let reach = self.radius + other.radius + ROOM_M;
        self.centre.distance_squared(other.centre) < reach * reach
    }
}

/// What the two bones of a limb might come into, a bit for each obstacle.
#[derive(Clone, Copy, Debug, Default)]
struct Near {
    fore: u32,
    upper: u32,
}

impl Near {
    /// - `first`: number of the first obstacle that counts.
    fn of(rod: &Rod, root: Vec3, shape: &LimbShape, (obstacles, first): (&[Capsule; NUM_OBSTACLES], usize)) -> Self {
        let fore = Ball::about(rod.axis(shape), shape.radius + rod.foot.length());
        let upper = Ball::about([root, rod.ends[0]], shape.upper_radius);
        let mut near = Self::default();
        for (i, capsule) in obstacles.iter().enumerate().skip(first) {
            let ball = Ball::about(capsule.ends, capsule.radius);
            near.fore |= u32::from(fore.is_near(&ball)) << i;
            near.upper |= u32::from(upper.is_near(&ball)) << i;
        }
        near
    }
}

/// A forearm or shin that is moved about.
#[derive(Clone, Copy, Debug)]
struct Rod {
    /// Elbow and wrist, or knee and ankle (m).
    ends: [Vec3; 2],
    /// From the ankle to the toes; none for arms (m).
    foot: Vec3,
    moved: bool,
}

impl Rod {
    /// From the elbow to where the fist begins to round, or from knee to ankle (m).
    fn axis(&self, shape: &LimbShape) -> [Vec3; 2] {
        let [elbow, wrist] = self.ends;
        [elbow, wrist + (wrist - elbow) * (shape.hand_m / shape.lengths[1])]
    }

    /// Moves a point of its axis; what is near the elbow carries the wrist along, and the foot the ankle (m).
    fn shift(&mut self, at: Vec3, by: Vec3) {
        let [elbow, wrist] = self.ends;
        let along = wrist - elbow;
        let s = ((at - elbow).dot(along) / along.length_squared().max(1e-9)).clamp(0.0, 1.0);
        let per = 1.0 / ((1.0 - s) * (1.0 - s) + s);
        self.ends = [elbow + by * ((1.0 - s) * per), wrist + by * per];
        self.moved = true;
    }

    /// Moves it out of a capsule that stays; false where it is not in it.
    fn leave(&mut self, shape: &LimbShape, capsule: &Capsule, give_m: f32) -> bool {
        let allowed_m = shape.radius + capsule.radius - give_m;
        let mut found = depth(self.axis(shape), capsule.ends, allowed_m);
        found.into_iter().for_each(|(at, _, by)| self.shift(at, by));
        if self.foot != Vec3::ZERO {
            let ankle = self.ends[1];
            let of_foot = depth([ankle, ankle + self.foot], capsule.ends, allowed_m);
            of_foot.into_iter().for_each(|(_, _, by)| self.shift(ankle, by));
            found = found.or(of_foot);
        }
        found.is_some()
    }

    /// Moves the elbow or knee, and what is beyond it, so that the upper arm or thigh leaves a capsule as well; false where it is not in it.
    fn lift(&mut self, shoulder: Vec3, shape: &LimbShape, capsule: &Capsule, give_m: f32) -> bool {
        /// A point of it nearer to its root than this share of its length is out of reach of the elbow or knee.
        const LEAST: f32 = 0.4;
        let allowed_m = shape.upper_radius + capsule.radius - give_m;
        let found = depth([shoulder, self.ends[0]], capsule.ends, allowed_m);
        let found = found.filter(|(at, ..)| at.distance(shoulder) > LEAST * shape.lengths[0]);
        if let Some((at, _, by)) = found {
            self.shift(self.ends[0], by * (shape.lengths[0] / at.distance(shoulder)));
        }
        found.is_some()
    }
}

/// Moves two forearms or shins apart, each by half; false where they do not meet.
fn part(a: &mut Rod, shape_a: &LimbShape, b: &mut Rod, shape_b: &LimbShape, give_m: f32) -> bool {
    let axes = (a.axis(shape_a), b.axis(shape_b));
    match depth(axes.0, axes.1, shape_a.radius + shape_b.radius - give_m) {
        Some((at_a, at_b, by)) => {
            a.shift(at_a, by * 0.5);
            b.shift(at_b, by * -0.5);
            true
        }
        None => false,
    }
}

/// Where two axes are nearest and how far the first one has to go, if they are nearer than allowed (m).
fn depth(a: [Vec3; 2], b: [Vec3; 2], allowed_m: f32) -> Option<(Vec3, Vec3, Vec3)> {
    let [p, q] = nearest_points(a, b);
    let way = p - q;
    let distance = way.length();
    // Crossing axes leave the way that the arm came from.
    let out = if distance > 1e-5 { way / distance } else { (a[0] - q).normalize_or(Vec3::Y) };
    (distance < allowed_m - ENOUGH_M).then(|| (p, q, out * (allowed_m - distance)))
}

/// Middle and end as near to `ends` as a limb of these lengths can be.
///
/// - `out`: where a straight limb bends to, and how much of that there is (0 to 1).
fn reach(shoulder: Vec3, [elbow, wrist]: [Vec3; 2], shape: &LimbShape, (out, soft): (Vec3, f32)) -> [Vec3; 2] {
    let [l1, l2] = shape.lengths;
    let way = wrist - shoulder;
    let direction = way.normalize_or(Vec3::NEG_Y);
    // Of bones shorter than that, the least distance is above the greatest one.
    let d = way.length().min((l1 + l2) * (1.0 - STRETCH * soft * soft)).max((l1 - l2).abs() + 1e-3);
    let across = |v: Vec3| v - direction * v.dot(direction);
    let pole = across(elbow - shoulder);
    let soft = (SOFT_ELBOW_M * soft - pole.length()).max(0.0);
    let pole = (pole + across(out).normalize_or_zero() * soft).normalize_or_zero();
    let along = (l1 * l1 - l2 * l2 + d * d) / (2.0 * d);
    let across = (l1 * l1 - along * along).max(0.0).sqrt();
    [shoulder + direction * along + pole * across, shoulder + direction * d]
}
