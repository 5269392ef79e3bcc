//! State of a task while it is worked on: clips as they are by now, and the place of every thing at every time.

use super::file::{Character, Start, Task};
use super::held::capsules;
use super::step::{Anchor, Place};
use crate::body::BodyShape;
use crate::correct::{Span, collisions};
use crate::driven::Driven;
use crate::limits::BodyLimits;
use crate::linkage::{Limb, LimbPose, Linkage};
use crate::problem::{PRESENT_STEP_S, Problem, Solid, State};
use crate::rotation::{Rigid, about};
use crate::setup::{Allowed, Held, Level, Other, ProblemSpec};
use crate::shape::Shape;
use crate::track::{Clock, Path as Motion, Track};
use crate::worn::Worn;
use glam::{DVec3, Quat};
use std::f64::consts::TAU;
use std::sync::Arc;
use throng_base::maths;
use throng_core::{Joint, NUM_JOINTS, Skeleton};
use throng_motion::Clip;

/// Number of turns that are tried for something upright whose turn is open.
const NUM_TURNS: u32 = 24;
/// Most things that stand on one another.
const MAX_STACK: usize = 8;
/// Most passes over a clip that search for collisions of a limb by itself.
const MOST_LOOKS: usize = 64;
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
pub(super) struct Actor {
    /// The clip as it was, placed in the scene.
    pub before: Clip,
    /// The clip with what was planned.
    pub clip: Clip,
    pub skeleton: Skeleton,
    pub limits: BodyLimits,
    pub shape: BodyShape,
    pub motion: Driven,
    /// Mesh that it wears, which others collide with in place of its capsules.
    pub worn: Option<Worn>,
    /// Collisions of limbs by the clip itself, in which they stay.
    pub pressed: Vec<(Limb, Allowed)>,
}

/// Placement of a thing from a time on.
#[derive(Clone, Debug)]
pub(super) struct Stretch {
    pub from_s: f64,
    pub at: Whereabouts,
}

/// Placement of a thing.
#[derive(Clone, Debug)]
pub(super) enum Whereabouts {
    Path(Motion),
    /// Carried by a joint; `holder` is the arm whose hand it is, `second` the other one that holds it, too.
    On {
        character: usize,
        joint: Joint,
        offset: Rigid,
        holder: Option<Limb>,
        second: Option<Follower>,
    },
    OnThing {
        thing: usize,
        offset: Rigid,
    },
}

/// The second hand at a thing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Follower {
    pub limb: Limb,
    /// Transform of its hand, relative to the first one.
    pub grip: Rigid,
}

/// A limb that was planned.
#[derive(Clone, Debug)]
pub(super) struct Planned {
    pub character: usize,
    pub limb: Limb,
    pub window_s: [f64; 2],
    /// Poses at both ends.
    pub ends: [LimbPose; 2],
}

/// A gaze of a character at the target of a limb.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Looked {
    /// Index of the character.
    pub character: usize,
    /// Times at which the head leaves the clip, the limb is at its target, and the head is back (s).
    pub times_s: [f64; 3],
    /// Position of the target when the limb is there (m).
    pub at: DVec3,
}

/// A bend of a character's trunk for a limb.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaned {
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
pub(super) struct Stage<'a> {
    pub task: &'a Task,
    pub actors: Vec<Actor>,
    /// Placements of every thing.
    pub lives: Vec<Vec<Stretch>>,
    /// Contacts that limbs are allowed by their actions.
    pub contacts: Vec<(usize, Limb, Allowed)>,
    pub planned: Vec<Planned>,
    pub pins: Vec<Pin>,
    pub looked: Vec<Looked>,
    pub leaned: Vec<Leaned>,
}

/// Surroundings of a limb in a stretch of time.
#[derive(Clone, Debug, Default)]
pub(super) struct Surroundings {
    pub solids: Vec<Solid>,
    pub held: Vec<Held>,
    pub allowed: Vec<Allowed>,
    pub level: Option<Level>,
}

impl Actor {
    fn new(actor: &ActorClip, character: &Character) -> Self {
        let placed = &character.placed;
        let (mut clip, skeleton) = (actor.clip.clone(), actor.skeleton.clone());
        if *placed != Rigid::IDENTITY {
            let turn: Quat = placed.rotation.as_quat();
            clip.root_positions.iter_mut().for_each(|p| *p = placed.point(p.as_dvec3()).as_vec3());
            clip.rotations.iter_mut().step_by(NUM_JOINTS).for_each(|q| *q = maths::compose(turn, *q).normalize());
        }
        let motion = driven(&clip, &skeleton);
        let limits = BodyLimits::built_in(&skeleton);
        // What was read fits one skeleton, and so all.
        let worn = character.body.as_ref().and_then(|b| Worn::of(&b.figure, &skeleton).ok());
        let shape = worn.as_ref().map_or_else(|| BodyShape::fitted(&skeleton), |w| w.capsules(&skeleton));
        let mut actor = Self { before: clip.clone(), clip, skeleton, limits, shape, motion, worn, pressed: Vec::new() };
        actor.pressed = Limb::ALL.iter().flat_map(|l| actor.presses(*l)).collect();
        actor
    }

    /// Collisions of a limb by the clip itself, in which it stays: an upper arm or thigh in the trunk, as flesh gives way;
    /// other parts where they are hardly in it, or where the clip begins or ends so, as there is no free pose to come from.
    fn presses(&self, limb: Limb) -> Vec<(Limb, Allowed)> {
        let mut allowed: Vec<Allowed> = Vec::new();
        let first = limb.joints()[0].name();
        // Times up to which a collision at the beginning lasts, and from which one at the end does.
        let mut ends = [f64::NEG_INFINITY, f64::INFINITY];
        // Each pass finds the deepest collision of a part: the one behind it comes next.
        for _ in 0..MOST_LOOKS {
            let spec = ProblemSpec { allowed: &allowed, ..self.spec(limb) };
            let Ok(problem) = Problem::prepare(&spec) else { break };
            let found = collisions(&problem);
            if allowed.is_empty() {
                let reaches = |s: &&Span| [s.from_s < PRESS_S, s.to_s > self.end_s() - PRESS_S];
                ends[0] = found.iter().filter(|s| reaches(s)[0]).fold(ends[0], |t, s| t.max(s.to_s + PRESS_S));
                ends[1] = found.iter().filter(|s| reaches(s)[1]).fold(ends[1], |t, s| t.min(s.from_s - PRESS_S));
            }
            let at_an_end = |s: &Span| s.to_s < ends[0] || s.from_s > ends[1];
            let stays = |s: &Span| s.part == first || s.depth_m < PRESS_M || at_an_end(s);
            let before = allowed.clone();
            for Span { from_s, to_s, part, with, .. } in found.into_iter().filter(stays) {
                let window = (part != first).then_some([from_s - PRESS_S, to_s + PRESS_S]);
                let part = Some(part);
                match allowed.iter_mut().find(|a| a.part == part && a.with == with) {
                    Some(known) => {
                        let both = known.window_s.zip(window);
                        known.window_s = both.map(|(a, b)| [a[0].min(b[0]), a[1].max(b[1])]);
                    }
                    None => allowed.push(Allowed { part, with, window_s: window }),
                }
            }
            if allowed == before {
                break;
            }
        }
        allowed.into_iter().map(|a| (limb, a)).collect()
    }

    /// Specification of a limb over the whole clip, in an empty world.
    fn spec(&self, limb: Limb) -> ProblemSpec<'_> {
        let linkage = Linkage::limb(limb);
        let ends = [0.0, self.end_s()].map(|time_s| State { pose: self.motion.limb_pose(linkage, time_s), time_s });
        ProblemSpec::new(&self.skeleton, linkage, &self.limits, &self.motion, &self.shape, ends)
    }

    /// Replaces the clip.
    pub fn change(&mut self, clip: Clip) {
        self.motion = driven(&clip, &self.skeleton);
        self.clip = clip;
    }

    pub fn end_s(&self) -> f64 {
        self.clip.num_frames().saturating_sub(1) as f64 / self.clip.rate_hz
    }

    /// Transform of a joint at a time.
    pub fn joint(&self, joint: Joint, time_s: f64) -> Rigid {
        let places = self.motion.places();
        let [from, to] = self.motion.window_s();
        let at =
            ((time_s - from) / (to - from).max(1e-9) * (places.len() - 1) as f64).clamp(0.0, (places.len() - 1) as f64);
        let i = (at + 1e-6) as usize;
        let next = (i + 1).min(places.len() - 1);
        places[i][joint.index()].lerp(&places[next][joint.index()], (at - i as f64).max(0.0))
    }
}

fn driven(clip: &Clip, skeleton: &Skeleton) -> Driven {
    Driven::of_clip(clip, skeleton, 0.0, clip.num_frames().saturating_sub(1) as f64 / clip.rate_hz)
}

impl<'a> Stage<'a> {
    /// The state of a task before anything was planned.
    pub fn new(task: &'a Task, clips: &[ActorClip]) -> Self {
        let actors = clips.iter().zip(&task.characters).map(|(c, who)| Actor::new(c, who)).collect();
        let life = |start: &Start| {
            let at = match start {
                Start::Path(path) => Whereabouts::Path(path.clone()),
                Start::On { character, joint, offset } => {
                    let holder = [Limb::LeftArm, Limb::RightArm].into_iter().find(|l| hand(*l) == *joint);
                    Whereabouts::On { character: *character, joint: *joint, offset: *offset, holder, second: None }
                }
            };
            vec![Stretch { from_s: f64::NEG_INFINITY, at }]
        };
        let lives = task.things.iter().map(|t| life(&t.start)).collect();
        let (contacts, planned, pins) = (Vec::new(), Vec::new(), Vec::new());
        Self { task, actors, lives, contacts, planned, pins, looked: Vec::new(), leaned: Vec::new() }
    }

    /// The end of the last clip (s).
    pub fn end_s(&self) -> f64 {
        self.actors.iter().map(Actor::end_s).fold(0.0, f64::max)
    }

    /// Placement of a thing at a time; at a change, the one after it.
    pub fn stretch(&self, thing: usize, time_s: f64) -> &Whereabouts {
        let life = &self.lives[thing];
        let i = life.iter().rposition(|s| s.from_s <= time_s + 1e-6).unwrap_or(0);
        &life[i].at
    }

    /// Transform of a thing at a time.
    pub fn place(&self, thing: usize, time_s: f64) -> Rigid {
        self.place_in(self.stretch(thing, time_s), time_s, 0)
    }

    /// Transform of a thing with a placement.
    pub fn place_in(&self, at: &Whereabouts, time_s: f64, depth: usize) -> Rigid {
        match at {
            Whereabouts::Path(path) => path.at(time_s),
            Whereabouts::On { character, joint, offset, .. } => {
                self.actors[*character].joint(*joint, time_s).then(*offset)
            }
            Whereabouts::OnThing { thing, offset } if depth < MAX_STACK => {
                self.place_in(self.stretch(*thing, time_s), time_s, depth + 1).then(*offset)
            }
            Whereabouts::OnThing { offset, .. } => *offset,
        }
    }

    /// Frame from which a place is seen.
    pub fn base_of(&self, place: &Place, time_s: f64) -> Rigid {
        match place.on {
            Anchor::World => Rigid::IDENTITY,
            Anchor::Thing(thing) => self.place(thing, time_s),
            Anchor::Joint(who, joint) => self.actors[who].joint(joint, time_s),
        }
    }

    /// Transforms of a place: one, or many upright ones where its turn is open.
    pub fn resolve(&self, place: &Place, time_s: f64) -> Vec<Rigid> {
        let at = self.base_of(place, time_s).then(place.offset);
        let turns = if place.any_turn { NUM_TURNS } else { 1 };
        let turn = |k: u32| about(DVec3::Y, TAU * f64::from(k) / f64::from(turns));
        (0..turns).map(|k| at.then(Rigid { position: DVec3::ZERO, rotation: turn(k) })).collect()
    }

    /// The thing in a hand at a time, and its transform relative to the hand.
    pub fn held_by(&self, who: usize, limb: Limb, time_s: f64) -> Option<(usize, Rigid)> {
        (0..self.lives.len()).find_map(|thing| match self.stretch(thing, time_s) {
            Whereabouts::On { character, holder, offset, .. } if *character == who && *holder == Some(limb) => {
                Some((thing, *offset))
            }
            _ => None,
        })
    }

    /// The thing that two hands hold, one of which is a limb's, at some time of a stretch; the leading hand, and the following
    /// one.
    pub fn held_by_both(&self, who: usize, limb: Limb, [from_s, to_s]: [f64; 2]) -> Option<(usize, Limb, Follower)> {
        self.lives.iter().enumerate().find_map(|(thing, life)| {
            life.iter().enumerate().find_map(|(i, s)| match &s.at {
                Whereabouts::On { character, holder: Some(lead), second: Some(second), .. }
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
    pub fn path(&self, thing: usize) -> Motion {
        if let [Stretch { at: Whereabouts::Path(path), .. }] = &self.lives[thing][..] {
            return path.clone();
        }
        // Samples of a clip, if one moves the thing.
        let even = |a: &Actor| match a.motion.clock() {
            Clock::Even { step_s, .. } if a.motion.places().len() > 1 => Some(step_s),
            _ => None,
        };
        let step_s = self.actors.iter().find_map(even).unwrap_or(PRESENT_STEP_S);
        let clock = Clock::Even { start_s: 0.0, step_s };
        let count = (self.end_s() / step_s).ceil() as usize + 1;
        let samples = (0..count).map(|i| self.place(thing, i as f64 * step_s)).collect();
        Motion::Track(Arc::new(Track::rigid(clock, samples)))
    }

    /// Surroundings of a limb, and contacts that it is allowed.
    pub fn around(&self, who: usize, limb: Limb, [from_s, to_s]: [f64; 2]) -> Surroundings {
        let mut out = Surroundings::default();
        let middle = 0.5 * (from_s + to_s);
        for (i, thing) in self.task.things.iter().enumerate() {
            match self.stretch(i, middle) {
                Whereabouts::On { character, holder, offset, .. } if *character == who && *holder == Some(limb) => {
                    let all = thing.shapes.iter().flat_map(capsules);
                    out.held.extend(all.map(|(core, radius)| Held {
                        name: thing.name.clone(),
                        core: core.map(|p| offset.point(p)),
                        radius,
                    }));
                }
                at => {
                    let path = self.path(i);
                    let solid = |s: &crate::shape::Shape| Solid {
                        name: thing.name.clone(),
                        shape: s.clone(),
                        path: path.clone(),
                    };
                    out.solids.extend(thing.shapes.iter().map(solid));
                    if matches!(at, Whereabouts::On { character, .. } if *character == who) {
                        let driven = Joint::ALL.into_iter().filter(|j| !limb.moves(*j));
                        out.allowed.extend(driven.map(|j| may(j, &thing.name)));
                    }
                }
            }
        }
        for (name, other) in self.others(who) {
            let pieces = other.worn.iter().flat_map(|w| &w.pieces);
            out.solids.extend(pieces.map(|(joint, mesh)| Solid {
                name: name.clone(),
                shape: Shape::Mesh(Arc::clone(mesh)),
                path: Motion::Track(Arc::new(Track::rigid(other.motion.clock(), other.motion.of_joint(*joint)))),
            }));
        }
        out.allowed.extend(self.actors[who].pressed.iter().filter(|(l, _)| *l == limb).map(|(_, a)| a.clone()));
        self.leave_to_others(who, limb, &mut out);
        let known = |a: &Allowed| {
            let part =
                a.part.as_ref().is_none_or(|p| Joint::from_name(p).is_some() || out.held.iter().any(|h| h.name == *p));
            let with = Joint::from_name(&a.with).is_some()
                || out.solids.iter().any(|s| s.name == a.with)
                || self.others(who).any(|(name, _)| *name == a.with);
            part && with
        };
        let overlaps = |a: &Allowed| a.window_s.is_none_or(|[a, b]| a < to_s && b > from_s);
        let own = self.contacts.iter().filter(|(w, l, a)| *w == who && *l == limb && overlaps(a)).map(|c| c.2.clone());
        let allowed: Vec<Allowed> = own.chain(out.allowed.iter().cloned()).filter(known).collect();
        out.allowed = allowed;
        out
    }

    /// Allows contacts of the character's other limbs that have steps of their own: those steps check them.
    fn leave_to_others(&self, who: usize, limb: Limb, out: &mut Surroundings) {
        let receivers = self.task.steps.iter().filter_map(|s| s.receiver.as_ref()).map(|r| (r.character, r.limb));
        let seconds = self.task.steps.iter().filter_map(|s| Some((s.character, s.second.as_ref()?.limb)));
        let limbs = self.task.steps.iter().map(|s| (s.character, s.limb)).chain(receivers).chain(seconds);
        let mut others: Vec<Limb> = limbs.filter(|(w, l)| *w == who && *l != limb).map(|(_, l)| l).collect();
        others.sort();
        others.dedup();
        let mut names: Vec<&str> = self.task.things.iter().map(|t| t.name.as_str()).collect();
        names.extend(self.others(who).map(|(name, _)| name.as_str()));
        for joint in Joint::ALL.into_iter().filter(|j| others.iter().any(|l| l.moves(*j))) {
            out.allowed.extend(names.iter().map(|name| may(joint, name)));
        }
    }

    fn others(&self, who: usize) -> impl Iterator<Item = (&String, &Actor)> {
        let all = self.task.characters.iter().zip(&self.actors).enumerate();
        all.filter(move |(i, _)| *i != who).map(|(_, (c, actor))| (&c.name, actor))
    }

    /// All other characters whose meshes are not part of the [surroundings](Stage::around).
    pub fn other_bodies(&self, who: usize) -> Vec<Other<'_>> {
        let all = self.others(who).filter(|(_, a)| a.worn.is_none());
        all.map(|(name, a)| Other { name, motion: &a.motion, shape: &a.shape }).collect()
    }

    /// All other characters, as capsules.
    pub fn other_capsules(&self, who: usize) -> Vec<Other<'_>> {
        self.others(who).map(|(name, a)| Other { name, motion: &a.motion, shape: &a.shape }).collect()
    }

    /// Specification of a limb's problem, without ends.
    pub fn spec<'s>(
        &'s self,
        who: usize,
        limb: Limb,
        around: &'s Surroundings,
        others: &'s [Other<'s>],
    ) -> ProblemSpec<'s> {
        let spec = self.actors[who].spec(limb);
        let Surroundings { solids, held, allowed, level } = around;
        ProblemSpec { solids, held, allowed, level: *level, others, clearance_m: self.task.clearance_m, ..spec }
    }

    /// Records that a limb was planned.
    pub fn note(&mut self, character: usize, limb: Limb, window_s: [f64; 2]) {
        let motion = &self.actors[character].motion;
        let ends = window_s.map(|t| motion.limb_pose(Linkage::limb(limb), t));
        self.planned.push(Planned { character, limb, window_s, ends });
    }
}

fn may(joint: Joint, with: &str) -> Allowed {
    Allowed { part: Some(joint.name().into()), with: with.into(), window_s: None }
}

/// The joint that holds things.
pub(super) fn hand(limb: Limb) -> Joint {
    limb.joints()[2]
}

/// Middle of the hand in the hand's frame: where a fist closes (m).
pub(super) fn palm(skeleton: &Skeleton, limb: Limb) -> DVec3 {
    let fore = skeleton.offsets[hand(limb).index()].as_dvec3();
    0.3 * fore
}
