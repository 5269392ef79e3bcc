//! Safe choices: the best action whose ground is clear, or the stop.

use super::super::block::{MotionBlock, SCHEDULED};
use super::super::control::{self, MAX_GOALS, OwnGoal};
use super::super::manner::{MannerName, OrderedChoice};
use super::super::transition::{SegmentChange, StartTransitionsJob};
use super::super::{ActionChoice, Characters, CharactersConfig, PolicyOrder, pace};
use super::path::{self, SegmentPlan};
use super::steer::{NUM_DIRECTIONS, SteeringQuery};
use super::{super::idle::StandingChooser, super::motion_set::MotionSet};
use super::{AvoidConfig, PathAvoidance, elapsed_s};
use crate::policy::{self, LookAheadJob, MAX_RANKED, NO_ACTION, RankedActions};
use crate::{body::RANGE_LEN, planar::Planar};
use glam::{Vec2, Vec3};
use std::cmp::Reverse;
use throng_base::maths;
use throng_base::simd::{LANES, dispatch};

/// Time after which a held character chooses again (frames).
const CHOOSE_AGAIN_FRAMES: f32 = 8.0;

/// Number of failed choices up to which a character waits rather than turn aside widely, and after which it takes any
/// action that leads away.
const WAITS: u32 = 3;
const DESPAIRS: u32 = 8;
/// See [`WAITS`] (rad).
const WIDE: f32 = 1.0;

/// Room that an action leaves around the place where it ends: a body that turns on the spot sways by as much (m). Each failed
/// choice takes a part of it, as far as a least one.
const TURNING_ROOM_M: f32 = 0.05;
const LEAST_ROOM_M: f32 = 0.015;

/// Shorter actions end where they begin (m).
const AWAY_M: f32 = 0.15;
/// Actions that turn by less do not turn (rad).
const TURN: f32 = 0.3;

/// Inputs of the choices of one step.
pub(crate) struct ChoiceInputs<'a> {
    pub motion_set: &'a MotionSet,
    pub config: &'a CharactersConfig,
    pub avoid: &'a AvoidConfig,
    pub orders: &'a [PolicyOrder],
}

impl Characters {
    /// Lets every character that has reached the end of its segment choose, one after the other in the order of time.
    pub(in super::super) fn choose_avoiding(&mut self, step: &ChoiceInputs<'_>) {
        let Self { avoiding: Some(avoiding), blocks, num_characters, .. } = self else { return };
        if avoiding.is_stale {
            // A character that was moved may overlap another one; the overlap ends as they move on.
            avoiding.rebuild_paths(blocks, *num_characters, step.motion_set);
        }
        for at in 0..*num_characters {
            avoiding.book.set_elapsed(at, elapsed_s(&blocks[at / LANES], at % LANES, step.motion_set));
        }
        (0..self.num_characters).for_each(|at| self.push_due(at));
        while let Some((ago, Reverse(at))) = self.avoiding.as_mut().and_then(|avoiding| avoiding.due.pop()) {
            self.choose_one(step, at as usize, f32::from_bits(ago));
            self.push_due(at as usize);
        }
    }

    /// Queues a character that has reached the end of a segment.
    fn push_due(&mut self, at: usize) {
        let (b, lane) = (&self.blocks[at / LANES], at % LANES);
        let ago = match b.pace[lane] {
            _ if b.segment[lane] == SCHEDULED => return,
            pace::HELD_STILL => -b.wait[lane],
            _ => b.time[lane] - b.length[lane] as f32,
        };
        if let Some(avoiding) = self.avoiding.as_mut().filter(|_| ago >= 0.0) {
            // Bits of floats that are not negative have their order; -0 has not.
            avoiding.due.push(((ago + 0.0).to_bits(), Reverse(at as u32)));
        }
    }

    /// Makes one choice.
    fn choose_one(&mut self, step: &ChoiceInputs<'_>, at: usize, ago: f32) {
        let Self { avoiding: Some(avoiding), blocks, bodies, passed, .. } = self else { return };
        let motion_set = step.motion_set;
        let (b, lane) = (&blocks[at / LANES], at % LANES);
        let state = motion_set.graph.segments[b.segment[lane] as usize].end;
        let root = b.root_at_end(lane, motion_set);
        let is_held = b.pace[lane] == pace::HELD_STILL;
        let ago_s = ago / motion_set.rate_hz;
        let (num_goals, goals) = control::active_goals(&step.orders[at], motion_set);
        let room_m = TURNING_ROOM_M * (1.0 - b.blocked[lane] as f32 / DESPAIRS as f32);
        let own = ChoosingCharacter {
            at,
            state,
            root,
            is_held: is_held || b.pace[lane] == pace::SLOWING,
            ago_s,
            floor_m: b.floor[lane],
            goals: &goals[..num_goals],
            step,
            // Opponents stand as near to each other as they were captured.
            room_m: if step.avoid.pairs_m.is_none() { room_m.max(LEAST_ROOM_M) } else { 0.0 },
        };
        let found = own.clear_plan(avoiding, b);
        let b = &mut blocks[at / LANES];
        b.blocked[lane] = match found {
            _ if own.order().is_to_stand() => 0,
            Some((_, true)) => 0,
            Some((plan, false)) if leads_away(plan, motion_set) => b.blocked[lane],
            _ => b.blocked[lane].saturating_add(1),
        };
        let plan = match found {
            Some((plan, _)) => plan,
            None if own.is_held => {
                // Nothing to play: it is held where it is.
                let plan = SegmentPlan { segment: b.segment[lane], pace: pace::HELD_STILL, bend: 0.0 };
                if !is_held {
                    plan.lay_path(None, root, motion_set, &mut avoiding.path);
                    avoiding.find_heights(b.floor[lane]);
                    avoiding.book.set(at, &avoiding.path, 0.0);
                    b.pace[lane] = pace::HELD_STILL;
                    b.time[lane] = b.length[lane] as f32;
                }
                b.wait[lane] = CHOOSE_AGAIN_FRAMES - ago;
                return;
            }
            None => {
                let plan = path::stop_of(state, motion_set);
                plan.lay_path(Some(state), root, motion_set, &mut avoiding.path);
                avoiding.find_heights(b.floor[lane]);
                plan
            }
        };
        let range = &mut passed[at / RANGE_LEN];
        let begin = control::SegmentBegin { at, state, root, plan, left: ago };
        let change = control::begin_segment(b, &begin, range, motion_set);
        avoiding.book.set(at, &avoiding.path, elapsed_s(b, lane, motion_set));
        if let Some(change) = change.filter(|_| bodies[at / LANES].awake == 1) {
            let group = &[SegmentChange { character: at as u32, ..change }];
            let half_life_s = step.config.half_life_s;
            dispatch(StartTransitionsJob { group, motion_set, half_life_s, bodies });
        }
    }
}

/// True of an action that does not end where it begins.
fn leads_away(plan: SegmentPlan, motion_set: &MotionSet) -> bool {
    let d = motion_set.graph.segments[plan.segment as usize].displacement();
    maths::hypot(d.x, d.z) > AWAY_M
}

/// True of an action that leads away or turns.
fn moves_root(plan: SegmentPlan, motion_set: &MotionSet) -> bool {
    leads_away(plan, motion_set) || motion_set.graph.segments[plan.segment as usize].displacement[2].abs() > TURN
}

/// The character that chooses.
struct ChoosingCharacter<'a> {
    at: usize,
    state: u32,
    root: Planar,
    /// True if it was stopped in the middle of its motion.
    is_held: bool,
    /// Time since the end of its segment (s).
    ago_s: f32,
    /// Height to which its floor is the nearest one (m).
    floor_m: f32,
    goals: &'a [OwnGoal],
    step: &'a ChoiceInputs<'a>,
    /// Room around the place where its action ends (m).
    room_m: f32,
}

impl ChoosingCharacter<'_> {
    /// Best action whose ground is clear, and whether it is the action that it would take without others; its path is
    /// left in `avoiding.path`.
    fn clear_plan(&self, avoiding: &mut PathAvoidance, b: &MotionBlock) -> Option<(SegmentPlan, bool)> {
        let motion_set = self.step.motion_set;
        let segments = motion_set.graph.segments_of(self.state);
        let (order, chooser) = (self.order(), self.standing_chooser(b));
        let first = match self.goals {
            _ if order.manner == MannerName::NONE && order.speed_mps.is_none() => NO_ACTION,
            [] => chooser.choose_stand(order).0,
            _ => self.ranked_actions(b, 0.0)[0],
        };
        let stays = first != NO_ACTION && chooser.stays(first);
        let seen = |goal: &OwnGoal| self.target_seen_turned(goal, 0.0);
        let left = match self.goals {
            [goal] => control::way_left(motion_set, goal.policy, seen(goal)),
            _ => None,
        };
        let aims = |goal: &OwnGoal| (&motion_set.policies[goal.policy], goal.weight, seen(goal));
        let worth = |segment| self.goals.iter().map(|g| control::worth_after(segment, aims(g))).sum();
        let choice = OrderedChoice { motion_set, order, state: self.state, chosen: first, stays, left };
        if let Some(ranked) = choice.preferred(worth) {
            let num_tried = if stays { 1 } else { MAX_RANKED };
            let known = ranked.into_iter().take(num_tried);
            let known = known.filter(|&action| action != NO_ACTION && (!stays || chooser.stays(action)));
            let mut plans = known.map(|action| self.segment_plan(segments[usize::from(action)], 0.0));
            if let Some(plan) = plans.find(|&plan| self.is_clear(plan, avoiding)) {
                return Some((plan, true));
            }
        }
        if order.is_to_stand() {
            let (action, bend) = chooser.choose_stand(order);
            let segment = segments[usize::from(action)];
            let stop = path::stop_of(self.state, motion_set);
            if segment == stop.segment && motion_set.graph.segments[segment as usize].idle == 0 {
                return None;
            }
            let plan = SegmentPlan { bend, ..self.segment_plan(segment, 0.0) };
            return self.is_clear(plan, avoiding).then_some((plan, true));
        }
        let turns = match self.goals.first() {
            Some(goal) if self.can_turn(goal) => {
                let chooser = SteeringQuery {
                    number: self.at,
                    place: Vec2::new(self.root.x, self.root.z),
                    target: Vec2::new(goal.target.x, goal.target.z),
                    speed_mps: avoiding.speed_mps,
                    ago_s: self.ago_s,
                    book: &avoiding.book,
                    config: self.step.avoid,
                };
                chooser.ranked_directions(&avoiding.turns)
            }
            _ => [0.0; NUM_DIRECTIONS],
        };
        let patience = b.blocked[self.at % LANES];
        let mut tried = [0u64; 4];
        let mut ranked = [None; NUM_DIRECTIONS];
        for k in 0..MAX_RANKED {
            for (i, turn) in turns.into_iter().enumerate() {
                if turns[..i].contains(&turn) || patience < WAITS && turn.abs() > WIDE {
                    continue;
                }
                let action = ranked[i].get_or_insert_with(|| self.ranked_actions(b, turn))[k];
                if action != NO_ACTION && self.is_first(action, &mut tried) {
                    let plan = self.segment_plan(segments[usize::from(action)], turn);
                    if self.is_clear(plan, avoiding) {
                        return Some((plan, (i, k) == (0, 0) && turn == 0.0));
                    }
                }
            }
        }
        if patience < DESPAIRS {
            return None;
        }
        // Any action that leads away, whatever its value.
        let begin = patience as usize % segments.len();
        let others = (begin..segments.len()).chain(0..begin).map(|action| action as u8);
        let plans =
            others.filter(|&a| self.is_first(a, &mut tried)).map(|a| self.segment_plan(segments[usize::from(a)], 0.0));
        let mut plans = plans.filter(|&plan| moves_root(plan, motion_set));
        plans.find(|&plan| self.is_clear(plan, avoiding)).map(|plan| (plan, false))
    }

    fn order(&self) -> &PolicyOrder {
        &self.step.orders[self.at]
    }

    fn standing_chooser<'a>(&'a self, b: &'a MotionBlock) -> StandingChooser<'a> {
        let ChoiceInputs { motion_set, config, .. } = *self.step;
        StandingChooser { b, lane: self.at % LANES, state: self.state, root: self.root, motion_set, config }
    }

    /// Notes that an action is tried; false where it has been.
    fn is_first(&self, action: u8, tried: &mut [u64; 4]) -> bool {
        let (word, bit) = (usize::from(action) / 64, 1u64 << (action % 64));
        let is_first = tried[word] & bit == 0;
        tried[word] |= bit;
        is_first
    }

    /// Pace and bending with which an action would be played.
    fn segment_plan(&self, segment: u32, turn: f32) -> SegmentPlan {
        let new = &self.step.motion_set.graph.segments[segment as usize];
        match self.goals.first() {
            _ if self.is_held => SegmentPlan { segment, pace: pace::STARTING, bend: 0.0 },
            None => SegmentPlan { segment, pace: control::pace_of(new), bend: 0.0 },
            Some(goal) => {
                let (policy, target) =
                    (&self.step.motion_set.policies[goal.policy], self.target_seen_turned(goal, turn));
                let bend = policy.bend(segment, target) / new.num_frames as f32;
                SegmentPlan { segment, pace: control::pace_of(new), bend }
            }
        }
    }

    /// True where the ground of a plan is clear, with room where it ends; its path is left in `avoiding.path`.
    fn is_clear(&self, plan: SegmentPlan, avoiding: &mut PathAvoidance) -> bool {
        plan.lay_path(Some(self.state), self.root, self.step.motion_set, &mut avoiding.path);
        avoiding.find_heights(self.floor_m);
        let end = avoiding.path.nodes.len() - 1;
        let radius_m = avoiding.path.nodes[end].radius_m;
        avoiding.path.nodes[end].radius_m += self.room_m;
        let is_clear = avoiding.book.is_clear(self.at, &avoiding.path, self.ago_s);
        avoiding.path.nodes[end].radius_m = radius_m;
        is_clear
    }

    /// A target on the ground around which there is no matter of blows may be turned aside.
    fn can_turn(&self, goal: &OwnGoal) -> bool {
        self.step.motion_set.policies[goal.policy].grid().is_polar() && goal.weight > 0.0
    }

    /// A target in the character's frame, turned aside about the character.
    fn target_seen_turned(&self, goal: &OwnGoal, turn: f32) -> Vec3 {
        let turn = if self.can_turn(goal) { turn } else { 0.0 };
        let local = self.root.inverse_transform_point(Vec2::new(goal.target.x, goal.target.z));
        let (sin, cos) = (maths::sin(turn), maths::cos(turn));
        Vec3::new(local.x * cos + local.y * sin, goal.target.y, local.y * cos - local.x * sin)
    }

    /// The best actions towards a target that is turned aside; who has arrived idles first.
    fn ranked_actions(&self, b: &MotionBlock, turn: f32) -> [u8; MAX_RANKED] {
        let mut actions = self.policy_actions(b, turn);
        if let ([goal], true) = (self.goals, turn == 0.0 && actions[0] != NO_ACTION) {
            let (policy, target) = (&self.step.motion_set.policies[goal.policy], self.target_seen_turned(goal, turn));
            let first = self.standing_chooser(b).replace_action(policy, goal.weight, target, actions[0]);
            if first != actions[0] {
                actions.rotate_right(1);
                actions[0] = first;
            }
        }
        actions
    }

    /// The best actions towards a target that is turned aside, by the policies.
    fn policy_actions(&self, b: &MotionBlock, turn: f32) -> [u8; MAX_RANKED] {
        let (motion_set, config) = (self.step.motion_set, self.step.config);
        let mut actions = [NO_ACTION; MAX_RANKED];
        if self.goals.is_empty() {
            actions[0] = 0;
            return actions;
        }
        let mut targets = [[Vec3::ZERO]; MAX_GOALS];
        let mut weights = [[0.0]; MAX_GOALS];
        for (g, goal) in self.goals.iter().enumerate() {
            targets[g] = [self.target_seen_turned(goal, turn)];
            let active = motion_set.policies[goal.policy].region().contains(targets[g][0]);
            weights[g] = [if active { goal.weight } else { 0.0 }];
        }
        if config.choice == ActionChoice::BestAction && self.goals.len() == 1 {
            let policy = &motion_set.policies[self.goals[0].policy];
            let best = policy.best_of(self.state, policy.nearest_cell(self.state, targets[0][0]));
            actions.iter_mut().zip(best).for_each(|(to, from)| *to = *from);
            return actions;
        }
        let jobs: [policy::LookAheadGoal<'_>; MAX_GOALS] = std::array::from_fn(|g| {
            let g = g.min(self.goals.len() - 1);
            policy::LookAheadGoal {
                policy: &motion_set.policies[self.goals[g].policy],
                weights: &weights[g],
                targets: &targets[g],
            }
        });
        let mut ranked = [RankedActions::NONE];
        let job = LookAheadJob { goals: &jobs[..self.goals.len()], states: &[self.state], ranked: &mut ranked };
        job.run().unwrap_or_else(|e| unreachable!("states come from the tables, targets were checked: {e}"));
        actions = ranked[0].actions;
        if let ActionChoice::LookAhead { temperature } = config.choice {
            let lane = self.at % LANES;
            let chosen = ranked[0].choose(temperature, control::draw_random(b, lane, config));
            // The drawn one first, then the others by rank.
            if let Some(k) = actions.iter().position(|&a| a == chosen) {
                actions[..=k].rotate_right(1);
            }
        }
        actions
    }
}
