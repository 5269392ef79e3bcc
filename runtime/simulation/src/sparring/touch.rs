//! Arms that stop where they meet the other's body or guard, or slide there.
//!
//! Each arm remembers how far it is displaced from where its motion has it. In a step the displacement fades, then elbow
//! and wrist are moved out of what they are in, as points of a rod that keeps its length (Müller et al. 2007, position
//! based dynamics); fast arms go their way in short pieces, so that none comes out on the other side. What a blow meets is
//! told by the motion and not by this.

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
/// Arms that are in something by less are out of it (m).
const ENOUGH_M: f32 = 1e-3;
/// How far an arm may be moved in a piece, for what it might come into (m).
const ROOM_M: f32 = 0.08;
/// Rounds in which arms are moved out of what they are in.
const ROUNDS: usize = 6;
/// Nobody's arms reach farther than this from the hips (m).
const REACH_M: f32 = 1.3;
/// Arms that are displaced by less are where their motion has them (m).
const AT_REST_M: f32 = 1e-4;
/// Bones of arms are taken to be at least this long (m).
const LEAST_M: f32 = 1e-3;
/// Elbows that are less off the straight line bend outwards and down (m).
const SOFT_ELBOW_M: f32 = 0.02;

/// Shoulder, elbow and wrist.
const ARMS: [[Joint; 3]; 2] = [
    [Joint::LeftUpperArm, Joint::LeftForearm, Joint::LeftHand],
    [Joint::RightUpperArm, Joint::RightForearm, Joint::RightHand],
];

/// What their shoulders hang from.
const CLAVICLES: [Joint; 2] = [Joint::LeftClavicle, Joint::RightClavicle];

impl TouchConfig {
    pub(super) fn check(&self) -> Result<()> {
        within("touch.half_life_s", self.half_life_s, 1e-3, 10.0, "between 0.001 and 10")?;
        within("touch.elbow_radps", self.elbow_radps, 1.0, 1000.0, "between 1 and 1000")?;
        within("touch.give_m", self.give_m, 0.0, 0.1, "between 0 and 0.1")
    }
}

/// What is remembered of an arm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Arm {
    /// How far elbow and wrist are from where the motion has them (m).
    off: [Vec3; 2],
    /// Where the motion had shoulder, elbow and wrist at the last step (m).
    was: [Vec3; 3],
}

impl Arm {
    fn is_displaced(&self) -> bool {
        self.off != [Vec3::ZERO; 2]
    }

    /// Where shoulder, elbow and wrist are (m).
    fn displaced(&self) -> [Vec3; 3] {
        let [shoulder, elbow, wrist] = self.was;
        [shoulder, elbow + self.off[0], wrist + self.off[1]]
    }

    /// Gives the arm its lengths, and its elbow as slow a turn as `most`: the wrist gives way along its way from the
    /// shoulder (rad).
    ///
    /// - `before`: the angle at the elbow at the last step (rad).
    /// - `out`: see [`reach`].
    fn keep_lengths(&mut self, shape: &ArmShape, before: f32, most: f32, out: Vec3) {
        let [shoulder, elbow, wrist] = self.displaced();
        let mut ends = reach(shoulder, [elbow, wrist], shape, out);
        let angle = elbow_angle([shoulder, ends[0], ends[1]]);
        let slow = angle.clamp(before - most, before + most);
        if slow != angle {
            let [l1, l2] = shape.lengths;
            let distance = (l1 * l1 + l2 * l2 - 2.0 * l1 * l2 * maths::cos(slow)).max(0.0).sqrt();
            let wrist = shoulder + (ends[1] - shoulder).normalize_or_zero() * distance;
            ends = reach(shoulder, [ends[0], wrist], shape, out);
        }
        self.off = [ends[0] - self.was[1], ends[1] - self.was[2]];
    }
}

/// What is remembered of the arms of two opponents.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Touch {
    /// Left and right arm of each.
    arms: [[Arm; 2]; 2],
    /// False where one has no step behind it.
    seen: [bool; 2],
}

/// What of an arm does not change.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ArmShape {
    /// Of upper arm and forearm (m).
    lengths: [f32; 2],
    /// How far the axis goes on beyond the wrist, into the fist (m).
    hand_m: f32,
    /// Of the forearm (m).
    radius: f32,
}

/// Left and right arm of a skeleton.
pub(crate) fn arm_shapes(skeleton: &Skeleton, body: &Body) -> [ArmShape; 2] {
    ARMS.map(|[_, elbow, wrist]| {
        let radius = body.forearm_radius();
        let fist = throng_core::hits::striking_offset(skeleton, wrist).length();
        let lengths = [elbow, wrist].map(|j| skeleton.offsets[j.index()].length().max(LEAST_M));
        ArmShape { lengths, hand_m: (fist - radius).max(0.0), radius }
    })
}

impl Touch {
    /// False for numbers that no arms have.
    pub fn may_be(&self) -> bool {
        let near = |v: &Vec3, most: f32| v.is_finite() && v.abs().max_element() < most;
        self.arms.iter().flatten().all(|a| a.off.iter().all(|v| near(v, 3.0)) && a.was.iter().all(|v| near(v, 2e6)))
    }

    /// Forgets one who was put elsewhere, and whom it touched.
    pub fn forget(&mut self, one: usize) {
        self.seen[one] = false;
        self.arms.iter_mut().flatten().for_each(|arm| arm.off = [Vec3::ZERO; 2]);
    }

    /// Finds how far all arms have to be displaced.
    ///
    /// - `poses`: as the motion has them.
    pub fn settle(
        &mut self,
        body: &Body,
        shapes: &[ArmShape; 2],
        poses: &[Posed<'_>; 2],
        config: &TouchConfig,
        dt_s: f32,
    ) {
        let now = [0, 1].map(|k| ARMS.map(|arm| arm.map(|j| poses[k].point(j, Vec3::ZERO))));
        let before = self.arms;
        let keep = maths::exp(-std::f32::consts::LN_2 * dt_s / config.half_life_s);
        for k in 0..2 {
            for a in 0..2 {
                let arm = &mut self.arms[k][a];
                if !self.seen[k] {
                    arm.was = now[k][a];
                }
                arm.off = arm.off.map(|o| o * keep);
                if arm.off.iter().all(|o| o.length_squared() < AT_REST_M * AT_REST_M) {
                    arm.off = [Vec3::ZERO; 2];
                }
            }
        }
        self.seen = [true; 2];
        let hips = poses.each_ref().map(|p| p.point(Joint::Hips, Vec3::ZERO));
        let is_near = hips[0].distance_squared(hips[1]) < 4.0 * REACH_M * REACH_M;
        if config.enabled && is_near && self.may_touch(shapes, &now, &hips) {
            let cores = poses.each_ref().map(|p| body.obstacles(p));
            let fastest = self.arms.iter().flatten().zip(now.iter().flatten());
            let fastest = fastest.map(|(arm, now)| now[2].distance(arm.was[2])).fold(0.0, f32::max);
            let pieces = ((fastest / PIECE_M).ceil() as usize).clamp(1, MOST_PIECES);
            for piece in 1..=pieces {
                self.piece(shapes, &cores, &now, piece as f32 / pieces as f32, config.give_m);
            }
        }
        for k in 0..2 {
            let across = (now[k][0][0] - now[k][1][0]).normalize_or_zero();
            for (a, across) in [across, -across].into_iter().enumerate() {
                let (arm, now) = (&mut self.arms[k][a], now[k][a]);
                let was = std::mem::replace(&mut arm.was, now);
                if arm.is_displaced() {
                    let most = (elbow_angle(now) - elbow_angle(was)).abs().max(config.elbow_radps * dt_s);
                    let before = elbow_angle(Arm { was, ..before[k][a] }.displaced());
                    arm.keep_lengths(&shapes[a], before, most, across - Vec3::Y);
                }
            }
        }
    }

    /// Whether any arm is displaced, or near enough to the other's trunk or arms that it could be in them.
    fn may_touch(&self, shapes: &[ArmShape; 2], now: &[[[Vec3; 3]; 2]; 2], hips: &[Vec3; 2]) -> bool {
        /// No core and no arm whose fist is there reaches farther from the axis over the hips than this (m).
        const WIDE: f32 = 0.45;
        if self.arms.iter().flatten().any(Arm::is_displaced) {
            return true;
        }
        let axis = |k: usize| [hips[k], hips[k] + Vec3::Y * 0.8];
        (0..2).any(|k| {
            (0..2).any(|a| {
                let [_, elbow, wrist] = now[k][a];
                let tip = wrist + (wrist - elbow) * (shapes[a].hand_m / shapes[a].lengths[1]);
                let [p, q] = nearest_points([elbow, tip], axis(k ^ 1));
                let other = &now[k ^ 1];
                p.distance_squared(q) < WIDE * WIDE
                    || other.iter().any(|o| {
                        let [p, q] = nearest_points([elbow, tip], [o[1], o[2]]);
                        p.distance_squared(q) < 0.3 * 0.3
                    })
            })
        })
    }

    /// Goes a piece of the way since the last step, and moves arms out of what they are in.
    fn piece(
        &mut self,
        shapes: &[ArmShape; 2],
        cores: &[[Capsule; NUM_CORE + 1]; 2],
        now: &[[[Vec3; 3]; 2]; 2],
        share: f32,
        give_m: f32,
    ) {
        let base: [[[Vec3; 3]; 2]; 2] =
            [0, 1].map(|k| [0, 1].map(|a| [0, 1, 2].map(|i| self.arms[k][a].was[i].lerp(now[k][a][i], share))));
        let mut rods: [[Rod; 2]; 2] = [0, 1].map(|k| {
            [0, 1].map(|a| {
                let (b, off) = (&base[k][a], &self.arms[k][a].off);
                Rod { ends: [b[1] + off[0], b[2] + off[1]], moved: false }
            })
        });
        let obstacles = [0, 1].map(|k| obstacles(&now[k], shapes, &cores[k]));
        let near = [0, 1].map(|k| [0, 1].map(|a| Near::of(&rods[k][a], base[k][a][0], &shapes[a], &obstacles[k ^ 1])));
        let forearms = rods.map(|rods| [0, 1].map(|a| Ball::about(rods[a].axis(&shapes[a]), shapes[a].radius)));
        let pairs = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(a, b)| (a, b, forearms[0][a].is_near(&forearms[1][b])));
        for _ in 0..ROUNDS {
            let mut any = false;
            for (a, b, _) in pairs.into_iter().filter(|(.., is_near)| *is_near) {
                let [first, second] = &mut rods;
                any |= part(&mut first[a], &shapes[a], &mut second[b], &shapes[b], give_m);
            }
            for k in 0..2 {
                for a in 0..2 {
                    let (rod, shape, near) = (&mut rods[k][a], &shapes[a], near[k][a]);
                    // Upper arms, then the core: what comes last counts most.
                    for (i, capsule) in obstacles[k ^ 1].iter().enumerate() {
                        if i >= ARMS.len() && near.upper >> i & 1 == 1 {
                            any |= rod.lift(base[k][a][0], shape, capsule, give_m);
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
                let across = (base[k][0][0] - base[k][1][0]).normalize_or_zero();
                for a in 0..2 {
                    if rods[k][a].moved {
                        let out = if a == 0 { across } else { -across } - Vec3::Y;
                        rods[k][a].ends = reach(base[k][a][0], rods[k][a].ends, &shapes[a], out);
                    }
                }
            }
        }
        for k in 0..2 {
            for a in 0..2 {
                if rods[k][a].moved {
                    self.arms[k][a].off = [0, 1].map(|i| rods[k][a].ends[i] - base[k][a][i + 1]);
                }
            }
        }
    }

    /// Displaces the arms of one of the two in its pose.
    ///
    /// - `model`: in model space, as the motion has it.
    /// - `locals`: the same relative to parents, or empty.
    pub fn apply(&self, one: usize, root: Planar, model: &mut [Mat3x4], locals: &mut [LocalTransform]) {
        let to_model = root.rotation().conjugate();
        for (a, arm) in self.arms[one].iter().enumerate().filter(|(_, arm)| arm.is_displaced()) {
            let joints = ARMS[a].map(Joint::index);
            let [shoulder, elbow, wrist] = joints.map(|j| model[j].translation());
            let off = arm.off.map(|o| maths::rotate(to_model, o));
            let [to_elbow, to_wrist] = [elbow + off[0], wrist + off[1]];
            let upper = arc(elbow - shoulder, to_elbow - shoulder);
            let lower = arc(wrist - elbow, to_wrist - to_elbow);
            for (j, turn, at) in
                [(joints[0], upper, shoulder), (joints[1], lower, to_elbow), (joints[2], lower, to_wrist)]
            {
                model[j] = Mat3x4::from_rotation_translation(turn, Vec3::ZERO) * model[j];
                model[j].rows.iter_mut().zip(at.to_array()).for_each(|(row, v)| row[3] = v);
            }
            if !locals.is_empty() {
                for (parent, j) in [(CLAVICLES[a].index(), joints[0]), (joints[0], joints[1])] {
                    let local = maths::compose(model[parent].rotation().conjugate(), model[j].rotation());
                    locals[j].rotation = local.to_array();
                }
            }
        }
    }
}

/// The angle at an elbow (rad).
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

/// What arms stop at: the other's upper arms, then the core.
const NUM_OBSTACLES: usize = ARMS.len() + NUM_CORE + 1;

fn obstacles(
    arms: &[[Vec3; 3]; 2],
    shapes: &[ArmShape; 2],
    core: &[Capsule; NUM_CORE + 1],
) -> [Capsule; NUM_OBSTACLES] {
    std::array::from_fn(|i| match arms.get(i) {
        Some(arm) => Capsule { ends: [arm[0], arm[1]], radius: shapes[i].radius },
        None => core[i - ARMS.len()],
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

/// What a forearm and an upper arm might come into, a bit for each obstacle.
#[derive(Clone, Copy, Debug)]
struct Near {
    fore: u32,
    upper: u32,
}

impl Near {
    fn of(rod: &Rod, shoulder: Vec3, shape: &ArmShape, obstacles: &[Capsule; NUM_OBSTACLES]) -> Self {
        let fore = Ball::about(rod.axis(shape), shape.radius);
        let upper = Ball::about([shoulder, rod.ends[0]], shape.radius);
        let mut near = Self { fore: 0, upper: 0 };
        for (i, capsule) in obstacles.iter().enumerate() {
            let ball = Ball::about(capsule.ends, capsule.radius);
            near.fore |= u32::from(fore.is_near(&ball)) << i;
            near.upper |= u32::from(upper.is_near(&ball)) << i;
        }
        near
    }
}

/// A forearm that is moved about.
#[derive(Clone, Copy, Debug)]
struct Rod {
    /// Elbow and wrist (m).
    ends: [Vec3; 2],
    moved: bool,
}

impl Rod {
    /// From the elbow to where the fist begins to round (m).
    fn axis(&self, shape: &ArmShape) -> [Vec3; 2] {
        let [elbow, wrist] = self.ends;
        [elbow, wrist + (wrist - elbow) * (shape.hand_m / shape.lengths[1])]
    }

    /// Moves a point of its axis; what is near the elbow carries the wrist along (m).
    fn shift(&mut self, at: Vec3, by: Vec3) {
        let [elbow, wrist] = self.ends;
        let along = wrist - elbow;
        let s = ((at - elbow).dot(along) / along.length_squared().max(1e-9)).clamp(0.0, 1.0);
        let per = 1.0 / ((1.0 - s) * (1.0 - s) + s);
        self.ends = [elbow + by * ((1.0 - s) * per), wrist + by * per];
        self.moved = true;
    }

    /// Moves it out of a capsule that stays; false where it is not in it.
    fn leave(&mut self, shape: &ArmShape, capsule: &Capsule, give_m: f32) -> bool {
        let allowed_m = shape.radius + capsule.radius - give_m;
        let found = depth(self.axis(shape), capsule.ends, allowed_m);
        found.into_iter().for_each(|(at, _, by)| self.shift(at, by));
        found.is_some()
    }

    /// Moves the elbow, and the wrist with it, so that the upper arm leaves a capsule as well; false where it is not in it.
    fn lift(&mut self, shoulder: Vec3, shape: &ArmShape, capsule: &Capsule, give_m: f32) -> bool {
        /// A point of the upper arm nearer to the shoulder than this share of its length is out of reach of the elbow.
        const LEAST: f32 = 0.4;
        let allowed_m = shape.radius + capsule.radius - give_m;
        let found = depth([shoulder, self.ends[0]], capsule.ends, allowed_m);
        let found = found.filter(|(at, ..)| at.distance(shoulder) > LEAST * shape.lengths[0]);
        if let Some((at, _, by)) = found {
            self.shift(self.ends[0], by * (shape.lengths[0] / at.distance(shoulder)));
        }
        found.is_some()
    }
}

/// Moves two forearms apart, each by half; false where they do not meet.
fn part(a: &mut Rod, shape_a: &ArmShape, b: &mut Rod, shape_b: &ArmShape, give_m: f32) -> bool {
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

/// Elbow and wrist as near to `ends` as an arm of these lengths can be.
///
/// - `out`: where the elbow of a straight arm bends to.
fn reach(shoulder: Vec3, [elbow, wrist]: [Vec3; 2], shape: &ArmShape, out: Vec3) -> [Vec3; 2] {
    let [l1, l2] = shape.lengths;
    let way = wrist - shoulder;
    let direction = way.normalize_or(Vec3::NEG_Y);
    // Of bones shorter than that, the least distance is above the greatest one.
    let d = way.length().min((l1 + l2) * 0.9995).max((l1 - l2).abs() + 1e-3);
    let across = |v: Vec3| v - direction * v.dot(direction);
    let pole = across(elbow - shoulder);
    let soft = (SOFT_ELBOW_M - pole.length()).max(0.0);
    let pole = (pole + across(out).normalize_or_zero() * soft).normalize_or_zero();
    let along = (l1 * l1 - l2 * l2 + d * d) / (2.0 * d);
    let across = (l1 * l1 - along * along).max(0.0).sqrt();
    [shoulder + direction * along + pole * across, shoulder + direction * d]
}
