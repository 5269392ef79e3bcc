//! Behaviours: a grid of target cells and a reward (003 sections 4.1 and 6).

use super::config::{ApproachReward, BehaviourConfig};
use super::model::SegmentMotion;
use crate::error::BuildError;
use throng_runtime::policy::{
    COMBINE_MAX, COMBINE_SUM, KERNEL_EXPONENTIAL, PolicyError, Reward, RewardRecord, SegmentRecord, TargetGrid,
};

/// What a policy is solved for.
///
/// The reward is a function the runtime evaluates too, for any target: a weighted kernel of the distances to four
/// samples of the action's motion. A behaviour says which samples and weights a segment has.
pub trait Behaviour: Sync {
    /// Name of the policy; unique in a bundle.
    fn name(&self) -> &str;
    /// Cells of the target.
    fn grid(&self) -> TargetGrid;
    /// Kernel of the distance, and how samples are combined.
    fn reward(&self) -> Reward;
    /// Discount per frame at the database rate. [Limit: > 0, < 1]
    fn discount(&self) -> f64;
    /// Sets the reward's samples: `inner`, `heights` and `weights` of `record`; the rest is set already.
    ///
    /// - `segment`: its index, for what a behaviour knows of segments beyond their path.
    fn sample(&self, segment: usize, motion: &SegmentMotion, record: &mut SegmentRecord);
}

/// Come to the target and stay there.
///
/// The default reward is the discounted *time* spent near: (1 - discount) * sum over the action's frames t of
/// discount^t * exp(-distance(t) / scale), a little more where the character stands. Standing on the target for ever
/// is then worth exactly 1, whatever the lengths of the actions that do it. Turning on the spot is not standing. The paper pays each *action* once, by its
/// best moment (eq. 5); an optimal policy then prefers many short actions to few long ones, and has no reason to
/// stand. [`ApproachReward::Max`] gives that form.
///
/// Either is evaluated at four moments: start, one third, two thirds, end. For the sum, the distance's kernel is
/// taken as linear in time between them, which gives four weights that already hold discount and standing. Differs
/// from the paper also in p(t): the root's ground path instead of the centre of the effective hitting points.
#[derive(Clone, Debug)]
pub struct Approach {
    config: BehaviourConfig,
    grid: TargetGrid,
    reward: Reward,
    discount: f64,
    rate_hz: f64,
}

impl Approach {
    /// - `rate_hz`: of the database. [Unit: Hz] [Limit: > 0]
    ///
    /// # Errors
    /// [`BuildError::Config`] names the key that is out of its range.
    pub fn new(config: &BehaviourConfig, rate_hz: f64) -> Result<Self, BuildError> {
        let c = config;
        for (key, value, low, high) in [
            ("discount", c.discount, 0.5, 0.9999),
            ("scale", c.scale, 1e-3, 1e3),
            ("stand_bonus", c.stand_bonus, 0.0, 1.0),
            ("stand_speed", c.stand_speed, 1e-3, 1e3),
        ] {
            if !(low..=high).contains(&value) {
                let message = format!("behaviour \"{}\", key `{key}`: {value} is not between {low} and {high}", c.name);
                return Err(BuildError::Config { message });
            }
        }
        let g = &c.grid;
        let of_key = |e: PolicyError| BuildError::Config {
            message: format!("behaviour \"{}\", key `grid`: {}", c.name, bare(&e)),
        };
        let (radius, inner, falloff) = (g.radius as f32, g.inner_spacing as f32, g.falloff as f32);
        let grid = TargetGrid::polar(g.rings, g.angles, radius, inner, falloff).map_err(of_key)?;
        let combine = if c.reward == ApproachReward::Max { COMBINE_MAX } else { COMBINE_SUM };
        let record = RewardRecord { combine, kernel: KERNEL_EXPONENTIAL, scale: c.scale as f32, reserved: 0 };
        let reward = Reward::new(record).map_err(of_key)?;
        let discount = c.discount.powf(30.0 / rate_hz);
        Ok(Self { config: config.clone(), grid, reward, discount, rate_hz })
    }

    /// Weights of the four moments: discounted time, shared between the two moments around each frame.
    fn time_weights(&self, motion: &SegmentMotion) -> [f32; 4] {
        let c = &self.config;
        let mut weights = [0.0f64; 4];
        let mut factor = (1.0 - self.discount) / (1.0 + c.stand_bonus);
        for frame in 0..motion.num_frames as usize {
            let slowness = (-(motion.speed(frame, self.rate_hz) / c.stand_speed).powi(2)).exp();
            let weight = factor * (1.0 + c.stand_bonus * slowness);
            let moment = 3.0 * frame as f64 / f64::from(motion.num_frames);
            let low = moment as usize;
            weights[low] += weight * (1.0 - (moment - low as f64));
            weights[low + 1] += weight * (moment - low as f64);
            factor *= self.discount;
        }
        weights.map(|w| w as f32)
    }
}

impl Behaviour for Approach {
    fn name(&self) -> &str {
        &self.config.name
    }

    fn grid(&self) -> TargetGrid {
        self.grid
    }

    fn reward(&self) -> Reward {
        self.reward
    }

    fn discount(&self) -> f64 {
        self.discount
    }

    fn sample(&self, _segment: usize, motion: &SegmentMotion, record: &mut SegmentRecord) {
        let n = motion.num_frames as f32;
        let (a, b) = (motion.position_at(n / 3.0), motion.position_at(2.0 * n / 3.0));
        record.inner = [a.x, a.y, b.x, b.y];
        record.weights = match self.config.reward {
            ApproachReward::Integral => self.time_weights(motion),
            ApproachReward::Max => {
                [0.0, 1.0, 2.0, 3.0].map(|k| self.discount.powf(f64::from(motion.num_frames) * k / 3.0) as f32)
            }
        };
    }
}

/// The fault without the advice to rebuild, which does not help a configuration.
fn bare(e: &PolicyError) -> String {
    let text = e.to_string();
    text.strip_suffix("; rebuild the bundle").unwrap_or(&text).trim_start_matches("policy table ").to_string()
}

/// Geometry and discount of every segment, with the samples of a behaviour.
pub fn segment_records(behaviour: &dyn Behaviour, segments: &[SegmentMotion]) -> Vec<SegmentRecord> {
    let record = |(i, motion): (usize, &SegmentMotion)| {
        let d = motion.displacement;
        let mut record = SegmentRecord {
            displacement: [d.heading.cos(), d.heading.sin(), d.x, d.z],
            discount: behaviour.discount().powi(motion.num_frames as i32) as f32,
            end: motion.end,
            ..SegmentRecord::default()
        };
        behaviour.sample(i, motion, &mut record);
        record
    };
    segments.iter().enumerate().map(record).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;
    use throng_runtime::Planar;

    fn straight(num_frames: u32, speed: f32) -> SegmentMotion {
        let length = speed * num_frames as f32 / 30.0;
        SegmentMotion {
            end: 0,
            num_frames,
            displacement: Planar::new(0.0, length, 0.0),
            path: (0..=num_frames).map(|f| Planar::new(0.0, length * f as f32 / num_frames as f32, 0.0)).collect(),
        }
    }

    fn record(config: &BehaviourConfig, motion: &SegmentMotion) -> (Approach, SegmentRecord) {
        let b = Approach::new(config, 30.0).expect("a valid behaviour");
        let r = segment_records(&b, std::slice::from_ref(motion))[0];
        (b, r)
    }

    #[test]
    fn standing_on_the_target_is_paid_by_time_alone() {
        for n in [1, 2, 7, 30, 200] {
            let (b, r) = record(&BehaviourConfig::default(), &straight(n, 0.0));
            let reward = b.reward().of_segment::<true>(&r, glam::Vec3::ZERO, 1.0, 0.0);
            let value = f64::from(reward) / (1.0 - b.discount().powi(n as i32));
            assert!((value - 1.0).abs() < 1e-5, "{n} frames: {value}");
        }
    }

    #[test]
    fn four_moments_come_close_to_the_sum_over_all_frames() {
        let config = BehaviourConfig { stand_bonus: 0.0, ..BehaviourConfig::default() };
        for (n, speed) in [(5, 1.4f32), (20, 1.4), (40, 1.4), (12, 3.0)] {
            let motion = straight(n, speed);
            let (b, r) = record(&config, &motion);
            for z in [-3.0f32, 0.3, 1.0, 2.0, 6.0] {
                let target = glam::Vec3::new(0.4, 0.0, z);
                let [_, _, end] = r.target_after(target);
                let got = f64::from(b.reward().of_segment::<true>(&r, target, b.reward().kernel(target.length()), end));
                let exact: f64 = (0..n)
                    .map(|f| {
                        let d = motion.position_at(f as f32).distance(Vec2::new(0.4, z));
                        (1.0 - b.discount()) * b.discount().powi(f as i32) * f64::from(-d / 1.5).exp()
                    })
                    .sum();
                assert!((got - exact).abs() < 0.06 * exact, "{n} frames, {z} m: {got} {exact}");
            }
        }
    }

    #[test]
    fn discount_follows_the_rate() {
        let config = BehaviourConfig::default();
        let at = |rate| Approach::new(&config, rate).expect("a valid behaviour").discount();
        assert!((at(15.0) - 0.985f64.powi(2)).abs() < 1e-12 && (at(60.0).powi(2) - 0.985).abs() < 1e-12);
    }

    #[test]
    fn refuses_numbers_out_of_range_by_name() {
        let config = BehaviourConfig { discount: 1.0, ..BehaviourConfig::default() };
        let message = Approach::new(&config, 30.0).expect_err("out of range").to_string();
        assert!(message.contains("`discount`") && message.contains("0.9999"), "{message}");
        let mut config = BehaviourConfig::default();
        config.grid.rings = 0;
        let message = Approach::new(&config, 30.0).expect_err("out of range").to_string();
        assert!(message.contains("`grid`") && !message.contains("rebuild"), "{message}");
    }
}
