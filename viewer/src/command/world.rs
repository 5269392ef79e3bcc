//! Selection in a world, tools of the mouse, and the commands that panels may give about a world.

use crate::document::world::UnitChange;
use std::path::PathBuf;
use throng_core::patch::Placement;

/// Tool: the effect of a click in a world.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tool {
    /// Selects a character or a unit.
    #[default]
    Select,
    /// Sends the selected character to the place that was clicked.
    Send,
    /// Units are dragged over the ground.
    Move,
    /// Places a unit of the bundle.
    Create(usize),
}

/// A unit that is about to be placed or moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitDraft {
    /// Number of the unit in the bundle's set.
    pub unit: usize,
    /// Placement that the unit would have.
    pub at: Placement,
}

/// Selection and tool in a world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WorldSelection {
    /// Effect of a click.
    pub tool: Tool,
    /// Placed unit that is selected.
    pub place: Option<usize>,
    /// Instance that is selected; none follows the unit, or else the selected character.
    pub instance: Option<u32>,
    /// Link of the instance that is selected.
    pub link: Option<u32>,
    /// A unit that is about to be placed or moved.
    pub draft: Option<UnitDraft>,
    /// Links of the instance are not drawn.
    pub hides_links: bool,
}

/// A request of a panel about a world.
#[derive(Clone, Debug, PartialEq)]
pub enum WorldCommand {
    /// Select another tool.
    Tool(Tool),
    /// Select a placed unit, or none.
    SelectPlace(Option<usize>),
    /// Select an instance; none follows the unit or the character.
    SelectInstance(Option<u32>),
    /// Select a link of the instance, or none.
    SelectLink(Option<u32>),
    /// Draw the links of the instance, or hide them.
    ShowLinks(bool),
    /// Show a unit where it would stand.
    Draft(Option<UnitDraft>),
    /// Add, remove or move a unit.
    Edit(UnitChange),
    /// Undo the last change.
    Undo,
    /// Redo the last undone change.
    Redo,
    /// Forget that an edit was refused.
    ForgetRefused,
    /// Write the present world.
    Save(PathBuf),
}
