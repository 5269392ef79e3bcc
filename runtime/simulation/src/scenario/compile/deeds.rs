//! Compilation of expressions and behaviours: predicates, amounts, actions with their arguments.

use super::{Compiled, Compiler, Wrong, checked_point, wrong};
use crate::scenario::language::{self, Amount, Program, Sort, Spot, Type};
use crate::scenario::tables::{Action, Claims, Scenario};
use crate::scenario::verbs::{Operand, Verb, WORDS, Word};
use crate::scene::{ActionConfig, DoConfig, WordConfig};
use throng_base::text::did_you_mean;

/// Most points of a list: each agent that follows it has a route of its own.
const MOST_POINTS: usize = 1000;

impl Compiler<'_> {
    pub(super) fn when(&mut self, when: Option<&str>, key: &str, trigger: u16) -> Compiled<Option<Program>> {
        when.map(|text| self.predicate(text, key, trigger)).transpose()
    }

    pub(super) fn predicate(&mut self, text: &str, key: &str, trigger: u16) -> Compiled<Program> {
        self.expression(text, Type::Truth, key, trigger)
    }

    pub(super) fn expression(&mut self, text: &str, of: Type, key: &str, trigger: u16) -> Compiled<Program> {
        self.scope(trigger);
        let Scenario { code, names, .. } = &mut self.out;
        let compiled = language::parse(text).and_then(|node| language::compile(&node, of, names, code));
        compiled.map_err(|fault| Wrong { key: key.into(), at: Some(fault.at), why: fault.why })
    }

    /// Compiles the actions of a behaviour: returns the first of them, and whether all take no time.
    pub(super) fn behaviour(&mut self, does: &DoConfig, key: &str, trigger: u16) -> Compiled<(u32, bool)> {
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

    pub(super) fn actions(&mut self, actions: &[ActionConfig], key: &str, trigger: u16) -> Compiled<(u32, bool)> {
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

    pub(super) fn action(&mut self, action: &ActionConfig, key: &str, trigger: u16) -> Compiled<Action> {
        // `speed` is an action of its own, and an argument of others.
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
        let dimensions = self.scene.environment.space.dimensions();
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
                (Word::Points, WordConfig::Points(points)) if (2..=MOST_POINTS).contains(&points.len()) => {
                    way = Some(self.out.ways.len() as u16);
                    let at = |(i, p): (usize, &Vec<f32>)| checked_point(p, &format!("{word_key}[{i}]"), dimensions);
                    self.out.ways.push(points.iter().enumerate().map(at).collect::<Compiled<_>>()?);
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

    pub(super) fn motion(&mut self, tag: &str) -> u16 {
        let motions = &mut self.out.motions;
        let number = motions.iter().position(|m| m == tag).unwrap_or_else(|| {
            motions.push(tag.into());
            motions.len() - 1
        });
        number as u16
    }

    pub(super) fn word(&mut self, kind: Word, value: &WordConfig, key: &str, trigger: u16) -> Compiled<Operand> {
        let expected = |what: &str| wrong(key, format!("expected {what}"));
        let dimensions = self.scene.environment.space.dimensions();
        Ok(match (kind, value) {
            (Word::Flag, WordConfig::Flag(flag)) => Operand::Flag(*flag),
            (Word::Flag, _) => return expected("true or false"),
            (Word::Amount, WordConfig::Number(number)) if !number.is_nan() => Operand::Amount(Amount::Number(*number)),
            (Word::Amount, WordConfig::Text(text)) => {
                Operand::Amount(Amount::Program(self.expression(text, Type::Number, key, trigger)?))
            }
            (Word::Amount, _) => return expected("a number, or an expression in quotes"),
            (Word::Target | Word::Slot | Word::Queue, WordConfig::Point(at)) => {
                Operand::Point(checked_point(at, key, dimensions)?.to_array())
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
            (Word::Rest, WordConfig::Point(at)) if at.len() == 3 => {
                Operand::Point(checked_point(at, key, 3)?.to_array())
            }
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
            (Word::Points, _) => return expected("2 to 1000 points"),
            _ => return expected("a name in quotes"),
        })
    }
}
