//! Compilation of expressions and behaviours: predicates, amounts, actions with their arguments.

use super::{CompileFault, CompileResult, ScenarioCompiler, checked_point, compile_fault};
use crate::scenario::action_registry::{ActionOperand, Effect, GESTURES, MAX_WORDS, RegisteredAction, WordKind};
use crate::scenario::language::{self, Amount, NameKind, Program, SpotName, Type};
use crate::scenario::tables::{ActionClaim, CompiledAction, Scenario};
use crate::scene::{ActionConfig, StoryBehaviour, WordConfig};
use glam::Vec3;
use throng_base::text::did_you_mean;

/// Most points of a list: each agent that follows it has a route of its own.
const MOST_POINTS: usize = 1000;

impl ScenarioCompiler<'_> {
    /// Compiles a condition in the scope that was set last.
    pub(super) fn compile_condition(&mut self, when: Option<&str>, key: &str) -> CompileResult<Option<Program>> {
        when.map(|text| self.compile_expression(text, Type::Truth, key)).transpose()
    }

    pub(super) fn compile_expression(&mut self, text: &str, of: Type, key: &str) -> CompileResult<Program> {
        let Scenario { code, names, .. } = &mut self.out;
        let compiled =
            language::parse_expression(text).and_then(|node| language::compile_expression(&node, of, names, code));
        compiled.map_err(|fault| CompileFault { key: key.into(), at: Some(fault.at), why: fault.why })
    }

    /// Compiles the actions of a behaviour: returns the first of them, and whether all take no time.
    pub(super) fn compile_behaviour(&mut self, does: &StoryBehaviour, key: &str) -> CompileResult<(u32, bool)> {
        let name = match does {
            StoryBehaviour::Actions(actions) => return self.compile_actions(actions, key),
            StoryBehaviour::Named(name) => name,
        };
        let known = (name.clone(), self.out.names.has_other, self.out.names.has_place);
        if let Some(&done) = self.compiled_behaviours.get(&known) {
            return Ok(done);
        }
        let Some(actions) = self.scene.behaviours.get(name) else {
            let help = did_you_mean(name, self.scene.behaviours.keys().map(String::as_str));
            return compile_fault(key, format!("there is no behaviour `{name}` in `[behaviours]`.{help}"));
        };
        let done = self.compile_actions(actions, &format!("behaviours.{name}"))?;
        self.compiled_behaviours.insert(known, done);
        Ok(done)
    }

    fn compile_actions(&mut self, actions: &[ActionConfig], key: &str) -> CompileResult<(u32, bool)> {
        if actions.is_empty() {
            return compile_fault(key, "expected at least one action, found none");
        }
        let mut compiled = Vec::new();
        for (i, action) in actions.iter().enumerate() {
            let action = self.compile_action(action, &format!("{key}[{i}]"))?;
            match action {
                CompiledAction::Primitive { claims: ActionClaim::Serve(service), .. } => {
                    compiled.extend(self.service_actions(action, service));
                }
                action => compiled.push(action),
            }
        }
        let is_instant = compiled.iter().all(|a| matches!(a, CompiledAction::Effect(..)));
        let first = self.out.actions.len() as u32;
        self.out.actions.extend(compiled);
        self.out.actions.push(CompiledAction::End);
        Ok((first, is_instant))
    }

    /// Actions of a service: to stand in line, to be served at a till, and to leave the till.
    fn service_actions(&mut self, action: CompiledAction, service: u16) -> [CompiledAction; 3] {
        let CompiledAction::Primitive { number, words, motion, route, claims } = action else { return [action; 3] };
        let mut at_till = words;
        at_till[0] = ActionOperand::Spot(SpotName::Place(self.out.services[usize::from(service)].tills));
        if at_till[2] == ActionOperand::Nothing {
            at_till[2] = ActionOperand::Duration(service);
        }
        let in_line = self.motion_number("queue");
        [
            CompiledAction::Primitive { number, words, motion: Some(in_line), route, claims },
            CompiledAction::Primitive { number, words: at_till, motion, route, claims: ActionClaim::Slot },
            CompiledAction::Effect(Effect::Release, words),
        ]
    }

    fn compile_action(&mut self, action: &ActionConfig, key: &str) -> CompileResult<CompiledAction> {
        // `speed` is an action of its own, and an argument of others.
        let action_names: Vec<&String> =
            action.keys().filter(|k| self.out.primitives.find_action(k).is_some()).collect();
        let own: Vec<&String> =
            action_names.iter().copied().filter(|k| action_names.len() == 1 || *k != "speed").collect();
        let [name] = own[..] else {
            let found: Vec<_> = action.keys().map(String::as_str).collect();
            let help =
                found.iter().map(|word| did_you_mean(word, self.out.primitives.action_names())).find(|h| !h.is_empty());
            let all: Vec<_> = self.out.primitives.action_names().collect();
            let why = match (own.is_empty(), help) {
                (true, Some(help)) => format!("there is no action `{}`.{help}", found.join("`, `")),
                (true, None) => format!("expected one of {}, found `{}`", all.join(", "), found.join("`, `")),
                (false, _) => format!("expected one action in one table, found `{}`", found.join("`, `")),
            };
            return compile_fault(key, why);
        };
        let Some((action_name, words)) = self.out.primitives.find_action(name) else {
            return compile_fault(key, "expected an action");
        };
        let mut said = [ActionOperand::Nothing; MAX_WORDS];
        let (mut motion, mut route, mut claims) = (None, None, ActionClaim::Nothing);
        let dimensions = self.scene.environment.space.dimensions();
        if let RegisteredAction::Primitive(number) = action_name {
            motion = self.out.primitives.get(number).motion.map(|tag| self.motion_number(tag));
        }
        for (word, value) in action {
            let Some(at) = words.iter().position(|w| w.0 == word) else {
                let help = did_you_mean(word, words.iter().map(|w| w.0));
                let all: Vec<_> = words.iter().map(|w| w.0).collect();
                let why = format!("`{name}` has no word `{word}`, expected {}.{help}", all.join(", "));
                return compile_fault(key, why);
            };
            let word_key = format!("{key}.{word}");
            said[at] = match (words[at].1, value) {
                (WordKind::Motion, WordConfig::Text(tag)) => {
                    motion = Some(self.motion_number(tag));
                    ActionOperand::Nothing
                }
                (WordKind::Points, WordConfig::Points(points)) if (2..=MOST_POINTS).contains(&points.len()) => {
                    route = Some(self.out.paths.len() as u16);
                    let at = |(i, p): (usize, &Vec<f32>)| checked_point(p, &format!("{word_key}[{i}]"), dimensions);
                    self.out.paths.push(points.iter().enumerate().map(at).collect::<CompileResult<_>>()?);
                    ActionOperand::Nothing
                }
                (kind, value) => self.compile_word(kind, value, &word_key)?,
            };
            let is_signed = matches!(word.as_str(), "to" | "by" | "befriend");
            if let ActionOperand::Amount(Amount::Number(number)) = said[at]
                && number < 0.0
                && !is_signed
            {
                return compile_fault(word_key, format!("expected 0 or more, found {number}"));
            }
            if words[at].1 == WordKind::Place
                && let ActionOperand::Number(place) = said[at]
            {
                claims = ActionClaim::Queue(Some(place));
            }
        }
        match words[0].1 {
            WordKind::Take | WordKind::Put => {
                let ActionOperand::Number(thing) = said[0] else {
                    return compile_fault(key, "expected the name of a thing");
                };
                claims = if words[0].1 == WordKind::Take { ActionClaim::Take(thing) } else { ActionClaim::Put(thing) };
            }
            WordKind::Service => {
                if let ActionOperand::Number(service) = said[0] {
                    claims = ActionClaim::Serve(service);
                }
            }
            WordKind::Slot if matches!(said[0], ActionOperand::Spot(_)) => claims = ActionClaim::Slot,
            WordKind::Queue => {
                let is_queue = matches!(said[0], ActionOperand::Spot(SpotName::Place(p)) if self.out.places[usize::from(p)].is_queue);
                if !is_queue && said[0] != ActionOperand::Spot(SpotName::Here) {
                    return compile_fault(format!("{key}.{name}"), "expected the name of a place with a `queue`");
                }
                claims = if claims == ActionClaim::Nothing { ActionClaim::Queue(None) } else { claims };
            }
            _ => {}
        }
        let aims =
            matches!(said[0], ActionOperand::Number(n) if GESTURES.get(usize::from(n)).is_some_and(|g| g.0 == "point"));
        if words[0].1 == WordKind::Gesture && aims && said[1] == ActionOperand::Nothing {
            return compile_fault(key, "expected `at`, the target at which the arm points");
        }
        let at = match said[0] {
            ActionOperand::Point(at) => Some(Vec3::from_array(at)),
            ActionOperand::Spot(SpotName::Place(place)) => Some(self.out.places[usize::from(place)].at),
            _ => None,
        };
        if let Some(at) = at.filter(|_| ["go", "leave"].contains(&name.as_str())) {
            self.out.goals.push((format!("{key}.{name}"), at));
        }
        Ok(match action_name {
            RegisteredAction::Effect(effect) => CompiledAction::Effect(effect, said),
            RegisteredAction::Primitive(number) => {
                CompiledAction::Primitive { number, words: said, motion, route, claims }
            }
        })
    }

    pub(super) fn motion_number(&mut self, tag: &str) -> u16 {
        let motions = &mut self.out.motions;
        let number = motions.iter().position(|m| m == tag).unwrap_or_else(|| {
            motions.push(tag.into());
            motions.len() - 1
        });
        number as u16
    }

    fn compile_word(&mut self, kind: WordKind, value: &WordConfig, key: &str) -> CompileResult<ActionOperand> {
        let expected = |what: &str| compile_fault(key, format!("expected {what}"));
        let dimensions = self.scene.environment.space.dimensions();
        Ok(match (kind, value) {
            (WordKind::Flag, WordConfig::Flag(flag)) => ActionOperand::Flag(*flag),
            (WordKind::Flag, _) => return expected("true or false"),
            (WordKind::Amount, WordConfig::Number(number)) if !number.is_nan() => {
                ActionOperand::Amount(Amount::Number(*number))
            }
            (WordKind::Amount, WordConfig::Text(text)) => {
                ActionOperand::Amount(Amount::Program(self.compile_expression(text, Type::Number, key)?))
            }
            (WordKind::Amount, _) => return expected("a number, or an expression in quotes"),
            (WordKind::Target | WordKind::Slot | WordKind::Queue, WordConfig::Point(at)) => {
                ActionOperand::Point(checked_point(at, key, dimensions)?.to_array())
            }
            (WordKind::Target | WordKind::Slot | WordKind::Queue, WordConfig::Text(text)) => {
                let has_other = self.out.names.has_other && !self.is_untold;
                let has_place = self.out.names.has_place;
                // A group, or one of it such as `guards:0`.
                let group = self.out.names.groups.number_of(text.split(':').next().unwrap_or_default());
                let is_person = group.is_some() && self.out.names.places.number_of(text).is_none();
                let has_arrow = has_place && self.scene.places.iter().any(|site| site.arrow.is_some());
                match text.as_str() {
                    "me" => ActionOperand::Spot(SpotName::Me),
                    "home" => ActionOperand::Spot(SpotName::Home),
                    "arrow" if has_arrow => ActionOperand::Arrow,
                    "other" if has_other => ActionOperand::Spot(SpotName::Other),
                    "place" if has_place => ActionOperand::Spot(SpotName::Here),
                    "other" => {
                        return expected(
                            "somewhere: nothing that leads here has an `other`; `meets`, and events with `passed_on`, have",
                        );
                    }
                    "place" | "arrow" => return expected(&format!("somewhere: there is no `{text}` for this event")),
                    name if is_person => return expected(&format!("`other` or a place: `{name}` is neither")),
                    name => ActionOperand::Spot(SpotName::Place(self.name_number(NameKind::Place, name, key)?)),
                }
            }
            (WordKind::Target | WordKind::Slot | WordKind::Queue, _) => {
                return expected("a point, or the name of a place");
            }
            (WordKind::Rest, WordConfig::Point(at)) if at.len() == 3 => {
                ActionOperand::Point(checked_point(at, key, 3)?.to_array())
            }
            (WordKind::Rest, _) => return expected("a point of three numbers: x, y up, z"),
            (
                WordKind::Take | WordKind::Put | WordKind::Place | WordKind::Event | WordKind::Door | WordKind::Service,
                WordConfig::Text(name),
            ) => {
                let sort = match kind {
                    WordKind::Place => NameKind::Place,
                    WordKind::Service => NameKind::Service,
                    WordKind::Event => NameKind::Event,
                    WordKind::Door => NameKind::Door,
                    _ => NameKind::Thing,
                };
                ActionOperand::Number(self.name_number(sort, name, key)?)
            }
            (WordKind::Value, WordConfig::Text(name)) => match self.out.names.values.number_of(name) {
                Some(value) => ActionOperand::Number(value as u16),
                None => {
                    let help = did_you_mean(name, self.out.names.values.0.iter().map(String::as_str));
                    return compile_fault(key, format!("there is no value `{name}`.{help}"));
                }
            },
            (WordKind::Gesture, WordConfig::Text(name)) => {
                let names = || GESTURES.iter().map(|g| g.0).chain(["none"]);
                match names().position(|known| known == name) {
                    Some(number) => ActionOperand::Number(number as u16),
                    None => return expected(&format!("one of {}", names().collect::<Vec<_>>().join(", "))),
                }
            }
            (WordKind::Motion, _) => return expected("a tag of motion, in quotes"),
            (WordKind::Points, _) => return expected("2 to 1000 points"),
            _ => return expected("a name in quotes"),
        })
    }
}
