//! Reactions of agents to stimuli: rules, state graphs, values that pass a threshold.

use super::agent_brain::{ActionPhase, ActionReason, EventContext, Feeling, NO_NUMBER, Occasion};
use super::agent_brains::{AgentBrains, Stimulus};
use super::tables::{CompiledAction, EdgeTable, NONE, trigger};
use super::{happenings::RETRY_S, stage::ScenarioStage, turns::TurnKind};
use throng_base::{Error, Result, error::ensure};

/// Most stimuli of one agent at one time; more are taken to run in a circle.
const MOST_AT_ONCE: u32 = 100;
/// Most rounds in which conditions of events become true at one time; more are taken to run in a circle.
pub(super) const MOST_ROUNDS: u32 = 1000;

impl AgentBrains {
    /// Raises the events whose conditions have become true; true where one has.
    pub(super) fn check_conditions(&mut self, stage: &mut impl ScenarioStage) -> Result<bool> {
        let mut any = false;
        for e in 0..self.was_true.len() {
            let Some(condition) = self.scenario.events[e].condition else { continue };
            let on = Occasion { agent: 0, context: EventContext::default() };
            let is_true = !self.brains.is_empty() && self.evaluate_predicate(stage, on, condition);
            if is_true && !std::mem::replace(&mut self.was_true[e], is_true) {
                self.fire_event(stage, e)?;
                any = true;
            }
            self.was_true[e] = is_true;
        }
        Ok(any)
    }

    /// Handles a stimulus of an agent: follows a rule, or takes an edge of a graph.
    pub(super) fn handle_stimulus(&mut self, stage: &mut impl ScenarioStage, stimulus: Stimulus) -> Result<()> {
        let m = stimulus.on.agent as usize;
        let brain = &mut self.brains[m];
        let is_of_behaviour =
            [trigger::DONE, trigger::FULL, trigger::STUCK, trigger::GIVES_UP].contains(&stimulus.trigger);
        if is_of_behaviour && stimulus.begun != brain.begun {
            // The behaviour has been replaced by another one.
            return Ok(());
        }
        if brain.handled_at != self.now {
            (brain.handled_at, brain.handled) = (self.now, 0);
        }
        brain.handled += 1;
        ensure(brain.handled <= MOST_AT_ONCE, || self.circle_error(stimulus.on.agent, stimulus.trigger))?;
        self.record_sensed(stimulus);
        if self.follow_rule(stage, stimulus)? {
            return Ok(());
        }
        let upwards = stimulus.trigger == trigger::DONE;
        let own = &self.engagements[m];
        if own.led_at == self.now && own.led_on == stimulus.trigger && !upwards {
            // Its party has decided.
            return Ok(());
        }
        for i in 0..3 {
            let level = if upwards { 2 - i } else { i };
            let state = self.brains[m].states[level];
            if state == NO_NUMBER {
                continue;
            }
            let edges = self.scenario.states[usize::from(state)].edges;
            if upwards && self.waits_for_party(stage, stimulus.on.agent, level, edges) {
                return self.wait_for_party(stage, stimulus.on.agent);
            }
            if let Some(edge) = self.choose_edge(stage, stimulus, edges) {
                let EdgeTable { to, number, alone, .. } = self.scenario.edges[edge as usize];
                let graph = usize::from(self.scenario.states[usize::from(state)].graph_number);
                // A state that has ended begins again, one that came to nothing after a while; one that goes on is left alone.
                let begins = to != state || stimulus.trigger == trigger::DONE;
                let fails = is_of_behaviour && !begins && self.scenario.states[usize::from(state)].graph == NONE;
                let kind = TurnKind::Takes { level, graph, edge: usize::from(number), changes: begins };
                self.record_turn(stimulus, kind);
                self.brains[m].reason = ActionReason { edge, ..self.new_reason(stimulus) };
                if fails {
                    self.try_again(stage, stimulus.on.agent, state)?;
                } else if begins {
                    self.enter_state(stage, stimulus.on, u32::from(to))?;
                    if !alone {
                        self.lead_party(stage, stimulus, state, kind)?;
                    }
                    self.leave_party(stage, stimulus.on.agent);
                }
                return Ok(());
            }
        }
        if upwards && self.waits_for_condition(stage, stimulus.on) {
            self.brains[m].acts_again_at_s = self.now + RETRY_S;
        }
        Ok(())
    }

    /// True for an agent whose state has ended, and may be left only when a condition comes true: it looks again then.
    fn waits_for_condition(&mut self, stage: &impl ScenarioStage, on: Occasion) -> bool {
        let (scenario, brain) = (self.scenario.clone(), self.brains[on.agent as usize]);
        let [first, last] = scenario.rules_of[usize::from(trigger::DONE)];
        let rules = &scenario.rule_order[first as usize..last as usize];
        // Rules on the end of a behaviour act once.
        let has_rule = rules.iter().any(|&rule| scenario.rules[rule as usize].who >> brain.group & 1 == 1);
        let has_ended = matches!(scenario.actions.get(brain.action as usize), Some(CompiledAction::End));
        if brain.is_busy || has_rule || !has_ended {
            return false;
        }
        let own = brain.states.iter().filter_map(|state| scenario.states.get(usize::from(*state)));
        let edges = own.flat_map(|s| &scenario.edges[s.edges[0] as usize..s.edges[1] as usize]);
        let mut ends = edges.filter(|edge| edge.trigger == trigger::DONE).peekable();
        // An edge that is open leads on by its probability, once.
        ends.peek().is_some() && ends.all(|e| e.when.is_some_and(|when| !self.evaluate_predicate(stage, on, when)))
    }

    /// Follows the first rule that fits; true where its behaviour lasts.
    pub(super) fn follow_rule(&mut self, stage: &mut impl ScenarioStage, stimulus: Stimulus) -> Result<bool> {
        let m = stimulus.on.agent as usize;
        let scenario = self.scenario.clone();
        let [first, last] = scenario.rules_of[usize::from(stimulus.trigger)];
        for &number in &scenario.rule_order[first as usize..last as usize] {
            let rule = &scenario.rules[number as usize];
            if rule.who >> self.brains[m].group & 1 == 0 {
                continue;
            }
            let pause = m * scenario.num_pauses + rule.pause as usize;
            let brain = &self.brains[m];
            let is_held = !rule.is_instant && brain.is_busy && brain.priority > rule.priority;
            if is_held || rule.pause_s > 0.0 && self.now - self.followed[pause] < f64::from(rule.pause_s) {
                continue;
            }
            if !rule.when.is_none_or(|when| self.evaluate_predicate(stage, stimulus.on, when)) {
                continue;
            }
            if rule.probability < 1.0 && self.draw_chance(stimulus.on.agent) >= f64::from(rule.probability) {
                continue;
            }
            if rule.both && !self.join_partner(stage, stimulus, number)? {
                continue;
            }
            if rule.pause_s > 0.0 {
                self.followed[pause] = self.now;
            }
            let reason = ActionReason { rule: number, ..self.new_reason(stimulus) };
            let before = std::mem::replace(&mut self.brains[m].reason, reason);
            self.record_turn(stimulus, TurnKind::Follows(number as usize));
            if rule.is_instant {
                self.apply_effects(stage, stimulus.on, rule.actions)?;
                // This is no reason for what the agent goes on doing.
                self.brains[m].reason = before;
                self.at_once = (self.now, number);
                return Ok(false);
            }
            self.begin_rule(stage, stimulus.on, number)?;
            return Ok(true);
        }
        Ok(false)
    }

    fn begin_rule(&mut self, stage: &mut impl ScenarioStage, on: Occasion, number: u32) -> Result<()> {
        let (actions, priority) =
            (self.scenario.rules[number as usize].actions, self.scenario.rules[number as usize].priority);
        let brain = &mut self.brains[on.agent as usize];
        if !brain.is_busy {
            (brain.resumed, brain.resumed_context) = (brain.action, brain.context);
        }
        (brain.is_busy, brain.priority) = (true, priority);
        self.start_behaviour(stage, on, actions)
    }

    /// Lets the other agent of an event follow the same rule; false where it cannot.
    fn join_partner(&mut self, stage: &mut impl ScenarioStage, stimulus: Stimulus, number: u32) -> Result<bool> {
        let (me, other) = (stimulus.on.agent, stimulus.on.context.other);
        let rule = &self.scenario.rules[number as usize];
        let Some(partner) = self.brains.get(other as usize) else { return Ok(false) };
        let pause = other as usize * self.scenario.num_pauses + rule.pause as usize;
        let is_paused = rule.pause_s > 0.0 && self.now - self.followed[pause] < f64::from(rule.pause_s);
        let is_free = partner.is_there && !partner.is_busy;
        if !is_free || is_paused || self.brains[me as usize].is_busy {
            return Ok(false);
        }
        if rule.pause_s > 0.0 {
            self.followed[pause] = self.now;
        }
        let on = Occasion { agent: other, context: EventContext { other: me, ..stimulus.on.context } };
        let theirs = Stimulus { on, ..stimulus };
        self.brains[other as usize].reason = ActionReason { rule: number, ..self.new_reason(theirs) };
        self.record_turn(theirs, TurnKind::Follows(number as usize));
        self.mark_touched(other);
        self.begin_rule(stage, on, number)?;
        Ok(true)
    }

    /// Chooses among the edges that an event opens, by their probabilities.
    pub(super) fn choose_edge(&mut self, stage: &impl ScenarioStage, stimulus: Stimulus, all: [u32; 2]) -> Option<u32> {
        let scenario = self.scenario.clone();
        let (mut open, mut shared, mut sum) = (0u64, 0, 0.0_f32);
        let edges: &[EdgeTable] = &scenario.edges[all[0] as usize..all[1] as usize];
        for (i, edge) in edges.iter().enumerate() {
            if edge.trigger == stimulus.trigger
                && edge.when.is_none_or(|when| self.evaluate_predicate(stage, stimulus.on, when))
            {
                open |= 1 << i;
                if edge.probability < 0.0 { shared += 1 } else { sum += edge.probability }
            }
        }
        if open == 0 {
            return None;
        }
        let share = if shared > 0 { (1.0 - sum).max(0.0) / shared as f32 } else { 0.0 };
        let scale = sum.max(1.0).recip();
        let is_single = open.count_ones() == 1 && (shared == 1 || sum >= 1.0);
        let mut left = if is_single { 0.0 } else { self.draw_chance(stimulus.on.agent) as f32 };
        for (i, edge) in edges.iter().enumerate().filter(|(i, _)| open >> i & 1 == 1) {
            left -= if edge.probability < 0.0 { share } else { edge.probability * scale };
            if left < 0.0 || is_single {
                return Some(all[0] + i as u32);
            }
        }
        None
    }

    /// Enters a state, and restarts the graphs below it.
    pub(super) fn enter_state(&mut self, stage: &mut impl ScenarioStage, on: Occasion, state: u32) -> Result<()> {
        let m = on.agent as usize;
        let scenario = self.scenario.clone();
        let mut next = state;
        (self.brains[m].resumed, self.engagements[m].is_done) = (NONE, false);
        (self.brains[m].is_busy, self.brains[m].priority) = (false, i8::MIN);
        loop {
            let table = &scenario.states[next as usize];
            let level = usize::from(table.level);
            let brain = &mut self.brains[m];
            if brain.states[..level].iter().all(|s| *s == NO_NUMBER) {
                brain.state_since = self.now;
            }
            brain.states[level] = next as u16;
            brain.states[level + 1..].fill(NO_NUMBER);
            if table.graph == NONE {
                return self.start_behaviour(stage, on, table.actions);
            }
            if table.actions != NONE {
                self.apply_effects(stage, on, table.actions)?;
            }
            next = table.graph;
        }
    }

    /// Lets an agent that did not get what it came for stand, and begin its state again after a while; the end of its behaviour
    /// counts no more.
    fn try_again(&mut self, stage: &mut impl ScenarioStage, agent: u32, state: u16) -> Result<()> {
        let brain = &mut self.brains[agent as usize];
        brain.begun = brain.begun.wrapping_add(1);
        (brain.action, brain.phase) = (self.scenario.states[usize::from(state)].actions, ActionPhase::Idle);
        brain.acts_again_at_s = self.now + RETRY_S;
        stage.order_halt(agent)
    }

    /// Runs all thresholds, timers and actions of an agent that are due.
    pub(super) fn run_timers(&mut self, stage: &mut impl ScenarioStage, agent: u32) -> Result<()> {
        let m = agent as usize;
        while self.brains[m].crossing_at <= self.now {
            let t = self.brains[m].crossing;
            let threshold = self.scenario.thresholds[usize::from(t)];
            let v = m * self.scenario.values.len() + usize::from(threshold.value);
            // The value is set to the threshold exactly: rounding could put it on either side.
            self.feelings[v] = Feeling { value: threshold.at, since: self.now, ..self.feelings[v] };
            self.brains[m].passed |= 1 << t;
            self.push_stimulus(agent, trigger::EVENTS + self.scenario.events.len() as u16 + t, EventContext::default());
            self.find_crossing(agent);
        }
        if self.brains[m].told_at <= self.now {
            self.end_telling(stage, agent);
        }
        if self.brains[m].tells_at <= self.now {
            self.tell_again(stage, agent)?;
        }
        if self.brains[m].timer <= self.now {
            self.brains[m].timer = f64::INFINITY;
            self.push_stimulus(agent, trigger::TIMER, EventContext::default());
        }
        if self.lose_patience(stage, agent)? {
            return Ok(());
        }
        let brain = &self.brains[m];
        if brain.phase == ActionPhase::Idle && brain.acts_again_at_s <= self.now {
            return self.enter_action(stage, agent, brain.action);
        }
        let is_over = brain.stands_until_s <= self.now || brain.gives_up_at_s <= self.now;
        if is_over || brain.acts_again_at_s <= self.now && self.run_primitive(stage, agent, true)? {
            return self.next_action(stage, agent);
        }
        Ok(())
    }

    /// Changes a value, or its rate.
    pub(super) fn change_value(&mut self, agent: u32, value: u16, change: impl FnOnce(&mut Feeling)) {
        let (m, scenario) = (agent as usize, self.scenario.clone());
        let table = &scenario.values[usize::from(value)];
        let feeling = &mut self.feelings[m * scenario.values.len() + usize::from(value)];
        *feeling = Feeling { value: feeling.value_at(table, self.now), since: self.now, ..*feeling };
        change(feeling);
        feeling.value = feeling.value.clamp(table.limits[0], table.limits[1]);
        let now = feeling.value;
        for t in table.thresholds[0]..table.thresholds[1] {
            let bit = 1u32 << t;
            let (was, is) = (self.brains[m].passed & bit != 0, scenario.thresholds[usize::from(t)].is_passed(now));
            self.brains[m].passed = self.brains[m].passed & !bit | u32::from(is) << t;
            if is && !was {
                self.push_stimulus(agent, trigger::EVENTS + scenario.events.len() as u16 + t, EventContext::default());
            }
        }
        self.find_crossing(agent);
        self.mark_touched(agent);
    }

    /// Finds the next threshold that an agent's values pass by themselves.
    pub(super) fn find_crossing(&mut self, agent: u32) {
        let m = agent as usize;
        let scenario = &self.scenario;
        let (mut next, mut when) = (NO_NUMBER, f64::INFINITY);
        for (t, threshold) in scenario.thresholds.iter().enumerate() {
            let v = usize::from(threshold.value);
            let (feeling, table) = (&self.feelings[m * scenario.values.len() + v], &scenario.values[v]);
            if self.brains[m].passed >> t & 1 == 1 {
                // It stays passed until the value is changed.
                continue;
            }
            if let Some(at) = feeling.crossing_time(table, threshold).filter(|at| *at < when) {
                (next, when) = (t as u16, at.max(self.now));
            }
        }
        (self.brains[m].crossing, self.brains[m].crossing_at) = (next, when);
    }

    pub(super) fn set_door_open(&mut self, stage: &mut impl ScenarioStage, door: usize, open: bool) -> Result<()> {
        if stage.set_door_open(door as u16, open)? {
            (self.is_open[door], self.closing[door]) = (open, f64::INFINITY);
        } else {
            self.closing[door] = self.now + RETRY_S;
        }
        Ok(())
    }

    /// Reason without rule and edge.
    pub(super) fn new_reason(&self, Stimulus { trigger, on, .. }: Stimulus) -> ActionReason {
        let EventContext { other, place, .. } = on.context;
        ActionReason { time_s: self.now, trigger, rule: NONE, edge: NONE, other, place }
    }

    pub(super) fn event_circle_error(&self) -> Error {
        let names = self.scenario.names.events.0.iter().enumerate();
        let is_of_it = |e: usize| self.scenario.events[e].condition.is_some() && self.happened[e] == self.now;
        let names: Vec<_> = names.filter(|(e, _)| is_of_it(*e)).map(|(_, name)| format!("`{name}`")).collect();
        let why = format!(
            "conditions of events become true more than {MOST_ROUNDS} times at {:.3} s, those of {}: they follow each other in a \
             circle; let `when` of one of them stay true, or wait for a later `time`",
            self.now,
            names.join(", ")
        );
        self.scenario.source.error_at_key("events", why)
    }

    pub(super) fn circle_error(&self, agent: u32, trigger: u16) -> Error {
        let reason = self.brains[agent as usize].reason;
        let reason = if self.at_once.0 == self.now { ActionReason { rule: self.at_once.1, ..reason } } else { reason };
        let rule = if reason.rule != NONE {
            format!("rule \"{}\"", self.scenario.rules[reason.rule as usize].name)
        } else if reason.edge != NONE {
            let to = self.scenario.edges[reason.edge as usize].to;
            format!("an edge to `{}`", self.scenario.states[usize::from(to)].name)
        } else {
            "no rule".into()
        };
        let event = self.scenario.trigger_name(trigger);
        let why = format!(
            "agent {agent} handles more than {MOST_AT_ONCE} events at {:.3} s, the last one `{event}`, before that {rule}: \
             rules or states follow each other in a circle; let one of them take time, such as `stay`",
            self.now
        );
        self.scenario.source.error_at_key(if reason.rule == NONE { "graphs" } else { "rules" }, why)
    }
}
