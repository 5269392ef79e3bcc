//! Keeping what sparring characters remember, to go back to it.

use super::bout::{Sparring, State};
use crate::troupe::{TroupeError, TroupeSnapshot};

/// What sparring characters remember at one instant: all that their next steps depend on, and the running figures.
#[derive(Clone, Debug, Default)]
pub struct SparringSnapshot {
    troupe: TroupeSnapshot,
    state: State,
}

impl SparringSnapshot {
    /// Memory that it takes. [Unit: bytes]
    pub fn num_bytes(&self) -> usize {
        let s = &self.state;
        let vectors = size_of_val(s.heads.as_slice()) + size_of_val(s.threats.as_slice());
        self.troupe.num_bytes() + vectors + size_of_val(s.pairs.as_slice()) + size_of_val(s.tallies.as_slice())
    }
}

impl Sparring {
    /// Keeps what the characters remember.
    pub fn snapshot(&self) -> SparringSnapshot {
        SparringSnapshot { troupe: self.troupe.snapshot(), state: self.state.clone() }
    }

    /// Goes back to a snapshot, see [`crate::troupe::Troupe::restore`].
    ///
    /// # Errors
    /// As [`crate::troupe::Troupe::restore`]; nothing has changed then.
    pub fn restore(&mut self, snapshot: &SparringSnapshot) -> Result<(), TroupeError> {
        self.troupe.restore(&snapshot.troupe)?;
        self.state.clone_from(&snapshot.state);
        Ok(())
    }
}
