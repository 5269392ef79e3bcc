//! View options of a scene, and the commands that panels may give about it.

use crate::document::SceneChoice;
use crate::run::agents::AgentEventKind;
use std::path::PathBuf;
use throng_simulation::scenario::BlackboardArea;

/// For which agents something is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OverlayScope {
    /// For none.
    None,
    /// For the selected agent.
    #[default]
    Selected,
    /// For all.
    All,
}

impl OverlayScope {
    /// All scopes with their names.
    pub const ALL: [(Self, &'static str); 3] = [(Self::None, "none"), (Self::Selected, "selected"), (Self::All, "all")];
}

/// Which blackboards of cells are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BlackboardFilter {
    /// None.
    Nothing,
    /// Cells of all levels.
    #[default]
    All,
    /// Cells of one level, 0 for the smallest cells.
    Level(u32),
}

/// A cell with a blackboard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlackboardCell {
    /// Level, 0 for the smallest cells.
    pub level: u32,
    /// Number along x and z.
    pub at: [i32; 2],
}

impl BlackboardCell {
    /// The key of a cell.
    pub fn from_cell(cell: &BlackboardArea) -> Self {
        Self { level: cell.level, at: cell.middle.map(|m| (m / cell.side_m).floor() as i32) }
    }
}

/// View options for the agents of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SceneViewOptions {
    /// Time-varying bounds.
    pub bounds: OverlayScope,
    /// Routes to goals.
    pub paths: OverlayScope,
    /// Cell, region and neighbour cells of the selected agent.
    pub cells: bool,
    /// Forces of the selected agent.
    pub forces: bool,
    /// Marks where something happened.
    pub marks: bool,
    /// Bodies, where the scene has some.
    pub bodies: bool,
    /// Kinds of events that are listed and marked.
    pub kinds: [bool; AgentEventKind::COUNT],
    /// Number of the message that is shown spreading.
    pub message: Option<usize>,
    /// Blackboards of cells.
    pub blackboards: BlackboardFilter,
    /// Cell with the blackboard that is read.
    pub cell: Option<BlackboardCell>,
}

impl Default for SceneViewOptions {
    fn default() -> Self {
        Self {
            bounds: OverlayScope::default(),
            paths: OverlayScope::default(),
            cells: true,
            forces: true,
            marks: true,
            bodies: true,
            kinds: [true; AgentEventKind::COUNT],
            message: None,
            blackboards: BlackboardFilter::All,
            cell: None,
        }
    }
}

/// A request of a panel about a scene, the crowd of a bundle, or the characters of a world.
#[derive(Clone, Debug, PartialEq)]
pub enum SceneCommand {
    /// Draw more or less.
    SetOptions(SceneViewOptions),
    /// Restart, with other numbers if they differ.
    Restart(SceneChoice),
    /// Write the state.
    Save(PathBuf),
    /// Go on from a state that was written.
    Restore(PathBuf),
}
