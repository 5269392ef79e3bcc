//! Idling: who has arrived, or is ordered to stop, stands at ease in place of what a policy would have it do there.
//!
//! A policy's reward is the distance to a point, so that any standing motion is as good as another to it. Idle segments
//! are found when a bundle is baked ([`MotionSegment::idle`]). A character goes on in an idle clip as long as it lasts,
//! and at times of its own it changes to another one.

use super::block::{MotionBlock, NO_STATE};
use super::order::{PolicyOrder, StandOrder};
use super::{Characters, CharactersConfig, MotionSet, control::uniform_random, manner::Manners, pace};
use crate::graph::{MotionGraph, MotionSegment};
use crate::planar::{Planar, wrap_angle};
use crate::policy::{NO_ACTION, PolicyTable};
use crate::stops::REST;
use glam::Vec3;
use throng_base::{maths, simd::LANES};

/// Time between two changes of clip of a character that idles (s).
const CHANGE_S: [f32; 2] = [8.0, 20.0];
/// Error at which a transition between idle clips is e times less likely.
const ERROR: f32 = 0.15;
/// Distance between the feet of two clips at which a transition is e times less likely, and at which there is none without need
/// (m).
const FOOT_M: f32 = 0.04;
const FOOT_FAR_M: f32 = 0.07;
/// Idle time beyond which a clip is no likelier (s).
const LONG_S: f32 = 8.0;
/// Idle time below which a clip is left for a longer one (s).
const MOMENT_S: f32 = 1.5;
/// Likelihood of a stand in another manner, beside one in the same.
const OTHER_MANNER: f32 = 1e-9;
/// Distances from a target within which a character that would stand has arrived, and any other that can stand (m).
const NEAR_TARGET_M: [f32; 2] = [0.5, 0.3];
/// Largest displacement and turn of a segment that stays in its place (m, rad).
const STAYS: [f32; 2] = [0.15, 0.3];
/// Largest difference between the rates at which two characters idle.
const RATES: f32 = 0.08;
/// Distinguishes the draws of idling from those of other choices.
const DRAWS: u64 = 0x1D1E;

/// Most actions on the path to an idle one, largest displacement of each (m), and frames that an error of 1 is worth.
const MAX_PATH: usize = 8;
const PATH_STEP_M: f32 = 0.25;
pub(super) const ERROR_FRAMES: f32 = 60.0;
/// Cost of each frame that a stand lasts less than a long one (frames).
const SHORT: f32 = 1.0;

/// Error of the heading up to which a character turns no more, and up to which it faces where it is to (rad).
pub(super) const FACING: f32 = 0.15;
pub(super) const FACED: f32 = 0.26;
/// Cost of the time, the distance and the error of a turn (rad/s, rad/m, rad).
const TURN_COSTS: [f32; 3] = [0.1, 0.4, 0.3];
/// Turns to which paths are known, and error of the heading up to which a turn is taken for one of them (rad).
const TURNS: [f32; 7] = [-2.356, -1.571, -0.785, 0.785, 1.571, 2.356, std::f32::consts::PI];
pub(super) const TURN_MISSES: f32 = 0.45;
/// Least part of a turn for which motion is taken that turns less far (rad).
const PART: f32 = 0.35;
/// Longest turn that is looked at (s).
const LONGEST_TURN_S: f32 = 3.0;
/// Largest change of a turn on the spot so that it ends where it is to face, as a share of it.
const TURN_BEND: f32 = 0.25;

/// What follows a segment as its clip goes on, up to the next stand.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TurnToStand {
    /// Planar root at the stand as seen from the segment's first frame.
    pub by: Planar,
    /// (frames)
    pub frames: u32,
}

/// [`TurnToStand`] of every segment; zero frames where its clip does not come to a stand soon (num_segments).
pub(super) fn find_turns(graph: &MotionGraph, rate_hz: f32) -> Vec<TurnToStand> {
    let longest = (LONGEST_TURN_S * rate_hz) as u32;
    let mut out = vec![TurnToStand::default(); graph.segments.len()];
    // Segments ascend by start, and those that follow begin later.
    for (i, s) in graph.segments.iter().enumerate().rev() {
        let end = &graph.states[s.end as usize];
        let own = TurnToStand { by: s.displacement(), frames: s.num_frames };
        let next = graph.segments_of(s.end).first().filter(|&&n| graph.segments[n as usize].start == end.frame);
        let rest = next.map_or(TurnToStand::default(), |&n| out[n as usize]);
        out[i] = match end.standing {
            1 => own,
            _ if rest.frames == 0 || rest.frames + own.frames > longest => TurnToStand::default(),
            _ => TurnToStand { by: own.by.compose(rest.by), frames: own.frames + rest.frames },
        };
    }
    out
}

/// Paths over motion that hardly moves, to idle actions and to turns on the spot: the action to take in each state, or
/// [`NO_ACTION`].
#[derive(Clone, Debug, Default)]
pub(super) struct PathsToStand {
    /// To an idle action (num_states).
    to_idle: Vec<u8>,
    /// To turns by [`TURNS`] (num_states each).
    to_turns: Vec<Vec<u8>>,
}

impl PathsToStand {
    /// Finds the shortest paths; a short stand is worth a path to a longer one.
    pub fn find(graph: &MotionGraph, manners: &Manners, turns: &[TurnToStand], rate_hz: f32) -> Self {
        let find = |most_turn: f32, cost: &dyn Fn(u32) -> f32| {
            let least = |state: u32| {
                let changed = |s: u32| manners.change_frames(state, graph.segments[s as usize].end);
                graph.segments_of(state).iter().map(|&s| cost(s) + changed(s)).fold(f32::INFINITY, f32::min)
            };
            find_paths(graph, manners, (0..graph.states.len() as u32).map(least).collect(), most_turn)
        };
        let to_turn = |wanted: f32| {
            find(STAYS[1], &|s| {
                let to = &turns[s as usize];
                let left = wrap_angle(wanted - to.by.heading).abs();
                if to.frames > 0 && left < TURN_MISSES { to.frames as f32 + left * ERROR_FRAMES } else { f32::INFINITY }
            })
        };
        let long = LONG_S * rate_hz;
        let to_idle = find(f32::INFINITY, &|s| match graph.segments[s as usize].idle {
            0 => f32::INFINITY,
            idle => (long - idle as f32).max(0.0) * SHORT,
        });
        Self { to_idle, to_turns: TURNS.iter().map(|&wanted| to_turn(wanted)).collect() }
    }

    /// Action on the path to the turn that leaves least of one.
    ///
    /// - `most`: of it that may be left (rad).
    fn to_turn(&self, state: u32, turn: f32, most: f32) -> Option<u8> {
        let left = |k: &usize| wrap_angle(turn - TURNS[*k]).abs();
        let is_known = |k: &usize| self.to_turns[*k][state as usize] != NO_ACTION && left(k) < most;
        let best = (0..TURNS.len()).filter(is_known).min_by(|a, b| left(a).total_cmp(&left(b)))?;
        Some(self.to_turns[best][state as usize])
    }
}

/// Action that leads from each state on the cheapest path to one that has a cost of its own, over segments that turn no further
/// (rad).
fn find_paths(graph: &MotionGraph, manners: &Manners, mut costs: Vec<f32>, most_turn: f32) -> Vec<u8> {
    let mut out = vec![NO_ACTION; costs.len()];
    for _ in 0..MAX_PATH {
        let before = costs.clone();
        for (state, (least, first)) in costs.iter_mut().zip(&mut out).enumerate() {
            let (segments, errors) = graph.actions_of(state as u32);
            for (action, (&s, error)) in segments.iter().zip(errors).enumerate() {
                let s = &graph.segments[s as usize];
                let changed = manners.change_frames(state as u32, s.end);
                let cost = before[s.end as usize] + s.num_frames as f32 + ERROR_FRAMES * error + changed;
                let [x, z, heading] = s.displacement;
                if cost < *least && maths::hypot(x, z) < PATH_STEP_M && heading.abs() < most_turn {
                    (*least, *first) = (cost, action as u8);
                }
            }
        }
        if costs == before {
            break;
        }
    }
    out
}

/// A character that is about to choose, to see whether it stands.
pub(super) struct StandingChooser<'a> {
    pub b: &'a MotionBlock,
    pub lane: usize,
    pub state: u32,
    /// Planar root in the world.
    pub root: Planar,
    pub motion_set: &'a MotionSet,
    pub config: &'a CharactersConfig,
}

impl StandingChooser<'_> {
    /// Action in place of one that a policy chose: an idle one where the character has arrived.
    ///
    /// - `weight`: of the policy.
    /// - `target`: of the policy, in the character's frame (m).
    #[inline]
    pub fn replace_action(&self, policy: &PolicyTable, weight: f32, target: Vec3, chosen: u8) -> u8 {
        let reward = policy.reward().record();
        let left = (target.with_y(0.0).distance(policy.centre().with_y(0.0)) - reward.offset).abs();
        let [near, nearer] = NEAR_TARGET_M;
        if left > near || weight * reward.gain <= 0.0 || !policy.grid().is_polar() {
            return chosen;
        }
        let arrived = left < nearer || self.is_stand(chosen);
        if arrived { self.rest_action().unwrap_or(chosen) } else { chosen }
    }

    /// Action of a character that is ordered to stand, and the share by which its turn is bent (rad).
    pub fn choose_stand(&self, order: &PolicyOrder) -> (u8, f32) {
        let stop = &self.motion_set.stops.stops[self.state as usize];
        let segments = self.motion_set.graph.segments_of(self.state);
        let onwards = || segments.iter().position(|&s| s == stop.segment).unwrap_or(0) as u8;
        match order.stands {
            StandOrder::Follow => (0, 0.0),
            StandOrder::Stop => (self.rest_action().unwrap_or_else(onwards), 0.0),
            StandOrder::Turn(_) => {
                let turn = order.turn_left(self.root.heading);
                self.turn_action(turn).unwrap_or_else(|| (self.rest_action().unwrap_or_else(onwards), 0.0))
            }
        }
    }

    /// True while an idle segment is played.
    fn idles(&self) -> bool {
        self.segment(self.b.segment[self.lane]).idle > 0
    }

    fn segment(&self, number: u32) -> &MotionSegment {
        &self.motion_set.graph.segments[number as usize]
    }

    /// True of an action that stays where it is.
    fn is_stand(&self, action: u8) -> bool {
        let segment = self.segment(self.motion_set.graph.segments_of(self.state)[usize::from(action)]);
        let [x, z, heading] = segment.displacement;
        maths::hypot(x, z) < STAYS[0] && heading.abs() < STAYS[1]
    }

    fn number(&self) -> u64 {
        self.config.first_number.wrapping_add(self.b.name[self.lane])
    }

    /// True of an action with which one that idles goes on to do so.
    pub fn stays(&self, action: u8) -> bool {
        let next = self.segment(self.motion_set.graph.segments_of(self.state)[usize::from(action)]);
        self.idles() && next.idle >= next.num_frames
    }

    /// An idle action, or one on the way to a longer stand; `None` where any is far.
    fn rest_action(&self) -> Option<u8> {
        let action = self.motion_set.paths_to_stand.to_idle[self.state as usize];
        if self.long_onwards().is_none() && action != NO_ACTION { Some(action) } else { self.idle_action() }
    }

    /// The segment with which the clip goes on, if it idles.
    fn onwards(&self) -> Option<&MotionSegment> {
        let graph = &self.motion_set.graph;
        let next = graph.segments_of(self.state).first().map(|&s| self.segment(s));
        next.filter(|s| s.start == graph.states[self.state as usize].frame && s.idle > 0)
    }

    /// The segment with which the clip goes on, if it idles for some time yet. Who has a far longer stand in the same manner at
    /// hand does not wait for its end.
    fn long_onwards(&self) -> Option<&MotionSegment> {
        let (graph, rate) = (&self.motion_set.graph, self.motion_set.rate_hz);
        let own = graph.segments_of(self.state).iter().map(|&s| self.segment(s));
        let own = own.filter(|s| self.motion_set.manners.are_alike(self.state, s.end));
        let longest = own.map(|s| s.idle).max().unwrap_or(0) as f32;
        let enough = (0.5 * longest.min(LONG_S * rate)).max(MOMENT_S * rate);
        self.onwards().filter(|s| s.idle as f32 >= enough)
    }

    /// An idle action: the clip goes on while it idles, up to a time that is drawn; then a random one. `None` where the
    /// state has none.
    fn idle_action(&self) -> Option<u8> {
        let graph = &self.motion_set.graph;
        let (segments, errors) = graph.actions_of(self.state);
        let frame = graph.states[self.state as usize].frame;
        let goes_on = self.long_onwards();
        let [least, most] = CHANGE_S;
        let seed = self.config.seed ^ DRAWS;
        let draw = u64::from(self.b.change[1][self.lane]);
        let due_s = least + (most - least) * uniform_random(seed, self.number(), draw);
        if goes_on.is_some() && self.idles() && self.b.age_s[self.lane] < due_s {
            return Some(0);
        }
        let long = LONG_S * self.motion_set.rate_hz;
        let ankles = self.motion_set.ankles(frame);
        let weight = |(&s, &error): (&u32, &f32)| {
            let segment = self.segment(s);
            // Who goes on changes nothing.
            if segment.idle == 0 || segment.start == frame && self.idles() {
                return 0.0;
            }
            let manner = if self.motion_set.manners.are_alike(self.state, segment.end) { 1.0 } else { OTHER_MANNER };
            let to = self.motion_set.ankles(segment.start);
            let apart = (0..2).map(|k| to[k].distance_squared(ankles[k])).fold(0.0, f32::max);
            // Feet that are far from their clip take a step.
            if apart > FOOT_FAR_M * FOOT_FAR_M && goes_on.is_some() {
                return 0.0;
            }
            let differs = error * error / (ERROR * ERROR) + apart / (FOOT_M * FOOT_M);
            // Who changes often looks restless.
            let lasts = (segment.idle as f32).min(long);
            manner * maths::exp(-differs.min(50.0)) * lasts * lasts
        };
        let total: f32 = segments.iter().zip(errors).map(weight).sum();
        let mut left = total * uniform_random(seed, self.number(), u64::from(self.b.num_choices[self.lane]));
        let mut last = self.onwards().map(|_| 0);
        for (action, pair) in segments.iter().zip(errors).enumerate() {
            let weight = weight(pair);
            if weight > 0.0 {
                last = Some(action as u8);
                left -= weight;
                if left < 0.0 {
                    break;
                }
            }
        }
        last
    }

    /// The action that turns a standing character nearest to a heading, or leads to such a one, and how far it is bent;
    /// `None` where there is none, or it faces there.
    fn turn_action(&self, turn: f32) -> Option<(u8, f32)> {
        let r = self.motion_set;
        // Until it stands, it goes on with what it began.
        if turn.abs() < FACING {
            return None;
        }
        let path = |most: f32| Some((r.paths_to_stand.to_turn(self.state, turn, most)?, 0.0));
        let least = turn.abs() - PART;
        // Where no motion turns as far, it turns in parts.
        self.direct_turn(turn, TURN_MISSES)
            .or_else(|| path(TURN_MISSES))
            .or_else(|| self.direct_turn(turn, least))
            .or_else(|| path(least))
    }

    /// The action whose clip turns nearest to a heading, and how far it is bent.
    ///
    /// - `most`: of the turn that may be left (rad).
    fn direct_turn(&self, turn: f32, most: f32) -> Option<(u8, f32)> {
        let r = self.motion_set;
        let (segments, errors) = r.graph.actions_of(self.state);
        let [per_s, per_m, per_error] = TURN_COSTS;
        let mut best = (turn.abs() - FACING, None);
        for (action, (&s, &error)) in segments.iter().zip(errors).enumerate() {
            let to = r.turns[s as usize];
            if to.frames == 0 {
                continue;
            }
            let bent = bend_of(to.by.heading, turn);
            let left = wrap_angle(turn - to.by.heading - bent).abs();
            let distance = maths::hypot(to.by.x, to.by.z);
            let cost = left + per_s * to.frames as f32 / r.rate_hz + per_m * distance + per_error * error;
            if cost < best.0 && left < most {
                best = (cost, Some((action as u8, bent / to.frames as f32)));
            }
        }
        best.1
    }
}

impl Characters {
    /// True of a character that stays where it is: it idles, rests, or is held (character < num_characters).
    pub(super) fn is_at_rest(&self, motion_set: &MotionSet, character: usize) -> bool {
        let (b, lane) = (&self.blocks[character / LANES], character % LANES);
        let state = b.choice_state[lane];
        let rests = state != NO_STATE && motion_set.stops.stops[state as usize].kind == REST;
        let segment = b.segment[lane];
        b.pace[lane] == pace::HELD_STILL
            || motion_set.graph.segments[segment as usize].idle > 0
            || rests && motion_set.stops.stops[state as usize].segment == segment
    }
}

/// Change of a turn so that it ends nearer to where it is to face (rad).
fn bend_of(turns: f32, wanted: f32) -> f32 {
    let most = TURN_BEND * turns.abs();
    wrap_angle(wanted - turns).clamp(-most, most)
}

/// Rate at which a character idles, relative to that of its clip.
pub(super) fn idle_rate(name: u64, config: &CharactersConfig) -> f32 {
    1.0 + RATES * (uniform_random(config.seed ^ DRAWS, config.first_number.wrapping_add(name), 0) - 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::StateRecord;

    #[test]
    fn turns_are_followed_to_the_next_stand_and_ways_to_the_next_idle_action() {
        let state = |frame, standing| StateRecord { frame, standing };
        let segment = |start, end, heading, idle| MotionSegment {
            start,
            num_frames: 10,
            end,
            clip: 0,
            displacement: [0.0, 0.1, heading],
            idle,
        };
        let graph = MotionGraph {
            states: vec![state(10, 1), state(20, 0), state(30, 1)].into(),
            segments: vec![segment(0, 0, 0.0, 10), segment(10, 1, 0.5, 0), segment(20, 2, 0.6, 0)].into(),
            action_offsets: vec![0, 1, 2, 3].into(),
            action_segments: vec![1, 2, 0].into(),
            action_errors: vec![0.0; 3].into(),
        };
        let turns = find_turns(&graph, 30.0);
        let found: Vec<(u32, f32)> = turns.iter().map(|t| (t.frames, t.by.heading)).collect();
        assert_eq!(found, [(10, 0.0), (20, 1.1), (10, 0.6)]);
        let paths = PathsToStand::find(&graph, &Manners::default(), &turns, 1.0);
        assert_eq!(paths.to_idle, [0, 0, NO_ACTION]);
        assert_eq!([0, 1, 2].map(|state| paths.to_turn(state, 0.9, TURN_MISSES)), [None, None, Some(0)]);
        assert_eq!([0, 1, 2].map(|state| paths.to_turn(state, -1.5, TURN_MISSES)), [None; 3]);
        // A part of a turn that no motion turns as far as.
        assert_eq!([TURN_MISSES, 0.9].map(|most| paths.to_turn(2, 1.5, most)), [None, Some(0)]);
        // What takes longer than a turn may is no turn.
        assert_eq!(find_turns(&graph, 5.0)[1].frames, 0);
    }

    /// Action of somebody who idles in the first clip, at a state where that idles on for some frames, and another clip for others.
    ///
    /// - `in_another`: true where the other clip is in another manner.
    fn rest_between(onwards: u32, other: u32, in_another: bool) -> Option<u8> {
        let mut motion_set = MotionSet::new(&super::super::made_up::standing_tables());
        let segment = |start, idle| MotionSegment { start, num_frames: 10, idle, ..bytemuck::Zeroable::zeroed() };
        motion_set.graph = MotionGraph {
            states: [20, 90].map(|frame| StateRecord { frame, standing: 1 }).to_vec().into(),
            segments: vec![
                segment(10, onwards + 10),
                segment(20, onwards),
                MotionSegment { end: u32::from(in_another), ..segment(80, other) },
            ]
            .into(),
            action_offsets: vec![0, 2, 3].into(),
            action_segments: vec![1, 2, 2].into(),
            action_errors: vec![0.0, 0.1, 0.0].into(),
        };
        if in_another {
            motion_set.manners = Manners::made_up(&motion_set.graph).into();
        }
        let rate_hz = motion_set.rate_hz;
        motion_set.turns = find_turns(&motion_set.graph, rate_hz).into();
        motion_set.paths_to_stand =
            PathsToStand::find(&motion_set.graph, &motion_set.manners, &motion_set.turns, rate_hz).into();
        let b = MotionBlock { segment: [0; LANES], age_s: [1.0; LANES], ..MotionBlock::ZERO };
        let (root, config) = (Planar::IDENTITY, CharactersConfig::default());
        let chooser = StandingChooser { b: &b, lane: 0, state: 0, root, motion_set: &motion_set, config: &config };
        chooser.rest_action()
    }

    #[test]
    fn a_long_stand_goes_on_and_a_short_one_is_left_for_a_longer_one() {
        assert_eq!(rest_between(300, 300, false), Some(0));
        assert_eq!(rest_between(130, 900, false), Some(0), "two long ones");
        assert_eq!(rest_between(50, 300, false), Some(1), "a far longer one");
        assert_eq!(rest_between(20, 60, false), Some(1), "what lasts a moment");
        assert_eq!(rest_between(20, 0, false), Some(0), "nothing else");
        assert_eq!(rest_between(80, 900, true), Some(0), "one in another manner");
    }

    #[test]
    fn a_turn_is_bent_by_no_more_than_a_share_of_it() {
        assert!((bend_of(1.6, 1.5) + 0.1).abs() < 1e-6);
        assert!((bend_of(1.6, 3.0) - 0.4).abs() < 1e-6);
        assert!((bend_of(3.0, -3.0) - 0.283).abs() < 1e-3, "beyond half a turn");
        assert_eq!(bend_of(0.0, 2.0), 0.0);
    }
}
