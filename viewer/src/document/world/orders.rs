//! What may be asked of a world's editor, and what was done so far.

use throng_runtime::patch::Placement;

/// A change of what stands where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// One more unit.
    Add {
        /// Its number in the bundle's set.
        unit: usize,
        /// Where it stands.
        at: Placement,
    },
    /// A placed unit goes; those after it move up.
    Remove {
        /// Number of the place.
        place: usize,
    },
    /// A placed unit is moved.
    Move {
        /// Number of the place.
        place: usize,
        /// Where it stands then.
        to: Placement,
    },
}

/// What the editor is to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order {
    /// Make a change.
    Change(Change),
    /// Take the last change back that was not.
    Undo,
    /// Make the change again that was taken back last.
    Redo,
}

impl Order {
    /// The place that is moved, and where to.
    pub(super) fn moves(self) -> Option<(usize, Placement)> {
        match self {
            Self::Change(Change::Move { place, to }) => Some((place, to)),
            _ => None,
        }
    }
}

/// What is done on a thread of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Work {
    /// The editor carries out an order.
    Edit(Order),
    /// Other characters are let live in the same world.
    Populate,
}

impl Work {
    /// What the editor was ordered, where it is at work.
    pub fn order(self) -> Option<Order> {
        match self {
            Self::Edit(order) => Some(order),
            Self::Populate => None,
        }
    }

    /// In words, for what has to wait for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Edit(_) => "the last edit",
            Self::Populate => "finding room for characters",
        }
    }

    /// What is told where its thread ended and nothing came of it.
    pub fn ended(self) -> &'static str {
        match self {
            Self::Edit(_) => "the editor ended unexpectedly; save what was placed, then read the file again (Ctrl+R)",
            Self::Populate => {
                "finding room for characters ended unexpectedly; those before live on, and others can be asked for"
            }
        }
    }
}

/// Changes in words, as far as the editor knows them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Made {
    names: Vec<String>,
    /// The first so many are made, the others were taken back.
    made: usize,
}

impl Made {
    /// Follows the editor, which knows of so many changes that can be taken back and made again.
    ///
    /// - `new`: the change that was made last, where it is a new one.
    pub fn follow(&mut self, [undos, redos]: [usize; 2], new: Option<String>) {
        if let Some(name) = new {
            self.names.truncate(undos.saturating_sub(1));
            self.names.push(name);
        }
        self.names.truncate(undos + redos);
        self.made = undos;
    }

    /// The change that can be taken back.
    pub fn last(&self) -> Option<&str> {
        self.names.get(self.made.checked_sub(1)?).map(String::as_str)
    }

    /// The change that can be made again.
    pub fn next(&self) -> Option<&str> {
        self.names.get(self.made).map(String::as_str)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_follow_what_can_be_taken_back_and_made_again() {
        let mut made = Made::default();
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
