//! Scenarios: agents act by rules, state graphs, values, and what they have seen or been told (Kim, Kim and Shin 2003a,
//! section 3, and 2003b, section 3). They are compiled to flat tables before the run, and evaluated only at events.

mod boards;
mod compile;
mod deeds;
mod explain;
mod hands;
mod happenings;
mod language;
mod mind;
mod minds;
mod perceive;
mod reactions;
mod sample;
mod snapshot;
mod stage;
mod tables;
#[cfg(test)]
mod tests;
mod turns;
mod verbs;

pub use boards::{Cell, Posted};
pub use explain::{Because, Explanation, Known, Spread, ValueNow};
pub use mind::{Learnt, Mind};
pub use minds::{Minds, Signal};
pub(crate) use perceive::hashed;
pub use sample::evaluate_sample;
pub(crate) use stage::SIDES;
pub use stage::{Handling, NoStance, Stage};
pub use tables::Scenario;
pub use turns::{StateNow, Turn, TurnKind};
pub use verbs::{Deed, Primitive, Primitives, Said, Sight, Walk, Word};
