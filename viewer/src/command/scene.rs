//! View options of a scene, and the commands that panels may give about it.

use crate::document::SceneChoice;
use crate::run::agents::What;
use std::path::PathBuf;
use throng_runtime::simulation::scenario::Cell;

/// For which agents something is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Whose {
    /// For none.
    Nobody,
    /// For the selected agent.
    #[default]
    Selected,
    /// For all.
    All,
}

impl Whose {
    /// All scopes with their names.
    pub const ALL: [(Self, &'static str); 3] =
        [(Self::Nobody, "none"), (Self::Selected, "selected"), (Self::All, "all")];
}

/// Which billboards of cells are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Boards {
    /// None.
    Nothing,
    /// Cells of all levels.
    #[default]
    All,
    /// Cells of one level, 0 for the smallest cells.
    Level(u32),
}

/// A cell with a billboard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoardCell {
    /// Level, 0 for the smallest cells.
    pub level: u32,
    /// Number along x and z.
    pub at: [i32; 2],
}

impl BoardCell {
    /// The key of a cell.
    pub fn of(cell: &Cell) -> Self {
        Self { level: cell.level, at: cell.middle.map(|m| (m / cell.side_m).floor() as i32) }
    }
}

/// View options for the agents of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SceneLook {
    /// Time-varying bounds.
    pub bounds: Whose,
    /// Routes to goals.
    pub paths: Whose,
    /// Cell, region and neighbour cells of the selected agent.
    pub cells: bool,
    /// Forces of the selected agent.
    pub forces: bool,
    /// Marks where something happened.
    pub marks: bool,
    /// Bodies, where the scene has some.
    pub bodies: bool,
    /// Kinds of events that are listed and marked.
    pub kinds: [bool; What::COUNT],
    /// Number of the message that is shown spreading.
    pub message: Option<usize>,
    /// Billboards of cells.
    pub boards: Boards,
    /// Cell with the blackboard that is read.
    pub cell: Option<BoardCell>,
}

impl Default for SceneLook {
    fn default() -> Self {
        Self {
            bounds: Whose::default(),
            paths: Whose::default(),
            cells: true,
            forces: true,
            marks: true,
            bodies: true,
            kinds: [true; What::COUNT],
            message: None,
            boards: Boards::All,
            cell: None,
        }
    }
}

/// A request of a panel about a scene.
#[derive(Clone, Debug, PartialEq)]
pub enum SceneCommand {
    /// Draw more or less.
    Look(SceneLook),
    /// Restart, with other numbers if they differ.
    Restart(SceneChoice),
    /// Write the state.
    Save(PathBuf),
    /// Go on from a state that was written.
    Restore(PathBuf),
}
