//! Compilation of state graphs and rules.

use super::{CompileResult, MOST_EDGES, MOST_PAUSES, ScenarioCompiler, compile_fault};
use crate::scenario::language::NameKind;
use crate::scenario::tables::{CompiledAction, EdgeTable, NONE, RuleTable, StateTable, trigger};
use crate::scene::{LevelConfig, RuleConfig, StateGraphConfig};
use std::collections::{BTreeMap, BTreeSet};
use throng_base::text::did_you_mean;

fn check_probability(key: &str, probability: f32) -> CompileResult<()> {
    if (0.0..=1.0).contains(&probability) {
        return Ok(());
    }
    compile_fault(format!("{key}.probability"), format!("expected 0 to 1, found {probability}"))
}

impl ScenarioCompiler<'_> {
    pub(super) fn compile_states(&mut self) -> CompileResult<()> {
        let scene = self.scene;
        // Numbers first: graphs name each other.
        let mut number = 0;
        for (name, graph) in &scene.graphs {
            for state in graph.states.keys() {
                self.state_numbers.insert((name.clone(), state.clone()), number);
                number += 1;
            }
        }
        for (name, graph) in &scene.graphs {
            let key = format!("graphs.{name}.start");
            let start = self.state_number(name, &graph.start, &key)?;
            self.graph_starts.insert(name.clone(), start);
        }
        for (of, (name, graph)) in (0..).zip(&scene.graphs) {
            for (state, config) in &graph.states {
                let key = format!("graphs.{name}.states.{state}");
                let below = match &config.graph {
                    None => NONE,
                    Some(below) => self.lower_graph_start(below, graph.level, &format!("{key}.graph"))?,
                };
                let actions = match &config.does {
                    None if below == NONE => return compile_fault(key, "expected `do` or `graph`, found neither"),
                    None => NONE,
                    Some(does) => {
                        let has_other = self.may_have_other(name, graph, state)?;
                        self.set_scope(trigger::DONE);
                        self.out.names.has_other = has_other;
                        let (first, is_instant) = self.compile_behaviour(does, &format!("{key}.do"))?;
                        if below != NONE && !is_instant {
                            let why = "before a graph, expected actions that take no time";
                            return compile_fault(format!("{key}.do"), why);
                        }
                        first
                    }
                };
                let word = self.out.names.states.0.binary_search(state).unwrap_or(0) as u16;
                let (name, level, edges) = (state.clone(), graph.level as u8, [0; 2]);
                let table = StateTable { name, word, level, graph_number: of, actions, graph: below, edges };
                self.out.states.push(table);
            }
        }
        let mut at = 0;
        for (name, graph) in &scene.graphs {
            self.check_reached(name, graph)?;
            // Each edge with the state that it leads from; any state where absent.
            let mut all = Vec::with_capacity(graph.edges.len());
            for (i, edge) in graph.edges.iter().enumerate() {
                let key = format!("graphs.{name}.edges[{i}]");
                let number = |state: &String, of: &str| self.state_number(name, state, &format!("{key}.{of}"));
                let from = edge.from.as_ref().map(|from| number(from, "from")).transpose()?;
                let to = number(&edge.to, "to")? as u16;
                let trigger = self.trigger_number(&edge.on, &format!("{key}.on"))?;
                self.set_scope(trigger);
                let when = self.compile_condition(edge.when.as_deref(), &format!("{key}.when"))?;
                let probability = edge.probability.unwrap_or(-1.0);
                if edge.probability.is_some() {
                    check_probability(&key, probability)?;
                }
                all.push((from, EdgeTable { trigger, to, when, probability, number: i as u16, alone: edge.alone }));
            }
            for state in graph.states.keys() {
                let first = self.out.edges.len() as u32;
                let own = all.iter().filter(|(from, _)| from.is_none_or(|from| from as usize == at));
                self.out.edges.extend(own.map(|(_, edge)| *edge));
                let edges = &self.out.edges[first as usize..];
                if edges.len() > MOST_EDGES {
                    let why = format!(
                        "expected at most {MOST_EDGES} edges that lead from one state, found {} from `{state}` (those \
                         without `from` count): let its `graph` of a lower level choose among them",
                        edges.len()
                    );
                    return compile_fault(format!("graphs.{name}.edges"), why);
                }
                for e in edges {
                    let same = edges.iter().filter(|o| o.trigger == e.trigger && o.when.is_none());
                    let sum: f32 = same.map(|o| o.probability.max(0.0)).sum();
                    if sum > 1.0 + 1e-5 {
                        let event = self.out.trigger_name(e.trigger);
                        let why =
                            format!("from `{state}`, probabilities at `{event}` add up to {sum}, expected at most 1");
                        return compile_fault(format!("graphs.{name}.edges"), why);
                    }
                }
                self.out.states[at].edges = [first, self.out.edges.len() as u32];
                at += 1;
            }
        }
        Ok(())
    }

    /// True for a state into which an event with another agent may lead; a graph below others is entered with their events.
    fn may_have_other(&mut self, name: &str, graph: &StateGraphConfig, state: &str) -> CompileResult<bool> {
        let is_below = |g: &StateGraphConfig| g.states.values().any(|s| s.graph.as_deref() == Some(name));
        if self.scene.graphs.values().any(is_below) {
            return Ok(true);
        }
        for (i, edge) in graph.edges.iter().enumerate().filter(|(_, edge)| edge.to == state) {
            let trigger = self.trigger_number(&edge.on, &format!("graphs.{name}.edges[{i}].on"))?;
            self.set_scope(trigger);
            if trigger != trigger::DONE && self.out.names.has_other && !self.is_untold {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Checks that every state of a graph can be reached from its start.
    pub(super) fn check_reached(&self, name: &str, graph: &StateGraphConfig) -> CompileResult<()> {
        let mut led: BTreeMap<Option<&str>, Vec<&str>> = BTreeMap::new();
        graph.edges.iter().for_each(|edge| led.entry(edge.from.as_deref()).or_default().push(&edge.to));
        let (mut reached, mut left) = (BTreeSet::from([graph.start.as_str()]), vec![graph.start.as_str()]);
        left.extend(led.remove(&None).into_iter().flatten().filter(|to| reached.insert(to)));
        while let Some(from) = left.pop() {
            left.extend(led.remove(&Some(from)).into_iter().flatten().filter(|to| reached.insert(to)));
        }
        let Some(state) = graph.states.keys().find(|s| !reached.contains(s.as_str())) else { return Ok(()) };
        let why = format!("no edge leads to `{state}` from the start, `{}`: add one, or remove it", graph.start);
        compile_fault(format!("graphs.{name}.states.{state}"), why)
    }

    pub(super) fn state_number(&self, name: &str, state: &str, key: &str) -> CompileResult<u32> {
        if let Some(&number) = self.state_numbers.get(&(name.to_string(), state.to_string())) {
            return Ok(number);
        }
        let known: Vec<&str> = self.scene.graphs[name].states.keys().map(String::as_str).collect();
        let help = did_you_mean(state, known.iter().copied());
        compile_fault(key, format!("the graph has no state `{state}`: it has {}.{help}", known.join(", ")))
    }

    /// Start state of a graph of a lower level.
    pub(super) fn lower_graph_start(&self, name: &str, level: LevelConfig, key: &str) -> CompileResult<u32> {
        let Some(graph) = self.scene.graphs.get(name) else { return self.no_graph_fault(name, key) };
        if graph.level <= level {
            let why = format!("expected a graph of a lower level: `{name}` is {:?}", graph.level);
            return compile_fault(key, why.to_lowercase());
        }
        Ok(self.graph_starts[name])
    }

    pub(super) fn no_graph_fault<T>(&self, name: &str, key: &str) -> CompileResult<T> {
        let help = did_you_mean(name, self.scene.graphs.keys().map(String::as_str));
        compile_fault(key, format!("there is no graph `{name}`.{help}"))
    }

    pub(super) fn compile_rules(&mut self) -> CompileResult<()> {
        let mut triggers = Vec::new();
        let num = self.out.groups.last().map_or(0, |g| g.agents[1] as usize);
        for (i, rule) in self.scene.rules.iter().enumerate() {
            let key = format!("rules[{i}]");
            let trigger = self.trigger_number(&rule.on, &format!("{key}.on"))?;
            self.set_scope(trigger);
            let when = self.compile_condition(rule.when.as_deref(), &format!("{key}.when"))?;
            check_probability(&key, rule.probability)?;
            let mut who = if rule.who.is_empty() { u64::MAX } else { 0 };
            for (g, name) in rule.who.iter().enumerate() {
                who |= 1 << self.name_number(NameKind::Group, name, &format!("{key}.who[{g}]"))?;
            }
            let (actions, is_instant) = self.compile_behaviour(&rule.does, &format!("{key}.do"))?;
            let pause = self.out.num_pauses as u32;
            self.out.num_pauses += usize::from(rule.pause_s > 0.0);
            if self.out.num_pauses * num > MOST_PAUSES {
                let (rules, most) = (self.out.num_pauses, MOST_PAUSES / num);
                let why = format!(
                    "expected at most {most} rules with a pause for {num} agents, found {rules}: each agent remembers when it followed them"
                );
                return compile_fault(format!("{key}.pause_s"), why);
            }
            let name = if rule.name.is_empty() { format!("rule {i}") } else { rule.name.clone() };
            let &RuleConfig { probability, priority, pause_s, both, .. } = rule;
            if both && (is_instant || !self.out.names.has_other) {
                let why = "expected a behaviour that takes time, on an event with an `other`";
                return compile_fault(format!("{key}.both"), why);
            }
            let table = RuleTable { name, who, when, probability, actions, is_instant, priority, both, pause_s, pause };
            self.out.rules.push(table);
            triggers.push(trigger);
        }
        self.compile_happenings(&mut triggers);
        self.index_rules(&triggers);
        Ok(())
    }

    pub(super) fn index_rules(&mut self, triggers: &[u16]) {
        let num = trigger::NAMES.len() + self.out.names.events.0.len() + self.out.thresholds.len();
        for t in 0..num {
            let first = self.out.rule_order.len() as u32;
            let of = triggers.iter().enumerate().filter(|(_, other)| usize::from(**other) == t);
            self.out.rule_order.extend(of.map(|(r, _)| r as u32));
            self.out.rules_of.push([first, self.out.rule_order.len() as u32]);
        }
    }

    /// Compiles happenings to events with one rule each: agents that learn of one take the path to its goal.
    pub(super) fn compile_happenings(&mut self, triggers: &mut Vec<u16>) {
        for i in 0..self.scene.happenings.len() {
            let actions = self.out.actions.len() as u32;
            self.out.actions.extend([CompiledAction::Happening(i as u16), CompiledAction::End]);
            let (name, who, probability) = (format!("happenings[{i}]"), u64::MAX, 1.0);
            let rule = RuleTable { name, who, probability, actions, is_instant: true, ..RuleTable::default() };
            self.out.rules.push(rule);
            triggers.push(trigger::EVENTS + (self.scene.events.len() + i) as u16);
        }
    }
}
