//! Control: a character that reaches the end of its motion in this step decides on the next one.
//!
//! Decisions are made in the order of the characters, on one thread; they are few.

use super::chains::{APART_M, ChainSchedule, MAX_CHAIN, MAX_OPENED, SafetySearch};
use super::config::{InhabitantActivity, InhabitantGoal};
use super::reservations::{EXTERNAL_HOLDER, follow_nobody};
use super::{InhabitantEvent, Inhabitants, purpose::Purpose, schedule};
use crate::plan::{PlanTarget, SearchResult, SearchSpace, TOLL_TRIES};
use crate::{World, WorldGraph, WorldStep};
use throng_base::{Result, thresholds::WALK_SPEED_MPS};
use throng_core::{characters::uniform_random, patch::LinkRecord};

/// Random steps that are tried before those that need no search are taken.
const TRIES: usize = 4;
/// Least distance from its place at which a roaming character that has rested comes to rest again (m).
const LEAST_LEAVE_M: f32 = 1.0;
/// Most times that a detour doubles.
pub(super) const MAX_IMPATIENCE: u32 = 3;
/// Times that a character loses patience before it stays blocked: in all, and behind characters that stay.
pub(super) const MAX_TRIES: u32 = 20;
const MAX_TRIES_STAYING: u32 = 3;
/// Steps of its path after which a character is patient again.
pub(super) const CALM_AFTER: u32 = 6;
/// Factor on the patience of two characters that block each other's paths: of the one that yields, and of the other.
const YIELD_CHANCE: f32 = 0.25;
const INSISTS: f32 = 4.0;
/// Extra cost of an instance that others hold, for a character that lost patience (frames).
const TOLL: f32 = 120.0;
/// Extra cost of an instance where others stay, likewise (frames).
const TOLL_OF_WHO_STAYS: f32 = 3000.0;

impl Inhabitants {
    pub(super) fn control_all(&mut self, world: &World, dt_s: f32) -> Result<()> {
        let (motion_set, graph) = (world.motion_set(), world.graph());
        self.plan_paths(graph);
        self.begin_meetings(graph);
        let frames = dt_s * self.rate_hz;
        for c in 0..self.states.len() {
            while self.characters.frames_left(c) <= frames {
                let Some(step) = self.decide_step(graph, c) else { break };
                let from = std::mem::replace(&mut self.states[c].at, step.to);
                let left = std::mem::replace(&mut self.states[c].through, [from.instance, step.instance]);
                self.states[c].plays_pair = graph.link(&step).is_some_and(LinkRecord::is_for_two);
                let root = self.characters.scheduled_end(motion_set, c);
                let Some(scheduled_clip) = schedule::scheduled_clip(world, &step, Some(root)) else { break };
                self.characters.schedule_clip(motion_set, c, &scheduled_clip)?;
                self.release_units(graph, c, left);
            }
        }
        self.time_s += f64::from(dt_s);
        Ok(())
    }

    /// Plans the oldest requests.
    fn plan_paths(&mut self, graph: &WorldGraph) {
        for _ in 0..self.config.plans_per_step {
            let Some(c) = self.paths.next_waiting() else { return };
            let from = self.end_node(c);
            let Some(mut target) = self.paths.target(c) else { continue };
            if let PlanTarget::Tag { instance, tag } = target
                && !self.reservations.are_free(graph, instance, c as u32)
                && let Some(instance) = self.nearest_offer(graph, c, tag)
            {
                target = PlanTarget::Tag { instance, tag };
                self.set_target(graph, c, Some(target));
            }
            if !self.reservations.are_free(graph, target.instance(), c as u32)
                && self.turn_to_free(graph, c)
                && let Some(free) = self.paths.target(c)
            {
                target = free;
            }
            if target.is_at(graph, from) {
                continue;
            }
            // No character reaches its place through the future place of its partner.
            let partners = self.place_of_partner(c);
            let reservations = &self.reservations;
            let impatient = self.states[c].impatience > 0 || self.states[c].tries[1] > 0;
            let (states, rate_hz) = (&self.states, self.rate_hz);
            let toll = |i: u32| {
                if partners == Some(i) {
                    return TOLL_OF_WHO_STAYS;
                }
                let held =
                    reservations.other_holder(graph, i, c as u32, follow_nobody).filter(|_| i != target.instance());
                let stays = match held.map(|other| states.get(other as usize)) {
                    None => return 0.0,
                    // As long as waiting for its end takes.
                    Some(Some(s))
                        if matches!(s.activity, InhabitantActivity::Performing | InhabitantActivity::Meeting) =>
                    {
                        s.frames_left(rate_hz).min(TOLL_OF_WHO_STAYS)
                    }
                    Some(Some(s)) if s.activity == InhabitantActivity::Arrived && impatient => TOLL_OF_WHO_STAYS,
                    Some(_) => 0.0,
                };
                if impatient { stays.max(TOLL) } else { stays }
            };
            match self.planner.plan_around(graph, from, target, &toll, &TOLL_TRIES, self.paths.step_buffer(c)) {
                Some(plan) => {
                    self.paths.set(c, from, plan);
                    let steps = self.paths.steps_of(c).iter().map(|s| Some(s.to.instance));
                    if partners.is_some() && steps.skip_while(|i| *i == partners).any(|i| i == partners) {
                        self.states[c].activity = InhabitantActivity::Unreachable;
                    }
                }
                None => {
                    self.states[c].activity = InhabitantActivity::Unreachable;
                    self.events.push((self.roster.ids()[c], InhabitantEvent::NoPath));
                }
            }
        }
    }

    /// The next step of a character.
    fn decide_step(&mut self, graph: &WorldGraph, c: usize) -> Option<WorldStep> {
        if let Some(step) = self.chains.pop(c) {
            self.count_step(graph, c, &step);
            return Some(step);
        }
        if let Some(step) = self.decide_together(graph, c) {
            return step;
        }
        if self.states[c].detour == 0 && self.time_s < self.states[c].until_s {
            return self.rest_step(graph, c);
        }
        if self.states[c].detour > 0 {
            self.states[c].detour -= 1;
            self.states[c].activity = InhabitantActivity::Detour;
            if self.states[c].detour == 0 {
                // A pause, so that others have time to pass.
                let pause_s = 0.5 * self.draw_random(c) * self.config.patience_s;
                self.states[c].until_s = self.time_s + f64::from(pause_s);
            }
            // A step aside to rest is not counted.
            let at = self.states[c].at;
            let on = self.pick_step(graph, c, |s| s.to != at && !graph.is_rest(s.to));
            let step = on.and_then(|step| self.try_step(graph, c, step, None));
            return step.or_else(|| self.roam_step(graph, c)).or_else(|| self.rest_step(graph, c));
        }
        let Some(target) = self.paths.target(c) else {
            self.states[c].activity = InhabitantActivity::Roaming;
            return self.roam_step(graph, c).or_else(|| self.rest_step(graph, c));
        };
        if matches!(self.states[c].activity, InhabitantActivity::Unreachable | InhabitantActivity::Arrived) {
            return self.rest_step(graph, c);
        }
        if self.has_performed(c) || target.is_at(graph, self.states[c].at) {
            return self.act_at_target(graph, c, target);
        }
        let step = self.follow_path(graph, c);
        step.iter().for_each(|step| self.count_step(graph, c, step));
        step.or_else(|| self.rest_step(graph, c))
    }

    /// Counts a step towards the time of an action that is to be performed. Of a slide, the first part leads to where a
    /// character may stop and begin again.
    fn count_step(&mut self, graph: &WorldGraph, c: usize, step: &WorldStep) {
        let state = &mut self.states[c];
        if let InhabitantGoal::Perform { tag, .. } = state.goal
            && graph.link(step).is_some_and(|l| l.tag == tag)
        {
            state.performed = state.performed.saturating_add(step.num_frames());
        }
    }

    /// True once a character has performed its action long enough.
    fn has_performed(&self, c: usize) -> bool {
        let state = &self.states[c];
        matches!(state.goal, InhabitantGoal::Perform { .. })
            && state.performed > 0
            && state.frames_left(self.rate_hz) <= 0.0
    }

    /// Acts at the target: stays, or performs the action of its goal.
    fn act_at_target(&mut self, graph: &WorldGraph, c: usize, target: PlanTarget) -> Option<WorldStep> {
        self.reset_patience(c);
        if let (PlanTarget::Tag { tag, .. }, InhabitantGoal::Perform { seconds, .. }) = (target, self.states[c].goal)
            && seconds > 0.0
            && !self.has_performed(c)
        {
            self.states[c].activity = InhabitantActivity::Performing;
            let shown = self.pick_step(graph, c, |s| graph.link(s).is_some_and(|l| l.tag == tag));
            let step = shown.and_then(|step| self.try_step(graph, c, step, None));
            step.iter().for_each(|step| self.count_step(graph, c, step));
            return step.or_else(|| self.rest_step(graph, c));
        }
        let state = &mut self.states[c];
        state.activity = InhabitantActivity::Arrived;
        state.num_fulfilled = state.num_fulfilled.wrapping_add(1);
        self.events.push((self.roster.ids()[c], InhabitantEvent::Fulfilled));
        self.rest_step(graph, c)
    }

    /// Another character that holds a unit which steps of a character need, and is not followed.
    fn first_holder(&self, graph: &WorldGraph, c: usize, steps: &[WorldStep]) -> Option<usize> {
        let own = self.schedule_of(graph, c, steps);
        let holder = steps.iter().find_map(|s| {
            let follows = |other: u32, unit| {
                let other = self.schedule_of(graph, other as usize, self.chains.steps_of(other as usize));
                (own.is_narrow() || other.is_narrow()) && own.follows(&other, unit, APART_M)
            };
            self.reservations.holder_for_step(graph, s, c as u32, follows)
        });
        holder.map(|h| h as usize)
    }

    /// Places of a character over time, from now to the end of a chain.
    fn schedule_of<'a>(&self, graph: &'a WorldGraph, c: usize, chain: &'a [WorldStep]) -> ChainSchedule<'a> {
        let (state, frames_left) = (&self.states[c], self.characters.frames_left(c));
        ChainSchedule { graph, root: self.roots[c], frames_left, through: state.through, at: state.at, chain }
    }

    /// Number of steps that a character's path may go on by, up to where it may rest: there, or past it through a
    /// passage. Otherwise a character that holds a unit which they need.
    ///
    /// - returns `None` where the steps are not known.
    fn next_chain(&self, graph: &WorldGraph, c: usize) -> Option<Result<usize, usize>> {
        let steps = self.steps_to_rest(graph, c, 0)?;
        let Some(holder) = self.first_holder(graph, c, steps) else { return Some(Ok(steps.len())) };
        let further = self.steps_to_rest(graph, c, steps.len());
        Some(further.filter(|steps| self.first_holder(graph, c, steps).is_none()).map(<[_]>::len).ok_or(holder))
    }

    /// Steps of a character's path up to where it may come to rest, past some of them; none where they are not known.
    fn steps_to_rest(&self, graph: &WorldGraph, c: usize, past: usize) -> Option<&[WorldStep]> {
        let (path, target) = (self.paths.start_node(c, self.states[c].at), self.paths.target(c)?);
        // Whoever stands in a passage may also rest in it.
        let is_inside = !graph.is_stop(self.states[c].at);
        let can_stop = |node| graph.is_stop(node) || is_inside && graph.is_safe(node);
        let last = past + path.get(past..)?.iter().position(|s| can_stop(s.to) || target.is_at(graph, s.to))?;
        (last < MAX_CHAIN).then(|| &path[..=last])
    }

    /// The next steps of the path, where what they need is free.
    fn follow_path(&mut self, graph: &WorldGraph, c: usize) -> Option<WorldStep> {
        let Some(next) = self.next_chain(graph, c) else {
            if self.states[c].activity != InhabitantActivity::Blocked {
                self.states[c].activity = InhabitantActivity::Planning;
            }
            self.paths.request_path(c);
            self.states[c].leaves_s = Some(self.time_s);
            return None;
        };
        if let Some(step) = self.climb(graph, c) {
            return Some(step);
        }
        let len = match next {
            Ok(len) => len,
            Err(holder) => {
                self.note_refusal(graph, c, holder);
                return None;
            }
        };
        self.chains.set(c, &self.paths.start_node(c, self.states[c].at)[..len]);
        self.begin_walking(graph, c, len)
    }

    /// Reserves the chain, which begins with steps of the path.
    fn begin_walking(&mut self, graph: &WorldGraph, c: usize, num_steps: usize) -> Option<WorldStep> {
        self.paths.advance(c, num_steps);
        let state = &mut self.states[c];
        state.activity = InhabitantActivity::Walking;
        state.refused_s = None;
        state.progress += 1;
        if state.progress >= CALM_AFTER {
            (state.progress, state.impatience) = (0, state.impatience.saturating_sub(1));
        }
        self.reserve_chain(graph, c)
    }

    /// The rest of the path where it leads through a climb to an action, the action, and further steps until the
    /// character can come to rest off all climbs: nobody who follows has to wait for it.
    fn climb(&mut self, graph: &WorldGraph, c: usize) -> Option<WorldStep> {
        let (at, target) = (self.states[c].at, self.paths.target(c)?);
        let PlanTarget::Tag { tag, .. } = target else { return None };
        let path = self.paths.start_node(c, at);
        let len = 1 + path.iter().take(MAX_CHAIN / 2).position(|s| target.is_at(graph, s.to))?;
        let num_stops = path[..len].iter().filter(|s| graph.is_stop(s.to)).count();
        let from = path[len - 1].to;
        if num_stops > 1 || graph.is_stop(from) {
            return None;
        }
        let mut shown = None;
        graph
            .for_each_step(from, |s| shown = shown.or(Some(s).filter(|s| graph.link(s).is_some_and(|l| l.tag == tag))));
        self.chains.set(c, &path[..len]);
        let (character, seed, draw) = (c as u32, self.config.characters.seed, self.states[c].draws);
        let (reservations, bound, is_inside, off_climbs) = (&self.reservations, None, false, true);
        let mut space = SafetySearch { graph, reservations, character, seed, draw, bound, is_inside, off_climbs };
        let nodes = &mut self.planner.nodes;
        let is_safe = shown.is_some_and(|step| {
            let room = self.chains.extend_chain_by(c, step);
            match nodes.search(graph, step.to, &mut space, MAX_OPENED) {
                SearchResult::Path(path) if nodes.cost(path) < f32::INFINITY => {
                    let num_steps = nodes.write_path(path, room);
                    self.chains.extend_chain(c, len + num_steps)
                }
                _ => false,
            }
        });
        if !is_safe || self.first_holder(graph, c, self.chains.steps_of(c)).is_some() {
            self.chains.set(c, &[]);
            return None;
        }
        self.begin_walking(graph, c, len)
    }

    /// Notes that another character holds a unit that is needed.
    ///
    /// Behind a character that goes on, it waits, loses patience and makes a detour. If its place is taken by one that
    /// stays, or it lost patience too often, it waits and moves out of the way of others.
    fn note_refusal(&mut self, graph: &WorldGraph, c: usize, holder: usize) {
        let is_inhabitant = holder != EXTERNAL_HOLDER as usize;
        let is_blocked = is_inhabitant && self.states[holder].activity == InhabitantActivity::Blocked;
        let is_settled = is_blocked || is_inhabitant && self.has_come_to_stay(holder);
        let is_taken = is_settled && self.occupant_of(graph, c).is_some();
        self.forget_tries(c);
        // Of two that block each other's paths, one yields soon and the other one late.
        let share = match is_inhabitant && self.holder_in_way(graph, holder) == Some(c) {
            true if holder < c => YIELD_CHANCE,
            true => INSISTS,
            false => 1.0,
        };
        let chance = self.draw_random(c);
        let (now, patience_s) = (self.time_s, f64::from(self.config.patience_s * share * (0.5 + chance)));
        let [tries, tries_settled] = self.states[c].tries;
        let gives_up = tries >= MAX_TRIES || is_settled && tries_settled >= MAX_TRIES_STAYING;
        if is_taken && !gives_up && self.try_another_place(graph, c) || gives_up && self.set_nearest_target(graph, c) {
            return;
        }
        if is_blocked {
            self.states[holder].obstructs |= !is_taken && !gives_up;
        }
        // Patience is not lost behind a character that goes on, nor behind others that wait for it.
        let went_on_s = match is_inhabitant {
            true if self.chains.steps_of(holder).is_empty() => self.states[holder].went_on_s,
            true => now,
            false => 0.0,
        };
        let state = &mut self.states[c];
        state.activity = if is_taken || gives_up { InhabitantActivity::Blocked } else { InhabitantActivity::Waiting };
        state.progress = 0;
        state.went_on_s = state.went_on_s.max(went_on_s);
        let waits = now - state.refused_s.get_or_insert(now).max(state.went_on_s) < patience_s;
        let makes_room = std::mem::take(&mut state.obstructs) && !gives_up;
        if state.activity == InhabitantActivity::Blocked && !makes_room {
            if !waits {
                // Another path may have become free.
                state.refused_s = None;
                self.paths.request_path(c);
            }
            return;
        }
        if state.activity == InhabitantActivity::Waiting && waits || is_settled && self.try_another_place(graph, c) {
            return;
        }
        let state = &mut self.states[c];
        state.tries = [state.tries[0] + 1, state.tries[1] + u32::from(is_settled)];
        // Longer each time, so that it gets far enough out of the way.
        state.refused_s = None;
        state.detour = 1 + (chance * (2u32 << state.impatience) as f32) as u32;
        state.impatience = (state.impatience + 1).min(MAX_IMPATIENCE);
        self.paths.set_target(c, self.paths.target(c));
    }

    /// Resets the number of tries after a new order: without new ones, all characters come to rest in the end.
    fn forget_tries(&mut self, c: usize) {
        let state = &mut self.states[c];
        if std::mem::replace(&mut state.order_number, self.num_orders) != self.num_orders {
            state.tries = [0; 2];
        }
    }

    /// Sends a character to another free place near its target; false where there is none.
    fn try_another_place(&mut self, graph: &WorldGraph, c: usize) -> bool {
        let turned = self.turn_to_free(graph, c);
        if turned {
            self.states[c].activity = InhabitantActivity::Planning;
            self.states[c].tries[1] += 1;
            self.paths.request_path(c);
        }
        turned
    }

    /// Character that holds a unit which the next steps of a character's path need.
    pub(super) fn holder_in_way(&self, graph: &WorldGraph, c: usize) -> Option<usize> {
        self.next_chain(graph, c)?.err()
    }

    /// Resets patience, as nothing blocks the character any more.
    pub(super) fn reset_patience(&mut self, c: usize) {
        let state = &mut self.states[c];
        (state.refused_s, state.impatience, state.progress) = (None, 0, 0);
    }

    /// A random step anywhere else, preferably in the direction of the character's purpose, and further steps until it
    /// can come to rest.
    fn roam_step(&mut self, graph: &WorldGraph, c: usize) -> Option<WorldStep> {
        self.update_purpose(graph, c);
        let (at, purpose) = (self.states[c].at, self.states[c].purpose);
        let (rests, place, brisk) = (graph.is_rest(at), graph.place(at), self.rate_hz / WALK_SPEED_MPS);
        for attempt in 0..TRIES {
            // A character that has rested tries to leave first, not to rest elsewhere.
            let leave = rests && attempt < TRIES / 2;
            let wanted = |s: &WorldStep| s.to != at && !(leave && graph.is_rest(s.to));
            let share =
                |s: &WorldStep| if wanted(s) { purpose.step_weight(graph, [place.x, place.z], s, brisk) } else { 0.0 };
            let Some(step) = self.pick_step_of(graph, c, share) else { continue };
            if let Some(step) = self.try_step(graph, c, step, Some((purpose, LEAST_LEAVE_M * f32::from(leave)))) {
                return Some(step);
            }
        }
        let step = self.pick_step(graph, c, |s| s.to != at && graph.is_stop(s.to))?;
        self.try_step(graph, c, step, None)
    }

    /// Stays at rest, or goes there within the units it holds.
    pub(super) fn rest_step(&mut self, graph: &WorldGraph, c: usize) -> Option<WorldStep> {
        let at = self.states[c].at;
        if !graph.is_rest(at) {
            return graph.step_to_rest(at);
        }
        let still = |s: &WorldStep| s.to == at && graph.link(s).is_some_and(|l| l.tag == 0);
        self.pick_step(graph, c, still).or_else(|| graph.step_to_rest(at))
    }

    /// Any of the steps that can be taken now and are wanted, with equal chances.
    fn pick_step(&mut self, graph: &WorldGraph, c: usize, wanted: impl Fn(&WorldStep) -> bool) -> Option<WorldStep> {
        self.pick_step_of(graph, c, |s| if wanted(s) { 1.0 } else { 0.0 })
    }

    /// Random step among those that can be taken now, with the given weights (>= 0; 0 for steps that are not wanted).
    fn pick_step_of(&mut self, graph: &WorldGraph, c: usize, share: impl Fn(&WorldStep) -> f32) -> Option<WorldStep> {
        let (seed, name, mut draws) = (self.config.characters.seed, self.name(c), self.states[c].draws);
        let (mut chosen, mut sum) = (None, 0.0);
        graph.for_each_step(self.states[c].at, |step| {
            let share = share(&step);
            if share > 0.0 && self.reservations.holder_for_step(graph, &step, c as u32, follow_nobody).is_none() {
                sum += share;
                draws = draws.wrapping_add(1);
                if uniform_random(seed, name, draws.into()) * sum < share {
                    chosen = Some(step);
                }
            }
        });
        self.states[c].draws = draws;
        chosen
    }

    /// Tries a step, with further steps until the character can come to rest.
    ///
    /// - `purpose`: direction whose paths it prefers, and least distance from here at which it comes to rest (m).
    fn try_step(
        &mut self,
        graph: &WorldGraph,
        c: usize,
        step: WorldStep,
        purpose: Option<(Purpose, f32)>,
    ) -> Option<WorldStep> {
        let (character, seed, draw) = (c as u32, self.config.characters.seed, self.states[c].draws);
        let start = graph.place(self.states[c].at);
        let bound = purpose.map(|(p, least_m)| (p, [start.x, start.z], least_m));
        let is_inside = purpose.is_none() && !graph.is_stop(self.states[c].at);
        let reservations = &self.reservations;
        let mut space =
            SafetySearch { graph, reservations, character, seed, draw, bound, is_inside, off_climbs: false };
        let (nodes, mut len) = (&mut self.planner.nodes, 0);
        let room = self.chains.begin_chain(c, step);
        let mut is_safe = space.is_target(step.to);
        if !is_safe && let SearchResult::Path(path) = nodes.search(graph, step.to, &mut space, MAX_OPENED) {
            is_safe = nodes.cost(path) < f32::INFINITY;
            len = nodes.write_path(path, room);
        }
        if !self.chains.extend_chain(c, len) || !is_safe {
            self.chains.set(c, &[]);
            return None;
        }
        self.reserve_chain(graph, c)
    }

    /// Takes the units that the chain needs, and returns its first step.
    fn reserve_chain(&mut self, graph: &WorldGraph, c: usize) -> Option<WorldStep> {
        self.states[c].reserved_s = self.time_s;
        for step in self.chains.steps_of(c) {
            if graph.link(step).is_some() {
                self.reservations.take_units(graph.resources(step.instance), c as u32);
            }
            self.reservations.take_units(graph.resources(step.to.instance), c as u32);
        }
        self.chains.pop(c)
    }

    /// Releases units of instances that are left, unless the present step or those after it need them.
    fn release_units(&mut self, graph: &WorldGraph, c: usize, left: [u32; 2]) {
        let (state, chain) = (&self.states[c], self.chains.steps_of(c));
        for unit in left.into_iter().flat_map(|instance| graph.resources(instance)) {
            let mut is_needed = false;
            state.visit_needed_instances(graph, chain, |i| is_needed |= graph.resources(i).contains(unit));
            if !is_needed {
                self.reservations.release_unit(*unit, c as u32);
            }
        }
    }

    /// A random number of a character, in [0, 1).
    pub(super) fn draw_random(&mut self, c: usize) -> f32 {
        let (name, state) = (self.name(c), &mut self.states[c]);
        state.draws = state.draws.wrapping_add(1);
        uniform_random(self.config.characters.seed, name, state.draws.into())
    }

    /// Name by which random numbers of a character are drawn, beside the seed and their number.
    pub(super) fn name(&self, c: usize) -> u64 {
        let id = self.roster.ids()[c];
        let name = u64::from(id.generation) << 32 | u64::from(id.index);
        self.config.characters.first_number.wrapping_add(name)
    }
}
