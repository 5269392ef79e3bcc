//! Settings of what actions cost beside their transitions.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use throng_motion::error::{Result, check_ranges};

/// Costs of motion that nobody asked for, each a delay for which the behaviour takes it; 0 turns it off. In clips whose
/// frames have no class, only the first two and `made` count. A new one of 0 leaves policies as they are; another default changes
/// every `approach` that names no `costs`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct CostsConfig {
    /// Travel against the front, more than 120 degrees off it (s a second of it, 0 to 60).
    pub backwards: f64,
    /// Travel to a side, 45 to 120 degrees off the front (s a second of it, 0 to 60).
    pub sideways: f64,
    /// Standing that is not neutral, and jumps (s a second of it, 0 to 60).
    pub gesture: f64,
    /// Hands that hold a load (s a second of it, 0 to 60).
    pub carrying: f64,
    /// Transition to a frame of another manner; a sixteenth of it where there is too little motion to keep either (s, 0 to 60).
    pub manner_change_s: f64,
    /// Transition from standing to more standing (s, 0 to 60).
    pub standing_change_s: f64,
    /// Made motion, on the spot a tenth of it (s a second of it, 0 to 60).
    pub made: f64,
    /// Running, where there is walking to go on with (s a second of it, 0 to 60).
    pub running: f64,
}

impl Default for CostsConfig {
    fn default() -> Self {
        Self {
            backwards: 1.0,
            sideways: 0.1,
            gesture: 0.3,
            carrying: 0.5,
            manner_change_s: 4.8,
            standing_change_s: 0.0,
            made: 0.6,
            running: 3.0,
        }
    }
}

impl CostsConfig {
    /// No costs.
    pub const NONE: Self = Self {
        backwards: 0.0,
        sideways: 0.0,
        gesture: 0.0,
        carrying: 0.0,
        manner_change_s: 0.0,
        standing_change_s: 0.0,
        made: 0.0,
        running: 0.0,
    };

    /// Costs in the order of [`super::super::ActionTraits`].
    pub(in crate::policy) fn to_array(self) -> [f64; 8] {
        let Self { backwards, sideways, gesture, carrying, manner_change_s, standing_change_s, made, running } = self;
        [backwards, sideways, gesture, carrying, manner_change_s, standing_change_s, made, running]
    }

    pub(super) fn check(self) -> Result<()> {
        let keys =
            ["backwards", "sideways", "gesture", "carrying", "manner_change_s", "standing_change_s", "made", "running"];
        let ranges: Vec<_> = keys.into_iter().zip(self.to_array()).map(|(key, cost)| (key, cost, 0.0, 60.0)).collect();
        check_ranges(ranges).map_err(|e| e.within_key("costs"))
    }
}
