//! Values of arguments.

use crate::panels::{PANELS, PanelEntry};
use crate::render::{BodyStyle, OrbitCamera};
use crate::settings::{BODIES, PanelKind};
use eframe::egui::ThemePreference;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use throng_core::base::limits::{self, number_parser};
use throng_crowd::Scheme;
use throng_simulation::scene::engine as engines;

/// Size of a picture or a window (pixels).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PictureSize {
    /// From left to right (16 to 8192).
    pub width: u32,
    /// From top to bottom (16 to 8192).
    pub height: u32,
}

impl Default for PictureSize {
    fn default() -> Self {
        Self { width: 1280, height: 720 }
    }
}

/// Which graphics adapter draws pictures.
#[derive(clap::ValueEnum, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AdapterChoice {
    /// One that draws on the processor, where there is one: its pictures do not depend on the machine.
    #[default]
    Software,
    /// The fastest.
    Any,
}

/// Theme on the command line.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThemeName {
    /// Light text on dark.
    Dark,
    /// Dark text on light.
    Light,
}

impl From<ThemeName> for ThemePreference {
    fn from(name: ThemeName) -> Self {
        match name {
            ThemeName::Dark => Self::Dark,
            ThemeName::Light => Self::Light,
        }
    }
}

/// A panel on the command line, or `none`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PanelChoice {
    /// The 3-D view alone.
    None,
    /// This one is open.
    Open(PanelKind),
}

/// A body on the command line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BodyChoice {
    /// One that the viewer makes.
    Made(BodyStyle),
    /// A file with a mesh that all characters wear.
    File(PathBuf),
}

/// A camera on the command line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraArg {
    /// The camera.
    pub camera: OrbitCamera,
    /// Its target or its distance was given; otherwise both are such that all can be seen.
    pub is_placed: bool,
}

impl FromStr for CameraArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let given = |key: &str| text.split(',').any(|part| part.split('=').next().is_some_and(|k| k.trim() == key));
        Ok(Self { camera: text.parse()?, is_placed: given("distance") || given("target") })
    }
}

/// Name of a panel on the command line: its title in lower case, with dashes.
pub(super) fn panel_name(panel: &PanelEntry) -> String {
    panel.title.to_lowercase().replace(' ', "-")
}

pub(super) fn panel(text: &str) -> Result<PanelChoice, String> {
    let wanted = text.trim().to_lowercase().replace(' ', "-");
    if wanted == "none" {
        return Ok(PanelChoice::None);
    }
    let found = PANELS.iter().find(|p| panel_name(p) == wanted);
    found.map(|p| PanelChoice::Open(p.kind)).ok_or_else(|| {
        let names: Vec<String> = PANELS.iter().map(panel_name).collect();
        format!("there is no such panel; the panels are {}, or `none`", names.join(", "))
    })
}

pub(super) fn size(text: &str) -> Result<PictureSize, String> {
    let side = number_parser::<u32>(&limits::PICTURE_SIDE);
    let sides = text.split_once(['x', 'X']).and_then(|(w, h)| Some((side(w).ok()?, side(h).ok()?)));
    let (width, height) = sides
        .ok_or_else(|| format!("expected width x height, as in 640x400; each is {}", limits::PICTURE_SIDE.range))?;
    Ok(PictureSize { width, height })
}

pub(super) fn engine(text: &str) -> Result<Scheme, String> {
    engines::scheme_named(text).ok_or_else(|| format!("there is no such engine; expected one of {}", engines::names()))
}

pub(super) fn body(text: &str) -> Result<BodyChoice, String> {
    let made = BODIES.iter().find(|b| b.1 == text);
    let extension = Path::new(text).extension().map(|e| e.to_string_lossy().to_lowercase());
    match (made, extension.as_deref()) {
        (Some((body, _)), _) => Ok(BodyChoice::Made(*body)),
        (None, Some("glb" | "gltf")) => Ok(BodyChoice::File(text.into())),
        (None, _) => Err("the bodies are capsules, mannequin, or a character with a skin as a .glb file".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_panel_has_a_name_of_its_own() {
        for p in PANELS {
            assert_eq!(panel(&panel_name(p)), Ok(PanelChoice::Open(p.kind)));
            assert_ne!(panel_name(p), "none");
        }
    }

    #[test]
    fn sizes_need_two_sides_within_limits() {
        assert_eq!(size("640x400"), Ok(PictureSize { width: 640, height: 400 }));
        for wrong in ["", "x", "640", "640x", "-640x400", "640x400x3", "15x400", "640x8193", "1e3x400"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_camera_is_placed_where_target_or_distance_is_given() {
        let placed = |text: &str| text.parse::<CameraArg>().map(|v| v.is_placed);
        assert_eq!(placed("side"), Ok(false));
        assert_eq!(placed("yaw=3,pitch=10"), Ok(false));
        assert_eq!(placed("front, distance=4"), Ok(true));
        assert_eq!(placed("target=0:1:0"), Ok(true));
        assert!(placed("distance").is_err());
    }
}
