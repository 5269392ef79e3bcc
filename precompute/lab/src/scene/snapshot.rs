//! Keeping what a scene remembers, to go back to it.

use super::config::DragPoint;
use super::play::{Cast, Play};
use glam::Vec3;
use throng_runtime::characters::CharactersError;
use throng_runtime::sparring::{PracticeSnapshot, SparringSnapshot};

/// What a scene remembers at one instant: all that its next steps depend on, but for what goals count.
#[derive(Clone, Debug)]
pub struct PlaySnapshot {
    cast: CastSnapshot,
    homes: Vec<Vec3>,
    drag: Vec<DragPoint>,
    time_s: f64,
}

#[derive(Clone, Debug)]
enum CastSnapshot {
    Pairs(SparringSnapshot),
    Targets(PracticeSnapshot),
}

impl PlaySnapshot {
    /// Memory that it takes (bytes).
    pub fn num_bytes(&self) -> usize {
        let cast = match &self.cast {
            CastSnapshot::Pairs(s) => s.num_bytes(),
            CastSnapshot::Targets(s) => s.num_bytes(),
        };
        cast + size_of_val(self.homes.as_slice()) + size_of_val(self.drag.as_slice())
    }
}

impl Play {
    /// Keeps what the scene remembers.
    pub fn snapshot(&self) -> PlaySnapshot {
        let cast = match &self.cast {
            Cast::Pairs(pairs) => CastSnapshot::Pairs(pairs.snapshot()),
            Cast::Targets(practice) => CastSnapshot::Targets(practice.snapshot()),
        };
        PlaySnapshot { cast, homes: self.homes.clone(), drag: self.drag.clone(), time_s: self.time_s }
    }

    /// Goes back to a snapshot of this scene.
    ///
    /// # Errors
    /// [`CharactersError::Length`] for a snapshot of another scene; nothing has changed then.
    pub fn restore(&mut self, snapshot: &PlaySnapshot) -> Result<(), CharactersError> {
        match (&mut self.cast, &snapshot.cast) {
            (Cast::Pairs(pairs), CastSnapshot::Pairs(s)) => pairs.restore(s)?,
            (Cast::Targets(practice), CastSnapshot::Targets(s)) => practice.restore(s)?,
            (Cast::Pairs(_), _) => {
                return Err(CharactersError::Length { what: "targets", got: snapshot.homes.len(), expected: 0 });
            }
            (Cast::Targets(_), _) => {
                return Err(CharactersError::Length { what: "targets", got: 0, expected: self.homes.len() });
            }
        }
        self.homes.clone_from(&snapshot.homes);
        self.drag.clone_from(&snapshot.drag);
        self.time_s = snapshot.time_s;
        Ok(())
    }
}
