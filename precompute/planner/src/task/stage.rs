//! State of a task while it is worked on: clips as they are by now, and the place of every thing at every time.

use super::{Anchor, StepFailure, Task, TaskCharacter, TaskPlace, ThingStart, capsules_around};
use crate::correct::{CollisionStretch, CorrectConfig, find_collisions};
use crate::linkage::{Limb, LimbPose};
use crate::problem::{EXTERNAL_STEP_S, MovingSolid, Problem};
use crate::rotation::{Rigid, rotation_about};
use crate::setup::{AllowedContact, HeldCapsule, OtherCharacter, ProblemError, ProblemSpec, UprightConstraint};
use crate::track::{MotionTrack, RigidPath as Motion, SampleTimes};
use crate::{body::BodyCapsules, driven::DrivenMotion, limits::BodyLimits, stiff_mesh::StiffMesh};
use glam::{DVec3, Quat};
use std::{collections::BTreeSet, f64::consts::TAU, sync::Arc};
use throng_base::maths;
use throng_core::{Joint, NUM_JOINTS, Skeleton};
use throng_geometry::SolidShape;
use throng_motion::Clip;

/// Number of turns that are tried for something upright whose turn is open.
const NUM_TURNS: u32 = 24;
/// Most things that stand on one another.
const MAX_STACK: usize = 8;
/// Most passes over a clip that search for collisions of a limb by itself.
const MAX_SAMPLES: usize = 64;
/// Depth below which a limb may stay in an obstacle (m).
const PRESS_M: f64 = 0.03;
/// Time before and after such a collision in which it may stay (s).
const PRESS_S: f64 = 0.1;

/// A clip, and the skeleton of its character.
#[derive(Clone, Debug, PartialEq)]
pub struct ActorClip {
    /// Motion, from time 0 on.
    pub clip: Clip,
    /// Proportions.
    pub skeleton: Skeleton,
}

/// A character in its present state.
#[derive(Clone, Debug)]
pub(super) struct StageActor {
    /// The clip as it was, placed in the scene.
    pub before: Clip,
    /// The clip with what was planned.
    pub clip: Clip,
    pub skeleton: Skeleton,
    pub limits: BodyLimits,
    pub shape: BodyCapsules,
    pub motion: DrivenMotion,
    /// Mesh that it wears, which others collide with in place of its capsules.
    pub worn: Option<StiffMesh>,
    /// Collisions of limbs by the clip itself, in which they stay.
    pub pressed: Vec<(Limb, AllowedContact)>,
}

/// Placement of a thing from a time on.
#[derive(Clone, Debug)]
pub(super) struct PlacementSpan {
    pub from_s: f64,
    pub placement: ThingPlacement,
}

/// Placement of a thing.
#[derive(Clone, Debug)]
pub(super) enum ThingPlacement {
    Path(Motion),
    /// Carried by a joint; `holder` is the arm whose hand it is, `second` the other one that holds it, too.
    OnJoint {
        character: usize,
        joint: Joint,
        offset: Rigid,
        holder: Option<Limb>,
        second: Option<SecondHand>,
    },
    OnThing {
        thing: usize,
        offset: Rigid,
    },
}

/// The second hand at a thing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SecondHand {
    pub limb: Limb,
    /// Transform of its hand, relative to the first one.
    pub grip: Rigid,
}

/// A limb that was planned.
#[derive(Clone, Debug)]
pub(super) struct PlannedLimb {
    pub character: usize,
    pub limb: Limb,
    pub window_s: [f64; 2],
    /// Poses at both ends.
    pub ends: [LimbPose; 2],
}

/// A gaze of a character at the target of a limb.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaskGaze {
    /// Index of the character.
    pub character: usize,
    /// Times at which the head leaves the clip, the limb is at its target, and the head is back (s).
    pub times_s: [f64; 3],
    /// Position of the target when the limb is there (m).
    pub target: DVec3,
}

/// A bend of a character's trunk for a limb.
#[derive(Clone, Copy, Debug)]
pub(super) struct TrunkLean {
    pub character: usize,
    pub window_s: [f64; 2],
    /// True where hips and legs move, too.
    pub moves_hips: bool,
}

/// Transform that hand or foot has to have at a time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pin {
    pub character: usize,
    pub limb: Limb,
    pub time_s: f64,
    pub target: Rigid,
}

/// State of everything in a task.
#[derive(Clone, Debug)]
pub(super) struct TaskStage<'a> {
    pub task: &'a Task,
    pub actors: Vec<StageActor>,
    /// Placements of every thing.
    pub placements: Vec<Vec<PlacementSpan>>,
    /// Contacts that limbs are allowed by their actions.
    pub contacts: Vec<(usize, Limb, AllowedContact)>,
    pub planned_limbs: Vec<PlannedLimb>,
    pub pins: Vec<Pin>,
    pub gazes: Vec<TaskGaze>,
    pub leans: Vec<TrunkLean>,
    /// Settings of plans.
    pub config: CorrectConfig<'a>,
}

/// Surroundings of a limb in a stretch of time.
#[derive(Clone, Debug, Default)]
pub(super) struct LimbSurroundings {
    pub solids: Vec<MovingSolid>,
    pub held: Vec<HeldCapsule>,
    pub allowed: Vec<AllowedContact>,
    pub level: Option<UprightConstraint>,
}

impl StageActor {
    fn new(actor: &ActorClip, character: &TaskCharacter) -> Self {
        let placed = &character.placed;
        let (mut clip, skeleton) = (actor.clip.clone(), actor.skeleton.clone());
        if *placed != Rigid::IDENTITY {
            let turn: Quat = placed.rotation.as_quat();
            clip.root_positions.iter_mut().for_each(|p| *p = placed.transform_point(p.as_dvec3()).as_vec3());
            clip.rotations.iter_mut().step_by(NUM_JOINTS).for_each(|q| *q = maths::compose(turn, *q).normalize());
        }
        let motion = driven_motion(&clip, &skeleton);
        let limits = BodyLimits::built_in(&skeleton);
        // What was read fits one skeleton, and so all.
        let worn = character.body.as_ref().and_then(|b| StiffMesh::from_figure(&b.figure, &skeleton).ok());
        let shape = worn.as_ref().map_or_else(|| BodyCapsules::fitted(&skeleton), |w| w.capsules(&skeleton));
        let mut actor = Self { before: clip.clone(), clip, skeleton, limits, shape, motion, worn, pressed: Vec::new() };
        actor.pressed = Limb::ALL.iter().flat_map(|l| actor.initial_contacts(*l)).collect();
        actor
    }

    /// Collisions of a limb by the clip itself, in which it stays: an upper arm or thigh in the trunk, as flesh gives way;
    /// other parts where they are hardly in it, or where the clip begins or ends so, as there is no free pose to come from.
    fn initial_contacts(&self, limb: Limb) -> Vec<(Limb, AllowedContact)> {
        let mut allowed: Vec<AllowedContact> = Vec::new();
        let first = limb.joints()[0].name();
        // Times up to which a collision at the beginning lasts, and from which one at the end does.
        let mut ends = [f64::NEG_INFINITY, f64::INFINITY];
        // Each pass finds the deepest collision of a part: the one behind it comes next.
        for _ in 0..MAX_SAMPLES {
            let spec = ProblemSpec { allowed: &allowed, ..self.limb_spec(limb) };
            let Ok(problem) = Problem::prepare(&spec) else { break };
            let found = find_collisions(&problem);
            if allowed.is_empty() {
                let reaches = |s: &&CollisionStretch| [s.from_s < PRESS_S, s.to_s > self.end_s() - PRESS_S];
                ends[0] = found.iter().filter(|s| reaches(s)[0]).fold(ends[0], |t, s| t.max(s.to_s + PRESS_S));
                ends[1] = found.iter().filter(|s| reaches(s)[1]).fold(ends[1], |t, s| t.min(s.from_s - PRESS_S));
            }
            let at_an_end = |s: &CollisionStretch| s.to_s < ends[0] || s.from_s > ends[1];
            let stays = |s: &CollisionStretch| s.part == first || s.depth_m < PRESS_M || at_an_end(s);
            let before = allowed.clone();
            for CollisionStretch { from_s, to_s, part, with, .. } in found.into_iter().filter(stays) {
                let window = (part != first).then_some([from_s - PRESS_S, to_s + PRESS_S]);
                let part = Some(part);
                match allowed.iter_mut().find(|a| a.part == part && a.other == with) {
                    Some(AllowedContact { window_s, .. }) => {
                        *window_s = window_s.zip(window).map(|(a, b)| [a[0].min(b[0]), a[1].max(b[1])]);
                    }
                    None => allowed.push(AllowedContact { part, other: with, window_s: window }),
                }
            }
            if allowed == before {
                break;
            }
        }
        allowed.into_iter().map(|a| (limb, a)).collect()
    }

    /// Specification of a limb over the whole clip, in an empty world.
    fn limb_spec(&self, limb: Limb) -> ProblemSpec<'_> {
        let ends = [0.0, self.end_s()].map(|time_s| self.motion.limb_state(limb, time_s));
        ProblemSpec::new(&self.skeleton, limb, &self.limits, &self.motion, &self.shape, ends)
    }

    /// Replaces the clip.
    pub fn replace_clip(&mut self, clip: Clip) {
        self.motion = driven_motion(&clip, &self.skeleton);
        self.clip = clip;
    }

    pub fn end_s(&self) -> f64 {
        self.clip.num_frames().saturating_sub(1) as f64 / self.clip.rate_hz
    }

    /// Transform of a joint at a time.
    pub fn joint_place(&self, joint: Joint, time_s: f64) -> Rigid {
        let (places, [from, to]) = (self.motion.places(), self.motion.window_s());
        let last = places.len() - 1;
        let at = ((time_s - from) / (to - from).max(1e-9) * last as f64).clamp(0.0, last as f64);
        let i = (at + 1e-6) as usize;
        let next = (i + 1).min(last);
        places[i][joint.index()].lerp(&places[next][joint.index()], (at - i as f64).max(0.0))
    }
}

fn driven_motion(clip: &Clip, skeleton: &Skeleton) -> DrivenMotion {
    DrivenMotion::from_clip(clip, skeleton, 0.0, clip.num_frames().saturating_sub(1) as f64 / clip.rate_hz)
}

impl<'a> TaskStage<'a> {
    /// The state of a task before anything was planned.
    pub fn new(task: &'a Task, clips: &[ActorClip]) -> Self {
        let actors = clips.iter().zip(&task.characters).map(|(c, who)| StageActor::new(c, who)).collect();
        let first = |start: &ThingStart| {
            let placement = match *start {
                ThingStart::Path(ref path) => ThingPlacement::Path(path.clone()),
                ThingStart::OnJoint { character, joint, offset } => {
                    ThingPlacement::OnJoint { character, joint, offset, holder: arm_of_hand(joint), second: None }
                }
            };
            vec![PlacementSpan { from_s: f64::NEG_INFINITY, placement }]
        };
        let placements = task.things.iter().map(|t| first(&t.start)).collect();
        let (contacts, planned_limbs, pins, gazes, leans) = Default::default();
        Self { task, actors, placements, contacts, planned_limbs, pins, gazes, leans, config: task.config }
    }

    /// The end of the last clip (s).
    pub fn end_s(&self) -> f64 {
        self.actors.iter().map(StageActor::end_s).fold(0.0, f64::max)
    }

    /// Placement of a thing at a time; at a change, the one after it.
    pub fn placement_at(&self, thing: usize, time_s: f64) -> &ThingPlacement {
        let life = &self.placements[thing];
        let i = life.iter().rposition(|s| s.from_s <= time_s + 1e-6).unwrap_or(0);
        &life[i].placement
    }

    /// Transform of a thing at a time.
    pub fn thing_place(&self, thing: usize, time_s: f64) -> Rigid {
        self.resolve_placement(self.placement_at(thing, time_s), time_s, 0)
    }

    /// Transform of a thing with a placement.
    pub fn resolve_placement(&self, at: &ThingPlacement, time_s: f64, depth: usize) -> Rigid {
        match at {
            ThingPlacement::Path(path) => path.place_at(time_s),
            ThingPlacement::OnJoint { character, joint, offset, .. } => {
                self.actors[*character].joint_place(*joint, time_s).compose(*offset)
            }
            ThingPlacement::OnThing { thing, offset } if depth < MAX_STACK => {
                self.resolve_placement(self.placement_at(*thing, time_s), time_s, depth + 1).compose(*offset)
            }
            ThingPlacement::OnThing { offset, .. } => *offset,
        }
    }

    /// Frame from which a place is seen.
    pub fn base_of(&self, place: &TaskPlace, time_s: f64) -> Rigid {
        match place.on {
            Anchor::World => Rigid::IDENTITY,
            Anchor::Thing(thing) => self.thing_place(thing, time_s),
            Anchor::Joint(who, joint) => self.actors[who].joint_place(joint, time_s),
        }
    }

    /// Transforms of a place: one, or many upright ones where its turn is open.
    pub fn resolve_place(&self, place: &TaskPlace, time_s: f64) -> Vec<Rigid> {
        let at = self.base_of(place, time_s).compose(place.offset);
        let turns = if place.any_turn { NUM_TURNS } else { 1 };
        let turn = |k: u32| rotation_about(DVec3::Y, TAU * f64::from(k) / f64::from(turns));
        (0..turns).map(|k| at.compose(Rigid { position: DVec3::ZERO, rotation: turn(k) })).collect()
    }

    /// The thing in a hand at a time, and its transform relative to the hand.
    pub fn held_by(&self, who: usize, limb: Limb, time_s: f64) -> Option<(usize, Rigid)> {
        (0..self.placements.len()).find_map(|thing| match self.placement_at(thing, time_s) {
            ThingPlacement::OnJoint { character, holder, offset, .. } if *character == who && *holder == Some(limb) => {
                Some((thing, *offset))
            }
            _ => None,
        })
    }

    /// The thing that two hands hold, one of which is a limb's, at some time of a stretch; the leading hand, and the following
    /// one.
    pub fn held_by_both(&self, who: usize, limb: Limb, [from_s, to_s]: [f64; 2]) -> Option<(usize, Limb, SecondHand)> {
        self.placements.iter().enumerate().find_map(|(thing, life)| {
            life.iter().enumerate().find_map(|(i, s)| match &s.placement {
                ThingPlacement::OnJoint { character, holder: Some(lead), second: Some(second), .. }
                    if *character == who && [*lead, second.limb].contains(&limb) =>
                {
                    let end_s = life.get(i + 1).map_or(f64::INFINITY, |next| next.from_s);
                    (s.from_s < to_s - 1e-6 && end_s > from_s + 1e-6).then_some((thing, *lead, *second))
                }
                _ => None,
            })
        })
    }

    /// Motion of a thing over all of the task.
    pub fn thing_path(&self, thing: usize) -> Motion {
        if let [PlacementSpan { placement: ThingPlacement::Path(path), .. }] = &self.placements[thing][..] {
            return path.clone();
        }
        // Samples of a clip, if one moves the thing.
        let even = |a: &StageActor| match a.motion.clock() {
            SampleTimes::Even { step_s, .. } if a.motion.places().len() > 1 => Some(step_s),
            _ => None,
        };
        let step_s = self.actors.iter().find_map(even).unwrap_or(EXTERNAL_STEP_S);
        let clock = SampleTimes::Even { start_s: 0.0, step_s };
        let count = (self.end_s() / step_s).ceil() as usize + 1;
        let samples = (0..count).map(|i| self.thing_place(thing, i as f64 * step_s)).collect();
        Motion::Track(Arc::new(MotionTrack::rigid(clock, samples)))
    }

    /// Surroundings of a limb, and contacts that it is allowed.
    pub fn surroundings_of_limb(&self, who: usize, limb: Limb, [from_s, to_s]: [f64; 2]) -> LimbSurroundings {
        let mut out = LimbSurroundings::default();
        let middle = 0.5 * (from_s + to_s);
        for (i, thing) in self.task.things.iter().enumerate() {
            match self.placement_at(i, middle) {
                ThingPlacement::OnJoint { character, holder, offset, .. }
                    if *character == who && *holder == Some(limb) =>
                {
                    let all = thing.shapes.iter().flat_map(capsules_around);
                    out.held.extend(all.map(|(core, radius)| {
                        let core = core.map(|p| offset.transform_point(p));
                        HeldCapsule { name: thing.name.clone(), core, radius }
                    }));
                }
                at => {
                    let (name, path) = (&thing.name, self.thing_path(i));
                    let solid = |shape| MovingSolid { name: name.clone(), shape, path: path.clone() };
                    out.solids.extend(thing.shapes.iter().cloned().map(solid));
                    if matches!(at, ThingPlacement::OnJoint { character, .. } if *character == who) {
                        let driven = Joint::ALL.into_iter().filter(|j| !limb.moves_joint(*j));
                        out.allowed.extend(driven.map(|j| allow_contact(j, &thing.name)));
                    }
                }
            }
        }
        for (name, other) in self.others(who) {
            for (joint, mesh) in other.worn.iter().flat_map(|w| &w.pieces) {
                let track = MotionTrack::rigid(other.motion.clock(), other.motion.joint_places(*joint));
                let (shape, path) = (SolidShape::Mesh(Arc::clone(mesh)), Motion::Track(Arc::new(track)));
                out.solids.push(MovingSolid { name: name.clone(), shape, path });
            }
        }
        out.allowed.extend(self.actors[who].pressed.iter().filter(|(l, _)| *l == limb).map(|(_, a)| a.clone()));
        self.leave_to_others(who, limb, &mut out);
        let known = |a: &AllowedContact| {
            let is_held = |p: &String| out.held.iter().any(|h| h.name == *p);
            let part = a.part.as_ref().is_none_or(|p| Joint::from_name(p).is_some() || is_held(p));
            let with = Joint::from_name(&a.other).is_some()
                || out.solids.iter().any(|s| s.name == a.other)
                || self.others(who).any(|(name, _)| *name == a.other);
            part && with
        };
        let overlaps = |a: &AllowedContact| a.window_s.is_none_or(|[a, b]| a < to_s && b > from_s);
        let own = self.contacts.iter().filter(|(w, l, a)| *w == who && *l == limb && overlaps(a)).map(|c| c.2.clone());
        out.allowed = own.chain(out.allowed.iter().cloned()).filter(known).collect();
        out
    }

    /// Allows contacts of the character's other limbs that have steps of their own: those steps check them.
    fn leave_to_others(&self, who: usize, limb: Limb, out: &mut LimbSurroundings) {
        let receivers = self.task.steps.iter().filter_map(|s| s.receiver.as_ref()).map(|r| (r.character, r.limb));
        let seconds = self.task.steps.iter().filter_map(|s| Some((s.character, s.second.as_ref()?.limb)));
        let limbs = self.task.steps.iter().map(|s| (s.character, s.limb)).chain(receivers).chain(seconds);
        let others: BTreeSet<Limb> = limbs.filter(|(w, l)| *w == who && *l != limb).map(|(_, l)| l).collect();
        let mut names: Vec<&str> = self.task.things.iter().map(|t| t.name.as_str()).collect();
        names.extend(self.others(who).map(|(name, _)| name.as_str()));
        let moved = Joint::ALL.into_iter().filter(|j| others.iter().any(|l| l.moves_joint(*j)));
        out.allowed.extend(moved.flat_map(|joint| names.iter().map(move |name| allow_contact(joint, name))));
    }

    fn others(&self, who: usize) -> impl Iterator<Item = (&String, &StageActor)> {
        let all = self.task.characters.iter().zip(&self.actors).enumerate();
        all.filter(move |(i, _)| *i != who).map(|(_, (c, actor))| (&c.name, actor))
    }

    /// All other characters whose meshes are not part of the [surroundings](TaskStage::around).
    pub fn other_bodies(&self, who: usize) -> Vec<OtherCharacter<'_>> {
        self.other_capsules(who, |a| a.worn.is_none())
    }

    /// The other characters that count, as capsules.
    pub fn other_capsules(&self, who: usize, counts: impl Fn(&StageActor) -> bool) -> Vec<OtherCharacter<'_>> {
        let all = self.others(who).filter(|(_, a)| counts(a));
        all.map(|(name, a)| OtherCharacter { name, motion: &a.motion, shape: &a.shape }).collect()
    }

    /// The problem of a limb between the poses of its clip at two times (s), which limits admit.
    pub fn limb_problem(
        &self,
        who: usize,
        limb: Limb,
        around: &LimbSurroundings,
        window_s: [f64; 2],
    ) -> Result<Problem, ProblemError> {
        let others = self.other_bodies(who);
        Problem::prepare(&self.limb_spec(who, limb, around, &others).between_times(window_s))
    }

    /// Fails where a limb, whose name is given, has to be elsewhere within a window (s).
    pub fn check_unpinned(&self, who: usize, limb: Limb, name: &str, window_s: [f64; 2]) -> Result<(), StepFailure> {
        let is_within = |t: f64| t > window_s[0] + 1e-6 && t < window_s[1] - 1e-6;
        match self.pins.iter().find(|p| p.character == who && p.limb == limb && is_within(p.time_s)) {
            Some(Pin { time_s: t, .. }) => {
                Err(StepFailure::new(format!("{name} has to be elsewhere at {t:.2} s; begin then, or end before")))
            }
            None => Ok(()),
        }
    }

    /// Specification of a limb's problem, without ends.
    pub fn limb_spec<'s>(
        &'s self,
        who: usize,
        limb: Limb,
        around: &'s LimbSurroundings,
        others: &'s [OtherCharacter<'s>],
    ) -> ProblemSpec<'s> {
        let spec = self.actors[who].limb_spec(limb);
        let LimbSurroundings { solids, held, allowed, level } = around;
        ProblemSpec { solids, held, allowed, upright: *level, others, clearance_m: self.task.clearance_m, ..spec }
    }

    /// Records that a limb was planned.
    pub fn record_planned(&mut self, character: usize, limb: Limb, window_s: [f64; 2]) {
        let motion = &self.actors[character].motion;
        let ends = window_s.map(|t| motion.limb_pose(limb, t));
        self.planned_limbs.push(PlannedLimb { character, limb, window_s, ends });
    }
}

fn allow_contact(joint: Joint, with: &str) -> AllowedContact {
    AllowedContact { part: Some(joint.name().into()), other: with.into(), window_s: None }
}

/// The joint that holds things.
pub(super) fn hand_joint(limb: Limb) -> Joint {
    limb.joints()[2]
}

/// The arm that ends in a hand.
pub(super) fn arm_of_hand(joint: Joint) -> Option<Limb> {
    [Limb::LeftArm, Limb::RightArm].into_iter().find(|l| hand_joint(*l) == joint)
}

/// Middle of the hand in the hand's frame: where a fist closes (m).
pub(super) fn palm(skeleton: &Skeleton, limb: Limb) -> DVec3 {
    0.3 * skeleton.offsets[hand_joint(limb).index()].as_dvec3()
}
