//! Settings of the active region of a behaviour.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use throng_core::policy::RegionRecord;
use throng_motion::error::{BuildError, Result};

/// Targets for which a behaviour is active, in the character's frame. Absent settings depend on the kind: everywhere
/// for `approach`, or beyond the reach of blows if its centre is that of hits; the grid itself for the others (Lee and
/// Lee 2004, section 6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RegionConfig {
    /// Least and greatest distance over ground (m).
    pub distance_m: Option<[f64; 2]>,
    /// Least and greatest angle from straight ahead, positive to the left (rad, -pi to pi).
    pub angle_rad: Option<[f64; 2]>,
    /// Least and greatest height above ground (m).
    pub height_m: Option<[f64; 2]>,
    /// Least and greatest time left, for `evade` (s).
    pub time_s: Option<[f64; 2]>,
}

/// Tolerance beyond a half turn, so that pi may be written with few digits (rad).
pub(super) const ANGLE_TOLERANCE: f64 = 1e-4;

impl RegionConfig {
    /// Makes the region, with `default` for absent settings.
    ///
    /// - `default`: all targets that the behaviour supports; a region without any of them is an error.
    ///
    /// # Errors
    /// [`BuildError::Key`].
    pub fn make_region(&self, space_time: bool, default: RegionRecord) -> Result<RegionRecord> {
        let fail = |key: &str, why: String| Err(BuildError::key(format!("region.{key}"), why));
        let (height, time) = (("height_m", self.height_m), ("time_s", self.time_s));
        let (unread, (third_key, third)) = if space_time { (height, time) } else { (time, height) };
        if unread.1.is_some() {
            return fail(unread.0, "this kind of behaviour has no such key; leave it out".into());
        }
        let mut out = default;
        for (key, given, to) in [
            ("distance_m", self.distance_m, &mut out.distance),
            ("angle_rad", self.angle_rad, &mut out.angle),
            (third_key, third, &mut out.height),
        ] {
            let Some([from, until]) = given else { continue };
            if !(from <= until && from.abs() <= 1e6 && until.abs() <= 1e6) {
                return fail(key, format!("expected [least, greatest], found [{from}, {until}]"));
            }
            if key == "angle_rad" && from.abs().max(until.abs()) > PI + ANGLE_TOLERANCE {
                return fail(key, format!("expected angles from -pi to pi, found [{from}, {until}]"));
            }
            let [low, high] = to.map(f64::from);
            if until < low || from > high {
                let why = format!(
                    "[{from}, {until}] has no target of this behaviour, whose own are from {low:.3} to {high:.3}; \
                     change it, or what `grid` covers"
                );
                return fail(key, why);
            }
            *to = [from as f32, until as f32];
        }
        Ok(out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: RegionRecord = RegionRecord { distance: [0.4, 1.2], angle: [-1.0, 1.0], height: [0.0, 0.8] };

    fn fault(text: &str, space_time: bool, default: RegionRecord) -> String {
        let config: RegionConfig = toml::from_str(text).unwrap();
        config.make_region(space_time, default).unwrap_err().to_string()
    }

    #[test]
    fn takes_what_is_given_and_the_default_for_the_rest() {
        let config: RegionConfig = toml::from_str("distance_m = [0.5, 9.0]\nangle_rad = [-3.0, 3.0]").unwrap();
        let region = config.make_region(false, GRID).unwrap();
        assert_eq!(region, RegionRecord { distance: [0.5, 9.0], angle: [-3.0, 3.0], ..GRID });
    }

    #[test]
    fn refuses_angles_beyond_a_half_turn() {
        for text in ["angle_rad = [-90.0, 90.0]", "angle_rad = [0.0, 4.0]", "angle_rad = [-3.2, 0.0]"] {
            let message = fault(text, false, RegionRecord::EVERYWHERE);
            assert!(message.starts_with("region.angle_rad: ") && message.contains("-pi to pi"), "{message}");
        }
    }

    #[test]
    fn refuses_what_holds_no_target_of_the_grid() {
        for (key, bounds, space_time) in [
            ("distance_m", "[1.5, 2.0]", false),
            ("distance_m", "[0.0, 0.3]", true),
            ("angle_rad", "[1.5, 2.0]", false),
            ("height_m", "[0.9, 2.0]", false),
            ("time_s", "[-1.0, -0.5]", true),
        ] {
            let message = fault(&format!("{key} = {bounds}"), space_time, GRID);
            assert!(message.starts_with(&format!("region.{key}: ")) && message.contains("`grid`"), "{message}");
        }
        assert!(fault("distance_m = [-2.0, -1.0]", false, RegionRecord::EVERYWHERE).starts_with("region.distance_m: "));
    }

    #[test]
    fn refuses_bounds_that_do_not_ascend() {
        for text in ["distance_m = [1.0, 0.5]", "height_m = [nan, 1.0]", "angle_rad = [0.0, inf]"] {
            assert!(fault(text, false, GRID).contains("expected [least, greatest]"), "{text}");
        }
    }
}
