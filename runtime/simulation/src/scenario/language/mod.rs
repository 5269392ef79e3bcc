//! The language of predicates and amounts: text, parsed, checked for types, and compiled to flat code.

mod code;
mod compile;
mod parse;

pub use code::{
    Amount, Attribute, EventAttribute, Load, Op, Perception, PlaceAttribute, Program, SpotName, Subject, run_program,
};
pub use compile::{NameKind, NameList, ScenarioVocabulary, Type, compile_expression};
pub use parse::parse_expression;
#[cfg(test)]
pub use parse::{ExpressionNode, ExpressionTree};
