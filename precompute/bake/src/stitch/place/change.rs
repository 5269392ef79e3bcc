//! One change of what stands in an environment.

use crate::environment::PlacedUnit;
use throng_core::patch::Placement;

/// A change of what stands in an environment.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::stitch) enum Edit {
    /// One more unit, before the one that has this place (index <= number of units).
    Insert {
        /// Its place.
        index: usize,
        /// The unit.
        unit: PlacedUnit,
    },
    /// One less (index < number of units).
    Remove {
        /// Its place.
        index: usize,
    },
    /// One stands elsewhere (index < number of units).
    Move {
        /// Its place.
        index: usize,
        /// Where it stands.
        placement: Placement,
    },
}

impl Edit {
    /// Makes the change; returns the one that takes it back.
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
