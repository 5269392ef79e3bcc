//! What is drawn of a task of limbs, and what panels may ask of it.

use glam::Vec3;
use std::path::PathBuf;
use throng_planner::task::Handle;

/// What is drawn of a task, and how it is planned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanLook {
    /// What is selected to be put elsewhere.
    pub handle: Option<Handle>,
    /// The thing to do that is looked at; none looks at all.
    pub step: Option<usize>,
    /// The trees of the searches.
    pub trees: bool,
    /// Other motions, and the clip as it was.
    pub ghosts: bool,
    /// It is planned as soon as something was dragged.
    pub replans: bool,
    /// So many motions are planned.
    pub number: u64,
    /// Seed in place of the task's.
    pub seed: Option<u64>,
}

impl Default for PlanLook {
    fn default() -> Self {
        Self { handle: None, step: None, trees: true, ghosts: true, replans: true, number: 1, seed: None }
    }
}

/// A request of a panel about a task.
#[derive(Clone, Debug, PartialEq)]
pub enum PlanCommand {
    /// Draw more or less, or plan in another way.
    Look(PlanLook),
    /// Plan motions.
    Plan,
    /// Stop planning; the motions stay as they are.
    Cancel,
    /// Show a motion, or the clip as it was.
    Show(Option<usize>),
    /// Put something elsewhere, by some way (m).
    Move(Handle, Vec3),
    /// Something was put where it shall stay.
    Settle,
    /// Write the motion that is shown.
    Save(PathBuf),
    /// Write the task with things and places where they are.
    SaveTask(PathBuf),
}
