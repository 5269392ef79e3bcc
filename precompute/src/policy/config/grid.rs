//! Cells of a behaviour's target.

use super::AdaptiveConfig;
use crate::error::BuildError;
use glam::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use throng_runtime::policy::{PolicyError, TargetGrid};

/// Cells of the target. What is absent is taken from the behaviour's kind:
///
/// - `approach`: polar, 16 rings x 32 angles over 8 m;
/// - `throw_punches`: 10 rings x 10 angles x 4 heights over the bounding volume of the hits;
/// - `evade`: polar, 8 rings x 16 angles over 1.2 m, at 9 moments over 0.8 s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct GridConfig {
    /// Rings, from the character outwards. [Limit: 2 to 4096]
    pub rings: Option<u32>,
    /// Angles, the first straight ahead where they go all around. [Limit: 2 to 4096]
    pub angles: Option<u32>,
    /// Heights, for `throw_punches`. [Limit: 1 to 4096]
    pub heights: Option<u32>,
    /// Moments of the time left, for `evade`. [Limit: 2 to 4096]
    pub moments: Option<u32>,
    /// Distance of the last ring where angles go all around; targets farther away are treated as if on it.
    /// [Unit: m] [Limit: > 0]
    pub radius: Option<f64>,
    /// For `approach`, distance between the first two rings: an equal share, radius / (rings - 1), or less, which
    /// makes the distances grow outwards. [Unit: m] [Limit: > radius / (rings - 1)^2]
    pub inner_spacing: Option<f64>,
    /// For `evade`, the longest time left. [Unit: s] [Limit: > 0]
    pub horizon_s: Option<f64>,
    /// Distance beyond the grid over which values fall to about 1/e. [Unit: m] [Limit: > 0]
    pub falloff: Option<f64>,
    /// For `throw_punches`, the volume covered in place of the bounding volume of the hits.
    pub bounds: BoundsConfig,
    /// For `approach` and `throw_punches`: a resolution for every state, in place of these counts for all.
    pub adaptive: Option<AdaptiveConfig>,
}

/// A volume in front of the character; what is absent is that of the hits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BoundsConfig {
    /// Least and greatest angle from straight ahead, positive to the left. [Unit: rad]
    pub angle_rad: Option<[f64; 2]>,
    /// Least and greatest distance over ground. [Unit: m]
    pub distance_m: Option<[f64; 2]>,
    /// Least and greatest height above ground. [Unit: m]
    pub height_m: Option<[f64; 2]>,
}

/// A volume that is not flat in any direction: (angle, distance, height), least and greatest.
pub type Bounds = [Vec3; 2];

/// Least extent of a volume along each axis: a grid needs some. [Unit: rad, m, m]
const LEAST_EXTENT: Vec3 = Vec3::new(0.1, 0.05, 0.05);

impl GridConfig {
    /// A polar grid with every number given. Lengths in metres.
    pub fn polar(rings: u32, angles: u32, radius: f64, inner_spacing: f64, falloff: f64) -> Self {
        Self {
            rings: Some(rings),
            angles: Some(angles),
            radius: Some(radius),
            inner_spacing: Some(inner_spacing),
            falloff: Some(falloff),
            ..Self::default()
        }
    }

    /// The grid of 003 section 6 for coming near: 5 distances x 13 angles over 2 m.
    pub fn paper() -> Self {
        Self::polar(5, 13, 2.0, 0.5, 2.5)
    }

    fn check_adaptive(&self, behaviour: &str) -> Result<(), BuildError> {
        self.adaptive.map_or(Ok(()), |a| a.check(behaviour))
    }

    /// The polar grid it describes.
    ///
    /// # Errors
    /// [`BuildError::Config`] that names behaviour and key.
    pub fn make_polar(&self, behaviour: &str) -> Result<TargetGrid, BuildError> {
        let keys = [
            ("heights", self.heights.is_some()),
            ("moments", self.moments.is_some()),
            ("horizon_s", self.horizon_s.is_some()),
            ("bounds", self.bounds != BoundsConfig::default()),
        ];
        refuse(behaviour, "approach", &keys)?;
        self.check_adaptive(behaviour)?;
        let (rings, radius) = (self.rings.unwrap_or(16), self.radius.unwrap_or(8.0));
        let inner = self.inner_spacing.unwrap_or(0.25);
        let falloff = self.falloff.unwrap_or(2.5) as f32;
        TargetGrid::polar(rings, self.angles.unwrap_or(32), radius as f32, inner as f32, falloff)
            .map_err(|e| wrong(behaviour, &e))
    }

    /// The cylinder sector it describes, over `bounds` where the config does not say otherwise.
    ///
    /// # Errors
    /// As [`Self::make_polar`].
    pub fn make_cylinder(&self, behaviour: &str, bounds: Bounds) -> Result<TargetGrid, BuildError> {
        let keys = [
            ("moments", self.moments.is_some()),
            ("horizon_s", self.horizon_s.is_some()),
            ("radius", self.radius.is_some()),
            ("inner_spacing", self.inner_spacing.is_some()),
        ];
        refuse(behaviour, "throw_punches", &keys)?;
        self.check_adaptive(behaviour)?;
        let b = &self.bounds;
        let [mut low, mut high] = bounds;
        let middle = 0.5 * (low + high);
        (low, high) = (low.min(middle - 0.5 * LEAST_EXTENT), high.max(middle + 0.5 * LEAST_EXTENT));
        low.y = low.y.max(0.0);
        for (axis, key, given) in
            [(0, "angle_rad", b.angle_rad), (1, "distance_m", b.distance_m), (2, "height_m", b.height_m)]
        {
            let Some([from, to]) = given else { continue };
            if !(from < to && from.abs() < 1e3 && to.abs() < 1e3) {
                let message = format!(
                    "behaviour \"{behaviour}\", key `grid.bounds.{key}`: expected [least, greatest], found [{from}, {to}]"
                );
                return Err(BuildError::Config { message });
            }
            (low[axis], high[axis]) = (from as f32, to as f32);
        }
        let counts = [self.angles.unwrap_or(10), self.rings.unwrap_or(10), self.heights.unwrap_or(4)];
        let falloff = self.falloff.unwrap_or(0.3) as f32;
        TargetGrid::cylinder(counts, low, high, falloff).map_err(|e| wrong(behaviour, &e))
    }

    /// The grid of moments it describes.
    ///
    /// # Errors
    /// As [`Self::make_polar`].
    pub fn make_moments(&self, behaviour: &str) -> Result<TargetGrid, BuildError> {
        let keys = [
            ("heights", self.heights.is_some()),
            ("inner_spacing", self.inner_spacing.is_some()),
            ("bounds", self.bounds != BoundsConfig::default()),
            ("adaptive", self.adaptive.is_some()),
        ];
        refuse(behaviour, "evade", &keys)?;
        let counts = [self.rings.unwrap_or(8), self.angles.unwrap_or(16), self.moments.unwrap_or(9)];
        let (radius, horizon) = (self.radius.unwrap_or(1.2) as f32, self.horizon_s.unwrap_or(0.8) as f32);
        TargetGrid::moments(counts, radius, horizon, self.falloff.unwrap_or(0.3) as f32)
            .map_err(|e| wrong(behaviour, &e))
    }
}

/// Refuses keys that a kind of behaviour does not read.
fn refuse(behaviour: &str, kind: &str, keys: &[(&str, bool)]) -> Result<(), BuildError> {
    match keys.iter().find(|(_, given)| *given) {
        Some((key, _)) => Err(BuildError::Config {
            message: format!(
                "behaviour \"{behaviour}\", key `grid.{key}`: the kind `{kind}` has no such key; leave it out"
            ),
        }),
        None => Ok(()),
    }
}

/// The fault without the advice to rebuild, which does not help a configuration.
pub(in crate::policy) fn wrong(behaviour: &str, e: &PolicyError) -> BuildError {
    let text = e.to_string();
    let text = text.strip_suffix("; rebuild the bundle").unwrap_or(&text).trim_start_matches("policy table ");
    BuildError::Config { message: format!("behaviour \"{behaviour}\", key `grid`: {text}") }
}
