//! Dependence of steps on walking speed and turning.

/// Shape of a step: its length and its timing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepShape {
    /// Distance from foot to foot along the path (m).
    pub length: f64,
    /// Time from landing to landing (s).
    pub period: f64,
    /// Time on both feet at the beginning of the step (s, < period).
    pub double_support: f64,
}

impl StepShape {
    /// Time in the air (s).
    pub fn swing(&self) -> f64 {
        self.period - self.double_support
    }
}

/// Step length over cadence, nearly the same for an adult at every comfortable speed (m/(steps/min)).
const WALK_RATIO: f64 = 0.0061;

/// Step of level, straight walking at a speed.
///
/// - `speed`: (m/s, > 0)
///
/// # Source
/// The constant walk ratio is Sekiya and Nagasaki 1998, *Reproducibility of the walking patterns of normal young
/// adults*; the share of stance in a stride falls with speed as in Murray 1967, *Gait as a total pattern of movement*
/// (66 % at 0.6 m/s, 62 % at 1.3 m/s, 59 % at 1.8 m/s). Differs: stance ends here when the ball of the foot leaves the
/// ground, 5 % of a stride before the tip of the toes.
pub fn step_at(speed: f64) -> StepShape {
    let length = (60.0 * speed * WALK_RATIO).sqrt();
    let period = length / speed;
    let stance = (0.642 - 0.055 * speed).clamp(0.552, 0.64);
    StepShape { length, period, double_support: (2.0 * stance - 1.0) * period }
}

/// Step of walking at a speed through a turn of `turn` radians a step: shorter and a little slower.
pub fn turning_step_at(speed: f64, turn: f64) -> StepShape {
    let sharpness = (turn.abs() / 0.8).min(1.0);
    let straight = step_at(speed);
    let period = straight.period * (1.0 + 0.06 * sharpness);
    StepShape {
        length: straight.length * (1.0 - 0.45 * sharpness),
        period: period.min(0.68),
        double_support: straight.double_support.min(0.18),
    }
}

/// Step of turning in place. Larger angles take a little longer.
pub fn pivot_step(turn: f64) -> StepShape {
    StepShape { length: 0.0, period: 0.54 + 0.06 * turn.abs().min(1.2), double_support: 0.15 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn steps_add_up_to_the_speed(v in 0.5f64..2.0) {
            let s = step_at(v);
            prop_assert!((s.length / s.period - v).abs() < 1e-12);
            prop_assert!(s.double_support > 0.08 * s.period && s.double_support < 0.4 * s.period);
        }

        #[test]
        fn faster_walking_takes_longer_quicker_steps(v in 0.5f64..1.9) {
            let (a, b) = (step_at(v), step_at(v + 0.1));
            prop_assert!(b.length > a.length && b.period < a.period && b.double_support < a.double_support);
        }
    }

    #[test]
    fn comfortable_walking_is_as_published() {
        let s = step_at(1.3);
        assert!((s.length - 0.69).abs() < 0.01);
        assert!((60.0 / s.period - 113.0).abs() < 1.0);
    }
}
