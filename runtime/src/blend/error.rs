//! What can be wrong with a blend space, or with what is asked of it.

/// A blend space that cannot be used, or a call that cannot be done.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BlendError {
    /// A space that the bundle does not have, or a body that was not given.
    #[error("{what} {got} does not exist, there are {limit}")]
    Index {
        /// What was named.
        what: &'static str,
        /// Its number.
        got: usize,
        /// How many there are.
        limit: usize,
    },
    /// A slice of the wrong length.
    #[error("`{what}` has {got} elements, expected {expected}")]
    Length {
        /// Which slice.
        what: &'static str,
        /// Its length.
        got: usize,
        /// The length it must have.
        expected: usize,
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
    /// Tables that do not belong together.
    #[error("blend space {space}: its {what} do not lie within the table of {limit}; build the bundle again")]
    Table {
        /// Number of the space.
        space: usize,
        /// Which rows.
        what: &'static str,
        /// Rows that there are.
        limit: usize,
    },
    /// The space is not the one the walkers were made with.
    #[error("the walkers were made with a space of {expected} {what}, this one has {got}; make new walkers")]
    OtherSpace {
        /// What is counted.
        what: &'static str,
        /// How many the walkers' space has.
        expected: usize,
        /// How many this one has.
        got: usize,
    },
}

pub(crate) fn check(what: &'static str, got: f32, good: bool, expected: &'static str) -> Result<(), BlendError> {
    if good { Ok(()) } else { Err(BlendError::Value { what, got, expected }) }
}

pub(crate) fn check_length(what: &'static str, got: usize, expected: usize) -> Result<(), BlendError> {
    if got == expected { Ok(()) } else { Err(BlendError::Length { what, got, expected }) }
}
