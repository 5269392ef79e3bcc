//! Errors of characters.

/// A step that cannot be taken.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CharactersError {
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
    /// The motion set is not the one the characters were made with.
    #[error("the characters were made with a bundle of {expected} {what}, this one has {got}; make new characters")]
    OtherBundle {
        /// What is counted.
        what: &'static str,
        /// How many the characters' bundle has.
        expected: usize,
        /// How many this one has.
        got: usize,
    },
}

pub(super) fn check_index(what: &'static str, got: usize, limit: usize) -> Result<(), CharactersError> {
    if got < limit { Ok(()) } else { Err(CharactersError::Index { what, got, limit }) }
}

pub(super) fn check(what: &'static str, got: f32, good: bool, expected: &'static str) -> Result<(), CharactersError> {
    if good { Ok(()) } else { Err(CharactersError::Value { what, got, expected }) }
}

impl From<CharactersError> for throng_base::Error {
    fn from(error: CharactersError) -> Self {
        match error {
            CharactersError::Length { what, got, expected } => {
                Self::Length { what, got, expected: format!("{expected}: one per character") }
            }
            CharactersError::Index { what, got, limit } => Self::Index { what, who: None, got, limit },
            CharactersError::Value { what, got, expected } => {
                Self::Value { what, who: None, got: got.into(), expected }
            }
            CharactersError::OtherBundle { what, expected, got } => {
                Self::Length { what, got, expected: format!("{expected}, as in the bundle they were made with") }
            }
        }
    }
}
