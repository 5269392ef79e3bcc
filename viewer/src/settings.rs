//! Settings that the viewer stores between runs.

use crate::render::{BodyStyle, OrbitCamera};
use crate::run::SceneChoice;
use eframe::egui::ThemePreference;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Entries remembered.
const MAX_RECENT: usize = 8;

/// Built-in bodies with their names.
pub const BODIES: [(BodyStyle, &str); 2] = [(BodyStyle::Capsules, "capsules"), (BodyStyle::Mannequin, "mannequin")];

/// Which panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum PanelKind {
    /// Control of the crowd.
    Control,
    /// Measurements.
    Statistics,
    /// Clips, and a timeline of one of them.
    Database,
    /// Import report of a motion file, or the sources of a bundle.
    Report,
    /// States and actions.
    Graph,
    /// Values and choices.
    Policy,
    /// Effective hits.
    Hits,
    /// Worlds of motion patches.
    Patches,
    /// Blend spaces.
    Blend,
    /// Scenes of crowds.
    Crowd,
    /// Tasks of limbs.
    Plan,
}

/// Dock of a panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dock {
    /// Right of the 3-D view.
    Side,
    /// Below it.
    Bottom,
}

impl PanelKind {
    /// Dock of the panel.
    pub fn dock(self) -> Dock {
        if matches!(self, Self::Graph | Self::Database | Self::Hits) { Dock::Bottom } else { Dock::Side }
    }
}

/// Cues drawn in the 3-D view beside bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Overlays {
    /// Axes of every joint of the selected character.
    pub joint_axes: bool,
    /// Planted heels and toes.
    pub contacts: bool,
    /// Past positions of characters.
    pub trails: bool,
    /// Path of the action that is played.
    pub trajectory: bool,
    /// Targets.
    pub targets: bool,
    /// Cues of all characters, not only of the selected one.
    pub of_all: bool,
    /// Poses before and after the one shown, in the clip view.
    pub onion_skin: bool,
}

impl Default for Overlays {
    fn default() -> Self {
        Self {
            joint_axes: false,
            contacts: true,
            trails: true,
            trajectory: true,
            targets: true,
            of_all: false,
            onion_skin: true,
        }
    }
}

/// Meaning of the colours of characters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Colouring {
    /// Whether the target is reached.
    #[default]
    Target,
    /// Which clip is played.
    Clip,
    /// Speed of the character.
    Speed,
    /// Whether the motion is made or captured.
    Made,
    /// Nothing: all alike.
    Plain,
}

impl Colouring {
    /// All colourings with their names.
    pub const ALL: [(Self, &'static str); 5] = [
        (Self::Target, "target reached"),
        (Self::Clip, "clip"),
        (Self::Speed, "speed"),
        (Self::Made, "made motion (pink)"),
        (Self::Plain, "plain"),
    ];
}

/// Settings that the viewer stores between runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ViewerSettings {
    /// Dark, light, or as the system.
    pub theme: ThemePreference,
    /// Scale of everything in the window (0.5 to 3).
    pub zoom: f32,
    /// Body of the characters.
    pub body: BodyStyle,
    /// Bodies differ from one another, but capsules.
    pub varied: bool,
    /// Colours of the characters.
    pub colouring: Colouring,
    /// Cues.
    pub overlays: Overlays,
    /// Panel at the right.
    pub side_panel: Option<PanelKind>,
    /// Panel below the view.
    pub bottom_panel: Option<PanelKind>,
    /// Camera.
    pub camera: OrbitCamera,
    /// The camera goes with the selected character.
    pub follow: bool,
    /// Settings of the crowds of bundles.
    pub crowd: SceneChoice,
    /// Recently opened files, the latest first; several files of motion together are one entry.
    pub opened: Vec<Vec<PathBuf>>,
}

impl Default for ViewerSettings {
    fn default() -> Self {
        Self {
            theme: ThemePreference::Dark,
            zoom: 1.0,
            body: BodyStyle::default(),
            varied: true,
            colouring: Colouring::default(),
            overlays: Overlays::default(),
            side_panel: Some(PanelKind::Control),
            bottom_panel: None,
            camera: OrbitCamera::default(),
            follow: false,
            crowd: SceneChoice::default(),
            opened: Vec::new(),
        }
    }
}

impl ViewerSettings {
    /// The nearest valid settings: stored ones may come from another version, or may have been edited by hand.
    pub fn limited(mut self) -> Self {
        self.zoom = if self.zoom.is_finite() { self.zoom.clamp(0.5, 3.0) } else { 1.0 };
        self.camera.limit();
        if self.body == BodyStyle::Own {
            // The file of a user's body has to be named in every run.
            self.body = BodyStyle::Mannequin;
        }
        self
    }

    /// The panel that is open in a dock.
    pub fn panel(&self, dock: Dock) -> Option<PanelKind> {
        match dock {
            Dock::Side => self.side_panel,
            Dock::Bottom => self.bottom_panel,
        }
    }

    /// The panel that is open in a dock, mutable.
    pub fn panel_mut(&mut self, dock: Dock) -> &mut Option<PanelKind> {
        match dock {
            Dock::Side => &mut self.side_panel,
            Dock::Bottom => &mut self.bottom_panel,
        }
    }

    /// Adds an entry at the head of the recently opened files.
    pub fn remember(&mut self, paths: &[PathBuf]) {
        let paths: Vec<PathBuf> = paths.iter().map(|p| std::path::absolute(p).unwrap_or_else(|_| p.clone())).collect();
        self.forget(&paths);
        self.opened.insert(0, paths);
        self.opened.truncate(MAX_RECENT);
    }

    /// Removes an entry from the recently opened files.
    pub fn forget(&mut self, paths: &[PathBuf]) {
        self.opened.retain(|p| p != paths);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_latest_files_are_remembered_once_each() {
        let mut settings = ViewerSettings::default();
        for i in 0..20 {
            settings.remember(&[format!("/{}.throng", i % 10).into()]);
        }
        assert_eq!(settings.opened.len(), MAX_RECENT);
        assert_eq!(settings.opened[0], [PathBuf::from("/9.throng")]);
        let five = [PathBuf::from("/5.throng")];
        settings.remember(&five);
        assert_eq!(settings.opened[0], five);
        assert_eq!(settings.opened.iter().filter(|p| **p == five).count(), 1);
        settings.forget(&five);
        assert!(settings.opened.len() == MAX_RECENT - 1 && !settings.opened.contains(&five.to_vec()));
    }
}
