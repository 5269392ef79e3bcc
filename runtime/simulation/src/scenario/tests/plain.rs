//! A slow reading of what a scene says, straight from the words of the file and of the papers: lists that are searched, names that
//! are compared, trees that are walked. It lives the same lives as the compiled tables.

use super::super::action_registry::{ActionArguments, ActionCommand, ActionRegistry, PrimitiveInput, WalkCommand};
use super::super::language::{ExpressionNode, ExpressionTree, parse_expression};
use super::super::perceive::hashed_chance;
use super::random::script;
use super::{Lives, Paper, ScenarioStage, Signal, brains, play, scene};
use crate::scene::{ActionConfig, Scene, StateConfig, StoryBehaviour, WordConfig};
use glam::Vec3;
use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

const NEVER: f64 = f64::INFINITY;

/// The event that something is about.
#[derive(Clone, Debug, Default)]
struct About {
    event: String,
    how: &'static str,
    other: Option<u32>,
    strength: Option<f32>,
}

#[derive(Clone, Debug, Default)]
struct Doing {
    actions: Vec<ActionConfig>,
    at: usize,
    about: About,
}

#[derive(Clone, Debug, Default)]
struct Person {
    is_there: bool,
    /// (graph, state) by level.
    states: [Option<(String, String)>; 3],
    doing: Option<Doing>,
    walks: bool,
    until: f64,
    again: f64,
    most: f64,
    /// Priority of the rule whose behaviour lasts, and what it interrupted.
    busy: Option<(i8, Option<Doing>)>,
    timer: f64,
    news: BTreeSet<String>,
    /// How, from whom, when.
    learnt: BTreeMap<String, (String, Option<u32>, f64)>,
    /// Value, rate, since.
    values: BTreeMap<String, (f32, f32, f64)>,
    /// Thresholds that are passed.
    passed: BTreeSet<String>,
    slot: Option<(String, usize)>,
    relationships: Vec<(u32, f32)>,
    followed: BTreeMap<usize, f64>,
    draws: u32,
    home: Vec3,
    begun: u32,
}

/// An event on a board, its cell, and until when.
type Post = (String, Option<(i32, i32, i32)>, f64);

pub(super) struct Plain {
    scene: Scene,
    now: f64,
    people: Vec<Person>,
    due: Vec<(f64, u32)>,
    happened: BTreeMap<String, f64>,
    posts: Vec<Post>,
    /// What happens to whom, and how many behaviours that one had begun.
    queue: Vec<(u32, String, About, u32)>,
    touched: Vec<u32>,
}

impl Plain {
    pub fn new(scene: &Scene) -> Self {
        let num = scene.num_characters();
        let due = scene.events.iter().map(|e| (e.period_s.or(e.at_s).unwrap_or(NEVER), 0)).collect();
        let person = Person { until: NEVER, again: NEVER, most: NEVER, timer: NEVER, ..Person::default() };
        let (happened, people) = (BTreeMap::new(), vec![person; num]);
        Self { scene: scene.clone(), now: 0.0, people, due, happened, posts: vec![], queue: vec![], touched: vec![] }
    }

    fn chance(&mut self, a: u32) -> f64 {
        self.people[a as usize].draws += 1;
        hashed_chance(self.scene.seed, a, self.people[a as usize].draws)
    }

    fn touch(&mut self, a: u32) {
        if !self.touched.contains(&a) {
            self.touched.push(a);
        }
    }

    fn value(&self, a: u32, name: &str) -> f32 {
        let (value, rate, since) = self.people[a as usize].values[name];
        let config = &self.scene.values[name];
        let after = self.now - since;
        let value = match config.rest {
            Some(rest) => {
                let pull = std::f32::consts::LN_2 / config.half_life_s;
                let end = f64::from(rest) + f64::from(rate / pull);
                end + (f64::from(value) - end) * throng_base::maths::exp(-f64::from(pull) * after)
            }
            None => f64::from(value) + f64::from(rate) * after,
        };
        (value as f32).clamp(config.limits[0], config.limits[1])
    }

    /// All thresholds that anything waits for: value, number, rises.
    fn thresholds(&self) -> Vec<(String, f32, bool, String)> {
        let edges = self.scene.graphs.values().flat_map(|g| g.edges.iter().map(|e| &e.on));
        let mut all: Vec<_> = self
            .scene
            .rules
            .iter()
            .map(|r| &r.on)
            .chain(edges)
            .filter_map(|on| {
                let (name, rises, at) = match (on.split_once('>'), on.split_once('<')) {
                    (Some((n, a)), _) => (n, true, a),
                    (_, Some((n, a))) => (n, false, a),
                    _ => return None,
                };
                Some((name.trim().to_string(), at.trim().parse::<f32>().unwrap(), rises, on.clone()))
            })
            .collect();
        all.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        all.dedup_by(|a, b| a.3 == b.3);
        all
    }

    fn change(&mut self, a: u32, name: &str, change: impl FnOnce(&mut f32, &mut f32)) {
        let now = self.now;
        let value = self.value(a, name);
        let limits = self.scene.values[name].limits;
        let own = self.people[a as usize].values.get_mut(name).unwrap();
        (own.0, own.2) = (value, now);
        let (mut v, mut r) = (own.0, own.1);
        change(&mut v, &mut r);
        (own.0, own.1) = (v.clamp(limits[0], limits[1]), r);
        let is = own.0;
        for (value, at, rises, on) in self.thresholds() {
            if value != name {
                continue;
            }
            let passed = if rises { is >= at } else { is <= at };
            let own = &mut self.people[a as usize].passed;
            let was = if passed { !own.insert(on.clone()) } else { own.remove(&on) };
            if passed && !was {
                self.push(a, on, About::default());
            }
        }
        self.touch(a);
    }

    /// The next threshold that is passed by itself.
    fn crossing(&self, a: u32) -> Option<(f64, String, String, f32)> {
        let mut best: Option<(f64, String, String, f32)> = None;
        for (name, at, _, on) in self.thresholds() {
            let person = &self.people[a as usize];
            if person.passed.contains(&on) {
                continue;
            }
            let (value, rate, since) = person.values[&name];
            let config = &self.scene.values[&name];
            let after = match config.rest {
                Some(rest) => {
                    let pull = std::f32::consts::LN_2 / config.half_life_s;
                    let end = f64::from(rest) + f64::from(rate / pull);
                    let left = (f64::from(at) - end) / (f64::from(value) - end);
                    if left > 0.0 && left < 1.0 { -throng_base::maths::ln(left) / f64::from(pull) } else { -1.0 }
                }
                None => (f64::from(at) - f64::from(value)) / f64::from(rate),
            };
            if (0.0..1e9).contains(&after) && best.as_ref().is_none_or(|b| since + after < b.0) {
                best = Some((since + after, on, name, at));
            }
        }
        best
    }

    fn friendship(&self, a: u32, b: u32) -> f32 {
        let of_all = self.scene.relations.iter().enumerate().rev().find_map(|(n, r)| {
            let knows =
                r.share >= 1.0 || hashed_chance(self.scene.seed ^ n as u64, a.min(b), a.max(b)) < f64::from(r.share);
            r.friendship.filter(|_| knows)
        });
        let relationship = self.people[a as usize].relationships.iter().find(|b2| b2.0 == b).map_or(0.0, |b| b.1);
        (of_all.unwrap_or(0.0) + relationship).clamp(-1.0, 1.0)
    }

    /// What an expression is worth: a number, or a truth as 0 or 1.
    fn worth(&mut self, node: &ExpressionNode, a: u32, about: &About) -> f64 {
        let truth = |is: bool| f64::from(u8::from(is));
        match &node.tree {
            ExpressionTree::Number(n) => *n,
            ExpressionTree::Truth(t) => truth(*t),
            ExpressionTree::Word(word) => match word.as_str() {
                "random" => self.chance(a),
                "time" => self.now,
                "other.busy" => truth(about.other.is_some_and(|o| self.people[o as usize].busy.is_some())),
                "event.strength" => f64::from(about.strength.unwrap_or(1.0)),
                "me.number" => f64::from(a),
                word => f64::from(self.value(a, word.trim_start_matches("me."))),
            },
            ExpressionTree::Unary("-", x) => -self.worth(x, a, about),
            ExpressionTree::Unary(_, x) => truth(self.worth(x, a, about) == 0.0),
            ExpressionTree::Binary("and", x, y) => {
                truth(self.worth(x, a, about) != 0.0 && self.worth(y, a, about) != 0.0)
            }
            ExpressionTree::Binary("or", x, y) => {
                truth(self.worth(x, a, about) != 0.0 || self.worth(y, a, about) != 0.0)
            }
            ExpressionTree::Binary("in", x, _) => {
                let ExpressionTree::Text(name) = &x.tree else { panic!("{x:?}") };
                truth(self.people[a as usize].news.contains(name))
            }
            ExpressionTree::Binary(op, x, y) => {
                let (x, y) = (self.worth(x, a, about), self.worth(y, a, about));
                match *op {
                    "<" => truth(x < y),
                    ">" => truth(x > y),
                    "+" => x + y,
                    "*" => x * y,
                    op => panic!("{op}"),
                }
            }
            ExpressionTree::Call(name, _) if name == "friendship" => {
                about.other.map_or(0.0, |o| f64::from(self.friendship(a, o)))
            }
            other => panic!("{other:?}"),
        }
    }

    fn holds(&mut self, text: Option<&String>, a: u32, about: &About) -> bool {
        text.is_none_or(|t| self.worth(&parse_expression(t).unwrap(), a, about) != 0.0)
    }

    fn push(&mut self, a: u32, on: impl Into<String>, about: About) {
        let begun = self.people[a as usize].begun;
        self.queue.push((a, on.into(), about, begun));
    }

    fn learn(&mut self, a: u32, about: About) {
        let known = self.people[a as usize].news.contains(&about.event);
        if known && ["passed_on", "read"].contains(&about.how) {
            return;
        }
        let person = &mut self.people[a as usize];
        person.news.insert(about.event.clone());
        if !known {
            person.learnt.insert(about.event.clone(), (about.how.into(), about.other, self.now));
        }
        self.touch(a);
        self.push(a, about.event.clone(), about);
    }

    fn read(&mut self, stage: &Paper, a: u32) {
        let at = stage.position(a).unwrap();
        let side = self.scene.agents.cell_m;
        for e in self.scene.events.clone() {
            let shown = self.posts.iter().any(|(event, cell, until)| {
                let here = cell.is_none_or(|(level, x, z)| {
                    let side = side * (1 << level) as f32;
                    ((at.x / side).floor() as i32, (at.z / side).floor() as i32) == (x, z)
                });
                *event == e.name && here && self.now <= *until
            });
            if shown && !self.people[a as usize].news.contains(&e.name) {
                self.learn(a, About { event: e.name, how: "read", ..About::default() });
            }
        }
    }

    fn actions(&self, does: &StoryBehaviour) -> Vec<ActionConfig> {
        match does {
            StoryBehaviour::Named(name) => self.scene.behaviours[name].clone(),
            StoryBehaviour::Actions(all) => all.clone(),
        }
    }

    /// The verb of an action, and what is said of it.
    fn action_name(action: &ActionConfig) -> &str {
        let known = [
            "set", "add", "timer", "post", "convey", "befriend", "release", "greet", "flee", "roam", "stay", "go",
            "buy",
        ];
        known.into_iter().find(|v| action.contains_key(*v)).expect("a verb that scenes of these tests have")
    }

    fn takes_time(action: &ActionConfig) -> bool {
        ["greet", "flee", "roam", "stay", "go", "buy"].contains(&Self::action_name(action))
    }

    fn said(&mut self, a: u32, about: &About, word: Option<&WordConfig>) -> Option<f64> {
        match word? {
            WordConfig::Number(n) => Some(*n),
            WordConfig::Flag(f) => Some(f64::from(u8::from(*f))),
            WordConfig::Text(t) => Some(self.worth(&parse_expression(t).unwrap(), a, about)),
            _ => None,
        }
    }

    fn affect(&mut self, stage: &mut Paper, a: u32, action: &ActionConfig, about: &About) {
        let text = |word: &str| match &action[word] {
            WordConfig::Text(t) => t.clone(),
            other => panic!("{other:?}"),
        };
        let of = |plain: &mut Self, word: &str| plain.said(a, about, action.get(word));
        match Self::action_name(action) {
            "set" => {
                let to = of(self, "to").unwrap() as f32;
                self.change(a, &text("set"), |v, _| *v = to);
            }
            "add" => {
                let by = of(self, "by").unwrap() as f32;
                self.change(a, &text("add"), |v, _| *v += by);
            }
            "timer" => self.people[a as usize].timer = self.now + of(self, "timer").unwrap(),
            "post" => {
                let (level, long) = (of(self, "cells").unwrap() as i32, of(self, "for_s").unwrap_or(NEVER));
                let at = stage.position(a).unwrap();
                let side = self.scene.agents.cell_m * (1 << level) as f32;
                let cell = (level, (at.x / side).floor() as i32, (at.z / side).floor() as i32);
                let event = text("post");
                self.happened.insert(event.clone(), self.now);
                self.posts.retain(|p| p.0 != event || p.1 != Some(cell));
                self.posts.push((event, Some(cell), self.now + long));
            }
            "convey" => {
                let (within, friends) =
                    (of(self, "within_m").unwrap() as f32, of(self, "friends").unwrap_or(0.0) > 0.0);
                let (event, at) = (text("convey"), stage.position(a).unwrap());
                self.happened.insert(event.clone(), self.now);
                for b in (0..self.people.len() as u32).filter(|b| *b != a) {
                    let far = stage.position(b).unwrap().distance(at);
                    let liking = if friends { self.friendship(b, a).max(0.0) } else { 1.0 };
                    let strength = (1.0 - far / within) * liking;
                    if far <= within && strength > 0.0 {
                        let about =
                            About { event: event.clone(), how: "felt", other: Some(a), strength: Some(strength) };
                        self.learn(b, about);
                    }
                }
            }
            "befriend" => {
                let (Some(other), by) = (about.other, of(self, "befriend").unwrap() as f32) else { return };
                let relationships = &mut self.people[a as usize].relationships;
                let old = relationships.iter().position(|b| b.0 == other).map_or(0.0, |i| relationships.remove(i).1);
                relationships.insert(0, (other, (old + by).clamp(-2.0, 2.0)));
                relationships.truncate(4);
            }
            "release" => self.people[a as usize].slot = None,
            other => panic!("{other}"),
        }
    }

    /// Begins or goes on with what somebody does, from an action on.
    fn go_on(&mut self, stage: &mut Paper, a: u32, mut at: usize) {
        loop {
            let person = &mut self.people[a as usize];
            (person.until, person.again, person.most, person.walks) = (NEVER, NEVER, NEVER, false);
            let Some(doing) = &mut person.doing else { return };
            doing.at = at;
            let (action, about) = (doing.actions.get(at).cloned(), doing.about.clone());
            let Some(action) = action else {
                match self.people[a as usize].busy.take() {
                    None => self.push(a, "done", About::default()),
                    Some((_, before)) => {
                        self.people[a as usize].doing = before;
                        if let Some(before) = &self.people[a as usize].doing {
                            let at = before.at;
                            self.go_on(stage, a, at);
                        } else if self.people[a as usize].states.iter().all(Option::is_none) {
                            stage.resume_route(a).unwrap();
                        }
                    }
                }
                return;
            };
            if Self::takes_time(&action) {
                return self.perform(stage, a, &action, &about);
            }
            self.affect(stage, a, &action, &about);
            at += 1;
        }
    }

    fn ended(&mut self, stage: &mut Paper, a: u32) {
        stage.set_speed(a, 1.3).unwrap();
        stage.show_activity(a, None, None);
        let at = self.people[a as usize].doing.as_ref().unwrap().at;
        self.go_on(stage, a, at + 1);
    }

    /// The command that an action gives now.
    fn command(
        &mut self,
        stage: &Paper,
        a: u32,
        action: &ActionConfig,
        about: &About,
        chance: [f32; 2],
    ) -> ActionCommand {
        let primitives = ActionRegistry::default();
        let name = Self::action_name(action);
        let primitive = (0..).map(|n| *primitives.get(n)).find(|p| p.name == name).unwrap();
        let mut said = ActionArguments { arrival_m: 0.5, ..ActionArguments::default() };
        for (i, (word, kind)) in primitive.words.iter().enumerate() {
            let Some(value) = action.get(*word) else { continue };
            if !matches!(
                kind,
                super::super::action_registry::WordKind::Target | super::super::action_registry::WordKind::Slot
            ) {
                said.amounts[i] = self.said(a, about, Some(value));
                continue;
            }
            let WordConfig::Text(to) = value else { panic!("{value:?}") };
            said.targets[i] = match to.as_str() {
                "home" => Some(self.people[a as usize].home),
                "other" => about.other.and_then(|o| stage.position(o)),
                name => {
                    let site = self.scene.places.iter().find(|p| p.name == *name).unwrap();
                    Some(Vec3::new(site.at[0], 0.0, site.at[1]))
                }
            };
        }
        if let Some((place, slot)) = &self.people[a as usize].slot {
            let site = self.scene.places.iter().find(|p| p.name == *place).unwrap();
            let at = &site.slots[*slot].at;
            said.targets[0] = Some(Vec3::new(at[0], 0.0, at[1]));
            said.facing = Some(Vec3::new(site.at[0], 0.0, site.at[1]));
            said.arrival_m = 0.15;
        }
        let (position, velocity) = (stage.position(a).unwrap(), stage.velocity(a));
        let home = self.people[a as usize].home;
        (primitive.act)(&PrimitiveInput { time_s: self.now, position, velocity, desired_mps: 1.3, home, chance }, &said)
    }

    fn perform(&mut self, stage: &mut Paper, a: u32, action: &ActionConfig, about: &About) {
        // Amounts are asked for before chances, as they are said first.
        let draws = self.people[a as usize].draws;
        if Self::action_name(action) == "buy" {
            let WordConfig::Text(name) = &action["buy"] else { panic!() };
            let site = self.scene.places.iter().find(|p| p.name == *name).unwrap().clone();
            let at = stage.position(a).unwrap();
            let holds = |plain: &Self, slot: usize| {
                plain.people.iter().any(|p| p.slot.as_ref().is_some_and(|s| s.0 == *name && s.1 == slot))
            };
            if self.people[a as usize].slot.as_ref().is_none_or(|s| s.0 != *name) {
                let far = |slot: &usize| {
                    let s = &site.slots[*slot].at;
                    Vec3::new(s[0], 0.0, s[1]).distance_squared(at)
                };
                let free = (0..site.slots.len()).filter(|s| !holds(self, *s)).min_by(|x, y| far(x).total_cmp(&far(y)));
                let Some(slot) = free else {
                    // What is said is asked for all the same.
                    self.command(stage, a, action, about, [0.0; 2]);
                    self.push(a, "full", About::default());
                    return self.ended(stage, a);
                };
                self.people[a as usize].slot = Some((name.clone(), slot));
            }
        } else {
            self.people[a as usize].slot = None;
        }
        // Amounts draw first, then two chances; the function is asked with both.
        self.command(stage, a, action, about, [0.0; 2]);
        let chance = [self.chance(a) as f32, self.chance(a) as f32];
        let after = self.people[a as usize].draws;
        self.people[a as usize].draws = draws;
        let command = self.command(stage, a, action, about, chance);
        self.people[a as usize].draws = after;
        if let Some(speed) = command.speed_mps {
            stage.set_speed(a, speed).unwrap();
        }
        let now = self.now;
        let position = stage.position(a).unwrap();
        let person = &mut self.people[a as usize];
        person.most = now + command.most_s;
        match command.walk {
            WalkCommand::Halt => {
                stage.order_halt(a).unwrap();
                stage.show_activity(a, ["greet", "buy"].contains(&Self::action_name(action)).then_some(0), None);
                if command.stay_s > 0.0 { person.until = now + command.stay_s } else { self.ended(stage, a) }
            }
            // Nothing is in the way on paper.
            WalkCommand::To { at, arrival_m }
            | WalkCommand::Near { at, arrival_m, .. }
            | WalkCommand::Away { at, arrival_m, .. } => {
                person.walks = true;
                if position.distance(at) <= arrival_m {
                    self.arrived(stage, a);
                } else {
                    stage.order_walk(a, at, arrival_m, false).unwrap();
                }
            }
            other => panic!("{other:?}"),
        }
    }

    fn arrived(&mut self, stage: &mut Paper, a: u32) {
        let doing = self.people[a as usize].doing.clone().unwrap();
        let action = &doing.actions[doing.at];
        let command = self.command(stage, a, action, &doing.about, [0.0; 2]);
        self.people[a as usize].walks = false;
        if command.stay_s <= 0.0 {
            self.people[a as usize].walks = true;
            return self.ended(stage, a);
        }
        stage.show_activity(a, ["greet", "buy"].contains(&Self::action_name(action)).then_some(0), None);
        self.people[a as usize].until = self.now + command.stay_s;
    }

    fn enter_state(&mut self, stage: &mut Paper, a: u32, graph: &str, state: &str, about: &About) {
        let person = &mut self.people[a as usize];
        person.busy = None;
        let (mut graph, mut state) = (graph.to_string(), state.to_string());
        loop {
            let level = self.scene.graphs[&graph].level as usize;
            let config: StateConfig = self.scene.graphs[&graph].states[&state].clone();
            let person = &mut self.people[a as usize];
            person.states[level] = Some((graph.clone(), state.clone()));
            person.states[level + 1..].fill(None);
            let Some(below) = config.graph else {
                let actions = self.actions(&config.does.unwrap());
                self.people[a as usize].begun += 1;
                self.people[a as usize].doing = Some(Doing { actions, at: 0, about: about.clone() });
                return self.go_on(stage, a, 0);
            };
            state = self.scene.graphs[&below].start.clone();
            graph = below;
        }
    }

    fn handle(&mut self, stage: &mut Paper, a: u32, on: &str, about: &About) {
        for (r, rule) in self.scene.rules.clone().into_iter().enumerate() {
            let actions = self.actions(&rule.does);
            let lasts = actions.iter().any(Self::takes_time);
            let person = &self.people[a as usize];
            let is_held = lasts && person.busy.as_ref().is_some_and(|b| b.0 > rule.priority);
            let waits = person.followed.get(&r).is_some_and(|t| self.now - t < f64::from(rule.pause_s));
            if rule.on != on || is_held || rule.pause_s > 0.0 && waits || !self.holds(rule.when.as_ref(), a, about) {
                continue;
            }
            if rule.probability < 1.0 && self.chance(a) >= f64::from(rule.probability) {
                continue;
            }
            self.people[a as usize].followed.insert(r, self.now);
            if !lasts {
                actions.iter().for_each(|action| self.affect(stage, a, action, about));
                break;
            }
            let person = &mut self.people[a as usize];
            let before = match person.busy.take() {
                Some((_, before)) => before,
                None => person.doing.take(),
            };
            person.busy = Some((rule.priority, before));
            person.begun += 1;
            person.doing = Some(Doing { actions, at: 0, about: about.clone() });
            return self.go_on(stage, a, 0);
        }
        let mut levels = [0, 1, 2];
        if on == "done" {
            levels.reverse();
        }
        for level in levels {
            let Some((graph, state)) = self.people[a as usize].states[level].clone() else { continue };
            let edges = self.scene.graphs[&graph].edges.clone();
            let mut open = Vec::new();
            for edge in edges {
                if edge.from.as_ref().is_none_or(|f| *f == state)
                    && edge.on == on
                    && self.holds(edge.when.as_ref(), a, about)
                {
                    open.push(edge);
                }
            }
            let said: f32 = open.iter().filter_map(|e| e.probability).sum();
            let unsaid = open.iter().filter(|e| e.probability.is_none()).count();
            let chances: Vec<f32> = open
                .iter()
                .map(|e| e.probability.map_or((1.0 - said).max(0.0) / unsaid as f32, |p| p / said.max(1.0)))
                .collect();
            if open.is_empty() {
                continue;
            }
            let is_sure = open.len() == 1 && (unsaid == 1 || said >= 1.0);
            let mut left = if is_sure { 0.0 } else { self.chance(a) as f32 };
            let taken = chances.iter().position(|p| {
                left -= p;
                is_sure || left < 0.0
            });
            if let Some(taken) = taken {
                if open[taken].to != state || on == "done" {
                    self.enter_state(stage, a, &graph, &open[taken].to, about);
                }
                return;
            }
        }
    }

    fn finish(&mut self, stage: &mut Paper) {
        while !self.queue.is_empty() {
            let (a, on, about, begun) = self.queue.remove(0);
            let is_of_behaviour = ["done", "full", "stuck"].contains(&&*on);
            if is_of_behaviour && begun != self.people[a as usize].begun {
                continue;
            }
            self.touch(a);
            self.handle(stage, a, &on, &about);
        }
        for a in std::mem::take(&mut self.touched) {
            let crossing = self.crossing(a).map_or(NEVER, |c| c.0.max(self.now));
            let p = &self.people[a as usize];
            stage.timers[a as usize] = p.until.min(p.again).min(p.most).min(p.timer).min(crossing);
        }
    }
}

impl Lives for Plain {
    fn begin(&mut self, stage: &mut Paper) {
        for a in 0..self.people.len() as u32 {
            self.people[a as usize].is_there = true;
            self.people[a as usize].home = stage.position(a).unwrap();
            for (name, config) in self.scene.values.clone() {
                let value = config.start[0] + (config.start[1] - config.start[0]) * self.chance(a) as f32;
                self.people[a as usize].values.insert(name, (value, config.rate_per_s, 0.0));
            }
            for (name, at, rises, on) in self.thresholds() {
                let value = self.people[a as usize].values[&name].0;
                if if rises { value >= at } else { value <= at } {
                    self.people[a as usize].passed.insert(on);
                }
            }
            self.touch(a);
            let graph = self.scene.graphs["life"].clone();
            self.enter_state(stage, a, "life", &graph.start, &About::default());
            self.push(a, "starts", About::default());
            let at = stage.position(a).unwrap();
            for site in self.scene.places.clone() {
                if Vec3::new(site.at[0], 0.0, site.at[1]).distance(at) <= site.radius_m {
                    self.read(stage, a);
                    self.push(a, "enters", About::default());
                }
            }
        }
        self.finish(stage);
    }

    fn next_external_s(&self) -> f64 {
        self.due.iter().map(|d| d.0).fold(NEVER, f64::min)
    }

    fn external(&mut self, stage: &mut Paper, now: f64) {
        self.now = now;
        for (e, event) in self.scene.events.clone().into_iter().enumerate() {
            if self.due[e].0 > now {
                continue;
            }
            self.due[e].0 = event.period_s.map_or(NEVER, |p| now + p);
            self.happened.insert(event.name.clone(), now);
            for a in 0..self.people.len() as u32 {
                let about = About { event: event.name.clone(), how: "happens", ..About::default() };
                if self.holds(event.who.as_ref(), a, &about) {
                    self.learn(a, about);
                }
            }
        }
        self.finish(stage);
    }

    fn signal(&mut self, stage: &mut Paper, now: f64, signal: Signal) {
        self.now = now;
        match signal {
            Signal::Met(a, b) => {
                self.touch(a);
                self.touch(b);
                for (from, to) in [(a, b), (b, a)] {
                    for e in self.scene.events.clone().into_iter().filter(|e| e.passed_on) {
                        let is_fresh =
                            self.happened.get(&e.name).is_some_and(|t| now - t <= e.fresh_s.unwrap_or(NEVER));
                        let has = |p: u32| self.people[p as usize].news.contains(&e.name);
                        if is_fresh && has(from) && !has(to) {
                            self.learn(
                                to,
                                About { event: e.name, how: "passed_on", other: Some(from), ..About::default() },
                            );
                        }
                    }
                }
                for (a, b) in [(a, b), (b, a)] {
                    self.push(a, "meets", About { other: Some(b), ..About::default() });
                }
            }
            Signal::CameTo(a, _) => {
                self.touch(a);
                self.read(stage, a);
                self.push(a, "enters", About::default());
            }
            Signal::WentFrom(a, _) => {
                self.touch(a);
                self.push(a, "leaves", About::default());
            }
            Signal::Crossed(a) => {
                self.touch(a);
                self.read(stage, a);
                self.push(a, "crosses", About::default());
            }
            Signal::Arrived(a) => {
                self.touch(a);
                if self.people[a as usize].walks {
                    self.arrived(stage, a);
                } else {
                    self.push(a, "arrives", About::default());
                }
            }
            Signal::Timer(a) => {
                self.touch(a);
                while let Some((at, on, name, number)) = self.crossing(a).filter(|c| c.0 <= now) {
                    let _ = at;
                    let own = self.people[a as usize].values.get_mut(&name).unwrap();
                    (own.0, own.2) = (number, now);
                    self.people[a as usize].passed.insert(on.clone());
                    self.push(a, on, About::default());
                }
                if self.people[a as usize].timer <= now {
                    self.people[a as usize].timer = NEVER;
                    self.push(a, "timer", About::default());
                }
                let p = &self.people[a as usize];
                if p.until <= now || p.most <= now {
                    self.ended(stage, a);
                }
            }
            other => panic!("{other:?}"),
        }
        self.finish(stage);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, ..ProptestConfig::default() })]
    /// The same commands at the same times, the same states, values and news, on random scenes with random meetings.
    #[test]
    fn tables_live_as_the_words_say(
        period in 0.5f64..4.0, rate in -0.05f64..0.3, probability in 0.0f64..1.0, seed in any::<u64>(), num in 2usize..8,
    ) {
        let scene = scene(num, &super::random::lively(period, rate, probability));
        let script = script(num as u32, seed, 20.0);
        let (mut fast, mut slow) = (brains(&scene), Plain::new(&scene));
        let (mut a, mut b) = (Paper::new(num), Paper::new(num));
        Lives::begin(&mut fast, &mut a);
        slow.begin(&mut b);
        play(&mut fast, &mut a, &script, 20.0);
        play(&mut slow, &mut b, &script, 20.0);
        let first = a.log.iter().zip(&b.log).position(|(x, y)| x != y).unwrap_or(a.log.len().min(b.log.len()));
        let near = |log: &[String]| log[first.saturating_sub(6)..(first + 4).min(log.len())].join("\n");
        prop_assert!(a.log == b.log, "tables:\n{}\nwords:\n{}", near(&a.log), near(&b.log));
        prop_assert!(a.log.len() > 8);
        for (agent, person) in slow.people.iter().enumerate() {
            let why = fast.explain(agent, 0.0);
            let states: Vec<String> = person.states.iter().flatten().map(|s| s.1.clone()).collect();
            prop_assert_eq!(&why.states, &states);
            for known in &why.knows {
                let (how, from, time_s) = &person.learnt[&known.event];
                prop_assert_eq!((&known.how, known.from, known.time_s), (how, from.map(|f| f as usize), *time_s));
            }
            prop_assert_eq!(why.knows.len(), person.learnt.len());
            for value in &why.values {
                prop_assert_eq!(value.value, slow.value(agent as u32, &value.name), "{} of {}", value.name, agent);
            }
        }
    }
}
