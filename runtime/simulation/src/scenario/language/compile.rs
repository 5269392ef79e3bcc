//! Compiler from expression trees to flat code: resolves names and checks types.

use super::code::{Attribute, EventAttribute, Load, Op, PlaceAttribute, Program, STACK, SpotName, Subject};
use super::parse::{ExpressionFault, ExpressionNode, ExpressionTree};
use throng_base::text::did_you_mean;

/// Names of one kind, by their numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NameList(pub Vec<String>);

impl NameList {
    /// Number of a name.
    pub fn number_of(&self, name: &str) -> Option<usize> {
        self.0.iter().position(|n| n == name)
    }
}

/// Type of an expression.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Type {
    /// A number.
    Number,
    /// True or false.
    Truth,
    /// A name of some kind.
    Name(NameKind),
    /// A set of events.
    Set,
    /// An agent or a place.
    Spot(SpotName),
}

/// Kind of a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NameKind {
    Group,
    State,
    Place,
    Kind,
    Event,
    How,
    Door,
    Thing,
    Service,
}

/// All names that expressions may use, and whether the event has another agent and a place.
#[derive(Clone, Debug, Default)]
pub struct ScenarioVocabulary {
    pub groups: NameList,
    pub states: NameList,
    pub places: NameList,
    pub kinds: NameList,
    pub events: NameList,
    pub values: NameList,
    pub doors: NameList,
    pub things: NameList,
    pub services: NameList,
    pub how: NameList,
    /// Whether the event has another agent, which is met or tells.
    pub has_other: bool,
    /// Whether the event has a place.
    pub has_place: bool,
    /// Whether the expression is about no agent in particular.
    pub is_of_all: bool,
}

/// Words that stand alone, with their quantities and types.
const WORDS: &[(&str, Load, Type)] = &[
    ("time", Load::Time, Type::Number),
    ("random", Load::Random, Type::Number),
    ("event", Load::Event(EventAttribute::Name), Type::Name(NameKind::Event)),
    ("event.name", Load::Event(EventAttribute::Name), Type::Name(NameKind::Event)),
    ("event.age", Load::Event(EventAttribute::Age), Type::Number),
    ("event.strength", Load::Event(EventAttribute::Strength), Type::Number),
    ("event.how", Load::Event(EventAttribute::How), Type::Name(NameKind::How)),
    ("place.name", Load::Place(SpotName::Here, PlaceAttribute::Name), Type::Name(NameKind::Place)),
    ("place.kind", Load::Place(SpotName::Here, PlaceAttribute::Kind), Type::Name(NameKind::Kind)),
    ("place.free", Load::Place(SpotName::Here, PlaceAttribute::Free), Type::Number),
    ("place.held", Load::Place(SpotName::Here, PlaceAttribute::Held), Type::Number),
    ("blackboard", Load::Blackboard(false), Type::Set),
    ("cell", Load::Blackboard(true), Type::Set),
];

/// Attributes of `me` and `other`, beside the values of the scene.
const ATTRIBUTES: &[(&str, Attribute, Type)] = &[
    ("x", Attribute::X, Type::Number),
    ("y", Attribute::Y, Type::Number),
    ("z", Attribute::Z, Type::Number),
    ("speed", Attribute::Speed, Type::Number),
    ("desired_speed", Attribute::DesiredSpeed, Type::Number),
    ("group", Attribute::Group, Type::Name(NameKind::Group)),
    ("state", Attribute::State(0), Type::Name(NameKind::State)),
    ("spatial", Attribute::State(1), Type::Name(NameKind::State)),
    ("primitive", Attribute::State(2), Type::Name(NameKind::State)),
    ("state_s", Attribute::StateSeconds, Type::Number),
    ("news", Attribute::News, Type::Set),
    ("busy", Attribute::Busy, Type::Truth),
    ("number", Attribute::Number, Type::Number),
    ("waits", Attribute::Waits, Type::Truth),
    ("laps", Attribute::Laps, Type::Number),
    ("progress", Attribute::Progress, Type::Number),
];

/// Message for words of one agent in an expression about no agent.
const OF_ALL: &str = "what an event waits for is about nobody in particular, such as `count(\"a group\") > 9`";

/// Functions, with their forms of call.
const CALLS: &[(&str, &str)] = &[
    ("distance", "distance(me, other)"),
    ("friendship", "friendship(me, other)"),
    ("curiosity", "curiosity(me, place)"),
    ("count", "count(\"a group\")"),
    ("free", "free(\"a place\")"),
    ("held", "held(\"a place\")"),
    ("open", "open(\"a door\")"),
    ("holds", "holds(me, \"a thing\")"),
    ("taken", "taken(\"a thing\")"),
    ("size", "size(me.news)"),
    ("min", "min(a, b)"),
    ("max", "max(a, b)"),
    ("abs", "abs(a)"),
    ("sqrt", "sqrt(a)"),
    ("floor", "floor(a)"),
    ("clamp", "clamp(a, least, most)"),
    ("if", "if(truth, a, b)"),
];

impl Type {
    fn describe(self) -> String {
        match self {
            Self::Number => "a number".into(),
            Self::Truth => "true or false".into(),
            Self::Name(sort) => format!("the name of a {}", sort.noun()),
            Self::Set => "a set of events".into(),
            Self::Spot(_) => "somebody or somewhere".into(),
        }
    }
}

impl NameKind {
    fn noun(self) -> &'static str {
        match self {
            Self::Group => "group",
            Self::State => "state",
            Self::Place => "place",
            Self::Kind => "kind of place",
            Self::Event => "event",
            Self::How => "way of learning",
            Self::Door => "door",
            Self::Thing => "thing",
            Self::Service => "service",
        }
    }
}

impl ScenarioVocabulary {
    fn names_of(&self, sort: NameKind) -> &NameList {
        match sort {
            NameKind::Group => &self.groups,
            NameKind::State => &self.states,
            NameKind::Place => &self.places,
            NameKind::Kind => &self.kinds,
            NameKind::Event => &self.events,
            NameKind::How => &self.how,
            NameKind::Door => &self.doors,
            NameKind::Thing => &self.things,
            NameKind::Service => &self.services,
        }
    }

    /// Number of a name of a kind.
    ///
    /// # Errors
    /// A message with the nearest known name.
    pub fn number_of(&self, sort: NameKind, name: &str) -> Result<usize, String> {
        let known = &self.names_of(sort).0;
        known.iter().position(|n| n == name).ok_or_else(|| {
            let word = sort.noun();
            let help = did_you_mean(name, known.iter().map(String::as_str));
            match known.len() {
                0 => format!("there is no {word} `{name}`: the scene has none"),
                _ if help.is_empty() => format!("there is no {word} `{name}`: there is {}", known.join(", ")),
                _ => format!("there is no {word} `{name}`.{help}"),
            }
        })
    }
}

/// Compiles an expression to the end of `code`.
///
/// # Errors
/// [`ExpressionFault`] for unknown names, with the nearest known, and types that do not fit.
pub fn compile_expression(
    node: &ExpressionNode,
    expected: Type,
    names: &ScenarioVocabulary,
    code: &mut Vec<Op>,
) -> Result<Program, ExpressionFault> {
    let first = code.len();
    let mut compiler = ExpressionCompiler { names, code, depth: 0 };
    let result = compiler.compile_expected(node, expected);
    if let Err(fault) = result {
        code.truncate(first);
        return Err(fault);
    }
    Ok(Program { first: first as u32, count: (code.len() - first) as u32 })
}

struct ExpressionCompiler<'a> {
    names: &'a ScenarioVocabulary,
    code: &'a mut Vec<Op>,
    /// Depth of the stack at this place of the code.
    depth: usize,
}

impl ExpressionCompiler<'_> {
    fn push_op(&mut self, op: Op, at: usize) -> Result<(), ExpressionFault> {
        self.depth += 1;
        if self.depth > STACK {
            return ExpressionFault::new(at, format!("expected at most {STACK} values at a time"));
        }
        self.code.push(op);
        Ok(())
    }

    /// Number of a name in quotes that stands at a place of the text.
    fn number_of(&self, sort: NameKind, name: &str, at: usize) -> Result<usize, ExpressionFault> {
        self.names.number_of(sort, name).map_err(|why| ExpressionFault { at: at + 1, why })
    }

    /// Adds an operation with two operands.
    fn push_binary(&mut self, op: Op) {
        self.code.push(op);
        self.depth -= 1;
    }

    fn compile_expected(&mut self, node: &ExpressionNode, expected: Type) -> Result<(), ExpressionFault> {
        if let (ExpressionTree::Text(name), Type::Name(sort)) = (&node.tree, expected) {
            let number = self.number_of(sort, name, node.at)?;
            return self.push_op(Op::Number(number as f64), node.at);
        }
        let found = self.compile_any(node)?;
        if found == expected {
            return Ok(());
        }
        ExpressionFault::new(node.at, format!("expected {}, found {}", expected.describe(), found.describe()))
    }

    fn compile_any(&mut self, node: &ExpressionNode) -> Result<Type, ExpressionFault> {
        match &node.tree {
            ExpressionTree::Number(number) => self.push_op(Op::Number(*number), node.at).map(|()| Type::Number),
            ExpressionTree::Truth(is) => {
                self.push_op(Op::Number(f64::from(u8::from(*is))), node.at).map(|()| Type::Truth)
            }
            ExpressionTree::Text(text) => {
                ExpressionFault::new(node.at, format!("expected a value, found \"{text}\": compare it with a name"))
            }
            ExpressionTree::Set(_) => {
                ExpressionFault::new(node.at, "expected a value, found a set: write `NAME in { .. }`")
            }
            ExpressionTree::Word(word) => self.compile_word(word, node.at),
            ExpressionTree::Call(name, operands) => self.compile_call(name, operands, node.at),
            ExpressionTree::Unary(operator, of) => {
                let (sort, op) = if *operator == "-" { (Type::Number, Op::Negate) } else { (Type::Truth, Op::Not) };
                self.compile_expected(of, sort)?;
                self.code.push(op);
                Ok(sort)
            }
            ExpressionTree::Binary(operator, a, b) => self.compile_binary(operator, a, b, node.at),
        }
    }

    fn compile_binary(
        &mut self,
        operator: &str,
        a: &ExpressionNode,
        b: &ExpressionNode,
        at: usize,
    ) -> Result<Type, ExpressionFault> {
        match operator {
            "and" | "or" => {
                self.compile_expected(a, Type::Truth)?;
                let jump = self.code.len();
                self.code.push(Op::Not);
                self.depth -= 1;
                self.compile_expected(b, Type::Truth)?;
                let far = (self.code.len() - jump - 1) as u32;
                self.code[jump] = if operator == "and" { Op::And(far) } else { Op::Or(far) };
                Ok(Type::Truth)
            }
            "==" | "!=" => {
                let (first, second) = if matches!(a.tree, ExpressionTree::Text(_)) { (b, a) } else { (a, b) };
                let sort = self.compile_any(first)?;
                if matches!(sort, Type::Set | Type::Spot(_)) {
                    let why = "expected numbers, truths or names to compare; compare `place.name` with a name";
                    return ExpressionFault::new(at, why);
                }
                self.compile_expected(second, sort)?;
                self.push_binary(if operator == "==" { Op::Equal } else { Op::Unequal });
                Ok(Type::Truth)
            }
            "in" => self.compile_membership(a, b),
            _ => {
                let (first, second) = if matches!(operator, ">" | ">=") { (b, a) } else { (a, b) };
                self.compile_expected(first, Type::Number)?;
                self.compile_expected(second, Type::Number)?;
                if operator == "/" && self.code.last() == Some(&Op::Number(0.0)) {
                    return ExpressionFault::new(second.at, "expected another number to divide by than 0");
                }
                let (op, of) = match operator {
                    "+" => (Op::Add, Type::Number),
                    "-" => (Op::Subtract, Type::Number),
                    "*" => (Op::Multiply, Type::Number),
                    "/" => (Op::Divide, Type::Number),
                    "<" | ">" => (Op::Less, Type::Truth),
                    _ => (Op::LessOrEqual, Type::Truth),
                };
                self.push_binary(op);
                Ok(of)
            }
        }
    }

    fn compile_membership(&mut self, a: &ExpressionNode, b: &ExpressionNode) -> Result<Type, ExpressionFault> {
        if let ExpressionTree::Set(members) = &b.tree {
            let Type::Name(sort) = self.compile_any(a)? else {
                return ExpressionFault::new(a.at, "expected a name, such as `me.group`, before `in { .. }`");
            };
            self.code.push(Op::OneOf(members.len() as u32));
            for member in members {
                let ExpressionTree::Text(name) = &member.tree else {
                    return ExpressionFault::new(member.at, "expected a name in quotes");
                };
                self.code.push(Op::Number(self.number_of(sort, name, member.at)? as f64));
            }
            return Ok(Type::Truth);
        }
        self.compile_expected(a, Type::Name(NameKind::Event))?;
        self.compile_expected(b, Type::Set)?;
        self.push_binary(Op::In);
        Ok(Type::Truth)
    }

    fn compile_word(&mut self, word: &str, at: usize) -> Result<Type, ExpressionFault> {
        if let Some(spot) = spot_named(word) {
            self.check_available(spot, at)?;
            return Ok(Type::Spot(spot));
        }
        if let Some(&(_, load, of)) = WORDS.iter().find(|w| w.0 == word) {
            match load {
                Load::Place(spot, _) => self.check_available(spot, at)?,
                Load::Random | Load::Blackboard(true) if self.names.is_of_all => {
                    return ExpressionFault::new(at, format!("there is no `{word}`: {OF_ALL}"));
                }
                _ => {}
            }
            return self.push_op(Op::Load(load), at).map(|()| of);
        }
        let (of, name) = word.split_once('.').unwrap_or(("me", word));
        let who = match of {
            "me" => Subject::Me,
            "other" => Subject::Other,
            _ => return self.unknown_word(word, at),
        };
        let value = self.names.values.number_of(name).map(|v| (Attribute::Value(v as u16), Type::Number));
        let own = || ATTRIBUTES.iter().find(|a| a.0 == name).map(|a| (a.1, a.2));
        match value.or_else(own) {
            Some((attribute, of)) => {
                self.check_available(if who == Subject::Me { SpotName::Me } else { SpotName::Other }, at)?;
                self.push_op(Op::Load(Load::Of(who, attribute)), at).map(|()| of)
            }
            None => self.unknown_word(word, at),
        }
    }

    fn unknown_word<T>(&self, word: &str, at: usize) -> Result<T, ExpressionFault> {
        let own = ATTRIBUTES.iter().map(|a| a.0).chain(self.names.values.0.iter().map(String::as_str));
        let own: Vec<String> = own.flat_map(|a| [format!("me.{a}"), format!("other.{a}")]).collect();
        let all = WORDS.iter().map(|w| w.0).chain(own.iter().map(String::as_str));
        let help = did_you_mean(word, all);
        let way_out = if help.is_empty() { " Values are declared in `[values]`.".into() } else { help };
        ExpressionFault::new(at, format!("unknown word `{word}`.{way_out}"))
    }

    /// Checks that the event has the named agent or place.
    fn check_available(&self, spot: SpotName, at: usize) -> Result<(), ExpressionFault> {
        match spot {
            SpotName::Me if self.names.is_of_all => ExpressionFault::new(at, format!("there is no `me`: {OF_ALL}")),
            SpotName::Other if !self.names.has_other => {
                ExpressionFault::new(at, "there is no `other`: only what is met, told, conveyed or read has one")
            }
            SpotName::Here if !self.names.has_place => {
                ExpressionFault::new(at, "there is no `place`: only `enters`, `leaves` and `arrives` have one")
            }
            _ => Ok(()),
        }
    }

    fn compile_spot(&self, node: &ExpressionNode) -> Result<SpotName, ExpressionFault> {
        let spot = match &node.tree {
            ExpressionTree::Word(word) => spot_named(word),
            ExpressionTree::Text(name) => Some(SpotName::Place(self.number_of(NameKind::Place, name, node.at)? as u16)),
            _ => None,
        };
        let Some(spot) = spot else {
            let why = "expected `me`, `other`, `place`, `home` or the name of a place in quotes";
            return ExpressionFault::new(node.at, why);
        };
        self.check_available(spot, node.at)?;
        Ok(spot)
    }

    fn compile_call(&mut self, name: &str, operands: &[ExpressionNode], at: usize) -> Result<Type, ExpressionFault> {
        let Some((_, form)) = CALLS.iter().find(|c| c.0 == name) else {
            let help = did_you_mean(name, CALLS.iter().map(|c| c.0));
            return ExpressionFault::new(at, format!("unknown function `{name}`.{help}"));
        };
        if operands.len() != form.matches(',').count() + 1 {
            return ExpressionFault::new(at, format!("expected `{form}`, found {} operands", operands.len()));
        }
        let spot = |of: usize| self.compile_spot(&operands[of]);
        let who = |of: usize| match spot(of)? {
            SpotName::Me => Ok(Subject::Me),
            SpotName::Other => Ok(Subject::Other),
            _ => ExpressionFault::new(operands[of].at, "expected `me` or `other`"),
        };
        let named_at = |sort: NameKind, of: usize| match &operands[of].tree {
            ExpressionTree::Text(name) => self.number_of(sort, name, operands[of].at).map(|n| n as u16),
            _ => ExpressionFault::new(operands[of].at, format!("expected {} in quotes", Type::Name(sort).describe())),
        };
        let named = |sort: NameKind| named_at(sort, 0);
        let load = match name {
            "distance" => Load::Distance(spot(0)?, spot(1)?),
            "friendship" => Load::Friendship(who(0)?, who(1)?),
            "curiosity" => Load::Curiosity(who(0)?, spot(1)?),
            "count" => Load::Count(named(NameKind::Group)?),
            "open" => Load::Open(named(NameKind::Door)?),
            "taken" => Load::Taken(named(NameKind::Thing)?),
            "holds" => Load::Holds(who(0)?, named_at(NameKind::Thing, 1)?),
            "free" => Load::Place(SpotName::Place(named(NameKind::Place)?), PlaceAttribute::Free),
            "held" => Load::Place(SpotName::Place(named(NameKind::Place)?), PlaceAttribute::Held),
            "size" => {
                self.compile_expected(&operands[0], Type::Set)?;
                self.code.push(Op::Size);
                return Ok(Type::Number);
            }
            "if" => return self.compile_conditional(operands),
            _ => return self.compile_numeric(name, operands),
        };
        self.push_op(Op::Load(load), at)?;
        Ok(if ["open", "taken", "holds"].contains(&name) { Type::Truth } else { Type::Number })
    }

    fn compile_conditional(&mut self, operands: &[ExpressionNode]) -> Result<Type, ExpressionFault> {
        self.compile_expected(&operands[0], Type::Truth)?;
        let unless = self.code.len();
        self.code.push(Op::Not);
        self.depth -= 1;
        let of = self.compile_any(&operands[1])?;
        if let Type::Spot(_) = of {
            let why = "expected a value, found somebody or somewhere: ask for something of it, such as `me.x`";
            return ExpressionFault::new(operands[1].at, why);
        }
        let skip = self.code.len();
        self.code.push(Op::Not);
        self.code[unless] = Op::Unless((skip - unless) as u32);
        self.depth -= 1;
        self.compile_expected(&operands[2], of)?;
        self.code[skip] = Op::Skip((self.code.len() - skip - 1) as u32);
        Ok(of)
    }

    fn compile_numeric(&mut self, name: &str, operands: &[ExpressionNode]) -> Result<Type, ExpressionFault> {
        self.compile_expected(&operands[0], Type::Number)?;
        match (name, operands) {
            ("abs", _) => self.code.push(Op::Absolute),
            ("sqrt", _) => self.code.push(Op::Root),
            ("floor", _) => self.code.push(Op::Floor),
            (_, [_, least, most]) => {
                self.compile_expected(most, Type::Number)?;
                self.push_binary(Op::Least);
                self.compile_expected(least, Type::Number)?;
                self.push_binary(Op::Greatest);
            }
            (_, operands) => {
                self.compile_expected(&operands[1], Type::Number)?;
                self.push_binary(if name == "min" { Op::Least } else { Op::Greatest });
            }
        }
        Ok(Type::Number)
    }
}

fn spot_named(word: &str) -> Option<SpotName> {
    match word {
        "me" => Some(SpotName::Me),
        "other" => Some(SpotName::Other),
        "home" => Some(SpotName::Home),
        "place" => Some(SpotName::Here),
        _ => None,
    }
}
