//! A change of the placed units of an environment.

use crate::environment::PlacedUnit;
use throng_core::patch::Placement;

/// A change of the placed units of an environment.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::stitch) enum EnvironmentEdit {
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
