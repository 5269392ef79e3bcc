//! Keeping what sparring characters and practising ones remember, to go back to it.

use super::bout::{self, Sparring};
use super::direct::check_weights;
use super::pair::Pair;
use super::practice::{self, TargetPractice};
use super::tally::Tally;
use super::target::StruckTarget;
use glam::Vec3;
use throng_base::{Error, Result, SnapshotKind};
use throng_core::characters::{CharactersSnapshot, MotionSet};

impl Sparring {
    /// Appends all that the next steps depend on, weights and figures among it (about 600 bytes a character).
    pub fn save(&self, out: &mut Vec<u8>) {
        let weights: Vec<f32> = self.config.goals.iter().map(|g| g.weight).collect();
        self.snapshot_kind().write(&(weights, &self.state, self.characters.snapshot()), out);
    }

    /// Goes back to what was saved, see [`throng_core::characters::Characters::restore`].
    ///
    /// # Errors
    /// [`Error::Snapshot`]; nothing has changed then.
    pub fn load(&mut self, motion_set: &MotionSet, bytes: &[u8]) -> Result<()> {
        let kind = self.snapshot_kind();
        let (weights, state, characters): (Vec<f32>, bout::State, CharactersSnapshot) = kind.read_all(bytes)?;
        let own = &self.state;
        let lengths = |s: &bout::State| [s.heads.len(), s.threats.len(), s.pairs.len(), s.tallies.len()];
        let good = check_weights(&weights, self.config.goals.len()).is_ok()
            && lengths(&state) == lengths(own)
            && state.heads.iter().chain(&state.threats).all(may_be_aim)
            && state.pairs.iter().all(Pair::may_be)
            && Tally::may_be(&state.tallies)
            && (0.0..1e9).contains(&state.seconds);
        if !good {
            return Err(damaged(kind));
        }
        self.characters.restore(motion_set, &characters)?;
        self.config.goals.iter_mut().zip(weights).for_each(|(goal, weight)| goal.weight = weight);
        (self.state, self.num_landings) = (state, 0);
        Ok(())
    }

    fn snapshot_kind(&self) -> SnapshotKind {
        SnapshotKind { what: "sparring", tag: *b"SPAR", version: 1, setup: self.setup }
    }
}

impl TargetPractice {
    /// As [`Sparring::save`].
    pub fn save(&self, out: &mut Vec<u8>) {
        let weights: Vec<f32> = self.config.goals.iter().map(|g| g.weight).collect();
        self.snapshot_kind().write(&(weights, &self.state, self.characters.snapshot()), out);
    }

    /// As [`Sparring::load`].
    ///
    /// # Errors
    /// As [`Sparring::load`].
    pub fn load(&mut self, motion_set: &MotionSet, bytes: &[u8]) -> Result<()> {
        let kind = self.snapshot_kind();
        let (weights, state, characters): (Vec<f32>, practice::State, CharactersSnapshot) = kind.read_all(bytes)?;
        let lengths = |s: &practice::State| [s.targets.len(), s.positions.len(), s.tallies.len()];
        let good = check_weights(&weights, self.config.goals.len()).is_ok()
            && lengths(&state) == lengths(&self.state)
            && state.targets.iter().all(StruckTarget::may_be)
            && state.positions.iter().all(may_be_aim)
            && Tally::may_be(&state.tallies)
            && (0.0..1e9).contains(&state.seconds);
        if !good {
            return Err(damaged(kind));
        }
        self.characters.restore(motion_set, &characters)?;
        self.config.goals.iter_mut().zip(weights).for_each(|(goal, weight)| goal.weight = weight);
        (self.state, self.num_hits) = (state, 0);
        Ok(())
    }

    fn snapshot_kind(&self) -> SnapshotKind {
        SnapshotKind { what: "target practice", tag: *b"PRAC", version: 1, setup: self.setup }
    }
}

/// What characters can be asked to aim at.
fn may_be_aim(at: &Vec3) -> bool {
    at.is_finite() && at.abs().max_element() < 1e6
}

fn damaged(kind: SnapshotKind) -> Error {
    Error::Snapshot { what: kind.what, why: "it holds numbers that cannot be; it is damaged".into() }
}
