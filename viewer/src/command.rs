//! Everything a panel may ask for.

mod plan;
mod scene;
mod steer;
mod world;

pub use plan::{PlanCommand, PlanViewOptions};
pub use scene::{BlackboardCell, BlackboardFilter, OverlayScope, SceneCommand, SceneViewOptions};
pub use steer::{SteerCommand, SteerInput};
pub use world::{Tool, UnitDraft, WorldCommand, WorldSelection};

use crate::render::OrbitCamera;
use crate::run::{Blending, RunInput};
use crate::settings::{PanelKind, ViewerSettings};
use std::path::PathBuf;

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
    /// Inspect one height, or time, of the grid of that behaviour.
    SelectSlice(u32),

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
