//! Keeping what a scene remembers, to go back to it.

use super::config::DragPoint;
use super::play::{Cast, Play};
use glam::Vec3;
use throng_runtime::Result;
use throng_runtime::characters::MotionSet;

/// What a scene remembers at one instant: all that its next steps depend on, but for what goals count.
#[derive(Clone, Debug)]
pub struct PlaySnapshot {
    cast: Vec<u8>,
    homes: Vec<Vec3>,
    drag: Vec<DragPoint>,
    time_s: f64,
}

impl PlaySnapshot {
    /// Memory that it takes (bytes).
    pub fn num_bytes(&self) -> usize {
        self.cast.len() + size_of_val(self.homes.as_slice()) + size_of_val(self.drag.as_slice())
    }
}

impl Play {
    /// Keeps what the scene remembers.
    pub fn snapshot(&self) -> PlaySnapshot {
        let mut cast = Vec::new();
        match &self.cast {
            Cast::Pairs(pairs) => pairs.save(&mut cast),
            Cast::Targets(practice) => practice.save(&mut cast),
        }
        PlaySnapshot { cast, homes: self.homes.clone(), drag: self.drag.clone(), time_s: self.time_s }
    }

    /// Goes back to a snapshot of this scene.
    ///
    /// # Errors
    /// [`throng_runtime::Error::Snapshot`] for a snapshot of another scene; nothing has changed then.
    pub fn restore(&mut self, motion_set: &MotionSet, snapshot: &PlaySnapshot) -> Result<()> {
        match &mut self.cast {
            Cast::Pairs(pairs) => pairs.load(motion_set, &snapshot.cast)?,
            Cast::Targets(practice) => practice.load(motion_set, &snapshot.cast)?,
        }
        self.homes.clone_from(&snapshot.homes);
        self.drag.clone_from(&snapshot.drag);
        self.time_s = snapshot.time_s;
        Ok(())
    }
}
