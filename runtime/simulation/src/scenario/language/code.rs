//! Flat code, and what runs it.

use serde::{Deserialize, Serialize};

/// Deepest stack of a program.
pub(super) const STACK: usize = 32;

/// One operation: takes its operands from the stack and leaves its result there. Truths are 0 and 1, names their numbers,
/// sets of events the bits of their numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Op {
    Number(f64),
    Load(Load),
    Not,
    Negate,
    Add,
    Subtract,
    Multiply,
    Divide,
    Equal,
    Unequal,
    Less,
    LessOrEqual,
    /// Name and set: is it in the set?
    In,
    /// Is the name one of `count` that follow in the code as numbers? They are skipped.
    OneOf(u32),
    /// Members of a set.
    Size,
    Least,
    Greatest,
    Absolute,
    Root,
    Floor,
    /// Goes on `0` operations later where the truth on the stack is false, and keeps it; otherwise drops it.
    And(u32),
    /// The same where it is true.
    Or(u32),
    /// Drops a truth, and goes on later where it is false.
    Unless(u32),
    /// Goes on later.
    Skip(u32),
}

/// Something that is looked up.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Load {
    /// Simulated time (s).
    Time,
    /// A number by chance, from 0 up to 1.
    Random,
    /// Something of somebody.
    Of(Who, Attribute),
    /// Of the event.
    Event(EventAttribute),
    /// Of a place.
    Place(Spot, PlaceAttribute),
    /// Set of the events on the global board (`false`) or on those of the agent's cells (`true`).
    Board(bool),
    /// Between two spots (m); infinite where one is not there.
    Distance(Spot, Spot),
    /// Of one to the other (-1 to 1).
    Friendship(Who, Who),
    /// Of one in somebody or something (-1 to 1).
    Curiosity(Who, Spot),
    /// Number of those of a group who are there.
    Count(u16),
    /// 1 where a door is open.
    Open(u16),
    /// 1 where somebody has a thing in hand, or goes to take it.
    Taken(u16),
    /// 1 where it is this one.
    Holds(Who, u16),
}

/// Who.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Who {
    /// To whom the event happens.
    Me,
    /// Who is met, or tells.
    Other,
}

/// What somebody has.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Attribute {
    /// A value of the scene, by its number.
    Value(u16),
    X,
    Z,
    Speed,
    DesiredSpeed,
    Group,
    /// State of a level: 0 social, 1 spatial, 2 primitive.
    State(u8),
    /// How long it has been in its state of the highest level (s).
    StateSeconds,
    /// Events that it knows of.
    News,
    /// 1 while a rule's behaviour lasts.
    Busy,
    /// Number of the agent.
    Number,
    Y,
}

/// What an event has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum EventAttribute {
    /// Its name.
    Name,
    /// Time since it happened first (s).
    Age,
    /// 1 as it happens, weaker farther off for what is conveyed.
    Strength,
    /// How one learnt of it.
    How,
}

/// What a place has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum PlaceAttribute {
    Name,
    Kind,
    /// Slots that nobody holds.
    Free,
    /// Slots that are held.
    Held,
}

/// Somewhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Spot {
    Me,
    Other,
    /// Where the agent entered.
    Home,
    /// The place of the event.
    Here,
    Place(u16),
}

/// Where the code of an expression is among that of all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Program {
    pub(super) first: u32,
    pub(super) count: u32,
}

/// A number that the file gives, or an expression for it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Amount {
    /// The same always.
    Number(f64),
    /// As it is when it is asked for.
    Program(Program),
}

/// What a program looks at.
pub trait Perception {
    /// What is asked for, as a number of the stack.
    fn load(&mut self, what: Load) -> f64;
}

/// Runs a program of code that [`super::compile`] made, or that was checked when it was read.
///
/// - returns what is left on the stack.
pub fn run(code: &[Op], program: Program, perception: &mut impl Perception) -> f64 {
    let code = &code[program.first as usize..][..program.count as usize];
    let mut stack = [0.0_f64; STACK];
    let mut top = 0;
    let mut at = 0;
    macro_rules! two {
        (|$a:ident, $b:ident| $result:expr) => {{
            let ($a, $b) = (stack[top - 2], stack[top - 1]);
            top -= 1;
            stack[top - 1] = $result;
        }};
    }
    macro_rules! one {
        (|$a:ident| $result:expr) => {{
            let $a = stack[top - 1];
            stack[top - 1] = $result;
        }};
    }
    let truth = |is: bool| f64::from(u8::from(is));
    while let Some(op) = code.get(at) {
        at += 1;
        match *op {
            Op::Number(number) => {
                stack[top] = number;
                top += 1;
            }
            Op::Load(what) => {
                stack[top] = perception.load(what);
                top += 1;
            }
            Op::Not => one!(|a| truth(a == 0.0)),
            Op::Negate => one!(|a| -a),
            Op::Add => two!(|a, b| a + b),
            Op::Subtract => two!(|a, b| a - b),
            Op::Multiply => two!(|a, b| a * b),
            Op::Divide => two!(|a, b| if b == 0.0 { 0.0 } else { a / b }),
            Op::Equal => two!(|a, b| truth(a == b)),
            Op::Unequal => two!(|a, b| truth(a != b)),
            Op::Less => two!(|a, b| truth(a < b)),
            Op::LessOrEqual => two!(|a, b| truth(a <= b)),
            Op::In => two!(|a, b| truth(a >= 0.0 && b.to_bits() >> (a as u32 & 63) & 1 == 1)),
            Op::OneOf(count) => {
                let names = &code[at..at + count as usize];
                one!(|a| truth(names.contains(&Op::Number(a))));
                at += count as usize;
            }
            Op::Size => one!(|a| f64::from(a.to_bits().count_ones())),
            Op::Least => two!(|a, b| a.min(b)),
            Op::Greatest => two!(|a, b| a.max(b)),
            Op::Absolute => one!(|a| a.abs()),
            Op::Root => one!(|a| a.max(0.0).sqrt()),
            Op::Floor => one!(|a| a.floor()),
            Op::And(far) if stack[top - 1] == 0.0 => at += far as usize,
            Op::Or(far) if stack[top - 1] != 0.0 => at += far as usize,
            Op::And(_) | Op::Or(_) => top -= 1,
            Op::Unless(far) => {
                top -= 1;
                at += if stack[top] == 0.0 { far as usize } else { 0 };
            }
            Op::Skip(far) => at += far as usize,
        }
    }
    stack[0]
}
