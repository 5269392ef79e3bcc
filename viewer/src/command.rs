//! Everything a panel may ask for.

use crate::run::{Blending, RunInput};
use crate::settings::{PanelKind, ViewerSettings};
use crate::{document::SceneChoice, document::world::UnitChange, render::OrbitCamera, run::agents::AgentEventKind};
use glam::Vec3;
use std::path::PathBuf;
use throng_core::patch::Placement;
use throng_planner::task::Handle;
use throng_simulation::scenario::BlackboardArea;

/// Stage of a bundle: which of its contents the 3-D view shows.
#[derive(clap::ValueEnum, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ViewStage {
    /// The run of a crowd.
    #[default]
    Crowd,
    /// A clip of the database.
    Clip,
    /// A character walking in a blend space.
    Blend,
}

/// Requests of panels, in order.
pub type Commands = Vec<ViewerCommand>;

/// A request of a panel, carried out by the model after all panels have been shown.
#[derive(Clone, Debug, PartialEq)]
pub enum ViewerCommand {
    /// Open a bundle, a scene, a world or a motion file; of a folder, an archive and several files of motion, build a
    /// bundle first.
    Open(Vec<PathBuf>),
    /// Read the open files again.
    Reload,
    /// Close the open document, and show the start page.
    Close,
    /// Stop the build or the reading under way.
    Stop,
    /// Remove the report of the last build.
    DismissBuild,
    /// Remove an entry from the list of recently opened files.
    Forget(Vec<PathBuf>),
    /// Take a message away.
    Dismiss(u64),

    /// Start or stop time.
    Play(bool),
    /// Move by steps of the run, or frames of the clip.
    Step(i32),
    /// Show a step of the run, or a frame of the clip.
    Seek(u32),
    /// Seconds that pass in one.
    Speed(f32),
    /// Restart the run, with the same settings.
    Restart,
    /// Do something to the run.
    Input(RunInput),
    /// Blend something else, or on another body, and show it.
    Blend(Blending),
    /// Do something to the world.
    World(WorldCommand),
    /// Do something to the scene.
    Scene(SceneCommand),
    /// Do something to the task of limbs.
    Plan(PlanCommand),
    /// Steer the selected character.
    Steer(SteerCommand),

    /// Let all characters wear the mesh of a file.
    Wear(PathBuf),

    /// Select a character, or none.
    SelectCharacter(Option<usize>),
    /// Show a clip of the database, from a frame within it on.
    ShowClip {
        /// Number of the clip.
        clip: usize,
        /// Frame within it.
        frame: u32,
    },
    /// Inspect a state of the motion graph; none follows the selected character.
    SelectState(Option<u32>),
    /// Inspect a behaviour in the policy panel.
    SelectPolicy(usize),

    /// Show the crowd or a clip.
    Stage(ViewStage),
    /// Open a panel, or close it if it is open.
    TogglePanel(PanelKind),
    /// Set the camera.
    Camera(OrbitCamera),
    /// Move the camera so that everything is in view.
    FrameAll,
    /// Change settings, except those of the run and the panels, which have their own commands.
    Settings(Box<ViewerSettings>),
}

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

/// Steering input held down: each axis from -1 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SteerInput {
    /// Away from the camera.
    pub ahead: f32,
    /// To the right of the picture.
    pub aside: f32,
    /// Faster.
    pub runs: bool,
}

impl SteerInput {
    /// True if a direction is held down.
    pub fn moves(&self) -> bool {
        self.ahead != 0.0 || self.aside != 0.0
    }
}

/// Steering of the selected character.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SteerCommand {
    /// Take over the selected character, or release it.
    Toggle,
    /// Change the input that is held down.
    Hold(SteerInput),
    /// Strike.
    Strike,
}

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
    /// Write the present world.
    Save(PathBuf),
}
