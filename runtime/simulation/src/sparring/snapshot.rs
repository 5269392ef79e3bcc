//! Keeping what sparring characters remember, to go back to it.

use super::bout::{Sparring, State};
use throng_core::characters::{CharactersError, CharactersSnapshot};

/// What sparring characters remember at one instant: all that their next steps depend on, and the running figures.
#[derive(Clone, Debug, Default)]
pub struct SparringSnapshot {
    characters: CharactersSnapshot,
    state: State,
}

impl SparringSnapshot {
    /// Memory that it takes (bytes).
    pub fn num_bytes(&self) -> usize {
        let s = &self.state;
        let vectors = size_of_val(s.heads.as_slice()) + size_of_val(s.threats.as_slice());
        self.characters.num_bytes() + vectors + size_of_val(s.pairs.as_slice()) + size_of_val(s.tallies.as_slice())
    }
}

impl Sparring {
    /// Keeps what the characters remember.
    pub fn snapshot(&self) -> SparringSnapshot {
        SparringSnapshot { characters: self.characters.snapshot(), state: self.state.clone() }
    }

    /// Goes back to a snapshot, see [`throng_core::characters::Characters::restore`].
    ///
    /// # Errors
    /// As [`throng_core::characters::Characters::restore`]; nothing has changed then.
    pub fn restore(&mut self, snapshot: &SparringSnapshot) -> Result<(), CharactersError> {
        self.characters.restore(&snapshot.characters)?;
        self.state.clone_from(&snapshot.state);
        Ok(())
    }
}
