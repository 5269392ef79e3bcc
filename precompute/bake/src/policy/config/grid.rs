//! Settings of the cells of a behaviour's target.

use super::{AdaptiveConfig, region::ANGLE_TOLERANCE};
use glam::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::{f32::consts::PI, f64::consts};
use throng_core::Error;
use throng_core::policy::{MAX_AXIS, TargetGrid};
use throng_motion::error::{BuildError, Result};

/// Cells of the target. Absent settings depend on the behaviour's kind:
///
/// - `approach`: polar, 16 rings x 32 angles over 8 m;
/// - `throw_punches`: 8 rings x 12 angles over the bounding volume of the hits, half a `scale` wider over ground, and 4 to 16
///   heights that are 0.4 of it apart or less;
/// - `evade`: polar, 8 rings x 16 angles over 1.2 m, at 9 times over 0.8 s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct GridConfig {
    /// Rings, from the character outwards (2 to 4096).
    pub rings: Option<u32>,
    /// Angles, the first straight ahead if they go all around (2 to 4096).
    pub angles: Option<u32>,
    /// Heights, for `throw_punches` (1 to 4096).
    pub heights: Option<u32>,
    /// Times left until the event, for `evade` (2 to 4096).
    pub times: Option<u32>,
    /// Distance of the last ring if angles go all around; targets farther away are treated as if on it (m, 0.01 to
    /// 10000).
    pub radius: Option<f64>,
    /// For `approach`, distance between the first two rings: an equal share, radius / (rings - 1), or less, which makes
    /// the distances grow outwards. Unused for two rings. If absent 0.25, or as near to it as rings and radius allow
    /// (m, > radius / (rings - 1)^2).
    pub inner_spacing: Option<f64>,
    /// For `evade`, the longest time left (s, 0.01 to 1000).
    pub horizon_s: Option<f64>,
    /// Distance beyond the grid over which values fall to about 1/e (m, 0.001 to 10000).
    pub falloff: Option<f64>,
    /// For `throw_punches`, the volume covered in place of that of the hits.
    pub bounds: BoundsConfig,
    /// For `approach` and `throw_punches`: a resolution per state, in place of these counts for all.
    pub adaptive: Option<AdaptiveConfig>,
}

/// A volume in front of the character; absent settings are those of the hits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BoundsConfig {
    /// Least and greatest angle from straight ahead, positive to the left; less than a full turn apart (rad, -pi to
    /// pi).
    pub angle_rad: Option<[f64; 2]>,
    /// Least and greatest distance over ground (m, 0 to 1000).
    pub distance_m: Option<[f64; 2]>,
    /// Least and greatest height above ground (m, -1000 to 1000).
    pub height_m: Option<[f64; 2]>,
}

impl BoundsConfig {
    /// Checks every given pair, by key.
    fn check(&self) -> Result<()> {
        let half_turn = consts::PI + ANGLE_TOLERANCE;
        for (key, given, [least, most], limits) in [
            ("angle_rad", self.angle_rad, [-half_turn, half_turn], "from -pi to pi, less than a full turn"),
            ("distance_m", self.distance_m, [0.0, 1e3], "from 0 to 1000"),
            ("height_m", self.height_m, [-1e3, 1e3], "from -1000 to 1000"),
        ] {
            let Some([from, to]) = given else { continue };
            let turns = key == "angle_rad" && to - from > consts::TAU - LEAST_GIVEN_EXTENT / 10.0;
            // Differences may be off by rounding.
            if !(from >= least && to <= most && to - from >= 0.999 * LEAST_GIVEN_EXTENT) || turns {
                let why = format!(
                    "expected [least, greatest] {limits}, {LEAST_GIVEN_EXTENT} apart or more, found [{from}, {to}]"
                );
                return Err(grid_error(&format!("bounds.{key}"), why));
            }
        }
        Ok(())
    }
}

/// A volume with an extent in every direction: (angle, distance, height), least and greatest.
pub type VolumeBounds = [Vec3; 2];

/// Least extent of a volume along each axis, as a grid needs some (rad, m, m).
const LEAST_EXTENT: Vec3 = Vec3::new(0.1, 0.05, 0.05);

/// Fewest and most heights if the config gives no number.
const LEAST_LAYERS: u32 = 4;
const MOST_LAYERS: u32 = 16;

/// Least extent of a configured volume, along each axis (rad or m).
const LEAST_GIVEN_EXTENT: f64 = 0.01;

impl GridConfig {
    /// A polar grid with all numbers given. Lengths in metres.
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

    /// Checks every given number, by key.
    pub(super) fn check(&self) -> Result<()> {
        let most = f64::from(MAX_AXIS);
        for (key, given, least, most) in [
            ("rings", self.rings.map(f64::from), 2.0, most),
            ("angles", self.angles.map(f64::from), 2.0, most),
            ("heights", self.heights.map(f64::from), 1.0, most),
            ("times", self.times.map(f64::from), 2.0, most),
            ("radius", self.radius, 0.01, 1e4),
            ("horizon_s", self.horizon_s, 0.01, 1e3),
            ("falloff", self.falloff, 1e-3, 1e4),
        ] {
            if let Some(v) = given.filter(|v| !(least..=most).contains(v)) {
                return Err(grid_error(key, format!("expected {least} to {most}, found {v}")));
            }
        }
        self.bounds.check()?;
        self.adaptive.map_or(Ok(()), |a| a.check().map_err(|e| e.within_key("grid.adaptive")))
    }

    /// Distance between the first two rings: as given, or 0.25 m if possible (m).
    fn inner_spacing(&self, rings: u32, radius: f64) -> Result<f64> {
        let last = f64::from(rings - 1);
        let (share, least) = (radius / last, radius / (last * last));
        let Some(given) = self.inner_spacing else { return Ok(0.25f64.max(2.0 * least).min(share)) };
        // Tolerance for single precision. Two rings have a single distance.
        let suits = given > 1.001 * least + 2e-6 && given <= 1.00005 * share;
        if suits || (rings == 2 && given > 0.0 && given <= 1e4) {
            return Ok(given);
        }
        let why = if rings == 2 {
            format!("expected above 0 to 10000, found {given}")
        } else {
            format!(
                "expected above radius / (rings - 1)^2, {least:.4}, and up to radius / (rings - 1), {share:.4}, found {given}"
            )
        };
        Err(grid_error("inner_spacing", why))
    }

    /// Makes the polar grid.
    ///
    /// # Errors
    /// [`BuildError::Key`].
    pub fn make_polar(&self) -> Result<TargetGrid> {
        let keys = [
            ("heights", self.heights.is_some()),
            ("times", self.times.is_some()),
            ("horizon_s", self.horizon_s.is_some()),
            ("bounds", self.bounds != BoundsConfig::default()),
        ];
        refuse_key("approach", &keys)?;
        self.check()?;
        let (rings, radius) = (self.rings.unwrap_or(16), self.radius.unwrap_or(8.0));
        let inner = self.inner_spacing(rings, radius)?;
        let falloff = self.falloff.unwrap_or(2.5) as f32;
        TargetGrid::polar(rings, self.angles.unwrap_or(32), radius as f32, inner as f32, falloff)
            .map_err(|e| value_error(&e))
    }

    /// Makes the cylinder sector, by default over `bounds`.
    ///
    /// - `layer`: largest distance between two heights if the config gives no number (m, > 0).
    ///
    /// # Errors
    /// As [`Self::make_polar`].
    pub fn make_cylinder(&self, bounds: VolumeBounds, layer: f32) -> Result<TargetGrid> {
        let keys = [
            ("times", self.times.is_some()),
            ("horizon_s", self.horizon_s.is_some()),
            ("radius", self.radius.is_some()),
            ("inner_spacing", self.inner_spacing.is_some()),
        ];
        refuse_key("throw_punches", &keys)?;
        self.check()?;
        let [mut low, mut high] = bounds;
        let middle = 0.5 * (low + high);
        (low, high) = (low.min(middle - 0.5 * LEAST_EXTENT), high.max(middle + 0.5 * LEAST_EXTENT));
        let b = &self.bounds;
        for (axis, given) in [b.angle_rad, b.distance_m, b.height_m].into_iter().enumerate() {
            let Some([from, to]) = given else { continue };
            (low[axis], high[axis]) = (from as f32, to as f32);
        }
        (low.x, high.x, low.y) = (low.x.max(-PI), high.x.min(PI), low.y.max(0.0));
        let layers = (((high.z - low.z) / layer).ceil() as u32).clamp(LEAST_LAYERS - 1, MOST_LAYERS - 1) + 1;
        let counts = [self.angles.unwrap_or(12), self.rings.unwrap_or(8), self.heights.unwrap_or(layers)];
        if counts[2] == 1 {
            low.z = 0.5 * (low.z + high.z);
        }
        let falloff = self.falloff.unwrap_or(0.3) as f32;
        TargetGrid::cylinder(counts, low, high, falloff).map_err(|e| value_error(&e))
    }

    /// Makes the space-time grid.
    ///
    /// # Errors
    /// As [`Self::make_polar`].
    pub fn make_space_time(&self) -> Result<TargetGrid> {
        let keys = [
            ("heights", self.heights.is_some()),
            ("inner_spacing", self.inner_spacing.is_some()),
            ("bounds", self.bounds != BoundsConfig::default()),
            ("adaptive", self.adaptive.is_some()),
        ];
        refuse_key("evade", &keys)?;
        self.check()?;
        let counts = [self.rings.unwrap_or(8), self.angles.unwrap_or(16), self.times.unwrap_or(9)];
        let (radius, horizon) = (self.radius.unwrap_or(1.2) as f32, self.horizon_s.unwrap_or(0.8) as f32);
        TargetGrid::space_time(counts, radius, horizon, self.falloff.unwrap_or(0.3) as f32).map_err(|e| value_error(&e))
    }
}

/// Refuses keys that a kind of behaviour does not use.
fn refuse_key(kind: &str, keys: &[(&str, bool)]) -> Result<()> {
    match keys.iter().find(|(_, given)| *given) {
        Some((key, _)) => Err(grid_error(key, format!("the kind `{kind}` has no such key; leave it out"))),
        None => Ok(()),
    }
}

/// Error for one key of the grid.
fn grid_error(key: &str, why: impl std::fmt::Display) -> BuildError {
    BuildError::key(format!("grid.{key}"), why)
}

/// Error of the runtime's own check of the whole grid.
fn value_error(e: &Error) -> BuildError {
    BuildError::key("grid", e)
}

#[cfg(test)]
mod tests {
    use super::*;

    const HITS: VolumeBounds = [Vec3::new(-0.5, 0.4, 1.2), Vec3::new(0.5, 0.9, 1.7)];

    fn read(text: &str) -> GridConfig {
        toml::from_str(text).expect("a grid")
    }

    #[test]
    fn faults_name_the_key_what_is_expected_and_what_was_found() {
        let polar = |text: &str| read(text).make_polar().expect_err(text).to_string();
        let cylinder = |text: &str| read(text).make_cylinder(HITS, 0.2).expect_err(text).to_string();
        let space_time = |text: &str| read(text).make_space_time().expect_err(text).to_string();
        for (message, expected) in [
            (polar("rings = 0"), "grid.rings: expected 2 to 4096, found 0"),
            (polar("angles = 1"), "grid.angles: expected 2 to 4096, found 1"),
            (polar("radius = -1.0"), "grid.radius: expected 0.01 to 10000, found -1"),
            (polar("radius = nan"), "grid.radius: expected 0.01 to 10000, found NaN"),
            (polar("falloff = inf"), "grid.falloff: expected 0.001 to 10000, found inf"),
            (polar("rings = 5\nradius = 8.0\ninner_spacing = 0.25"), "0.5000, and up to radius / (rings - 1), 2.0000"),
            (polar("inner_spacing = nan"), "grid.inner_spacing: expected above"),
            (polar("rings = 2\ninner_spacing = nan"), "grid.inner_spacing: expected above 0 to 10000, found NaN"),
            (cylinder("heights = 0"), "grid.heights: expected 1 to 4096, found 0"),
            (cylinder("rings = 5000"), "grid.rings: expected 2 to 4096, found 5000"),
            (cylinder("bounds.angle_rad = [-90.0, 90.0]"), "grid.bounds.angle_rad: expected [least, greatest]"),
            (cylinder("bounds.angle_rad = [-3.14159, 3.14159]"), "less than a full turn"),
            (cylinder("bounds.distance_m = [-1.0, 1.0]"), "grid.bounds.distance_m"),
            (cylinder("bounds.height_m = [1.0, nan]"), "grid.bounds.height_m"),
            (cylinder("bounds.height_m = [1.0, 1.0]"), "grid.bounds.height_m"),
            (space_time("times = 1"), "grid.times: expected 2 to 4096, found 1"),
            (space_time("horizon_s = 0.0"), "grid.horizon_s: expected 0.01 to 1000, found 0"),
        ] {
            assert!(message.starts_with("grid") && message.contains(expected), "{message}");
        }
    }

    #[test]
    fn counts_alone_make_a_polar_grid() {
        for rings in [2, 3, 4, 5, 6, 16, 33, 100, 4096] {
            for radius in [0.01, 0.5, 2.0, 8.0, 100.0, 1e4] {
                let config = GridConfig { rings: Some(rings), radius: Some(radius), ..GridConfig::default() };
                let grid = config.make_polar().unwrap_or_else(|e| panic!("{rings} rings, {radius} m: {e}"));
                assert!((f64::from(grid.radius()) - radius).abs() < 1e-3 * radius, "{rings} rings, {radius} m");
            }
        }
        let inner = |text: &str| {
            let r = *read(text).make_polar().expect(text).record();
            r.ring_spacing + r.ring_growth
        };
        assert!((inner("rings = 5\nangles = 8") - 1.0).abs() < 1e-5);
        assert!((inner("") - 0.25).abs() < 1e-5);
    }

    #[test]
    fn spacings_at_their_limits_are_sound() {
        for rings in [3u32, 5, 50, 1000] {
            let (last, radius) = (f64::from(rings - 1), 3.0);
            for inner in [radius / last, 1.002 * radius / (last * last) + 3e-6] {
                assert!(GridConfig::polar(rings, 8, radius, inner, 1.0).make_polar().is_ok(), "{rings}, {inner}");
            }
        }
    }

    #[test]
    fn extreme_bounds_make_a_cylinder() {
        for text in [
            "angles = 4096\nbounds.angle_rad = [3.13, 3.1416]",
            "bounds.angle_rad = [-3.1416, 3.14]",
            "rings = 4096\nbounds.distance_m = [0.0, 0.01]",
            "heights = 1\nbounds.height_m = [-1000.0, 1000.0]",
        ] {
            read(text).make_cylinder(HITS, 0.2).expect(text);
        }
        let behind = Vec3::new(PI, 0.5, 1.0);
        GridConfig::default().make_cylinder([behind, behind], 0.2).expect("a blow straight behind");
    }
}
