//! Orders to the editor of a world, and the history of its changes.

use throng_core::patch::Placement;

/// A change of the placed units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UnitChange {
    /// One more unit.
    Add {
        /// Number of the unit in the bundle's set.
        unit: usize,
        /// Placement of the new unit.
        at: Placement,
    },
    /// A placed unit is removed; later ones move up.
    Remove {
        /// Number of the place.
        place: usize,
    },
    /// A placed unit is moved.
    Move {
        /// Number of the place.
        place: usize,
        /// New placement.
        to: Placement,
    },
}

/// Order to the editor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EditorOrder {
    /// Make a change.
    Change(UnitChange),
    /// Undo the last change.
    Undo,
    /// Redo the last undone change.
    Redo,
}

impl EditorOrder {
    /// The place that is moved, and where to.
    pub(super) fn moves(self) -> Option<(usize, Placement)> {
        if let Self::Change(UnitChange::Move { place, to }) = self { Some((place, to)) } else { None }
    }
}

/// Name of work on its own thread, for messages to requests that have to wait.
///
/// - `order`: that the editor carries out; none where new inhabitants are placed in the unchanged world.
pub(super) fn work_name(order: Option<EditorOrder>) -> &'static str {
    if order.is_some() { "the last edit" } else { "finding room for characters" }
}

/// Message for a thread that ended without a result.
///
/// - `order`: as for [`work_name`].
pub(super) fn ended_message(order: Option<EditorOrder>) -> &'static str {
    match order {
        Some(_) => "the editor ended unexpectedly; save the world, then reload the file (Ctrl+R)",
        None => "finding room for characters ended unexpectedly; the old characters stay; try again",
    }
}

/// History of changes as text, as far as the editor can undo and redo them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct EditHistory {
    names: Vec<String>,
    /// Number of changes in effect; the others were undone.
    made: usize,
}

impl EditHistory {
    /// Follows the editor, which can undo and redo these numbers of changes.
    ///
    /// - `new`: the change made last, if it is a new one.
    pub fn follow(&mut self, [undos, redos]: [usize; 2], new: Option<String>) {
        if let Some(name) = new {
            self.names.truncate(undos.saturating_sub(1));
            self.names.push(name);
        }
        self.names.truncate(undos + redos);
        self.made = undos;
    }

    /// The change that can be undone.
    pub fn last(&self) -> Option<&str> {
        self.names.get(self.made.checked_sub(1)?).map(String::as_str)
    }

    /// The change that can be redone.
    pub fn next(&self) -> Option<&str> {
        self.names.get(self.made).map(String::as_str)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_follow_undo_and_redo() {
        let mut made = EditHistory::default();
        for (counts, new, last, next) in [
            ([0, 0], None, None, None),
            ([1, 0], Some("a"), Some("a"), None),
            ([2, 0], Some("b"), Some("b"), None),
            ([1, 1], None, Some("a"), Some("b")),
            ([0, 2], None, None, Some("a")),
            ([1, 1], None, Some("a"), Some("b")),
            ([2, 0], Some("c"), Some("c"), None),
            ([1, 1], None, Some("a"), Some("c")),
            ([1, 0], None, Some("a"), None),
        ] {
            made.follow(counts, new.map(str::to_owned));
            assert_eq!((made.last(), made.next()), (last, next), "{counts:?}");
        }
    }
}
