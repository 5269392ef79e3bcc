//! What can be wrong with what the runtime is given.

use crate::Id;
use glam::Vec3;
use std::path::PathBuf;

/// Something that cannot be done: who it concerns, what was expected, and the way out.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file that cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A file that is not what it should be.
    #[error("{}: {why}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong, where, and what to do.
        why: String,
    },
    /// A text file that says something wrong.
    #[error("{}:{line}:{column}: {why}", path.display())]
    Text {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong, and what to do.
        why: String,
    },
    /// A number out of its range.
    #[error("{}{what} is {got}, expected {expected}", of(.who))]
    Value {
        /// Which number.
        what: &'static str,
        /// Whose.
        who: Option<Id>,
        /// What it is.
        got: f64,
        /// What it may be.
        expected: &'static str,
    },
    /// A number of something that does not exist.
    #[error("{}{what} {got} does not exist, there are {limit}", of(.who))]
    Index {
        /// What was named.
        what: &'static str,
        /// Who named it.
        who: Option<Id>,
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
        /// What it may be, in words.
        expected: String,
    },
    /// A name of something that does not exist.
    #[error("there is no {what} \"{name}\"; {}", there_is(.known))]
    Unknown {
        /// What was named.
        what: &'static str,
        /// Its name.
        name: String,
        /// The names that there are.
        known: Vec<String>,
    },
    /// An agent or character that has left.
    #[error("{0} is not there: it has left")]
    Gone(Id),
    /// No room for another one.
    #[error("all {capacity} places are taken; make it with a larger capacity")]
    Full {
        /// How many it was made for.
        capacity: usize,
    },
    /// No way leads there.
    #[error("{}no way leads from {from} to {to}; name a place that can be reached", of(.who))]
    NoWay {
        /// Who was to go there.
        who: Option<Id>,
        /// Where it begins (m).
        from: Vec3,
        /// Where it should end (m).
        to: Vec3,
    },
    /// A place that is taken.
    #[error("{who} cannot be there: {by} is in the way; choose another place")]
    Occupied {
        /// Who was to be there.
        who: Id,
        /// Agent, character or obstacle that is in the way, in words.
        by: String,
    },
    /// Made with another bundle.
    #[error(
        "this was made with another bundle ({expected:032x}, not {got:032x}); make it anew (stitch a world again), or `adopt` the bundle"
    )]
    OtherBundle {
        /// Content hash of the bundle it was made with.
        expected: u128,
        /// Content hash of the bundle given.
        got: u128,
    },
    /// Bytes that are no snapshot of this.
    #[error("this is no snapshot of this {what}: {why}")]
    Snapshot {
        /// What should be restored.
        what: &'static str,
        /// What is wrong, and what to do.
        why: String,
    },
    /// One of several processes that work together, and why the others cannot go on.
    #[error("rank {rank} {why}")]
    Rank {
        /// Which one.
        rank: usize,
        /// What it did, and what to do.
        why: String,
    },
}

/// "3: " before a message about agent or character 3.
fn of(who: &Option<Id>) -> String {
    who.map_or(String::new(), |id| format!("{id}: "))
}

/// The names that may be given.
fn there_is(known: &[String]) -> String {
    if known.is_empty() { "there is none".into() } else { format!("there is {}", known.join(", ")) }
}

/// What the calls of the runtime return.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// [`Error::Value`] unless `good`.
///
/// # Errors
/// As said.
pub fn check(
    what: &'static str,
    who: Option<Id>,
    got: impl Into<f64>,
    good: bool,
    expected: &'static str,
) -> Result<()> {
    if good { Ok(()) } else { Err(Error::Value { what, who, got: got.into(), expected }) }
}

/// [`Error::Length`] unless `got` is as long as `expected`.
///
/// # Errors
/// As said.
pub fn check_length(what: &'static str, got: usize, expected: usize) -> Result<()> {
    if got == expected { Ok(()) } else { Err(Error::Length { what, got, expected: expected.to_string() }) }
}

/// [`Error::Index`] unless `got < limit`.
///
/// # Errors
/// As said.
pub fn check_index(what: &'static str, who: Option<Id>, got: usize, limit: usize) -> Result<()> {
    if got < limit { Ok(()) } else { Err(Error::Index { what, who, got, limit }) }
}
