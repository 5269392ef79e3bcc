//! Compiler from expression trees to flat code: resolves names and checks types.

use super::code::{Attribute, EventAttribute, Load, Op, PlaceAttribute, Program, STACK, Spot, Who};
use super::parse::{Fault, Node, Tree};
use throng_base::text::did_you_mean;

/// Names of one kind, by their numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Names(pub Vec<String>);

impl Names {
    /// Number of a name.
    pub fn find(&self, name: &str) -> Option<usize> {
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
    Name(Sort),
    /// A set of events.
    Set,
    /// An agent or a place.
    Spot(Spot),
}

/// Kind of a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sort {
    Group,
    State,
    Place,
    Kind,
    Event,
    How,
    Door,
    Thing,
}

/// All names that expressions may use, and whether the event has another agent and a place.
#[derive(Clone, Debug, Default)]
pub struct Vocabulary {
    pub groups: Names,
    pub states: Names,
    pub places: Names,
    pub kinds: Names,
    pub events: Names,
    pub values: Names,
    pub doors: Names,
    pub things: Names,
    /// Ways of learning of an event.
    pub how: Names,
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
    ("event", Load::Event(EventAttribute::Name), Type::Name(Sort::Event)),
    ("event.name", Load::Event(EventAttribute::Name), Type::Name(Sort::Event)),
    ("event.age", Load::Event(EventAttribute::Age), Type::Number),
    ("event.strength", Load::Event(EventAttribute::Strength), Type::Number),
    ("event.how", Load::Event(EventAttribute::How), Type::Name(Sort::How)),
    ("place.name", Load::Place(Spot::Here, PlaceAttribute::Name), Type::Name(Sort::Place)),
    ("place.kind", Load::Place(Spot::Here, PlaceAttribute::Kind), Type::Name(Sort::Kind)),
    ("place.free", Load::Place(Spot::Here, PlaceAttribute::Free), Type::Number),
    ("place.held", Load::Place(Spot::Here, PlaceAttribute::Held), Type::Number),
    ("board", Load::Board(false), Type::Set),
    ("cell", Load::Board(true), Type::Set),
];

/// Attributes of `me` and `other`, beside the values of the scene.
const ATTRIBUTES: &[(&str, Attribute, Type)] = &[
    ("x", Attribute::X, Type::Number),
    ("y", Attribute::Y, Type::Number),
    ("z", Attribute::Z, Type::Number),
    ("speed", Attribute::Speed, Type::Number),
    ("desired_speed", Attribute::DesiredSpeed, Type::Number),
    ("group", Attribute::Group, Type::Name(Sort::Group)),
    ("state", Attribute::State(0), Type::Name(Sort::State)),
    ("spatial", Attribute::State(1), Type::Name(Sort::State)),
    ("primitive", Attribute::State(2), Type::Name(Sort::State)),
    ("state_s", Attribute::StateSeconds, Type::Number),
    ("news", Attribute::News, Type::Set),
    ("busy", Attribute::Busy, Type::Truth),
    ("number", Attribute::Number, Type::Number),
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
    fn words(self) -> String {
        match self {
            Self::Number => "a number".into(),
            Self::Truth => "true or false".into(),
            Self::Name(sort) => format!("the name of a {}", sort.word()),
            Self::Set => "a set of events".into(),
            Self::Spot(_) => "somebody or somewhere".into(),
        }
    }
}

impl Sort {
    fn word(self) -> &'static str {
        match self {
            Self::Group => "group",
            Self::State => "state",
            Self::Place => "place",
            Self::Kind => "kind of place",
            Self::Event => "event",
            Self::How => "way of learning",
            Self::Door => "door",
            Self::Thing => "thing",
        }
    }
}

impl Vocabulary {
    fn names(&self, sort: Sort) -> &Names {
        match sort {
            Sort::Group => &self.groups,
            Sort::State => &self.states,
            Sort::Place => &self.places,
            Sort::Kind => &self.kinds,
            Sort::Event => &self.events,
            Sort::How => &self.how,
            Sort::Door => &self.doors,
            Sort::Thing => &self.things,
        }
    }

    /// Number of a name of a kind.
    ///
    /// # Errors
    /// A message with the nearest known name.
    pub fn number(&self, sort: Sort, name: &str) -> Result<usize, String> {
        let known = &self.names(sort).0;
        known.iter().position(|n| n == name).ok_or_else(|| {
            let word = sort.word();
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
/// [`Fault`] for unknown names, with the nearest known, and types that do not fit.
pub fn compile(node: &Node, expected: Type, names: &Vocabulary, code: &mut Vec<Op>) -> Result<Program, Fault> {
    let first = code.len();
    let mut compiler = Compiler { names, code, depth: 0 };
    let result = compiler.expect(node, expected);
    if let Err(fault) = result {
        code.truncate(first);
        return Err(fault);
    }
    Ok(Program { first: first as u32, count: (code.len() - first) as u32 })
}

struct Compiler<'a> {
    names: &'a Vocabulary,
    code: &'a mut Vec<Op>,
    /// Depth of the stack at this place of the code.
    depth: usize,
}

impl Compiler<'_> {
    fn push(&mut self, op: Op, at: usize) -> Result<(), Fault> {
        self.depth += 1;
        if self.depth > STACK {
            return Fault::new(at, format!("expected at most {STACK} values at a time"));
        }
        self.code.push(op);
        Ok(())
    }

    /// Adds an operation with two operands.
    fn join(&mut self, op: Op) {
        self.code.push(op);
        self.depth -= 1;
    }

    fn expect(&mut self, node: &Node, expected: Type) -> Result<(), Fault> {
        if let (Tree::Text(name), Type::Name(sort)) = (&node.tree, expected) {
            let number = self.names.number(sort, name).map_err(|why| Fault { at: node.at + 1, why })?;
            return self.push(Op::Number(number as f64), node.at);
        }
        let found = self.any(node)?;
        if found == expected {
            return Ok(());
        }
        Fault::new(node.at, format!("expected {}, found {}", expected.words(), found.words()))
    }

    fn any(&mut self, node: &Node) -> Result<Type, Fault> {
        match &node.tree {
            Tree::Number(number) => self.push(Op::Number(*number), node.at).map(|()| Type::Number),
            Tree::Truth(is) => self.push(Op::Number(f64::from(u8::from(*is))), node.at).map(|()| Type::Truth),
            Tree::Text(text) => {
                Fault::new(node.at, format!("expected a value, found \"{text}\": compare it with a name"))
            }
            Tree::Set(_) => Fault::new(node.at, "expected a value, found a set: write `NAME in { .. }`"),
            Tree::Word(word) => self.word(word, node.at),
            Tree::Call(name, operands) => self.call(name, operands, node.at),
            Tree::Unary("-", of) => {
                self.expect(of, Type::Number)?;
                self.code.push(Op::Negate);
                Ok(Type::Number)
            }
            Tree::Unary(_, of) => {
                self.expect(of, Type::Truth)?;
                self.code.push(Op::Not);
                Ok(Type::Truth)
            }
            Tree::Binary(operator, a, b) => self.binary(operator, a, b, node.at),
        }
    }

    fn binary(&mut self, operator: &str, a: &Node, b: &Node, at: usize) -> Result<Type, Fault> {
        match operator {
            "and" | "or" => {
                self.expect(a, Type::Truth)?;
                let jump = self.code.len();
                self.code.push(Op::Not);
                self.depth -= 1;
                self.expect(b, Type::Truth)?;
                let far = (self.code.len() - jump - 1) as u32;
                self.code[jump] = if operator == "and" { Op::And(far) } else { Op::Or(far) };
                Ok(Type::Truth)
            }
            "==" | "!=" => {
                let (first, second) = if matches!(a.tree, Tree::Text(_)) { (b, a) } else { (a, b) };
                let sort = self.any(first)?;
                if matches!(sort, Type::Set | Type::Spot(_)) {
                    let why = "expected numbers, truths or names to compare; compare `place.name` with a name";
                    return Fault::new(at, why);
                }
                self.expect(second, sort)?;
                self.join(if operator == "==" { Op::Equal } else { Op::Unequal });
                Ok(Type::Truth)
            }
            "in" => self.is_in(a, b),
            _ => {
                let (first, second) = if matches!(operator, ">" | ">=") { (b, a) } else { (a, b) };
                self.expect(first, Type::Number)?;
                self.expect(second, Type::Number)?;
                let (op, of) = match operator {
                    "+" => (Op::Add, Type::Number),
                    "-" => (Op::Subtract, Type::Number),
                    "*" => (Op::Multiply, Type::Number),
                    "/" => (Op::Divide, Type::Number),
                    "<" | ">" => (Op::Less, Type::Truth),
                    _ => (Op::LessOrEqual, Type::Truth),
                };
                self.join(op);
                Ok(of)
            }
        }
    }

    fn is_in(&mut self, a: &Node, b: &Node) -> Result<Type, Fault> {
        if let Tree::Set(members) = &b.tree {
            let Type::Name(sort) = self.any(a)? else {
                return Fault::new(a.at, "expected a name, such as `me.group`, before `in { .. }`");
            };
            self.code.push(Op::OneOf(members.len() as u32));
            for member in members {
                let Tree::Text(name) = &member.tree else { return Fault::new(member.at, "expected a name in quotes") };
                let number = self.names.number(sort, name).map_err(|why| Fault { at: member.at + 1, why })?;
                self.code.push(Op::Number(number as f64));
            }
            return Ok(Type::Truth);
        }
        self.expect(a, Type::Name(Sort::Event))?;
        self.expect(b, Type::Set)?;
        self.join(Op::In);
        Ok(Type::Truth)
    }

    fn word(&mut self, word: &str, at: usize) -> Result<Type, Fault> {
        if let Some(spot) = spot_named(word) {
            self.check_there(spot, at)?;
            return Ok(Type::Spot(spot));
        }
        if let Some(&(_, load, of)) = WORDS.iter().find(|w| w.0 == word) {
            match load {
                Load::Place(spot, _) => self.check_there(spot, at)?,
                Load::Random | Load::Board(true) if self.names.is_of_all => {
                    return Fault::new(at, format!("there is no `{word}`: {OF_ALL}"));
                }
                _ => {}
            }
            return self.push(Op::Load(load), at).map(|()| of);
        }
        let (of, name) = word.split_once('.').unwrap_or(("me", word));
        let who = match of {
            "me" => Who::Me,
            "other" => Who::Other,
            _ => return self.unknown(word, at),
        };
        let value = self.names.values.find(name).map(|v| (Attribute::Value(v as u16), Type::Number));
        let own = || ATTRIBUTES.iter().find(|a| a.0 == name).map(|a| (a.1, a.2));
        match value.or_else(own) {
            Some((attribute, of)) => {
                self.check_there(if who == Who::Me { Spot::Me } else { Spot::Other }, at)?;
                self.push(Op::Load(Load::Of(who, attribute)), at).map(|()| of)
            }
            None => self.unknown(word, at),
        }
    }

    fn unknown<T>(&self, word: &str, at: usize) -> Result<T, Fault> {
        let own = ATTRIBUTES.iter().map(|a| a.0).chain(self.names.values.0.iter().map(String::as_str));
        let own: Vec<String> = own.flat_map(|a| [format!("me.{a}"), format!("other.{a}")]).collect();
        let all = WORDS.iter().map(|w| w.0).chain(own.iter().map(String::as_str));
        let help = did_you_mean(word, all);
        let way_out = if help.is_empty() { " Values are declared in `[values]`.".into() } else { help };
        Fault::new(at, format!("unknown word `{word}`.{way_out}"))
    }

    /// Checks that the event has the named agent or place.
    fn check_there(&self, spot: Spot, at: usize) -> Result<(), Fault> {
        match spot {
            Spot::Me if self.names.is_of_all => Fault::new(at, format!("there is no `me`: {OF_ALL}")),
            Spot::Other if !self.names.has_other => {
                Fault::new(at, "there is no `other`: only what is met, told, conveyed or read has one")
            }
            Spot::Here if !self.names.has_place => {
                Fault::new(at, "there is no `place`: only `enters`, `leaves`, `freed` and `arrives` have one")
            }
            _ => Ok(()),
        }
    }

    fn spot(&self, node: &Node) -> Result<Spot, Fault> {
        let spot = match &node.tree {
            Tree::Word(word) => spot_named(word),
            Tree::Text(name) => {
                let number = self.names.number(Sort::Place, name).map_err(|why| Fault { at: node.at + 1, why })?;
                Some(Spot::Place(number as u16))
            }
            _ => None,
        };
        let Some(spot) = spot else {
            return Fault::new(node.at, "expected `me`, `other`, `place`, `home` or the name of a place in quotes");
        };
        self.check_there(spot, node.at)?;
        Ok(spot)
    }

    fn call(&mut self, name: &str, operands: &[Node], at: usize) -> Result<Type, Fault> {
        let Some((_, form)) = CALLS.iter().find(|c| c.0 == name) else {
            let help = did_you_mean(name, CALLS.iter().map(|c| c.0));
            return Fault::new(at, format!("unknown function `{name}`.{help}"));
        };
        let count = form.matches(',').count() + 1;
        if operands.len() != count {
            return Fault::new(at, format!("expected `{form}`, found {} operands", operands.len()));
        }
        let who = |spot: Spot, node: &Node| match spot {
            Spot::Me => Ok(Who::Me),
            Spot::Other => Ok(Who::Other),
            _ => Fault::new(node.at, "expected `me` or `other`"),
        };
        let named_at = |sort: Sort, of: usize| match &operands[of].tree {
            Tree::Text(name) => {
                self.names.number(sort, name).map(|n| n as u16).map_err(|why| Fault { at: operands[of].at + 1, why })
            }
            _ => Fault::new(operands[of].at, format!("expected {} in quotes", Type::Name(sort).words())),
        };
        let named = |sort: Sort| named_at(sort, 0);
        let load = match name {
            "distance" => Load::Distance(self.spot(&operands[0])?, self.spot(&operands[1])?),
            "friendship" => {
                let of = |node: &Node| who(self.spot(node)?, node);
                Load::Friendship(of(&operands[0])?, of(&operands[1])?)
            }
            "curiosity" => {
                let me = who(self.spot(&operands[0])?, &operands[0])?;
                Load::Curiosity(me, self.spot(&operands[1])?)
            }
            "count" => Load::Count(named(Sort::Group)?),
            "open" => Load::Open(named(Sort::Door)?),
            "taken" => Load::Taken(named(Sort::Thing)?),
            "holds" => Load::Holds(who(self.spot(&operands[0])?, &operands[0])?, named_at(Sort::Thing, 1)?),
            "free" => Load::Place(Spot::Place(named(Sort::Place)?), PlaceAttribute::Free),
            "held" => Load::Place(Spot::Place(named(Sort::Place)?), PlaceAttribute::Held),
            "size" => {
                self.expect(&operands[0], Type::Set)?;
                self.code.push(Op::Size);
                return Ok(Type::Number);
            }
            "if" => return self.choose(operands),
            _ => return self.numeric(name, operands),
        };
        self.push(Op::Load(load), at)?;
        Ok(if ["open", "taken", "holds"].contains(&name) { Type::Truth } else { Type::Number })
    }

    fn choose(&mut self, operands: &[Node]) -> Result<Type, Fault> {
        self.expect(&operands[0], Type::Truth)?;
        let unless = self.code.len();
        self.code.push(Op::Not);
        self.depth -= 1;
        let of = self.any(&operands[1])?;
        if let Type::Spot(_) = of {
            return Fault::new(
                operands[1].at,
                "expected a value, found somebody or somewhere: ask for something of it, such as `me.x`",
            );
        }
        let skip = self.code.len();
        self.code.push(Op::Not);
        self.code[unless] = Op::Unless((skip - unless) as u32);
        self.depth -= 1;
        self.expect(&operands[2], of)?;
        self.code[skip] = Op::Skip((self.code.len() - skip - 1) as u32);
        Ok(of)
    }

    fn numeric(&mut self, name: &str, operands: &[Node]) -> Result<Type, Fault> {
        self.expect(&operands[0], Type::Number)?;
        match (name, operands) {
            ("abs", _) => self.code.push(Op::Absolute),
            ("sqrt", _) => self.code.push(Op::Root),
            ("floor", _) => self.code.push(Op::Floor),
            (_, [_, least, most]) => {
                self.expect(most, Type::Number)?;
                self.join(Op::Least);
                self.expect(least, Type::Number)?;
                self.join(Op::Greatest);
            }
            (_, operands) => {
                self.expect(&operands[1], Type::Number)?;
                self.join(if name == "min" { Op::Least } else { Op::Greatest });
            }
        }
        Ok(Type::Number)
    }
}

fn spot_named(word: &str) -> Option<Spot> {
    match word {
        "me" => Some(Spot::Me),
        "other" => Some(Spot::Other),
        "home" => Some(Spot::Home),
        "place" => Some(Spot::Here),
        _ => None,
    }
}
