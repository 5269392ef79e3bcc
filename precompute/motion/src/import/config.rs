//! Settings by which users override what import detects.

use super::glitches::Glitches;
use crate::error::{Result, check_ranges};
use std::path::PathBuf;

/// The axis of a source that points up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum UpAxis {
    /// +Y, as in most BVH and all ASF files.
    Y,
    /// +Z, as in files made for Z-up tools.
    Z,
}

impl UpAxis {
    /// The letter, upper case.
    pub fn letter(self) -> char {
        ['Y', 'Z'][self as usize]
    }
}

/// Direction that the rest pose faces, once Y is up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub enum Forward {
    /// Along +Z, the convention of this project.
    #[serde(rename = "+z")]
    PosZ,
    /// Along -Z.
    #[serde(rename = "-z")]
    NegZ,
    /// Along +X.
    #[serde(rename = "+x")]
    PosX,
    /// Along -X.
    #[serde(rename = "-x")]
    NegX,
}

impl Forward {
    /// Heading about +Y (rad).
    pub fn heading(self) -> f32 {
        use std::f32::consts::{FRAC_PI_2, PI};
        [0.0, PI, FRAC_PI_2, -FRAC_PI_2][self as usize]
    }
}

/// Settings that override what import detects, and the treatment of faults.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ImportConfig {
    /// Length of one unit of the files; detected where absent (m, 1e-6 to 1e6).
    pub metres_per_unit: Option<f64>,
    /// Axis that points up in the files; detected where absent.
    pub up: Option<UpAxis>,
    /// Direction the rest pose faces, once Y is up; detected where absent. Says nothing of a rest pose that is not a
    /// standing body.
    pub forward: Option<Forward>,
    /// Frames a second, instead of what the files say (Hz, 0.1 to 100000).
    pub rate_hz: Option<f64>,
    /// Skeleton file of all AMC files; found beside each AMC file where absent.
    pub asf: Option<PathBuf>,
    /// Name of the skeleton profile to use; chosen by joint names where absent.
    pub profile: Option<String>,
    /// Further skeleton profiles (TOML files), tried before the built-in ones.
    pub profiles: Vec<PathBuf>,
    /// Treatment of frames that are no motion: pops, jumps, flips, freezes, drop-outs. A warning reports each of them.
    pub glitches: Glitches,
    /// True: walks on the spot get root motion from their planted feet. False: they stay there, and slide.
    pub root_motion: bool,
    /// True: loops of a cycle or two that step are repeated. False: they stay as short as they are.
    pub loops: bool,
    /// True: one bad file stops the build. False: it is named, skipped and counted.
    pub strict: bool,
}

impl Default for ImportConfig {
    fn default() -> Self {
        Self {
            metres_per_unit: None,
            up: None,
            forward: None,
            rate_hz: None,
            asf: None,
            profile: None,
            profiles: Vec::new(),
            glitches: Glitches::default(),
            root_motion: true,
            loops: true,
            strict: false,
        }
    }
}

impl ImportConfig {
    /// Checks every number against its range.
    ///
    /// # Errors
    /// [`crate::error::BuildError::Key`] names the first one out of it.
    pub fn check(&self) -> Result<()> {
        check_ranges([
            ("metres_per_unit", self.metres_per_unit.unwrap_or(1.0), 1e-6, 1e6),
            ("rate_hz", self.rate_hz.unwrap_or(1.0), 0.1, 1e5),
        ])
    }
}
