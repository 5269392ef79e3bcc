//! Scenarios: agents act by rules, state graphs, values, and what they have seen or been told (Kim, Kim and Shin 2003a,
//! section 3, and 2003b, section 3). They are compiled to flat tables before the run, and evaluated only at events.

mod action_commands;
mod action_registry;
mod agent_brain;
mod agent_brains;
mod blackboards;
mod compile;
mod courses;
mod expectations;
mod explain;
mod hands;
mod happenings;
mod language;
mod parties;
mod perceive;
mod reactions;
mod sample;
mod services;
mod slots;
mod snapshot;
mod stage;
mod tables;
#[cfg(test)]
mod tests;
mod turns;

pub(crate) use action_registry::GESTURES;
pub use action_registry::{
    ActionArguments, ActionCommand, ActionRegistry, PrimitiveBehaviour, PrimitiveInput, WalkCommand, WordKind,
};
pub use agent_brain::{AgentBrain, LearntEvent};
pub use agent_brains::{AgentBrains, Signal};
pub use blackboards::{BlackboardArea, BlackboardPost};
pub(crate) use expectations::{AgentsView, ExpectationMeters};
pub use expectations::{ExpectationOutcome, WorstAgent};
pub use explain::{ActionCause, CurrentValue, EventSpread, Explanation, KnownEvent};
pub(crate) use happenings::BrainChange;
pub(crate) use perceive::hashed_chance;
pub use sample::evaluate_sample;
pub use services::{ServiceStatistics, SourceStatistics, TillStatistics};
pub(crate) use stage::SIDES;
pub use stage::{Handling, ScenarioStage, ShownGesture, Stance, StanceError};
pub use tables::Scenario;
pub use turns::{CurrentState, Turn, TurnKind};
