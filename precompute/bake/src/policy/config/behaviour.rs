//! Settings of a behaviour.

use super::{super::behaviour::ActionCosts, CentreConfig, CostsConfig, GridConfig, RegionConfig};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use throng_core::policy::{
    COMBINE_MAX, COMBINE_SUM, KERNEL_EXPONENTIAL, KERNEL_LINEAR, KERNEL_WITHIN, Reward, RewardRecord,
};
use throng_motion::error::{BuildError, Result, check_ranges};

/// Settings of a behaviour: its reward, its cells of the target, and its active region.
///
/// Its kind selects what is rewarded: the place of the character (`approach`), its blows (`throw_punches`), or its
/// place when a blow lands (`evade`). Custom behaviours are these with other numbers: keeping away (`gain = -1`),
/// keeping a distance (`offset`), kicking (`hits = ["kick"]`), grasping by tags, guarding another joint (`point`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PolicyBehaviourConfig {
    /// Name of the policy in the bundle; unique, not empty.
    pub name: String,
    /// Kind of the behaviour.
    pub kind: BehaviourKind,
    /// Cells of the target.
    pub grid: GridConfig,
    /// Active region.
    pub region: RegionConfig,
    /// Discount per frame at 30 Hz, for any database rate; 0.97 of Lee and Lee (2004) at 15 Hz is 0.985 here. If absent, that, and
    /// 0.996 where `costs` count: with less, people would stop on their way to save a cost (0.5 to 0.9999).
    pub discount: Option<f64>,
    /// Combination of an action's moments to its reward; if absent, `integral` for `approach` and `max` for
    /// `throw_punches`.
    pub reward: Option<RewardForm>,
    /// Reward by distance; if absent, `exponential` for `approach` and `evade`, `linear` for `throw_punches`.
    pub kernel: Option<KernelConfig>,
    /// Distance at which the kernel has fallen to 1/e, or up to which it extends; if absent, 1.5 for `approach`, 0.3
    /// for `throw_punches`, 0.2 for `evade` (m, 0.001 to 1000).
    pub scale: Option<f64>,
    /// Distance with the greatest reward, in place of the target itself (m, 0 to 100).
    pub offset: f64,
    /// Factor on the reward, negative to avoid; if absent, 1, and -1 for `evade` (-100 to 100).
    pub gain: Option<f64>,
    /// Cost of a transition: the equivalent delay of one between frames at a distance of 1 rad; grows with the square
    /// of the distance. With a cost, characters change clips less often and at nearer frames, and arrive a little
    /// later. If absent, 1 for `approach` with a positive gain, else 0 (s, 0 to 60).
    ///
    /// # Source
    /// Transitions are weighed against control in Treuille, Lee and Popovic (2007), *Near-optimal Character Animation
    /// with Continuous Control*. Differs: the cost is a delay, so it weighs as much far from the target as near it.
    pub transition_cost_s: Option<f64>,
    /// Costs of motion that nobody asked for. If absent, the defaults of its keys for `approach` by the body with a positive gain,
    /// else none; with zeros, none.
    pub costs: Option<CostsConfig>,
    /// For `approach` by the body: how far a walked action may be bent towards the target, as far as people walk so without leaning;
    /// 0 plays motion as captured. If absent, 0.3 with a positive gain, else 0 (rad/m, 0 to 1).
    ///
    /// # Source
    /// Linear path editing of Lee, Choi and Lee (2006), *Motion Patches*, section 6.
    pub bend_rad_per_m: Option<f64>,
    /// For `approach`: point that is to reach the target.
    pub centre: CentreConfig,
    /// For `approach` with `integral`: additional weight of moments of standing, as a share (0 to 1).
    pub stand_bonus: f64,
    /// Speed, over ground or of the feet in a turn on the spot, at which most of that bonus is gone (m/s, 0.001 to
    /// 1000).
    pub stand_speed: f64,
    /// For `throw_punches`: kinds of hits that count (`punch`, `kick`, names of tags); all if empty.
    pub hits: Vec<String>,
    /// For `throw_punches`: joints that count (`left_hand`, ...); all if empty.
    pub joints: Vec<String>,
    /// For `evade`: guarded joint; `head` means its middle.
    pub point: String,
    /// For `evade`: height at which blows land; if absent, that of the guarded point of a character at ease, as the
    /// median over the database (m, -10 to 10).
    pub height: Option<f64>,
}

/// [`PolicyBehaviourConfig::transition_cost_s`] of `approach`.
const TRANSITION_COST_S: f64 = 1.0;
/// [`PolicyBehaviourConfig::discount`] without and with costs.
const DISCOUNT: f64 = 0.985;
const PATIENT_DISCOUNT: f64 = 0.996;

/// [`PolicyBehaviourConfig::bend_rad_per_m`] of behaviours that bring the body to a place.
const BEND_RAD_PER_M: f64 = 0.3;

impl Default for PolicyBehaviourConfig {
    fn default() -> Self {
        Self {
            name: "approach".into(),
            kind: BehaviourKind::Approach,
            grid: GridConfig::default(),
            region: RegionConfig::default(),
            discount: None,
            reward: None,
            kernel: None,
            scale: None,
            offset: 0.0,
            gain: None,
            transition_cost_s: None,
            costs: None,
            bend_rad_per_m: None,
            centre: CentreConfig::default(),
            stand_bonus: 0.2,
            stand_speed: 0.3,
            hits: Vec::new(),
            joints: Vec::new(),
            point: "head".into(),
            height: None,
        }
    }
}

/// Kind of a behaviour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BehaviourKind {
    /// Coming to a target on the ground and staying there (Lee and Lee 2004, equations 3 and 5).
    #[default]
    Approach,
    /// Effective hits on a target in space (Lee and Lee 2004, equations 2 and 6).
    ThrowPunches,
    /// Being elsewhere when a blow lands.
    Evade,
}

/// Combination of an action's moments to its reward.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RewardForm {
    /// For `approach`: discounted sum over the action's frames, a reward by time.
    Integral,
    /// The largest discounted moment of the action (Lee and Lee 2004, equations 2, 3, 5 and 6), a reward by action.
    Max,
    /// For `throw_punches`: sum of the discounted hits of an action.
    Sum,
}

/// Reward as a function of distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum KernelConfig {
    /// exp(-distance / scale).
    Exponential,
    /// 1 up to `scale`, 0 beyond.
    Within,
    /// 1 - distance / scale, 0 from `scale` on.
    Linear,
}

impl BehaviourKind {
    /// Name in configs.
    fn name(self) -> &'static str {
        match self {
            Self::Approach => "approach",
            Self::ThrowPunches => "throw_punches",
            Self::Evade => "evade",
        }
    }
}

impl PolicyBehaviourConfig {
    /// Checks the name, the numbers of all kinds, and that no key of another kind is given.
    ///
    /// # Errors
    /// [`BuildError::Key`] names the key out of its range or of another kind.
    pub(crate) fn check(&self) -> Result<()> {
        if self.name.trim().is_empty() {
            return Err(BuildError::key("name", "expected the policy's name in the bundle, found none"));
        }
        self.refuse_unread()?;
        self.grid.check()?;
        self.costs.map_or(Ok(()), CostsConfig::check)?;
        check_ranges([
            ("discount", self.discount.unwrap_or(DISCOUNT), 0.5, 0.9999),
            ("scale", self.scale.unwrap_or(1.0), 1e-3, 1e3),
            ("offset", self.offset, 0.0, 100.0),
            ("gain", self.gain.unwrap_or(1.0), -100.0, 100.0),
            ("transition_cost_s", self.transition_cost_s.unwrap_or(0.0), 0.0, 60.0),
            ("stand_bonus", self.stand_bonus, 0.0, 1.0),
            ("stand_speed", self.stand_speed, 1e-3, 1e3),
            ("height", self.height.unwrap_or(0.0), -10.0, 10.0),
            ("bend_rad_per_m", self.bend_rad_per_m.unwrap_or(0.0), 0.0, if self.by_body() { 1.0 } else { 0.0 }),
        ])
    }

    /// Refuses keys of other kinds, which would have no effect.
    fn refuse_unread(&self) -> Result<()> {
        use BehaviourKind::{Approach, Evade, ThrowPunches};
        let usual = Self::default();
        for (key, read_by, given) in [
            ("centre", Approach, self.centre != usual.centre),
            ("stand_bonus", Approach, self.stand_bonus != usual.stand_bonus),
            ("stand_speed", Approach, self.stand_speed != usual.stand_speed),
            ("hits", ThrowPunches, self.hits != usual.hits),
            ("joints", ThrowPunches, self.joints != usual.joints),
            ("point", Evade, self.point != usual.point),
            ("height", Evade, self.height != usual.height),
        ] {
            if given && read_by != self.kind {
                let kind = self.kind.name();
                return Err(BuildError::key(key, format!("the kind `{kind}` has no such key; leave it out")));
            }
        }
        Ok(())
    }

    /// True for behaviours that bring the body to a place.
    fn goes_somewhere(&self) -> bool {
        self.by_body() && self.gain.unwrap_or(1.0) > 0.0
    }

    /// True for behaviours about the place of the body.
    fn by_body(&self) -> bool {
        self.kind == BehaviourKind::Approach && self.centre == CentreConfig::default()
    }

    /// How far walked actions may be bent (rad/m).
    pub(in crate::policy) fn bend_rad_per_m(&self) -> f64 {
        self.bend_rad_per_m.unwrap_or(if self.goes_somewhere() { BEND_RAD_PER_M } else { 0.0 })
    }

    fn costs(&self) -> CostsConfig {
        let usual = if self.goes_somewhere() { CostsConfig::default() } else { CostsConfig::NONE };
        self.costs.unwrap_or(usual)
    }

    fn discount(&self) -> f64 {
        let usual = if self.costs() == CostsConfig::NONE { DISCOUNT } else { PATIENT_DISCOUNT };
        self.discount.unwrap_or(usual)
    }

    /// Discount per frame at the database's rate.
    pub(in crate::policy) fn discount_at(&self, rate_hz: f64) -> f64 {
        self.discount().powf(30.0 / rate_hz)
    }

    /// Reward and costs of actions, with the kind's defaults.
    pub(in crate::policy) fn make_reward(
        &self,
        form: RewardForm,
        kernel: KernelConfig,
        scale: f64,
        gain: f64,
    ) -> Result<(Reward, ActionCosts)> {
        let combine = if form == RewardForm::Max { COMBINE_MAX } else { COMBINE_SUM };
        let kernel = match self.kernel.unwrap_or(kernel) {
            KernelConfig::Exponential => KERNEL_EXPONENTIAL,
            KernelConfig::Within => KERNEL_WITHIN,
            KernelConfig::Linear => KERNEL_LINEAR,
        };
        let record = RewardRecord::new(combine, kernel, self.scale.unwrap_or(scale) as f32);
        let (offset, gain) = (self.offset as f32, self.gain.unwrap_or(gain) as f32);
        let per_s = -30.0 * self.discount().ln();
        let usual_s = if self.kind == BehaviourKind::Approach && gain > 0.0 { TRANSITION_COST_S } else { 0.0 };
        let transition_s = self.transition_cost_s.unwrap_or(usual_s);
        let costs = self.costs();
        for (key, cost) in [("transition_cost_s", transition_s), ("costs", costs.to_array().iter().sum())] {
            if cost > 0.0 && gain <= 0.0 {
                return Err(BuildError::key(key, format!("expected 0 with a gain of {gain}")));
            }
        }
        let has_costs = costs != CostsConfig::NONE;
        // What a distance of 1 rad costs (s).
        let unit_s = if has_costs && transition_s == 0.0 { 1.0 } else { transition_s };
        let (transition_cost, own_errors) = ((per_s * unit_s) as f32, u32::from(has_costs));
        let costs = ActionCosts {
            transition: f64::from(u8::from(transition_s > 0.0)),
            traits: costs.to_array().map(|c| if has_costs { c / unit_s } else { 0.0 }),
        };
        let reward = Reward::new(RewardRecord { offset, gain, transition_cost, own_errors, ..record });
        Ok((reward.map_err(|e| BuildError::key("scale", e))?, costs))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_keys_that_its_kind_does_not_read() {
        let keys = [
            ("centre = \"hits\"", "approach"),
            ("stand_bonus = 0.5", "approach"),
            ("stand_speed = 0.5", "approach"),
            ("hits = [\"kick\"]", "throw_punches"),
            ("joints = [\"left_hand\"]", "throw_punches"),
            ("point = \"hips\"", "evade"),
            ("height = 1.5", "evade"),
        ];
        for (line, read_by) in keys {
            for kind in ["approach", "throw_punches", "evade"] {
                let config: PolicyBehaviourConfig =
                    toml::from_str(&format!("name = \"b\"\nkind = \"{kind}\"\n{line}")).unwrap();
                let key = line.split(' ').next().unwrap();
                match config.check() {
                    Ok(()) => assert_eq!(kind, read_by, "{line}"),
                    Err(e) => {
                        let expected = format!("{key}: the kind `{kind}` has no such key; leave it out");
                        assert!(kind != read_by && e.to_string().contains(&expected), "{e}");
                    }
                }
            }
        }
    }

    #[test]
    fn refuses_names_and_heights_that_are_none() {
        let message = |c: PolicyBehaviourConfig| c.check().unwrap_err().to_string();
        for name in ["", "  "] {
            assert!(
                message(PolicyBehaviourConfig { name: name.into(), ..PolicyBehaviourConfig::default() })
                    .starts_with("name: ")
            );
        }
        for height in [f64::NAN, f64::INFINITY, 11.0, -11.0] {
            let config = PolicyBehaviourConfig {
                kind: BehaviourKind::Evade,
                height: Some(height),
                ..PolicyBehaviourConfig::default()
            };
            assert!(message(config).starts_with("height: "), "{height}");
        }
    }
}
