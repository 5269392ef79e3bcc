//! Vertical bounce of a runner's body with the steps, in free fall while no foot is on the ground.

use std::f64::consts::PI;

/// Standard gravity (m/s^2).
pub const GRAVITY: f64 = 9.81;

/// Vertical motion over one step. The ground pushes with half a sine wave during the contact, which comes first.
///
/// # Source
/// Blickhan 1989, *The spring-mass model for running and hopping*: a stiff spring pushes with half a sine wave. Its
/// strength follows from the impulse, which is that of gravity over the whole step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounce {
    /// Time of a step (s).
    pub period: f64,
    /// Time of a contact (s, > 0, < period).
    pub contact: f64,
}

impl Bounce {
    /// Height above that at landing (m).
    ///
    /// - `t`: since landing (s, 0 to period).
    pub fn height(&self, t: f64) -> f64 {
        let (period, contact) = (self.period, self.contact);
        // The landing speed equals the take-off speed: that of half a flight in gravity.
        let landing = -0.5 * GRAVITY * (period - contact);
        let free = landing * t - 0.5 * GRAVITY * t * t;
        // The push, integrated twice.
        let on = t.min(contact);
        let pushed = 0.5 * GRAVITY * period * (on - contact / PI * (PI * on / contact).sin());
        free + pushed + GRAVITY * period * (t - on)
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::signal::PieceEnd;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn falls_freely_in_flight_and_comes_back(period in 0.25f64..0.5, share in 0.4f64..0.95) {
            let b = Bounce { period, contact: share * period };
            prop_assert!(b.height(period).abs() < 1e-9 && b.height(0.0).abs() < 1e-12);
            let flight = period - b.contact;
            let air = PieceEnd::from_function(|t| b.height(t), b.contact + 0.5 * flight);
            prop_assert!((air.acceleration + GRAVITY).abs() < 1e-3 && air.rate.abs() < 1e-6);
            let up = PieceEnd::from_function(|t| b.height(t), b.contact);
            let down = PieceEnd::from_function(|t| b.height(t), 2e-4);
            prop_assert!((up.rate - 0.5 * GRAVITY * flight).abs() < 1e-3);
            prop_assert!((down.rate + 0.5 * GRAVITY * flight).abs() < 0.01);
        }
    }

    #[test]
    fn bodies_sink_on_the_ground_by_as_much_as_runners_do() {
        let b = Bounce { period: 0.345, contact: 0.22 };
        let deepest = -b.height(0.11);
        assert!((0.03..0.08).contains(&deepest), "{deepest}");
        assert!((0.01..0.03).contains(&b.height(0.5 * (0.345 + 0.22))));
    }
}
