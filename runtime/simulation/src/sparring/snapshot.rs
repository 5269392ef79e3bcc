//! Snapshots of striking characters and of the state beside them.

use super::{bout, pair::OpponentPair, practice, tally::BlowTally, target::StruckTarget};
use crate::motion_kind::check_snapshot;
use glam::Vec3;
use serde::{Serialize, de::DeserializeOwned};
use throng_base::{Bytes, Result, SnapshotKind};
use throng_core::{CharacterGroup, characters::PolicyCharacters};

/// State that the next steps depend on, beside the characters.
pub(super) trait SavedState: Serialize + DeserializeOwned {
    /// False for a state that so many characters cannot have.
    fn is_valid(&self, num_characters: usize) -> bool;
}

impl SavedState for bout::SparringState {
    fn is_valid(&self, n: usize) -> bool {
        [self.heads.len(), self.aims.len(), self.threats.len(), self.tallies.len()] == [n; 4]
            && 2 * self.pairs.len() == n
            && self.heads.iter().chain(&self.aims).chain(&self.threats).all(is_valid_aim)
            && self.pairs.iter().all(OpponentPair::is_valid)
            && BlowTally::is_valid(&self.tallies)
            && (0.0..1e9).contains(&self.seconds)
    }
}

impl SavedState for practice::PracticeState {
    fn is_valid(&self, n: usize) -> bool {
        [self.targets.len(), self.positions.len(), self.tallies.len()] == [n; 3]
            && self.targets.iter().all(StruckTarget::is_valid)
            && self.positions.iter().all(is_valid_aim)
            && BlowTally::is_valid(&self.tallies)
            && (0.0..1e9).contains(&self.seconds)
    }
}

/// Appends a snapshot of characters and state (about 1130 bytes a character).
pub(super) fn save(kind: SnapshotKind, characters: &PolicyCharacters, state: &impl SavedState, out: &mut Vec<u8>) {
    let mut bytes = Bytes::default();
    characters.save(&mut bytes.0);
    kind.write(&(bytes, state), out);
}

/// Restores saved characters, and returns the state beside them.
///
/// # Errors
/// [`throng_base::Error::Snapshot`]; nothing has changed then.
pub(super) fn load<S: SavedState>(kind: SnapshotKind, characters: &mut PolicyCharacters, bytes: &[u8]) -> Result<S> {
    let (saved, state): (Bytes, S) = kind.read_all(bytes)?;
    // Tried on a clone, so that nothing changes where a part is refused.
    let mut tried = characters.clone();
    tried.load(&saved.0)?;
    check_snapshot(state.is_valid(tried.ids().len()), kind.what, "it holds numbers that cannot be")?;
    characters.load(&saved.0)?;
    Ok(state)
}

/// True for a position that characters can aim at.
fn is_valid_aim(at: &Vec3) -> bool {
    at.is_finite() && at.abs().max_element() < 1e6
}

/// Methods that both groups of boxers have.
macro_rules! boxers_methods {
    ($group:ident) => {
        impl $group {
            /// Boxers, row by row as in [`CharacterGroup::bodies`].
            pub fn boxers(&self) -> &PolicyCharacters {
                &self.boxers
            }

            /// Mutable boxers, to set obstacles and reserved regions on the ground.
            pub(crate) fn boxers_mut(&mut self) -> &mut PolicyCharacters {
                &mut self.boxers
            }

            /// The characters, row by row: blows, segments and choices.
            pub fn characters(&self) -> &Characters {
                self.boxers.characters()
            }

            /// Makes a character play a segment at once, see [`PolicyCharacters::play_segment`].
            ///
            /// # Errors
            /// As [`PolicyCharacters::play_segment`].
            pub fn play(&mut self, id: Id, segment: u32) -> Result<()> {
                self.boxers.play_segment(id, segment)
            }

            /// Counts of a character's blows by outcome.
            ///
            /// # Errors
            /// [`throng_base::Error::Gone`].
            pub fn tally(&self, id: Id) -> Result<BlowTally> {
                Ok(self.state.tallies[self.boxers.row(id)?])
            }
        }
    };
}
pub(super) use boxers_methods;

/// Methods of [`throng_core::CharacterGroup`] that are alike for both groups of boxers.
macro_rules! boxers_group_methods {
    () => {
        /// Status as of [`PolicyCharacters`], in a bout with the opponent as target.
        fn status(&self, id: Id) -> Result<OrderStatus> {
            self.boxers.status(id)
        }

        /// Events of the last step, in the order of rows.
        fn events(&self) -> &[(Id, Self::Event)] {
            &self.events
        }

        fn bodies(&self) -> PosedBodies<'_> {
            self.boxers.bodies()
        }

        fn save(&self, out: &mut Vec<u8>) {
            snapshot::save(self.snapshot_kind(), &self.boxers, &self.state, out);
        }

        fn load(&mut self, bytes: &[u8]) -> Result<()> {
            self.state = snapshot::load(self.snapshot_kind(), &mut self.boxers, bytes)?;
            self.events.clear();
            Ok(())
        }
    };
}
pub(super) use boxers_group_methods;
