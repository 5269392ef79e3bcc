//! Flat code of expressions, and its interpreter.

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
    /// Membership of a name in a set.
    In,
    /// Membership of a name in a list of this length, which follows in the code as numbers and is skipped.
    OneOf(u32),
    /// Number of members of a set.
    Size,
    Least,
    Greatest,
    Absolute,
    Root,
    Floor,
    /// Jumps ahead by this number of operations where the truth on the stack is false, and keeps it; otherwise drops it.
    And(u32),
    /// Jumps ahead where the truth on the stack is true, and keeps it; otherwise drops it.
    Or(u32),
    /// Drops a truth, and jumps ahead where it is false.
    Unless(u32),
    /// Jumps ahead.
    Skip(u32),
}

/// Quantity that an expression looks up. Compiled code is never saved. It is asked only while something happens to agents: what
/// changes by itself wakes nobody.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Load {
    /// Simulated time (s).
    Time,
    /// Random number, from 0 up to 1.
    Random,
    /// Attribute of an agent.
    Of(Subject, Attribute),
    /// Attribute of the event.
    Event(EventAttribute),
    /// Attribute of a place.
    Place(SpotName, PlaceAttribute),
    /// Set of the events on the global blackboard (`false`) or also on those of the agent's cells (`true`).
    Blackboard(bool),
    /// Distance between two spots; infinite where one is not there (m).
    Distance(SpotName, SpotName),
    /// Friendship of one agent for another (-1 to 1).
    Friendship(Subject, Subject),
    /// Curiosity of an agent about a spot (-1 to 1).
    Curiosity(Subject, SpotName),
    /// Number of agents of a group that are there.
    Count(u16),
    /// Truth: a door is open.
    Open(u16),
    /// Truth: some agent has a thing in hand, or a claim to take it.
    Taken(u16),
    /// Truth: this agent has a thing in hand, or a claim to take it.
    Holds(Subject, u16),
}

/// Agent that an expression is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Subject {
    /// Agent to which the event happens.
    Me,
    /// Other agent, which is met or tells of the event.
    Other,
}

/// Attribute of an agent.
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
    /// Time in its state of the highest level (s).
    StateSeconds,
    /// Events that it knows of.
    News,
    /// Truth: a rule's behaviour lasts.
    Busy,
    /// Number of the agent.
    Number,
    Y,
    /// Truth: it is in a queue.
    Waits,
    /// Laps of its course that it has done.
    Laps,
    /// Distance that it has done along its course (m).
    Progress,
}

/// Attribute of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum EventAttribute {
    /// Name of the event.
    Name,
    /// Time since it happened last (s).
    Age,
    /// Strength: 1 where it happens, less at a distance where it is conveyed.
    Strength,
    /// Way in which the agent learnt of it.
    How,
}

/// Attribute of a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum PlaceAttribute {
    Name,
    Kind,
    /// Number of free slots.
    Free,
    /// Number of slots that agents hold.
    Held,
}

/// Named position.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SpotName {
    Me,
    Other,
    /// Position at which the agent entered.
    Home,
    /// The place of the event.
    Here,
    Place(u16),
}

/// Range of an expression's code within the code of all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Program {
    pub(super) first: u32,
    pub(super) count: u32,
}

/// Number of the scene file, or an expression for it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Amount {
    /// Constant number.
    Number(f64),
    /// Expression that is evaluated when the number is needed.
    Program(Program),
}

/// Source of the quantities that a program looks up.
pub trait Perception {
    /// Looks up a quantity, as a number of the stack.
    fn load_value(&mut self, what: Load) -> f64;
}

/// Runs a program of code that [`super::compile`] made, or that was checked when it was read.
///
/// - returns the number that is left on the stack.
pub fn run_program(code: &[Op], program: Program, perception: &mut impl Perception) -> f64 {
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
                stack[top] = perception.load_value(what);
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
