//! What can be wrong with what a troupe is given.

/// A step that cannot be taken.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TroupeError {
    /// A slice of the wrong length.
    #[error("`{what}` has {got} elements, expected {expected}: one per character")]
    Length {
        /// Which slice.
        what: &'static str,
        /// Its length.
        got: usize,
        /// Number of characters.
        expected: usize,
    },
    /// A state or policy that the bundle does not have.
    #[error("{what} {got} does not exist, the bundle has {limit}")]
    Index {
        /// What was named.
        what: &'static str,
        /// Its number.
        got: usize,
        /// How many there are.
        limit: usize,
    },
    /// A character without an opponent.
    #[error("{got} starts are not pairs: characters 2i and 2i + 1 spar with each other, add a start or take one away")]
    Odd {
        /// Number of starts.
        got: usize,
    },
    /// A number out of its range.
    #[error("{what} is {got}, expected {expected}")]
    Value {
        /// Which number.
        what: &'static str,
        /// What it is.
        got: f32,
        /// What it may be.
        expected: &'static str,
    },
    /// The repertoire is not the one the troupe was made with.
    #[error("the troupe was made with a bundle of {expected} {what}, this one has {got}; make a new troupe")]
    OtherBundle {
        /// What is counted.
        what: &'static str,
        /// How many the troupe's bundle has.
        expected: usize,
        /// How many this one has.
        got: usize,
    },
}

pub(super) fn check_index(what: &'static str, got: usize, limit: usize) -> Result<(), TroupeError> {
    if got < limit { Ok(()) } else { Err(TroupeError::Index { what, got, limit }) }
}

pub(super) fn check(what: &'static str, got: f32, good: bool, expected: &'static str) -> Result<(), TroupeError> {
    if good { Ok(()) } else { Err(TroupeError::Value { what, got, expected }) }
}
