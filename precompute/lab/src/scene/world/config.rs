//! Scene files of worlds: how many live there, and what they wish to do.

use crate::scene::file::{Fault, SceneFile, check_count, fault, one, same};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use throng_motion::error::BuildError;

/// A scene in a world of patches.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WorldScene {
    /// The scene's name; the file's stem where absent.
    #[serde(default)]
    pub name: String,
    /// World file (TOML), relative to the scene file's folder; it is stitched where that has not been done.
    pub world: PathBuf,
    /// Number of characters.
    pub characters: usize,
    /// Seed of places and choices.
    #[serde(default = "one")]
    pub seed: u64,
    /// What they wish, one after the other, drawn by their shares.
    #[serde(default = "roaming")]
    pub wishes: Vec<SharedWish>,
    /// What the picture shows.
    #[serde(default)]
    pub picture: PictureConfig,
}

fn roaming() -> Vec<SharedWish> {
    vec![SharedWish { share: 1.0, wish: WishConfig::Roam { seconds: [20.0, 40.0] } }]
}

/// A wish and how often it is drawn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SharedWish {
    /// How often it is drawn, against the others' shares (> 0).
    #[serde(default = "share")]
    pub share: f64,
    /// The wish.
    pub wish: WishConfig,
}

fn share() -> f64 {
    1.0
}

/// What a character wishes to do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum WishConfig {
    /// Go wherever chance leads.
    Roam {
        /// For how long: at least, at most (s).
        seconds: [f64; 2],
    },
    /// Go to a place drawn at random within a box of the world; anywhere where it is absent.
    Visit {
        /// Lowest and highest x and z of the places: [x, z, x, z] (m).
        #[serde(default)]
        within: Option<[f64; 4]>,
    },
    /// Go to where something can be done that the motion is tagged with, and do it.
    Perform {
        /// The tag, as the bundle names it.
        tag: String,
        /// For how long: at least, at most (s).
        seconds: [f64; 2],
    },
}

/// What a scene's picture shows.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PictureConfig {
    /// Number of the character that the lower row follows; the one that did the most different things where absent.
    pub follow: Option<usize>,
    /// What the overview looks at: x, y, z; the middle of the world where absent (m).
    pub focus: Option<[f32; 3]>,
    /// Width of what the overview shows; all of the world where absent (m).
    pub width_m: Option<f32>,
}

impl WorldScene {
    /// True for the text of a scene in a world, as against one on a bundle.
    pub fn is_one(path: &Path) -> bool {
        Self::is_one_of(path)
    }

    /// Reads a scene file; paths in it are taken from its folder.
    ///
    /// # Errors
    /// [`BuildError::Io`], or [`BuildError::Config`] with file, line and column, or file and key.
    pub fn load(path: &Path) -> Result<Self, BuildError> {
        Self::read(path)
    }

    /// Checks numbers; `path` is for messages alone.
    ///
    /// # Errors
    /// [`BuildError::Config`] with file and key.
    pub fn check(&self, path: &Path) -> Result<(), BuildError> {
        self.check_file(path)
    }
}

impl SceneFile for WorldScene {
    fn of(scene: &throng_runtime::simulation::Scene) -> Option<Self> {
        let is_one = |g: &throng_runtime::simulation::scene::GroupConfig| {
            g.motion == throng_runtime::simulation::Motion::Patches
        };
        let number = scene.groups.iter().position(is_one)?;
        let g = &scene.groups[number];
        let wishes = if g.wishes.is_empty() { roaming() } else { g.wishes.iter().filter_map(same).collect() };
        let p = &scene.picture;
        Some(Self {
            name: scene.name.clone(),
            world: scene.world_of(number).1?.to_path_buf(),
            characters: g.count,
            seed: scene.seed,
            wishes,
            picture: PictureConfig { follow: p.follow, focus: p.focus, width_m: p.width_m },
        })
    }

    fn find_fault(&self) -> Result<(), Fault> {
        check_count("characters", self.characters)?;
        if self.wishes.is_empty() {
            return fault("wishes", "expected at least one wish, found none");
        }
        for (i, w) in self.wishes.iter().enumerate() {
            if !(w.share > 0.0 && w.share < 1e6) {
                return fault(&format!("wishes[{i}].share"), format!("expected more than 0, found {}", w.share));
            }
            if let Some([low, high]) = w.wish.seconds()
                && !(0.0 < low && low <= high && high < 1e6)
            {
                let found = format!("expected two times that ascend from above 0, found {low} and {high}");
                return fault(&format!("wishes[{i}].wish.seconds"), found);
            }
            if let WishConfig::Visit { within: Some(b) } = &w.wish
                && !(b.iter().all(|v| v.abs() < 1e6) && b[0] <= b[2] && b[1] <= b[3])
            {
                return fault(
                    &format!("wishes[{i}].wish.within"),
                    format!("expected lowest x and z, then highest x and z, found {b:?}"),
                );
            }
        }
        Ok(())
    }
}

impl WishConfig {
    /// How long it takes, where that is given (s).
    pub fn seconds(&self) -> Option<[f64; 2]> {
        match self {
            Self::Roam { seconds } | Self::Perform { seconds, .. } => Some(*seconds),
            Self::Visit { .. } => None,
        }
    }
}
