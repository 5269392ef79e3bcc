//! Moving to a target and staying there.

use super::super::config::{CentreConfig, KernelConfig, PolicyBehaviourConfig, RewardForm};
use super::{super::model::SegmentMotion, BehaviourSpec, BendLimit, PolicyBehaviour, throw_punches::SCALE};
use glam::Vec2;
use throng_core::Planar;
use throng_core::policy::{RegionRecord, SegmentRecord};
use throng_motion::error::{BuildError, Result, ensure};

/// Behaviour of moving to the target and staying there.
///
/// The default reward is the discounted *time* spent near: (1 - discount) * sum over the action's frames t of
/// discount^t * exp(-distance(t) / scale), a little more for a standing character. Standing on the target for ever is
/// then worth exactly 1, for any lengths of actions. Turning on the spot is not standing. Lee and Lee (2004), equation
/// 5, reward each *action* once, by its best moment; an optimal policy then prefers many short actions to few long
/// ones, and has no reason to stand. [`RewardForm::Max`] gives that form.
///
/// Either is evaluated at four moments: start, one third, two thirds, end. For the sum, the distance's kernel is taken
/// as linear in time between them, which gives four weights that include discount and standing. p(t) is the root's path
/// over ground, or with [`CentreConfig::Hits`] that of the centroid of the effective hitting points, as in Lee and Lee.
#[derive(Clone, Debug)]
pub struct Approach {
    config: PolicyBehaviourConfig,
    form: RewardForm,
    /// Properties, without the name.
    spec: BehaviourSpec<'static>,
    rate_hz: f64,
}

impl Approach {
    /// - `rate_hz`: of the database (Hz, > 0).
    /// - `hit_centre`: centroid of the effective hitting points in the character's frame (x, z), if there are any
    ///   (m).
    ///
    /// # Errors
    /// [`BuildError::Key`] names the key out of its range.
    pub fn new(config: &PolicyBehaviourConfig, rate_hz: f64, hit_centre: Option<Vec2>) -> Result<Self> {
        let c = config;
        c.check()?;
        let form = c.reward.unwrap_or(RewardForm::Integral);
        ensure(form != RewardForm::Sum, || BuildError::key("reward", "the kind `approach` has `integral` and `max`"))?;
        let centre = match c.centre {
            CentreConfig::Root => Vec2::ZERO,
            CentreConfig::Place([x, z]) if x.abs() < 100.0 && z.abs() < 100.0 => Vec2::new(x as f32, z as f32),
            CentreConfig::Place(_) => return Err(BuildError::key("centre", "expected two lengths below 100 m")),
            CentreConfig::Hits => {
                let why =
                    "the database has no effective hits. Add clips with blows, lower `annotate.hits`, or choose `root`";
                hit_centre.ok_or_else(|| BuildError::key("centre", why))?
            }
        };
        let (reward, costs) = c.make_reward(form, KernelConfig::Exponential, 1.5, 1.0)?;
        let (grid, region) = (c.grid.make_polar()?, region_of(c, centre)?);
        let spec = BehaviourSpec::new("", grid, reward, c.discount_at(rate_hz));
        let bend = BendLimit { rad_per_m: c.bend_rad_per_m(), rate_hz };
        let spec = BehaviourSpec { region, centre, costs, adaptive: c.grid.adaptive, bend, ..spec };
        Ok(Self { config: config.clone(), form, spec, rate_hz })
    }

    /// Position at a moment of the point that is to reach the target, relative to its start (m).
    fn place_at(&self, motion: &SegmentMotion, moment: f32) -> Vec2 {
        let heading = motion.path[(moment.round() as usize).min(motion.path.len() - 1)].heading;
        let turned = Planar::new(0.0, 0.0, heading).transform_point(self.spec.centre);
        motion.position_at(moment) + turned - self.spec.centre
    }

    /// Weights of the four moments: discounted time, shared between the two moments around each frame.
    fn time_weights(&self, motion: &SegmentMotion) -> [f32; 4] {
        let c = &self.config;
        let mut weights = [0.0f64; 4];
        let mut factor = (1.0 - self.spec.discount) / (1.0 + c.stand_bonus);
        for frame in 0..motion.num_frames as usize {
            let slowness = (-(motion.speed(frame, self.rate_hz) / c.stand_speed).powi(2)).exp();
            let weight = factor * (1.0 + c.stand_bonus * slowness);
            let moment = 3.0 * frame as f64 / f64::from(motion.num_frames);
            let low = moment as usize;
            weights[low] += weight * (1.0 - (moment - low as f64));
            weights[low + 1] += weight * (moment - low as f64);
            factor *= self.spec.discount;
        }
        weights.map(|w| w as f32)
    }
}

/// Active region: that of the config, else all targets, or those beyond the reach of landing blows. Within that reach
/// blows count: a reward for being there would give no reason to leave a pose from which no blow comes soon.
fn region_of(c: &PolicyBehaviourConfig, centre: Vec2) -> Result<RegionRecord> {
    let mut region = c.region.make_region(false, RegionRecord::EVERYWHERE)?;
    if c.centre == CentreConfig::Hits && c.region.distance_m.is_none() {
        region.distance[0] = centre.length() + SCALE as f32;
    }
    Ok(region)
}

impl PolicyBehaviour for Approach {
    fn spec(&self) -> BehaviourSpec<'_> {
        BehaviourSpec { name: &self.config.name, ..self.spec }
    }

    fn sample(&self, _segment: usize, motion: &SegmentMotion, record: &mut SegmentRecord) {
        let n = motion.num_frames as f32;
        let (a, b) = (self.place_at(motion, n / 3.0), self.place_at(motion, 2.0 * n / 3.0));
        record.inner = [a.x, a.y, b.x, b.y];
        record.weights = match self.form {
            RewardForm::Integral => self.time_weights(motion),
            _ => [0.0, 1.0, 2.0, 3.0].map(|k| self.spec.discount.powf(f64::from(motion.num_frames) * k / 3.0) as f32),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::super::segment_records;
    use super::*;
    use crate::policy::config::CostsConfig;

    fn straight(num_frames: u32, speed: f32) -> SegmentMotion {
        let length = speed * num_frames as f32 / 30.0;
        SegmentMotion {
            end: 0,
            num_frames,
            displacement: Planar::new(0.0, length, 0.0),
            path: (0..=num_frames).map(|f| Planar::new(0.0, length * f as f32 / num_frames as f32, 0.0)).collect(),
        }
    }

    fn record(config: &PolicyBehaviourConfig, motion: &SegmentMotion) -> (Approach, SegmentRecord) {
        let b = Approach::new(config, 30.0, None).expect("a valid behaviour");
        let r = segment_records(&b, std::slice::from_ref(motion))[0];
        (b, r)
    }

    #[test]
    fn standing_on_the_target_is_paid_by_time_alone() {
        for n in [1, 2, 7, 30, 200] {
            let (b, r) = record(&PolicyBehaviourConfig::default(), &straight(n, 0.0));
            let reward = b.spec().reward.of_segment::<true>(&r, glam::Vec3::ZERO, 1.0, 0.0);
            let value = f64::from(reward) / (1.0 - b.spec().discount.powi(n as i32));
            assert!((value - 1.0).abs() < 1e-5, "{n} frames: {value}");
        }
    }

    #[test]
    fn four_moments_come_close_to_the_sum_over_all_frames() {
        let config = PolicyBehaviourConfig { stand_bonus: 0.0, ..PolicyBehaviourConfig::default() };
        for (n, speed) in [(5, 1.4f32), (20, 1.4), (40, 1.4), (12, 3.0)] {
            let motion = straight(n, speed);
            let (b, r) = record(&config, &motion);
            for z in [-3.0f32, 0.3, 1.0, 2.0, 6.0] {
                let target = glam::Vec3::new(0.4, 0.0, z);
                let [_, _, end] = r.target_after(target);
                let got = f64::from(b.spec().reward.of_segment::<true>(
                    &r,
                    target,
                    b.spec().reward.kernel(target.length()),
                    end,
                ));
                let exact: f64 = (0..n)
                    .map(|f| {
                        let d = motion.position_at(f as f32).distance(Vec2::new(0.4, z));
                        (1.0 - b.spec().discount) * b.spec().discount.powi(f as i32) * f64::from(-d / 1.5).exp()
                    })
                    .sum();
                assert!((got - exact).abs() < 0.06 * exact, "{n} frames, {z} m: {got} {exact}");
            }
        }
    }

    #[test]
    fn a_grid_around_a_centre_sees_the_target_from_there() {
        let turning = |f: u32| Planar::new(0.02 * f as f32, 0.05 * f as f32, 0.06 * f as f32);
        let path: Vec<Planar> = (0..=12).map(turning).collect();
        let motion = SegmentMotion { end: 0, num_frames: 12, displacement: path[12], path };
        let config = PolicyBehaviourConfig { centre: CentreConfig::Hits, ..PolicyBehaviourConfig::default() };
        let centre = Vec2::new(0.1, 0.7);
        let b = Approach::new(&config, 30.0, Some(centre)).expect("a valid behaviour");
        let r = segment_records(&b, std::slice::from_ref(&motion))[0];
        let target = Vec2::new(-0.6, 1.9);
        let seen = target - centre;
        let [x, z, distance] = r.target_after(glam::Vec3::new(seen.x, 0.0, seen.y));
        let after = motion.displacement.inverse_transform_point(target) - centre;
        assert!(Vec2::new(x, z).distance(after) < 1e-5 && (distance - after.length()).abs() < 1e-5);
        for (k, moment) in [4, 8].into_iter().enumerate() {
            let place = motion.path[moment].transform_point(centre);
            let inner = Vec2::new(r.inner[2 * k], r.inner[2 * k + 1]);
            assert!((inner.distance(seen) - place.distance(target)).abs() < 1e-5, "moment {moment}");
        }
        let counts = |z: f32| b.spec().region.contains(glam::Vec3::new(0.0, 1.5, z));
        assert!(counts(1.1) && !counts(1.0) && !counts(0.1), "blows reach 0.71 m, and 0.3 m beyond");
        assert!(Approach::new(&config, 30.0, None).expect_err("no hits").to_string().contains("annotate.hits"));
    }

    #[test]
    fn discount_follows_the_rate() {
        // Who pays for motion is more patient.
        for (costs, discount) in [(Some(CostsConfig::NONE), 0.985f64), (None, 0.996)] {
            let config = PolicyBehaviourConfig { costs, ..PolicyBehaviourConfig::default() };
            let at = |rate| Approach::new(&config, rate, None).expect("a valid behaviour").spec().discount;
            assert!((at(15.0) - discount.powi(2)).abs() < 1e-12 && (at(60.0).powi(2) - discount).abs() < 1e-12);
        }
    }

    #[test]
    fn refuses_numbers_out_of_range_by_name() {
        let config = PolicyBehaviourConfig { discount: Some(1.0), ..PolicyBehaviourConfig::default() };
        let message = Approach::new(&config, 30.0, None).expect_err("out of range").to_string();
        assert!(message.starts_with("discount: ") && message.contains("0.9999"), "{message}");
        let mut config = PolicyBehaviourConfig::default();
        config.grid.rings = Some(0);
        let message = Approach::new(&config, 30.0, None).expect_err("out of range").to_string();
        assert!(message.contains("grid.rings: expected 2 to 4096, found 0"), "{message}");
    }
}
