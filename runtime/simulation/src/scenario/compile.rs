//! From what a scene file says to flat tables.

use super::language::{self, Amount, Names, Program, Sort, Spot, Type, Vocabulary};
use super::tables::{
    Action, BoardTable, Claims, Edge, EndTable, EventTable, GroupTable, How, NONE, Party, PlaceTable, Relation, Rule,
    Scenario, Schedule, Slot, State, Threshold, ValueTable, trigger,
};
use super::verbs::{Effect, Operand, Primitives, Verb, WORDS, Word};
use crate::scene::{ActionConfig, DoConfig, EventConfig, GraphConfig, LevelConfig, Scene, SiteConfig, WordConfig};
use glam::Vec3;
use std::collections::BTreeMap;
use throng_base::Result;
use throng_base::text::did_you_mean;

/// Most events, groups and places that are entered once: each is a bit.
const MOST_BITS: usize = 64;
/// Most events that are told on: bits of what agents sense of each other, less the one for meetings.
const MOST_TOLD: usize = 31;
/// Most thresholds: bits of 32.
const MOST_THRESHOLDS: usize = 32;

/// What is wrong with a key, and at which byte of its text.
struct Wrong {
    key: String,
    at: Option<usize>,
    why: String,
}

type Compiled<T> = std::result::Result<T, Wrong>;

fn wrong<T>(key: impl Into<String>, why: impl Into<String>) -> Compiled<T> {
    Err(Wrong { key: key.into(), at: None, why: why.into() })
}

impl Scenario {
    /// Compiles all that people of a scene live by; `None` where the scene says nothing of it.
    ///
    /// - `num`: of each group of the scene, its agents.
    ///
    /// # Errors
    /// [`throng_base::Error::Text`] with file, line, column, and the nearest name that is known.
    pub fn new(scene: &Scene, primitives: &Primitives) -> Result<Option<Self>> {
        if !scene.has_story() {
            return Ok(None);
        }
        let compiler = Compiler::new(scene, primitives.clone());
        let compiled = compiler.and_then(Compiler::compile);
        compiled.map(Some).map_err(|w| scene.fault_within(&w.key, w.at, w.why))
    }
}

struct Compiler<'a> {
    scene: &'a Scene,
    out: Scenario,
    /// Of each named behaviour that is compiled: first of its actions, and whether they take no time, by the event's kind.
    done: BTreeMap<(String, bool, bool), (u32, bool)>,
    graph_starts: BTreeMap<String, u32>,
    /// Names of states by graph.
    state_numbers: BTreeMap<(String, String), u32>,
}

impl<'a> Compiler<'a> {
    fn new(scene: &'a Scene, primitives: Primitives) -> Compiled<Self> {
        let names = |key: &str, all: Vec<&String>| -> Compiled<Names> {
            for (i, name) in all.iter().enumerate() {
                if name.is_empty() || all[..i].contains(name) {
                    return wrong(format!("{key}[{i}]"), format!("expected a `name` of its own, found \"{name}\""));
                }
            }
            Ok(Names(all.into_iter().cloned().collect()))
        };
        let of_agents: Vec<_> = scene.groups.iter().enumerate().filter(|(_, g)| g.is_of_agents()).collect();
        let mut kinds: Vec<String> = scene.places.iter().map(|p| p.kind.clone()).collect();
        kinds.sort();
        kinds.dedup();
        let mut states: Vec<String> = scene.graphs.values().flat_map(|g| g.states.keys().cloned()).collect();
        states.sort();
        states.dedup();
        let mut events: Vec<&String> = scene.events.iter().map(|e| &e.name).collect();
        let happenings: Vec<String> = (0..scene.happenings.len()).map(|i| format!("happening {i}")).collect();
        events.extend(&happenings);
        let words = Vocabulary {
            groups: Names(of_agents.iter().map(|(g, group)| group.title(*g)).collect()),
            states: Names(states),
            places: names("places", scene.places.iter().map(|p| &p.name).collect())?,
            kinds: Names(kinds),
            events: names("events", events)?,
            values: Names(scene.values.keys().cloned().collect()),
            doors: names("environment.doors", scene.environment.doors.iter().map(|d| &d.name).collect())?,
            things: names("things", scene.things.iter().map(|t| &t.name).collect())?,
            how: Names(How::NAMES.iter().map(|h| (*h).to_string()).collect()),
            has_other: false,
            has_place: false,
        };
        for (count, what, key) in [
            (words.events.0.len(), "events", "events"),
            (words.groups.0.len(), "groups of agents", "groups"),
            (scene.places.iter().filter(|p| p.once).count(), "places with `once`", "places"),
            (words.values.0.len(), "values", "values"),
        ] {
            if count > MOST_BITS {
                return wrong(key, format!("expected at most {MOST_BITS} {what}, found {count}"));
            }
        }
        let mut first = 0;
        let groups = of_agents.iter().map(|(g, group)| {
            let agents = [first, first + group.count as u32];
            first = agents[1];
            let there = group.source.as_ref().map_or(group.count, |s| s.start.min(group.count)) as u32;
            let rates = group.source.as_ref().map_or_else(Vec::new, |s| s.rates.clone());
            GroupTable { number: *g, start: NONE, agents, there, rates }
        });
        let out = Scenario {
            code: Vec::new(),
            groups: groups.collect(),
            names: words,
            primitives,
            values: Vec::new(),
            thresholds: Vec::new(),
            events: Vec::new(),
            places: Vec::new(),
            slots: Vec::new(),
            things: scene.things.iter().map(|t| Vec3::from_array(t.at)).collect(),
            rules: Vec::new(),
            rules_of: Vec::new(),
            rule_order: Vec::new(),
            num_pauses: 0,
            source: scene.source.clone(),
            graphs: scene.graphs.keys().cloned().collect(),
            states: Vec::new(),
            edges: Vec::new(),
            actions: Vec::new(),
            ways: Vec::new(),
            relations: Vec::new(),
            motions: Vec::new(),
            boards: BoardTable::default(),
            end: EndTable::default(),
            senses_zones: false,
            meets: false,
            senses_cells: false,
        };
        Ok(Self { scene, out, done: BTreeMap::new(), graph_starts: BTreeMap::new(), state_numbers: BTreeMap::new() })
    }

    fn compile(mut self) -> Compiled<Scenario> {
        self.values();
        self.places()?;
        self.thresholds()?;
        self.events()?;
        self.relations()?;
        self.states()?;
        self.rules()?;
        self.group_starts()?;
        self.end()?;
        self.out.boards = BoardTable { cell_m: self.scene.agents.cell_m, levels: 4 };
        let needs_cells = self
            .out
            .actions
            .iter()
            .any(|a| matches!(a, Action::Effect(Effect::Post, words) if words[1] != Operand::Nothing));
        if needs_cells && self.out.boards.cell_m == 0.0 {
            return wrong("agents.cell_m", "boards of cells need cells: set `agents.cell_m`, such as 5.0");
        }
        let has = |t: u16, out: &Scenario| {
            out.rules_of[usize::from(t)][0] < out.rules_of[usize::from(t)][1]
                || out.edges.iter().any(|e| e.trigger == t)
        };
        let out = &mut self.out;
        out.meets = has(trigger::MEETS, out);
        out.senses_zones =
            has(trigger::ENTERS, out) || has(trigger::LEAVES, out) || out.places.iter().any(|p| p.guidepost);
        out.senses_cells = has(trigger::CROSSES, out) || needs_cells;
        Ok(self.out)
    }

    fn values(&mut self) {
        for value in self.scene.values.values() {
            let pull = value.rest.map_or(0.0, |_| std::f32::consts::LN_2 / value.half_life_s);
            let rest = value.rest.unwrap_or(0.0);
            let (start, rate, limits) = (value.start, value.rate_per_s, value.limits);
            self.out.values.push(ValueTable { start, rate, rest, pull, limits, thresholds: [0; 2] });
        }
    }

    fn places(&mut self) -> Compiled<()> {
        let mut once = 0;
        for (i, site) in self.scene.places.iter().enumerate() {
            let kind = self.out.names.kinds.find(&site.kind).unwrap_or(0) as u16;
            let arrow = match &site.arrow {
                None => None,
                Some(to) => Some(self.name(Sort::Place, to, &format!("places[{i}].arrow"))?),
            };
            let first = self.out.slots.len() as u32;
            self.slots(i, site)?;
            let bit = site.once.then_some(once);
            once += u8::from(site.once);
            self.out.places.push(PlaceTable {
                at: point(&site.at),
                radius_m: site.radius_m,
                kind,
                guidepost: site.guidepost || arrow.is_some(),
                once: bit,
                arrow,
                slots: [first, self.out.slots.len() as u32],
                is_queue: site.queue.is_some(),
            });
        }
        Ok(())
    }

    fn slots(&mut self, place: usize, site: &SiteConfig) -> Compiled<()> {
        let (middle, number) = (point(&site.at), place as u16);
        for slot in &site.slots {
            let facing = slot.facing.as_ref().map_or(middle, |f| point(f));
            self.out.slots.push(Slot { at: point(&slot.at), facing, place: number });
        }
        let Some(queue) = &site.queue else { return Ok(()) };
        if !site.slots.is_empty() {
            return wrong(format!("places[{place}].queue"), "expected either `slots` or `queue`, found both");
        }
        let corners: Vec<Vec3> = queue.points.iter().map(|p| point(p)).collect();
        let mut facing = middle;
        let mut left = 0.0;
        for leg in corners.windows(2) {
            let length = leg[0].distance(leg[1]);
            while left <= length {
                let at = leg[0] + (leg[1] - leg[0]) * (left / length.max(1e-6));
                self.out.slots.push(Slot { at, facing, place: number });
                facing = at;
                left += queue.spacing_m;
            }
            left -= length;
        }
        Ok(())
    }

    /// Finds all thresholds that rules and edges name, by value.
    fn thresholds(&mut self) -> Compiled<()> {
        let scene = self.scene;
        let of_rules = scene.rules.iter().enumerate().map(|(i, r)| (format!("rules[{i}].on"), &r.on));
        let of_graphs = scene.graphs.iter().flat_map(|(name, graph)| {
            graph.edges.iter().enumerate().map(move |(i, e)| (format!("graphs.{name}.edges[{i}].on"), &e.on))
        });
        let mut all: Vec<Threshold> = Vec::new();
        for (key, on) in of_rules.chain(of_graphs) {
            if let Some(threshold) = self.threshold(on, &key)?
                && !all.iter().any(|t| same(t, &threshold))
            {
                all.push(threshold);
            }
        }
        if all.len() > MOST_THRESHOLDS {
            return wrong("rules", format!("expected at most {MOST_THRESHOLDS} thresholds, found {}", all.len()));
        }
        all.sort_by(|a, b| (a.value, a.at).partial_cmp(&(b.value, b.at)).unwrap_or(std::cmp::Ordering::Equal));
        for (v, value) in self.out.values.iter_mut().enumerate() {
            let first = all.partition_point(|t| usize::from(t.value) < v);
            let last = all.partition_point(|t| usize::from(t.value) <= v);
            value.thresholds = [first as u16, last as u16];
        }
        self.out.thresholds = all;
        Ok(())
    }

    /// `fatigue > 0.7`, if it is one.
    fn threshold(&self, on: &str, key: &str) -> Compiled<Option<Threshold>> {
        let Some((name, rises, at)) =
            on.split_once('>').map(|(n, a)| (n, true, a)).or_else(|| on.split_once('<').map(|(n, a)| (n, false, a)))
        else {
            return Ok(None);
        };
        let (name, number) = (name.trim(), at.trim().parse::<f32>());
        let Some(value) = self.out.names.values.find(name) else {
            let help = did_you_mean(name, self.out.names.values.0.iter().map(String::as_str));
            return wrong(key, format!("there is no value `{name}`: values are declared in `[values]`.{help}"));
        };
        let limits = self.out.values[value].limits;
        match number {
            Ok(at) if limits[0] <= at && at <= limits[1] => Ok(Some(Threshold { value: value as u16, at, rises })),
            _ => {
                let [low, high] = limits;
                wrong(key, format!("expected a number within the limits of `{name}`, {low} to {high}, found `{at}`"))
            }
        }
    }

    fn trigger(&self, on: &str, key: &str) -> Compiled<u16> {
        if let Some(built_in) = trigger::NAMES.iter().position(|n| *n == on) {
            return Ok(built_in as u16);
        }
        if let Some(threshold) = self.threshold(on, key)? {
            let number = self.out.thresholds.iter().position(|t| same(t, &threshold)).unwrap_or(0);
            return Ok(trigger::EVENTS + (self.out.names.events.0.len() + number) as u16);
        }
        if let Some(event) = self.out.names.events.find(on) {
            return Ok(trigger::EVENTS + event as u16);
        }
        let events = self.out.names.events.0.iter().map(String::as_str);
        let help = did_you_mean(on, trigger::NAMES.into_iter().chain(events));
        let all = trigger::NAMES.join(", ");
        wrong(key, format!("there is no event `{on}`: expected one of `[[events]]`, {all}, or `VALUE > NUMBER`.{help}"))
    }

    fn events(&mut self) -> Compiled<()> {
        let mut channel = 0;
        for (i, event) in self.scene.events.iter().enumerate() {
            if trigger::NAMES.contains(&event.name.as_str()) || event.name.contains(['<', '>']) {
                let why = format!("\"{}\" means something else: give the event another name", event.name);
                return wrong(format!("events[{i}].name"), why);
            }
            let table = self.event(event, &format!("events[{i}]"))?;
            self.out.events.push(table);
        }
        for (i, happening) in self.scene.happenings.iter().enumerate() {
            let who = match &happening.near {
                None => None,
                Some(near) => {
                    let at = &near.at;
                    let by = |name: &str, v: f32| format!("({name} - {v}) * ({name} - {v})");
                    let far = near.radius_m * near.radius_m;
                    let z = at.get(if at.len() == 3 { 2 } else { 1 }).copied().unwrap_or(0.0);
                    let text = format!("{} + {} <= {far}", by("x", at[0]), by("z", z)).replace("- -", "+ ");
                    Some(self.predicate(&text, &format!("happenings[{i}].near"), trigger::EVENTS)?)
                }
            };
            self.out.events.push(EventTable {
                schedule: Schedule::At(happening.time_s),
                who,
                nobody: false,
                channel: happening.told_on.then_some(0),
                posted: false,
                fresh_s: f64::INFINITY,
                doors: Vec::new(),
                condition: None,
            });
        }
        for event in &mut self.out.events {
            if event.channel.is_some() {
                event.channel = Some(channel);
                channel += 1;
            }
        }
        match usize::from(channel) > MOST_TOLD {
            true => wrong("events", format!("expected at most {MOST_TOLD} events that are told on, found {channel}")),
            false => Ok(()),
        }
    }

    fn event(&mut self, event: &EventConfig, key: &str) -> Compiled<EventTable> {
        let ways = [
            event.at_s.is_some(),
            event.between_s.is_some(),
            event.every_s.is_some(),
            event.period_s.is_some(),
            event.when.is_some(),
        ];
        if ways.iter().filter(|w| **w).count() > 1 {
            return wrong(key, "expected one of `at_s`, `between_s`, `every_s`, `period_s` and `when`, found several");
        }
        let schedule = match event {
            EventConfig { at_s: Some(at), .. } => Schedule::At(*at),
            EventConfig { between_s: Some([from, to]), .. } => Schedule::Between(*from, *to),
            EventConfig { every_s: Some(mean), .. } => Schedule::Poisson(*mean),
            EventConfig { period_s: Some(period), .. } => Schedule::Period(*period),
            _ => Schedule::Never,
        };
        let who = match &event.who {
            Some(who) => Some(self.predicate(who, &format!("{key}.who"), trigger::EVENTS)?),
            None => None,
        };
        let condition = match &event.when {
            Some(when) => Some(self.predicate(when, &format!("{key}.when"), trigger::STARTS)?),
            None => None,
        };
        let mut doors = Vec::new();
        for (names, open, word) in [(&event.opens, true, "opens"), (&event.closes, false, "closes")] {
            for (d, name) in names.iter().enumerate() {
                doors.push((self.name(Sort::Door, name, &format!("{key}.{word}[{d}]"))?, open));
            }
        }
        Ok(EventTable {
            doors,
            schedule,
            who,
            nobody: event.nobody,
            channel: event.told_on.then_some(0),
            posted: event.posted,
            fresh_s: event.fresh_s.unwrap_or(f64::INFINITY),
            condition,
        })
    }

    fn relations(&mut self) -> Compiled<()> {
        for (i, r) in self.scene.relations.iter().enumerate() {
            let key = format!("relations[{i}]");
            let (of, to) = (self.party(&r.of, &format!("{key}.of"))?, self.party(&r.to, &format!("{key}.to"))?);
            if matches!(of, Party::Place(_)) {
                return wrong(format!("{key}.of"), "expected a group, or an agent such as \"group:3\", found a place");
            }
            if matches!(to, Party::Place(_)) && r.friendship.is_some() {
                return wrong(format!("{key}.friendship"), "nobody is friends with a place: expected `curiosity`");
            }
            let (friendship, curiosity) = (r.friendship.unwrap_or(f32::NAN), r.curiosity.unwrap_or(f32::NAN));
            self.out.relations.push(Relation { of, to, share: r.share, friendship, curiosity });
        }
        Ok(())
    }

    fn party(&self, text: &str, key: &str) -> Compiled<Party> {
        if let Some(place) = self.out.names.places.find(text) {
            return Ok(Party::Place(place as u16));
        }
        let (name, number) = match text.rsplit_once(':') {
            Some((name, number)) => (name, Some(number.parse::<u32>())),
            None => (text, None),
        };
        let group = self.name(Sort::Group, name, key)?;
        let [first, last] = self.out.groups[usize::from(group)].agents;
        match number {
            None => Ok(Party::Group(group)),
            Some(Ok(n)) if first + n < last => Ok(Party::Agent(first + n)),
            Some(_) => wrong(key, format!("expected an agent from 0 to {}, found \"{text}\"", last - first - 1)),
        }
    }

    fn states(&mut self) -> Compiled<()> {
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
            let start = self.state_number(name, graph, &graph.start, &key)?;
            self.graph_starts.insert(name.clone(), start);
        }
        for (of, (name, graph)) in (0..).zip(&scene.graphs) {
            for (state, config) in &graph.states {
                let key = format!("graphs.{name}.states.{state}");
                let below = match &config.graph {
                    None => NONE,
                    Some(below) => self.below(below, graph.level, &format!("{key}.graph"))?,
                };
                let actions = match &config.does {
                    None if below == NONE => return wrong(key, "expected `do` or `graph`, found neither"),
                    None => NONE,
                    Some(does) => {
                        let (first, is_instant) = self.behaviour(does, &format!("{key}.do"), trigger::DONE)?;
                        if below != NONE && !is_instant {
                            return wrong(format!("{key}.do"), "before a graph, expected actions that take no time");
                        }
                        first
                    }
                };
                let (name, word) = (state.clone(), self.out.names.states.find(state).unwrap_or(0) as u16);
                let level = graph.level as u8;
                self.out.states.push(State { name, word, level, of, actions, graph: below, edges: [0; 2] });
            }
        }
        let mut at = 0;
        for (name, graph) in &scene.graphs {
            self.check_reached(name, graph)?;
            for state in graph.states.keys() {
                let first = self.out.edges.len() as u32;
                for (i, edge) in graph.edges.iter().enumerate() {
                    let key = format!("graphs.{name}.edges[{i}]");
                    if let Some(from) = &edge.from {
                        self.state_number(name, graph, from, &format!("{key}.from"))?;
                        if from != state {
                            continue;
                        }
                    }
                    let to = self.state_number(name, graph, &edge.to, &format!("{key}.to"))? as u16;
                    let trigger = self.trigger(&edge.on, &format!("{key}.on"))?;
                    let when = self.when(edge.when.as_deref(), &format!("{key}.when"), trigger)?;
                    let probability = edge.probability.unwrap_or(-1.0);
                    if edge.probability.is_some() && !(0.0..=1.0).contains(&probability) {
                        return wrong(format!("{key}.probability"), format!("expected 0 to 1, found {probability}"));
                    }
                    self.out.edges.push(Edge { trigger, to, when, probability, number: i as u16 });
                }
                let edges = &self.out.edges[first as usize..];
                for e in edges {
                    let same = edges.iter().filter(|o| o.trigger == e.trigger && o.when.is_none());
                    let sum: f32 = same.map(|o| o.probability.max(0.0)).sum();
                    if sum > 1.0 + 1e-5 {
                        let event = self.out.trigger_name(e.trigger);
                        let why =
                            format!("from `{state}`, probabilities at `{event}` add up to {sum}, expected at most 1");
                        return wrong(format!("graphs.{name}.edges"), why);
                    }
                }
                self.out.states[at].edges = [first, self.out.edges.len() as u32];
                at += 1;
            }
        }
        Ok(())
    }

    /// Every state of a graph can be reached from its start.
    fn check_reached(&self, name: &str, graph: &GraphConfig) -> Compiled<()> {
        let mut reached = vec![graph.start.as_str()];
        let mut at = 0;
        while at < reached.len() {
            let from = reached[at];
            for edge in &graph.edges {
                if edge.from.as_deref().is_none_or(|f| f == from) && !reached.contains(&edge.to.as_str()) {
                    reached.push(&edge.to);
                }
            }
            at += 1;
        }
        match graph.states.keys().find(|s| !reached.contains(&s.as_str())) {
            None => Ok(()),
            Some(state) => {
                let key = format!("graphs.{name}.states.{state}");
                wrong(
                    key,
                    format!("no edge leads to `{state}` from the start, `{}`: add one, or remove it", graph.start),
                )
            }
        }
    }

    fn state_number(&self, name: &str, graph: &GraphConfig, state: &str, key: &str) -> Compiled<u32> {
        if let Some(&number) = self.state_numbers.get(&(name.to_string(), state.to_string())) {
            return Ok(number);
        }
        let known: Vec<&str> = graph.states.keys().map(String::as_str).collect();
        let help = did_you_mean(state, known.iter().copied());
        wrong(key, format!("the graph has no state `{state}`: it has {}.{help}", known.join(", ")))
    }

    /// The start of a graph of a lower level.
    fn below(&self, name: &str, level: LevelConfig, key: &str) -> Compiled<u32> {
        let Some(graph) = self.scene.graphs.get(name) else {
            let help = did_you_mean(name, self.scene.graphs.keys().map(String::as_str));
            return wrong(key, format!("there is no graph `{name}`.{help}"));
        };
        if graph.level <= level {
            return wrong(
                key,
                format!("expected a graph of a lower level: `{name}` is {:?}", graph.level).to_lowercase(),
            );
        }
        Ok(self.graph_starts[name])
    }

    fn rules(&mut self) -> Compiled<()> {
        let mut triggers = Vec::new();
        for (i, rule) in self.scene.rules.iter().enumerate() {
            let key = format!("rules[{i}]");
            let trigger = self.trigger(&rule.on, &format!("{key}.on"))?;
            let when = self.when(rule.when.as_deref(), &format!("{key}.when"), trigger)?;
            if !(0.0..=1.0).contains(&rule.probability) {
                let found = rule.probability;
                return wrong(format!("{key}.probability"), format!("expected 0 to 1, found {found}"));
            }
            let mut who = if rule.who.is_empty() { u64::MAX } else { 0 };
            for (g, name) in rule.who.iter().enumerate() {
                who |= 1 << self.name(Sort::Group, name, &format!("{key}.who[{g}]"))?;
            }
            let (actions, is_instant) = self.behaviour(&rule.does, &format!("{key}.do"), trigger)?;
            let pause = self.out.num_pauses as u32;
            self.out.num_pauses += usize::from(rule.pause_s > 0.0);
            let name = if rule.name.is_empty() { format!("rule {i}") } else { rule.name.clone() };
            let (probability, priority, pause_s) = (rule.probability, rule.priority, rule.pause_s);
            self.out.rules.push(Rule { name, who, when, probability, actions, is_instant, priority, pause_s, pause });
            triggers.push(trigger);
        }
        self.happenings(&mut triggers);
        self.index_rules(&triggers);
        Ok(())
    }

    fn index_rules(&mut self, triggers: &[u16]) {
        let num = trigger::NAMES.len() + self.out.names.events.0.len() + self.out.thresholds.len();
        for t in 0..num {
            let first = self.out.rule_order.len() as u32;
            let of = triggers.iter().enumerate().filter(|(_, other)| usize::from(**other) == t);
            self.out.rule_order.extend(of.map(|(r, _)| r as u32));
            self.out.rules_of.push([first, self.out.rule_order.len() as u32]);
        }
    }

    /// Happenings are events with one rule: who learns of it takes the way to its goal.
    fn happenings(&mut self, triggers: &mut Vec<u16>) {
        for i in 0..self.scene.happenings.len() {
            let actions = self.out.actions.len() as u32;
            self.out.actions.extend([Action::Happening(i as u16), Action::End]);
            self.out.rules.push(Rule {
                name: format!("happenings[{i}]"),
                who: u64::MAX,
                when: None,
                probability: 1.0,
                actions,
                is_instant: true,
                priority: 0,
                pause_s: 0.0,
                pause: 0,
            });
            triggers.push(trigger::EVENTS + (self.scene.events.len() + i) as u16);
        }
    }

    fn group_starts(&mut self) -> Compiled<()> {
        for g in 0..self.out.groups.len() {
            let number = self.out.groups[g].number;
            let Some(graph) = &self.scene.groups[number].graph else { continue };
            let key = format!("groups[{number}].graph");
            let Some(&start) = self.graph_starts.get(graph) else {
                let help = did_you_mean(graph, self.scene.graphs.keys().map(String::as_str));
                return wrong(key, format!("there is no graph `{graph}`.{help}"));
            };
            self.out.groups[g].start = start;
        }
        Ok(())
    }

    fn end(&mut self) -> Compiled<()> {
        let end = &self.scene.end;
        let mut left = 0;
        for (i, name) in end.left.iter().enumerate() {
            left |= 1u64 << self.name(Sort::Group, name, &format!("end.left[{i}]"))?;
        }
        let event = |name: &Option<String>, key: &str| match name {
            Some(name) => self.name(Sort::Event, name, key).map(Some),
            None => Ok(None),
        };
        let (known, event) = (event(&end.known, "end.known")?, event(&end.event, "end.event")?);
        self.out.end = EndTable { left, known, event };
        Ok(())
    }

    fn name(&self, sort: Sort, name: &str, key: &str) -> Compiled<u16> {
        let found = self.out.names.number(sort, name);
        found.map(|n| n as u16).map_err(|why| Wrong { key: key.into(), at: None, why })
    }

    /// Names that an expression may use where it is about an event of a kind.
    fn scope(&mut self, trigger: u16) {
        let is_event = (trigger::EVENTS..trigger::EVENTS + self.out.names.events.0.len() as u16).contains(&trigger);
        // A behaviour of a state goes on through several events: it may name all of them.
        let any = trigger == trigger::DONE;
        self.out.names.has_other = any || is_event || trigger == trigger::MEETS;
        self.out.names.has_place =
            any || [trigger::ENTERS, trigger::LEAVES, trigger::ARRIVES, trigger::FULL].contains(&trigger);
    }

    fn when(&mut self, when: Option<&str>, key: &str, trigger: u16) -> Compiled<Option<Program>> {
        when.map(|text| self.predicate(text, key, trigger)).transpose()
    }

    fn predicate(&mut self, text: &str, key: &str, trigger: u16) -> Compiled<Program> {
        self.expression(text, Type::Truth, key, trigger)
    }

    fn expression(&mut self, text: &str, of: Type, key: &str, trigger: u16) -> Compiled<Program> {
        self.scope(trigger);
        let Scenario { code, names, .. } = &mut self.out;
        let compiled = language::parse(text).and_then(|node| language::compile(&node, of, names, code));
        compiled.map_err(|fault| Wrong { key: key.into(), at: Some(fault.at), why: fault.why })
    }

    /// The actions of a behaviour: the first of them, and whether all take no time.
    fn behaviour(&mut self, does: &DoConfig, key: &str, trigger: u16) -> Compiled<(u32, bool)> {
        let (actions, key) = match does {
            DoConfig::Actions(actions) => (actions, key.to_string()),
            DoConfig::Named(name) => {
                self.scope(trigger);
                let known = (name.clone(), self.out.names.has_other, self.out.names.has_place);
                if let Some(&done) = self.done.get(&known) {
                    return Ok(done);
                }
                let Some(actions) = self.scene.behaviours.get(name) else {
                    let help = did_you_mean(name, self.scene.behaviours.keys().map(String::as_str));
                    return wrong(key, format!("there is no behaviour `{name}` in `[behaviours]`.{help}"));
                };
                let done = self.actions(actions, &format!("behaviours.{name}"), trigger)?;
                self.done.insert(known, done);
                return Ok(done);
            }
        };
        self.actions(actions, &key, trigger)
    }

    fn actions(&mut self, actions: &[ActionConfig], key: &str, trigger: u16) -> Compiled<(u32, bool)> {
        if actions.is_empty() {
            return wrong(key, "expected at least one action, found none");
        }
        let mut compiled = Vec::new();
        for (i, action) in actions.iter().enumerate() {
            compiled.push(self.action(action, &format!("{key}[{i}]"), trigger)?);
        }
        let is_instant = compiled.iter().all(|a| matches!(a, Action::Effect(..)));
        let first = self.out.actions.len() as u32;
        self.out.actions.extend(compiled);
        self.out.actions.push(Action::End);
        Ok((first, is_instant))
    }

    fn action(&mut self, action: &ActionConfig, key: &str, trigger: u16) -> Compiled<Action> {
        // `speed` is a verb of its own, and a word of others.
        let verbs: Vec<&String> = action.keys().filter(|k| self.out.primitives.verb(k).is_some()).collect();
        let own: Vec<&String> = verbs.iter().copied().filter(|k| verbs.len() == 1 || *k != "speed").collect();
        let [name] = own[..] else {
            let found: Vec<_> = action.keys().map(String::as_str).collect();
            let help = found.iter().map(|word| did_you_mean(word, self.out.primitives.verbs())).find(|h| !h.is_empty());
            let all: Vec<_> = self.out.primitives.verbs().collect();
            let why = match (own.is_empty(), help) {
                (true, Some(help)) => format!("there is no action `{}`.{help}", found.join("`, `")),
                (true, None) => format!("expected one of {}, found `{}`", all.join(", "), found.join("`, `")),
                (false, _) => format!("expected one action in one table, found `{}`", found.join("`, `")),
            };
            return wrong(key, why);
        };
        let Some((verb, words)) = self.out.primitives.verb(name) else { return wrong(key, "expected an action") };
        let mut said = [Operand::Nothing; WORDS];
        let (mut motion, mut way, mut claims) = (None, None, Claims::Nothing);
        if let Verb::Primitive(number) = verb {
            motion = self.out.primitives.get(number).motion.map(|tag| self.motion(tag));
        }
        for (word, value) in action {
            let Some(at) = words.iter().position(|w| w.0 == word) else {
                let help = did_you_mean(word, words.iter().map(|w| w.0));
                let all: Vec<_> = words.iter().map(|w| w.0).collect();
                return wrong(key, format!("`{name}` has no word `{word}`, expected {}.{help}", all.join(", ")));
            };
            let word_key = format!("{key}.{word}");
            said[at] = match (words[at].1, value) {
                (Word::Motion, WordConfig::Text(tag)) => {
                    motion = Some(self.motion(tag));
                    Operand::Nothing
                }
                (Word::Points, WordConfig::Points(points)) if points.len() > 1 => {
                    way = Some(self.out.ways.len() as u16);
                    self.out.ways.push(points.iter().map(|p| point(p)).collect());
                    Operand::Nothing
                }
                (kind, value) => self.word(kind, value, &word_key, trigger)?,
            };
            if words[at].1 == Word::Place
                && let Operand::Number(place) = said[at]
            {
                claims = Claims::Queue(Some(place));
            }
        }
        match words[0].1 {
            Word::Take | Word::Put => {
                let Operand::Number(thing) = said[0] else { return wrong(key, "expected the name of a thing") };
                claims = if words[0].1 == Word::Take { Claims::Take(thing) } else { Claims::Put(thing) };
            }
            Word::Slot if matches!(said[0], Operand::Spot(_)) => claims = Claims::Slot,
            Word::Queue => {
                let is_queue =
                    matches!(said[0], Operand::Spot(Spot::Place(p)) if self.out.places[usize::from(p)].is_queue);
                if !is_queue && said[0] != Operand::Spot(Spot::Here) {
                    return wrong(format!("{key}.{name}"), "expected the name of a place with a `queue`");
                }
                claims = if claims == Claims::Nothing { Claims::Queue(None) } else { claims };
            }
            _ => {}
        }
        Ok(match verb {
            Verb::Effect(effect) => Action::Effect(effect, said),
            Verb::Primitive(number) => Action::Primitive { number, words: said, motion, way, claims },
        })
    }

    fn motion(&mut self, tag: &str) -> u16 {
        let motions = &mut self.out.motions;
        let number = motions.iter().position(|m| m == tag).unwrap_or_else(|| {
            motions.push(tag.into());
            motions.len() - 1
        });
        number as u16
    }

    fn word(&mut self, kind: Word, value: &WordConfig, key: &str, trigger: u16) -> Compiled<Operand> {
        let expected = |what: &str| wrong(key, format!("expected {what}"));
        Ok(match (kind, value) {
            (Word::Flag, WordConfig::Flag(flag)) => Operand::Flag(*flag),
            (Word::Flag, _) => return expected("true or false"),
            (Word::Amount, WordConfig::Number(number)) => Operand::Amount(Amount::Number(*number)),
            (Word::Amount, WordConfig::Text(text)) => {
                Operand::Amount(Amount::Program(self.expression(text, Type::Number, key, trigger)?))
            }
            (Word::Amount, _) => return expected("a number, or an expression in quotes"),
            (Word::Target | Word::Slot | Word::Queue, WordConfig::Point(at)) => {
                let dimensions = self.scene.environment.space.dimensions();
                if at.len() != dimensions {
                    return expected(&format!("a point of {dimensions} numbers"));
                }
                Operand::Point(point(at).to_array())
            }
            (Word::Target | Word::Slot | Word::Queue, WordConfig::Text(text)) => {
                self.scope(trigger);
                let (has_other, has_place) = (self.out.names.has_other, self.out.names.has_place);
                match text.as_str() {
                    "me" => Operand::Spot(Spot::Me),
                    "home" => Operand::Spot(Spot::Home),
                    "arrow" if has_place => Operand::Arrow,
                    "other" if has_other => Operand::Spot(Spot::Other),
                    "place" if has_place => Operand::Spot(Spot::Here),
                    "other" | "place" | "arrow" => return expected(&format!("somewhere: this event has no `{text}`")),
                    name => Operand::Spot(Spot::Place(self.name(Sort::Place, name, key)?)),
                }
            }
            (Word::Target | Word::Slot | Word::Queue, _) => return expected("a point, or the name of a place"),
            (Word::Rest, WordConfig::Point(at)) if at.len() == 3 => Operand::Point(point(at).to_array()),
            (Word::Rest, _) => return expected("a point of three numbers: x, y up, z"),
            (Word::Take | Word::Put, WordConfig::Text(name)) => Operand::Number(self.name(Sort::Thing, name, key)?),
            (Word::Place, WordConfig::Text(name)) => Operand::Number(self.name(Sort::Place, name, key)?),
            (Word::Event, WordConfig::Text(name)) => Operand::Number(self.name(Sort::Event, name, key)?),
            (Word::Door, WordConfig::Text(name)) => Operand::Number(self.name(Sort::Door, name, key)?),
            (Word::Value, WordConfig::Text(name)) => match self.out.names.values.find(name) {
                Some(value) => Operand::Number(value as u16),
                None => {
                    let help = did_you_mean(name, self.out.names.values.0.iter().map(String::as_str));
                    return wrong(key, format!("there is no value `{name}`.{help}"));
                }
            },
            (Word::Motion, _) => return expected("a tag of motion, in quotes"),
            (Word::Points, _) => return expected("two points or more"),
            _ => return expected("a name in quotes"),
        })
    }
}

fn same(a: &Threshold, b: &Threshold) -> bool {
    (a.value, a.at.to_bits(), a.rises) == (b.value, b.at.to_bits(), b.rises)
}

/// A point of the file in the world.
pub(super) fn point(of: &[f32]) -> Vec3 {
    match of {
        [x, y, z] => Vec3::new(*x, *y, *z),
        [x, z] => Vec3::new(*x, 0.0, *z),
        _ => Vec3::ZERO,
    }
}
