//! What inhabitants cannot do.

use crate::Node;
use throng_core::characters::CharactersError;

/// Inhabitants that cannot be, or a wish that cannot be had.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InhabitantsError {
    /// A start where nobody can stay.
    #[error(
        "character {character} starts at cell {} of instance {}, where nobody can stay; take one of `scatter`'s places",
        node.cell, node.instance
    )]
    Start {
        /// The character.
        character: usize,
        /// Its start.
        node: Node,
    },
    /// A start that another one holds.
    #[error(
        "characters {character} and {other} both start where unit {unit} is needed; start one of them in another place"
    )]
    Held {
        /// The character.
        character: usize,
        /// Who holds the unit.
        other: usize,
        /// The unit.
        unit: u32,
    },
    /// Something that the world does not have.
    #[error("{what} {got} does not exist, there are {limit}")]
    Index {
        /// What was named.
        what: &'static str,
        /// Its number.
        got: usize,
        /// How many there are.
        limit: usize,
    },
    /// A place where nobody can stay.
    #[error("nobody can {what} in instance {instance}: none of its cells that are enabled allows it; name another one")]
    Nowhere {
        /// What was wished for.
        what: &'static str,
        /// The instance.
        instance: u32,
    },
    /// Nobody can do that anywhere.
    #[error("no instance of the world has motion with tag {tag} that can be entered and stayed in")]
    NoTag {
        /// The tag.
        tag: u16,
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
    /// What the characters refuse.
    #[error(transparent)]
    Characters(#[from] CharactersError),
}
