//! A hit that people mark by hand.

use crate::clip::HitKind;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use throng_base::text::did_you_mean;
use throng_core::Joint;

/// A hit: at one moment, or at the fastest moment of a range.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SidecarHit {
    /// `punch`, `kick`, or any other name: a kind of its own.
    pub name: String,
    /// The joint that strikes, in snake_case: `left_hand`, `right_foot`, `head`.
    pub joint: String,
    /// The moment; without `start` and `end` (as `unit` says).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<f64>,
    /// Begin of the range whose fastest moment of the joint is the hit; with `end` (as `unit` says).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<f64>,
    /// End of the range (as `unit` says).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end: Option<f64>,
}

impl SidecarHit {
    /// Begin and end, the same for a single moment, or the fault in it.
    pub(super) fn times(&self) -> Result<(f64, f64), String> {
        let sound = |t: f64| t >= 0.0 && t.is_finite();
        let name = &self.name;
        match (self.at, self.start, self.end) {
            (Some(at), None, None) if sound(at) => Ok((at, at)),
            (Some(at), None, None) => Err(format!("`{name}`: expected at >= 0, found {at}. Correct it.")),
            (None, Some(start), Some(end)) if sound(start) && end > start => Ok((start, end)),
            (None, Some(start), Some(end)) => Err(super::wrong_range(name, start, end)),
            _ => {
                Err(format!("`{name}`: expected `at`, or `start` and `end`, found neither or both. Keep one of them."))
            }
        }
    }

    /// The joint of that name, or the fault in the name.
    pub(super) fn joint(&self) -> Result<Joint, String> {
        Joint::from_name(&self.joint).ok_or_else(|| {
            let meant = did_you_mean(&self.joint, Joint::ALL.into_iter().map(Joint::name));
            format!("`{}`: there is no joint `{}`.{meant}", self.name, self.joint)
        })
    }

    /// Kind of blow.
    pub(super) fn kind(&self) -> HitKind {
        let found = [HitKind::Punch, HitKind::Kick].into_iter().find(|k| k.name() == self.name);
        found.unwrap_or_else(|| HitKind::Tag(self.name.clone()))
    }
}
