//! What can be wrong with a policy's tables or with a batch of queries.

/// Tables that do not fit together.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PolicyError {
    /// A slice of the wrong length.
    #[error("policy table `{what}` has {got} elements, expected {expected}; rebuild the bundle")]
    Length {
        /// Which slice.
        what: &'static str,
        /// Its length.
        got: usize,
        /// What the record asks for.
        expected: usize,
    },
    /// A stored index that points nowhere.
    #[error("policy table `{what}`, element {at}: index {got}, expected below {limit}; rebuild the bundle")]
    Index {
        /// Which slice.
        what: &'static str,
        /// Element of that slice.
        at: usize,
        /// The index found there.
        got: usize,
        /// What it must stay below.
        limit: usize,
    },
    /// A number that is not finite or out of its range.
    #[error("policy table `{what}`, element {at}: {got} is not {expected}; rebuild the bundle")]
    Value {
        /// Which field or slice.
        what: &'static str,
        /// Element of that slice, 0 for a field.
        at: usize,
        /// The number found there.
        got: f32,
        /// What was expected.
        expected: &'static str,
    },
}

/// A batch that cannot run.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PolicyJobError {
    /// Slices of different lengths.
    #[error("`{what}` has {got} elements, expected {expected}: one per character")]
    Length {
        /// Which slice.
        what: &'static str,
        /// Its length.
        got: usize,
        /// Number of characters.
        expected: usize,
    },
    /// A state the tables do not have.
    #[error("character {character}: state {state}, but the policy has {num_states}")]
    State {
        /// Index into the batch.
        character: usize,
        /// The state given.
        state: u32,
        /// States of the policy.
        num_states: usize,
    },
    /// A target that is no place.
    #[error("character {character}: the target is not finite or farther than 1e15 m")]
    Target {
        /// Index into the batch.
        character: usize,
    },
    /// A weight that is no factor.
    #[error("goal {goal}, character {character}: the weight is not between -1e6 and 1e6")]
    Weight {
        /// Index into the goals.
        goal: usize,
        /// Index into the batch.
        character: usize,
    },
    /// Policies of different motion graphs in one look-ahead.
    #[error("goal {goal} has a policy for other states and actions than goal 0")]
    Graph {
        /// Index into the goals.
        goal: usize,
    },
}
