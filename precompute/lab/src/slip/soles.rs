//! Slip of feet that roll: from the heel over the flat foot to the ball.

use super::Meter;
use glam::{Vec2, Vec3};
use throng_runtime::Contacts;

/// The bottom of the heel and the ball of the left and of the right foot, in the world (m).
pub type Soles = [[Vec3; 2]; 2];

/// Contacts of the feet, as [`Soles`] has them.
const FEET: [Contacts; 2] = [Contacts::LEFT, Contacts::RIGHT];

/// Measures how fast planted feet move over the ground.
///
/// A foot that rolls or turns always has an end that stands, so its slip is the speed, over the ground, of the slower of
/// heel and ball. A foot counts where any part of it was planted before and is now.
pub type SoleMeter = Meter<Soles>;

impl SoleMeter {
    /// Looks at all characters after a step of `dt_s`.
    ///
    /// - `character`: contacts of a character, and where its soles are.
    pub fn observe(&mut self, dt_s: f32, character: impl Fn(usize) -> (Contacts, Soles)) {
        for (c, before) in self.before.iter_mut().enumerate() {
            let (contacts, now) = character(c);
            let (was, were) = std::mem::replace(before, (now, contacts));
            for (side, foot) in FEET.into_iter().enumerate() {
                if dt_s > 0.0 && contacts.any(foot) && were.any(foot) {
                    let moved = |end: usize| over_ground(now[side][end] - was[side][end]).length();
                    self.speeds.add(moved(0).min(moved(1)) / dt_s);
                }
            }
        }
    }
}

fn over_ground(v: Vec3) -> Vec2 {
    Vec2::new(v.x, v.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Slip of a left foot whose heel and ball move so fast; the right one is always in the air.
    fn slip(heel: Vec3, ball: Vec3, contacts: Contacts) -> SoleMeter {
        let mut meter = SoleMeter::new(1);
        for step in 0..3 {
            let at = |v: Vec3| v * (0.1 * step as f32);
            meter.observe(0.1, |_| (contacts, [[at(heel), at(ball)], [at(Vec3::X * 9.0); 2]]));
        }
        meter
    }

    #[test]
    fn a_foot_slips_as_fast_as_its_slower_end() {
        let sliding = slip(Vec3::X * 0.2, Vec3::Z * 0.3, Contacts::LEFT_HEEL);
        assert_eq!(sliding.samples(), 2);
        assert!((sliding.mean_mps() - 0.2).abs() < 1e-6 && (sliding.p95_mps() - 0.2).abs() < 1e-3);
        assert!(slip(Vec3::X, Vec3::ZERO, Contacts::LEFT_TOE).p95_mps() < 1e-3, "it turns over its ball");
        assert!(slip(Vec3::Y, Vec3::X, Contacts::LEFT_TOE).p95_mps() < 1e-3, "a heel that rises does not slip");
        assert_eq!(slip(Vec3::X, Vec3::X, Contacts::RIGHT_HEEL).samples(), 2);
        assert_eq!(slip(Vec3::X, Vec3::X, Contacts::NONE).samples(), 0);
    }

    #[test]
    fn steps_that_are_no_neighbours_do_not_count() {
        let mut meter = slip(Vec3::X, Vec3::X, Contacts::LEFT);
        meter.forget_step();
        meter.observe(0.1, |_| (Contacts::LEFT, Soles::default()));
        assert_eq!(meter.samples(), 2);
    }
}
