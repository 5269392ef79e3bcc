//! Undo and redo of changes.

use crate::environment::PlacedUnit;
use throng_core::patch::Placement;

/// Stacks of changes for undo and redo.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct WorldEditHistory {
    /// Changes that undo the past ones, the last one at the end.
    pub undo: Vec<EnvironmentEdit>,
    /// Changes that redo the undone ones, the one undone last at the end.
    pub redo: Vec<EnvironmentEdit>,
    /// Redoable changes that the last change discarded; empty unless it was the last operation.
    dropped: Vec<EnvironmentEdit>,
}

impl WorldEditHistory {
    /// Records a change with its reverse `back`, and discards redoable changes.
    pub fn record_edit(&mut self, back: EnvironmentEdit) {
        self.undo.push(back);
        self.dropped = std::mem::take(&mut self.redo);
    }

    /// Records that the last change was withdrawn: if it was the last operation, changes redoable before it are
    /// restored.
    pub fn record_withdrawal(&mut self) {
        self.undo.pop();
        self.redo.append(&mut self.dropped);
    }

    /// Records that the last change was undone, with its reverse `again`.
    pub fn record_undo(&mut self, again: EnvironmentEdit) {
        self.undo.pop();
        self.redo.push(again);
        self.dropped.clear();
    }

    /// Records that the change undone last was redone, with its reverse `back`.
    pub fn record_redo(&mut self, back: EnvironmentEdit) {
        self.redo.pop();
        self.undo.push(back);
        self.dropped.clear();
    }
}

/// A change of the placed units of an environment.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum EnvironmentEdit {
    /// Inserts a unit before the one with this index (index <= number of units).
    Insert {
        /// Index of the unit.
        index: usize,
        /// Unit with its placement.
        unit: PlacedUnit,
    },
    /// Removes a unit (index < number of units).
    Remove {
        /// Index of the unit.
        index: usize,
    },
    /// Moves a unit (index < number of units).
    Move {
        /// Index of the unit.
        index: usize,
        /// New placement.
        placement: Placement,
    },
}

impl EnvironmentEdit {
    /// Makes the change; returns the reverse one.
    pub fn apply(self, units: &mut Vec<PlacedUnit>) -> Self {
        match self {
            Self::Insert { index, unit } => {
                units.insert(index, unit);
                Self::Remove { index }
            }
            Self::Remove { index } => Self::Insert { index, unit: units.remove(index) },
            Self::Move { index, placement } => {
                let placement = std::mem::replace(&mut units[index].placement, placement);
                Self::Move { index, placement }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn changes_are_taken_back_and_made_again(steps in prop::collection::vec((0usize..3, 0usize..99), 1..20)) {
            let unit = |k: usize| PlacedUnit { unit: k, placement: Placement::new(k as f32, 0.0, 0.0, 0.0) };
            let mut units: Vec<PlacedUnit> = (0..3).map(unit).collect();
            let mut history = WorldEditHistory::default();
            let mut states = vec![units.clone()];
            for (what, k) in steps {
                let edit = match what {
                    0 => EnvironmentEdit::Insert { index: k % (units.len() + 1), unit: unit(k) },
                    _ if units.is_empty() => continue,
                    1 => EnvironmentEdit::Remove { index: k % units.len() },
                    _ => EnvironmentEdit::Move { index: k % units.len(), placement: unit(k).placement },
                };
                history.record_edit(edit.apply(&mut units));
                states.push(units.clone());
            }
            for state in states.iter().rev().skip(1) {
                let again = history.undo.last().cloned().expect("a change").apply(&mut units);
                history.record_undo(again);
                prop_assert_eq!(&units, state);
            }
            prop_assert_eq!(history.undo.last().cloned(), None);
            for state in &states[1..] {
                let back = history.redo.last().cloned().expect("a change").apply(&mut units);
                history.record_redo(back);
                prop_assert_eq!(&units, state);
            }
            prop_assert_eq!(history.redo.last().cloned(), None);
        }

        #[test]
        fn what_is_withdrawn_leaves_no_trace(changes in 1usize..6, undos in 0usize..6, dones in 0usize..2) {
            let unit = |k: usize| PlacedUnit { unit: k, placement: Placement::IDENTITY };
            let mut units: Vec<PlacedUnit> = Vec::new();
            let mut history = WorldEditHistory::default();
            for k in 0..changes {
                history.record_edit(EnvironmentEdit::Insert { index: k, unit: unit(k) }.apply(&mut units));
            }
            for _ in 0..undos.min(changes) {
                let again = history.undo.last().cloned().expect("a change").apply(&mut units);
                history.record_undo(again);
            }
            for k in 0..dones {
                history.record_edit(EnvironmentEdit::Insert { index: 0, unit: unit(10 + k) }.apply(&mut units));
            }
            let (before, stood) = (history.clone(), units.clone());
            history.record_edit(EnvironmentEdit::Insert { index: 0, unit: unit(99) }.apply(&mut units));
            history.undo.last().cloned().expect("a change").apply(&mut units);
            history.record_withdrawal();
            prop_assert_eq!((&history.undo, &history.redo), (&before.undo, &before.redo));
            prop_assert_eq!(units, stood);
        }
    }
}
