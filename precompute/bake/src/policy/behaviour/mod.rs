//! Behaviours: a grid of target cells and a reward (Lee and Lee 2004, sections 4.1 and 6).

mod approach;
mod bend;
mod evade;
mod throw_punches;

use super::{AdaptiveConfig, SegmentMotion};
pub use approach::Approach;
pub use bend::BendLimit;
pub use evade::Evade;
use glam::Vec2;
use throng_core::policy::{PathRecord, RegionRecord, Reward, SegmentRecord, TargetGrid};
use throng_core::{Joint, Planar};
use throng_motion::error::{BuildError, Result};
pub use throw_punches::{SegmentHit, ThrowPunches, segment_hits};

/// Specification of a behaviour, independent of motion.
#[derive(Clone, Copy, Debug)]
pub struct BehaviourSpec<'a> {
    /// Name of the policy; unique in a bundle.
    pub name: &'a str,
    /// Cells of the target.
    pub grid: TargetGrid,
    /// Kernel of the distance, and how samples are combined.
    pub reward: Reward,
    /// Discount per frame at the database rate (> 0, < 1).
    pub discount: f64,
    /// Active region, in the character's frame.
    pub region: RegionRecord,
    /// Centre of the grid, in the character's frame: x, z (m).
    pub centre: Vec2,
    /// Memory for per-state resolutions; `None` for one grid. Not in a space-time grid.
    pub adaptive: Option<AdaptiveConfig>,
    /// Costs of actions, where the reward has errors of its own.
    pub costs: ActionCosts,
    /// How far actions are bent towards the target; counts in a polar grid around the root.
    pub bend: BendLimit,
}

/// Costs of actions, as squares of the distance of a transition that costs as much.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ActionCosts {
    /// Cost of the square of a transition's distance: 1, or 0 where transitions cost nothing.
    pub transition: f64,
    /// Costs of the traits of actions, in the order of [`super::ActionTraits`].
    pub traits: [f64; 8],
}

impl<'a> BehaviourSpec<'a> {
    /// Specification of a behaviour that is active everywhere, around the character's root, with one grid.
    pub fn new(name: &'a str, grid: TargetGrid, reward: Reward, discount: f64) -> Self {
        let (region, centre, costs) = (RegionRecord::EVERYWHERE, Vec2::ZERO, ActionCosts::default());
        Self { name, grid, reward, discount, region, centre, adaptive: None, costs, bend: BendLimit::default() }
    }
}

/// Behaviour that a policy is solved for.
///
/// The reward is a function that the runtime evaluates too, for any target: a weighted kernel of the distances to four
/// samples of the action's motion, or in a space-time grid of the distance to its path. A behaviour defines the samples
/// and weights of a segment.
pub trait PolicyBehaviour: Sync {
    /// Specification, independent of motion.
    fn spec(&self) -> BehaviourSpec<'_>;

    /// Sets the reward's samples: `inner`, `heights` and `weights` of `record`, whose other fields are set already.
    ///
    /// - `segment`: its index, for data of the behaviour beyond the segment's path.
    /// - positions are relative to [`BehaviourSpec::centre`].
    fn sample(&self, segment: usize, motion: &SegmentMotion, record: &mut SegmentRecord);

    /// Paths of the point that is to be away, in a space-time grid (num_segments, else 0).
    fn paths(&self) -> &[PathRecord] {
        &[]
    }

    /// Checks solved values: a behaviour that can never be rewarded is a mistake.
    ///
    /// # Errors
    /// [`throng_motion::error::BuildError::Stage`] with the change to make.
    fn check_values(&self, _values: &[f32]) -> Result<()> {
        Ok(())
    }
}

/// The joint of a name.
///
/// - `such`: names, for the message.
fn joint_named(key: &str, name: &str, such: &str) -> Result<Joint> {
    let why = || format!("there is no joint `{name}`; expected names such as {such}");
    Joint::from_name(name).ok_or_else(|| BuildError::key(key, why()))
}

/// Geometry and discount of every segment, with the samples of a behaviour.
pub fn segment_records(behaviour: &dyn PolicyBehaviour, segments: &[SegmentMotion]) -> Vec<SegmentRecord> {
    let BehaviourSpec { grid, centre, discount, bend, .. } = behaviour.spec();
    let to_centre = Planar::new(centre.x, centre.y, 0.0);
    let record = |(i, motion): (usize, &SegmentMotion)| {
        let d = to_centre.inverse().compose(motion.displacement.compose(to_centre));
        let mut record = SegmentRecord {
            displacement: [d.heading.cos(), d.heading.sin(), d.x, d.z],
            discount: discount.powi(motion.num_frames as i32) as f32,
            end: motion.end,
            ..SegmentRecord::default()
        };
        behaviour.sample(i, motion, &mut record);
        if grid.is_polar() {
            record.heights = bend.of_segment(motion);
        }
        record
    };
    segments.iter().enumerate().map(record).collect()
}
