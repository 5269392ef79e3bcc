//! View options of a task of limbs, and the commands that panels may give about it.

use glam::Vec3;
use std::path::PathBuf;
use throng_planner::task::Handle;

/// View options of a task, and how it is planned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanViewOptions {
    /// Selected thing or place, which can be moved.
    pub handle: Option<Handle>,
    /// Inspected step of the task; none inspects all steps.
    pub step: Option<usize>,
    /// The trees of the searches.
    pub trees: bool,
    /// Draws the other motions, and the clip before planning.
    pub ghosts: bool,
    /// Plans again as soon as something was dragged.
    pub replans: bool,
    /// Number of motions that are planned.
    pub num_motions: u64,
    /// Seed in place of the task's.
    pub seed: Option<u64>,
}

impl Default for PlanViewOptions {
    fn default() -> Self {
        Self { handle: None, step: None, trees: true, ghosts: true, replans: true, num_motions: 1, seed: None }
    }
}

/// A request of a panel about a task.
#[derive(Clone, Debug, PartialEq)]
pub enum PlanCommand {
    /// Change view options, or how motions are planned.
    SetOptions(PlanViewOptions),
    /// Plan motions.
    Plan,
    /// Stop planning; the motions stay unchanged.
    Cancel,
    /// Show a motion, or the clip before planning.
    Show(Option<usize>),
    /// Move a thing or place by an offset (m).
    Move(Handle, Vec3),
    /// End of a move: the thing or place was released.
    EndMove,
    /// Write the motion that is shown.
    Save(PathBuf),
    /// Write the task with things and places where they are.
    SaveTask(PathBuf),
}
