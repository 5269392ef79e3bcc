//! The language of predicates and amounts: text, parsed, checked for types, and compiled to flat code.

mod code;
mod compile;
mod parse;

pub use code::{Amount, Attribute, EventAttribute, Load, Op, Perception, PlaceAttribute, Program, Spot, Who, run};
pub use compile::{Names, Sort, Type, Vocabulary, compile};
pub use parse::parse;
#[cfg(test)]
pub use parse::{Node, Tree};
