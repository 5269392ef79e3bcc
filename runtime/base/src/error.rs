//! Errors of what the runtime is given.

use crate::Id;
use glam::Vec3;
use std::{ops::RangeBounds, path::PathBuf};

/// Error of a call: whom it concerns, what was expected, and how to correct it.
///
/// ```
/// use throng_base::{Error, limits::STEP_S};
///
/// let error = STEP_S.check("dt_s", None, -1.0).unwrap_err();
/// assert!(matches!(error, Error::Value { .. }));
/// assert!(error.to_string().contains("dt_s"), "{error}");
/// ```
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file that cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Message of the system.
        source: std::io::Error,
    },
    /// A file that is not what it should be.
    #[error("{}: {why}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// Description of the fault: its place, and how to correct it.
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
        /// Description of the fault, and how to correct it.
        why: String,
    },
    /// A number out of its range.
    #[error("{}{what} is {got}, expected {expected}", id_prefix(.who))]
    Value {
        /// Name of the number.
        what: &'static str,
        /// Agent or character that the number belongs to.
        who: Option<Id>,
        /// Value that was given.
        got: f64,
        /// Values that are allowed, in words.
        expected: &'static str,
    },
    /// A number of something that does not exist.
    #[error("{}{what} {got} does not exist, there are {limit}", id_prefix(.who))]
    Index {
        /// Kind of the item that was named.
        what: &'static str,
        /// Agent or character that named it.
        who: Option<Id>,
        /// Number that was given.
        got: usize,
        /// Number of such items.
        limit: usize,
    },
    /// A slice of the wrong length.
    #[error("`{what}` has {got} elements, expected {expected}")]
    Length {
        /// Name of the slice.
        what: &'static str,
        /// Its length.
        got: usize,
        /// Lengths that are allowed, in words.
        expected: String,
    },
    /// A name of something that does not exist.
    #[error("there is no {what} \"{name}\"; {}", list_known(.known))]
    Unknown {
        /// Kind of the item that was named.
        what: &'static str,
        /// Name that was given.
        name: String,
        /// Names that exist.
        known: Vec<String>,
    },
    /// An agent or character that has left.
    #[error("{0} is not there: it has left")]
    Gone(Id),
    /// No room for another one.
    #[error("all {capacity} places are taken; make it with a larger capacity")]
    Full {
        /// Number of places that it was made for.
        capacity: usize,
    },
    /// No path leads to a place.
    #[error("{}no way leads from {from} to {to}; name a place that can be reached", id_prefix(.who))]
    NoPath {
        /// Agent or character that should go there.
        who: Option<Id>,
        /// Start of the path (m).
        from: Vec3,
        /// End of the path (m).
        to: Vec3,
    },
    /// A place that is taken.
    #[error("{who} cannot be there: {by} is in the way; choose another place")]
    Occupied {
        /// Agent or character that should be there.
        who: Id,
        /// Agent, character or obstacle that is in the way, in words.
        by: String,
    },
    /// Data that was made with another bundle.
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
        /// Kind of state that should be restored.
        what: &'static str,
        /// Description of the fault, and how to correct it.
        why: String,
    },
    /// One of several processes that work together, and why the others cannot go on.
    #[error("rank {rank} {why}")]
    Rank {
        /// Number of the process.
        rank: usize,
        /// Description of the fault, and how to correct it.
        why: String,
    },
}

/// "3: " before a message about agent or character 3.
fn id_prefix(who: &Option<Id>) -> String {
    who.map_or(String::new(), |id| format!("{id}: "))
}

/// Sentence that lists the names that may be given.
fn list_known(known: &[String]) -> String {
    if known.is_empty() { "there is none".into() } else { format!("there is {}", known.join(", ")) }
}

/// Result of the calls of the runtime.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Fails with an error unless `good`.
///
/// # Errors
/// What `error` returns.
pub fn ensure<E>(good: bool, error: impl FnOnce() -> E) -> Result<(), E> {
    if good { Ok(()) } else { Err(error()) }
}

/// Fails with [`Error::Value`] unless `good`.
///
/// # Errors
/// As said.
pub fn check_value(
    what: &'static str,
    who: Option<Id>,
    got: impl Into<f64>,
    good: bool,
    expected: &'static str,
) -> Result<()> {
    if good { Ok(()) } else { Err(Error::Value { what, who, got: got.into(), expected }) }
}

/// Fails with [`Error::Value`] unless a setting lies in its range; NaN never does.
///
/// # Errors
/// As said.
pub fn check_range(what: &'static str, got: f32, range: impl RangeBounds<f32>, expected: &'static str) -> Result<()> {
    check_value(what, None, got, range.contains(&got), expected)
}

/// Fails with [`Error::Length`] unless `got` equals `expected`.
///
/// # Errors
/// As said.
pub fn check_length(what: &'static str, got: usize, expected: usize) -> Result<()> {
    if got == expected { Ok(()) } else { Err(Error::Length { what, got, expected: expected.to_string() }) }
}

/// Fails with [`Error::Index`] unless `got < limit`.
///
/// # Errors
/// As said.
pub fn check_index(what: &'static str, who: Option<Id>, got: usize, limit: usize) -> Result<()> {
    if got < limit { Ok(()) } else { Err(Error::Index { what, who, got, limit }) }
}
