//! Where a behaviour is active.

use crate::error::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use throng_runtime::policy::RegionRecord;

/// Targets for which a behaviour counts, in the character's frame; what is absent is that of the behaviour's kind:
/// everywhere for `approach`, the grid itself for the others (003 section 6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RegionConfig {
    /// Least and greatest distance over ground. [Unit: m]
    pub distance_m: Option<[f64; 2]>,
    /// Least and greatest angle from straight ahead, positive to the left. [Unit: rad] [Limit: -pi to pi]
    pub angle_rad: Option<[f64; 2]>,
    /// Least and greatest height above ground. [Unit: m]
    pub height_m: Option<[f64; 2]>,
    /// Least and greatest time left, for `evade`. [Unit: s]
    pub time_s: Option<[f64; 2]>,
}

impl RegionConfig {
    /// The region, `default` where the config says nothing.
    ///
    /// # Errors
    /// [`BuildError::Config`] that names behaviour and key.
    pub fn make(&self, behaviour: &str, moments: bool, default: RegionRecord) -> Result<RegionRecord, BuildError> {
        let fail = |key: &str, why: String| {
            Err(BuildError::Config { message: format!("behaviour \"{behaviour}\", key `region.{key}`: {why}") })
        };
        let (unread, third) = if moments { ("height_m", self.time_s) } else { ("time_s", self.height_m) };
        if (if moments { self.height_m } else { self.time_s }).is_some() {
            return fail(unread, "this kind of behaviour has no such key; leave it out".into());
        }
        let mut out = default;
        let third_key = if moments { "time_s" } else { "height_m" };
        for (key, given, to) in [
            ("distance_m", self.distance_m, &mut out.distance),
            ("angle_rad", self.angle_rad, &mut out.angle),
            (third_key, third, &mut out.height),
        ] {
            let Some([from, until]) = given else { continue };
            if !(from <= until && from.abs() <= 1e6 && until.abs() <= 1e6) {
                return fail(key, format!("expected [least, greatest], found [{from}, {until}]"));
            }
            *to = [from as f32, until as f32];
        }
        Ok(out)
    }
}
