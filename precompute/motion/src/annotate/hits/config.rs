//! Settings of the search for effective hits.

use crate::error::{Result, check_ranges};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Settings of the search for effective hits (Lee and Lee 2004, section 6).
///
/// A *thrust* is the blow of Lee and Lee (2004): the fist moves along the forearm, faster than a threshold. A *swing* moves
/// across it, as hooks and most kicks do, and is found by its whole speed. Speeds that decide are relative to the ground speed
/// of the hips, so that neither running nor stepping back counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct HitConfig {
    /// Look for hits. Hits that sidecars mark by hand count in any case.
    pub enabled: bool,
    /// A blow lands at the last frame at which the fist or foot still has this share of its greatest speed: near the
    /// limb's full length, with most of its power. 1 is the fastest frame itself (> 0, <= 1).
    pub landing_share: f32,
    /// Blows with the fists.
    pub punches: PunchConfig,
    /// Blows with the feet.
    pub kicks: KickConfig,
}

/// Blows with the fists.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PunchConfig {
    /// Look for punches.
    pub enabled: bool,
    /// Least speed of the fist along the forearm, elbow to wrist (m/s, > 0).
    pub thrust_speed: f32,
    /// Least growth of the distance from shoulder to wrist during a thrust, as a share of the arm's length. Arms that
    /// swing beside a walking or running body keep their length (0 to 1).
    pub extension: f32,
    /// Least speed of the fist in any direction with which a bent arm punches; absent: only thrusts count. Hooks that
    /// open the elbow are thrusts at the moment they land; uppercuts and tight hooks need this, 4 m/s finds them.
    /// Sprinting, waving and dancing arms are as fast: set it for motion of fighting alone (m/s, > 0).
    pub swing_speed: Option<f32>,
    /// A swing's fist is at most this far below its shoulder where it lands (m, >= 0).
    pub swing_drop: f32,
    /// Largest angle above or below level at which a striking arm points where it is longest, and at which its fist moves
    /// upwards: an arm that reaches up or down does not strike (deg, 0 to 90).
    pub elevation_deg: f32,
    /// Least shortening of the arm within 0.6 s of a thrust, as a share of its length: a hand that is offered, or that
    /// points, stays out. Thrusts at the end of a clip need not come back (0 to 1).
    pub retreat: f32,
    /// Height of one foot above the other from which arms balance or guard, 0.4 s before and after, too (m, >= 0).
    pub raised_foot: f32,
    /// Least time between two punches of one hand (s, >= 0).
    pub min_gap: f32,
}

/// Blows with the feet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct KickConfig {
    /// Look for kicks.
    pub enabled: bool,
    /// Least speed of the ball of the foot along the shin, knee to ankle, as in a push kick (m/s, > 0).
    pub thrust_speed: f32,
    /// Least speed of the ball of the foot in any direction: most kicks move across the shin (m/s, > 0).
    pub swing_speed: f32,
    /// Least growth of the distance from hip to ankle during a kick, as a share of the leg's length (0 to 1).
    pub extension: f32,
    /// Least height of the ball of the foot above that of the other foot where the leg is longest (m, >= 0).
    pub height: f32,
    /// Least time between two kicks of one foot (s, >= 0).
    pub min_gap: f32,
}

impl Default for HitConfig {
    fn default() -> Self {
        Self { enabled: true, landing_share: 0.7, punches: PunchConfig::default(), kicks: KickConfig::default() }
    }
}

impl Default for PunchConfig {
    fn default() -> Self {
        Self {
            enabled: true,
            thrust_speed: 1.5,
            extension: 0.2,
            swing_speed: None,
            swing_drop: 0.25,
            elevation_deg: 50.0,
            retreat: 0.15,
            raised_foot: 0.25,
            min_gap: 0.15,
        }
    }
}

impl Default for KickConfig {
    fn default() -> Self {
        Self { enabled: true, thrust_speed: 2.5, swing_speed: 4.5, extension: 0.15, height: 0.4, min_gap: 0.3 }
    }
}

impl HitConfig {
    /// Checks every number against its limits.
    ///
    /// # Errors
    /// [`crate::error::BuildError::Config`] with the key, what was expected and what was found.
    pub fn check(&self) -> Result<()> {
        let (p, k) = (&self.punches, &self.kicks);
        check_ranges([
            ("landing_share", self.landing_share, 0.01, 1.0),
            ("punches.thrust_speed", p.thrust_speed, 0.01, 100.0),
            ("punches.extension", p.extension, 0.0, 1.0),
            ("punches.swing_speed", p.swing_speed.unwrap_or(1.0), 0.01, 100.0),
            ("punches.swing_drop", p.swing_drop, 0.0, 10.0),
            ("punches.elevation_deg", p.elevation_deg, 0.0, 90.0),
            ("punches.retreat", p.retreat, 0.0, 1.0),
            ("punches.raised_foot", p.raised_foot, 0.0, 10.0),
            ("punches.min_gap", p.min_gap, 0.0, 60.0),
            ("kicks.thrust_speed", k.thrust_speed, 0.01, 100.0),
            ("kicks.swing_speed", k.swing_speed, 0.01, 100.0),
            ("kicks.extension", k.extension, 0.0, 1.0),
            ("kicks.height", k.height, 0.0, 10.0),
            ("kicks.min_gap", k.min_gap, 0.0, 60.0),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_outside_their_limits_are_named() {
        assert!(HitConfig::default().check().is_ok());
        type Change = fn(&mut HitConfig);
        let wrong: [(&str, Change); 5] = [
            ("landing_share: expected 0.01 to 1, found 0", |c| c.landing_share = 0.0),
            ("punches.thrust_speed: expected 0.01 to 100, found -1", |c| {
                c.punches.thrust_speed = -1.0;
            }),
            ("punches.swing_speed: expected 0.01 to 100, found NaN", |c| {
                c.punches.swing_speed = Some(f32::NAN);
            }),
            ("kicks.extension: expected 0 to 1, found 2", |c| c.kicks.extension = 2.0),
            ("kicks.min_gap: expected 0 to 60, found inf", |c| c.kicks.min_gap = f32::INFINITY),
        ];
        for (message, change) in wrong {
            let mut config = HitConfig::default();
            change(&mut config);
            let e = config.check().unwrap_err().to_string();
            assert!(e.starts_with(message), "{e}");
        }
    }
}
