//! Errors of policy tables.

/// A policy table that is malformed.
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
    /// A stored index out of range.
    #[error("policy table `{what}`, element {at}: index {got}, expected below {limit}; rebuild the bundle")]
    Index {
        /// Which slice.
        what: &'static str,
        /// Element of that slice.
        at: usize,
        /// The index found.
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
        /// The number found.
        got: f32,
        /// What was expected.
        expected: &'static str,
    },
}
