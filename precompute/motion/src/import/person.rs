//! Refuses clips of sizes that no person has, or far from the origin.

use super::{RoleMap, body_height, content_error};
use crate::{ImportError, raw::RawClip};
use throng_core::Joint;

/// Heights of people, small children included (m).
pub(super) const HEIGHTS: std::ops::RangeInclusive<f32> = 0.85..=2.5;
/// Heights accepted where the config gives `metres_per_unit` (m).
const HEIGHTS_OF_GIVEN_UNIT: std::ops::RangeInclusive<f32> = 0.4..=3.5;
/// Length below which legs are not legs (m).
const SHORTEST_LEG_M: f32 = 0.1;
/// Height of an adult (m).
pub(super) const ADULT_HEIGHT: f32 = 1.75;
/// Largest distance from the origin (m).
const FARTHEST_M: f32 = 5e3;

/// Refuses a clip in metres whose size is no person's, and offers the unit that would make it one.
///
/// - `is_meant`: true where a config names the unit, so that small and large bodies are intended.
///
/// # Errors
/// [`ImportError::Content`] naming the height or the joint.
pub fn check_size(clip: &RawClip, roles: &RoleMap, metres_per_unit: f64, is_meant: bool) -> Result<(), ImportError> {
    use Joint::*;
    let world = clip.world(0);
    for (thigh, shin, foot) in [(LeftThigh, LeftShin, LeftFoot), (RightThigh, RightShin, RightFoot)] {
        let at = |role| roles.get(role).map(|j| (world[j].0, &clip.joints[j].name));
        let (Some((hip, name)), Some((knee, _)), Some((ankle, _))) = (at(thigh), at(shin), at(foot)) else { continue };
        let length = hip.distance(knee) + knee.distance(ankle);
        if length.is_nan() || length < SHORTEST_LEG_M {
            let message = format!("joint {name}: expected a leg longer than {SHORTEST_LEG_M} m, found {length} m");
            let help = "Check `metres_per_unit` and which joints the profile names as thighs, shins and feet";
            return Err(content_error(&clip.path, message, help));
        }
    }
    let height = body_height(clip, roles);
    if HEIGHTS.contains(&height) || (is_meant && HEIGHTS_OF_GIVEN_UNIT.contains(&height)) {
        return Ok(());
    }
    let message = format!("at {metres_per_unit} m a unit the body is {height:.2} m tall, which no person is");
    let right = rounded(metres_per_unit * f64::from(ADULT_HEIGHT / height));
    let help = match height > 0.0 && height.is_finite() {
        true => format!(
            "`--metres-per-unit {right}`, or `import.metres_per_unit`, makes it {ADULT_HEIGHT} m tall; leave out what is no person"
        ),
        false => "check the lengths of its segments".to_owned(),
    };
    Err(content_error(&clip.path, message, &help))
}

/// Refuses a clip in metres that is so far from the origin that single precision would show.
///
/// - `frames`: frames that are checked.
///
/// # Errors
/// [`ImportError::Content`] naming the frame and how far it is.
pub fn check_place(
    clip: &RawClip,
    roles: &RoleMap,
    frames: impl IntoIterator<Item = usize>,
) -> Result<(), ImportError> {
    let Some(hips) = roles.get(Joint::Hips) else { return Ok(()) };
    let away = |frame: usize| (frame, clip.world_of(hips, frame).0.length());
    let far = frames.into_iter().map(away).find(|f| f.1 > FARTHEST_M);
    let Some((frame, away)) = far else { return Ok(()) };
    let message = format!("in frame {frame} the hips are {away:.0} m from the origin, expected at most {FARTHEST_M} m");
    let help = "Move the motion to the origin in the program that wrote it, and export it again";
    Err(content_error(&clip.path, message, help))
}

/// Three significant digits.
pub(super) fn rounded(value: f64) -> f64 {
    let digits = 10f64.powf(2.0 - value.abs().log10().floor());
    (value * digits).round() / digits
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_offered_with_three_digits() {
        for (value, want) in [(0.0123456, 0.0123), (1.0 / 3.0, 0.333), (254.49, 254.0)] {
            assert!((rounded(value) - want).abs() < 1e-9 * want, "{}", rounded(value));
        }
    }
}
