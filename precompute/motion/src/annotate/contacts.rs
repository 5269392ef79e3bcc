//! Foot contacts by height and speed, with hysteresis.

use crate::clip::{Clip, runs_where};
use crate::error::{Result, check_ranges};
use glam::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use throng_base::thresholds::{FOOT_CONTACT_M, FOOT_FREE_MPS, FOOT_PLANTED_MPS, REFERENCE_LEG_M};
use throng_core::{Contacts, Joint, Skeleton};

/// Thresholds by which a heel or toe counts as planted.
///
/// A run of frames below the `off` thresholds is a contact when at least one of its frames is below the `on`
/// thresholds. Lengths are for legs of 0.83 m and scale with the skeleton's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ContactConfig {
    /// Height above the joint's own floor below which a contact begins (m, <= height_off).
    pub height_on: f32,
    /// Height above the joint's own floor above which a contact ends (m).
    pub height_off: f32,
    /// Speed below which a contact begins, for a body in place (m/s, <= speed_off).
    pub speed_on: f32,
    /// Speed above which a contact ends, for a body in place (m/s).
    pub speed_off: f32,
    /// Contacts begin and end with a frame whose vertical speed is below this: a heel that rises while the toe still
    /// stands is no longer planted.
    /// (m/s)
    pub vertical_speed_off: f32,
    /// Share of the hips' speed over the ground that is added to both speeds: tracked feet slide more the faster they are put
    /// down.
    pub speed_share: f32,
    /// Contacts that last less are dropped (s).
    pub min_duration: f32,
    /// Shorter pauses within a contact are filled (s).
    pub max_gap: f32,
    /// Shape of the ground under the feet.
    pub ground: GroundShape,
}

impl Default for ContactConfig {
    fn default() -> Self {
        Self {
            height_on: FOOT_CONTACT_M[0],
            height_off: FOOT_CONTACT_M[1],
            speed_on: FOOT_PLANTED_MPS,
            speed_off: FOOT_FREE_MPS,
            vertical_speed_off: FOOT_PLANTED_MPS,
            speed_share: 0.1,
            min_duration: 0.09,
            max_gap: 0.07,
            ground: GroundShape::Auto,
        }
    }
}

impl ContactConfig {
    /// Checks every number against its range.
    ///
    /// # Errors
    /// [`crate::error::BuildError::Key`] names the first one out of it.
    pub fn check(&self) -> Result<()> {
        check_ranges([
            ("height_on", self.height_on, 0.0, self.height_off.into()),
            ("height_off", self.height_off, 0.0, 10.0),
            ("speed_on", self.speed_on, 0.0, self.speed_off.into()),
            ("speed_off", self.speed_off, 0.0, 100.0),
            ("vertical_speed_off", self.vertical_speed_off, 0.0, 100.0),
            ("speed_share", self.speed_share, 0.0, 10.0),
            ("min_duration", self.min_duration, 0.0, 60.0),
            ("max_gap", self.max_gap, 0.0, 60.0),
        ])
    }
}

/// Shape of the ground under the feet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum GroundShape {
    /// Uneven where standing feet are found at heights more than 0.1 m apart, flat otherwise; by clip.
    #[default]
    Auto,
    /// Level: heights count from one floor per joint and clip.
    Flat,
    /// Steps, slopes and things stood on: heights count from the joint's lowest point within a third of a second,
    /// so it is the speed that decides. A foot held still in the air then looks planted.
    Uneven,
}

/// Half width of the window over which the local floor on uneven ground is found (s).
const LOCAL_WINDOW: f32 = 0.33;

/// Spread of the heights of standing feet from which ground is uneven (m).
const UNEVEN_SPREAD: f32 = 0.1;

/// Heels and toes, in the order of the bits of [`Contacts`].
pub const FOOT_PARTS: [(Joint, Contacts); 4] = [
    (Joint::LeftFoot, Contacts::LEFT_HEEL),
    (Joint::LeftToe, Contacts::LEFT_TOE),
    (Joint::RightFoot, Contacts::RIGHT_HEEL),
    (Joint::RightToe, Contacts::RIGHT_TOE),
];

/// Contacts of every frame (num_frames).
pub fn detect_contacts(clip: &Clip, skeleton: &Skeleton, cfg: &ContactConfig) -> Vec<Contacts> {
    let scale = skeleton.leg_length() / REFERENCE_LEG_M;
    let rest = skeleton.rest_positions();
    let tracks = tracks(clip, skeleton);
    let path: Vec<Vec3> = clip.root_positions.iter().map(|p| p.with_y(0.0)).collect();
    let pace = speeds(&path, clip.rate_hz);
    let slow = FOOT_FREE_MPS * scale;
    let uneven = match cfg.ground {
        GroundShape::Flat => false,
        GroundShape::Uneven => true,
        GroundShape::Auto => height_spread(&tracks, slow) > UNEVEN_SPREAD * scale,
    };
    let mut out = vec![Contacts::NONE; clip.num_frames()];
    for (track, (joint, bit)) in tracks.iter().zip(FOOT_PARTS) {
        let floor = if uneven {
            local_floor(track, (LOCAL_WINDOW as f64 * clip.rate_hz).round() as usize)
        } else {
            vec![flat_floor(track, slow, rest[joint.index()].y, 0.06 * scale); track.heights.len()]
        };
        let below = |f: usize, height: f32, speed: f32| {
            let limit = speed * scale + cfg.speed_share * pace[f];
            track.heights[f] - floor[f] < height * scale && track.speeds[f] < limit
        };
        let weak: Vec<bool> = (0..floor.len()).map(|f| below(f, cfg.height_off, cfg.speed_off)).collect();
        let strong: Vec<bool> = (0..floor.len()).map(|f| below(f, cfg.height_on, cfg.speed_on)).collect();
        let frames = |s: f32| (s as f64 * clip.rate_hz).round() as usize;
        let mut planted = hysteresis(&weak, &strong, frames(cfg.min_duration), frames(cfg.max_gap));
        trim(&mut planted, |f| track.vertical_speeds[f] < cfg.vertical_speed_off * scale);
        planted.iter().enumerate().filter(|(_, p)| **p).for_each(|(f, _)| out[f].insert(bit));
    }
    out
}

/// Height and speed of one joint over a clip.
struct JointHeights {
    heights: Vec<f32>,
    speeds: Vec<f32>,
    vertical_speeds: Vec<f32>,
}

fn tracks(clip: &Clip, skeleton: &Skeleton) -> Vec<JointHeights> {
    let body: Vec<_> = (0..clip.num_frames()).map(|f| clip.joint_positions(skeleton, f)).collect();
    let track = |(joint, _): (Joint, Contacts)| {
        let p: Vec<Vec3> = body.iter().map(|p| p[joint.index()]).collect();
        let upright: Vec<Vec3> = p.iter().map(|p| Vec3::Y * p.y).collect();
        JointHeights {
            heights: p.iter().map(|p| p.y).collect(),
            speeds: speeds(&p, clip.rate_hz),
            vertical_speeds: speeds(&upright, clip.rate_hz),
        }
    };
    FOOT_PARTS.map(track).into()
}

/// Speed at each frame by central differences, one-sided at the ends (m/s).
pub fn speeds(positions: &[Vec3], rate_hz: f64) -> Vec<f32> {
    let last = positions.len().saturating_sub(1);
    let speed = |f: usize| {
        let (a, b) = (f.saturating_sub(1), (f + 1).min(last));
        (positions[b] - positions[a]).length() * rate_hz as f32 / (b - a).max(1) as f32
    };
    (0..positions.len()).map(speed).collect()
}

/// Sorted heights of the frames in which the joint is slow.
fn slow_heights(track: &JointHeights, slow: f32) -> Vec<f32> {
    let mut h: Vec<f32> =
        track.heights.iter().zip(&track.speeds).filter(|(_, s)| **s < slow).map(|(h, _)| *h).collect();
    h.sort_by(f32::total_cmp);
    h
}

/// Height of the joint while its foot stands: low among the frames in which it is slow, or the rest height where that is
/// further than `limit` away (a foot that never stands on the ground).
fn flat_floor(track: &JointHeights, slow: f32, rest: f32, limit: f32) -> f32 {
    let h = slow_heights(track, slow);
    match h.get(h.len() / 5) {
        Some(&floor) if (floor - rest).abs() < limit => floor,
        _ => rest,
    }
}

/// The joint's lowest height within `window` frames on either side.
fn local_floor(track: &JointHeights, window: usize) -> Vec<f32> {
    let n = track.heights.len();
    let around = |f: usize| &track.heights[f.saturating_sub(window)..(f + window + 1).min(n)];
    (0..n).map(|f| around(f).iter().copied().fold(f32::INFINITY, f32::min)).collect()
}

/// Spread of the heights at which toes stand: from the 10th to the 90th percentile, the larger foot's.
fn height_spread(tracks: &[JointHeights], slow: f32) -> f32 {
    let [left, right] = [1, 3].map(|toe: usize| {
        let h = slow_heights(&tracks[toe], slow);
        if h.is_empty() { 0.0 } else { h[h.len() * 9 / 10] - h[h.len() / 10] }
    });
    left.max(right)
}

/// Runs of `weak` that hold a `strong` frame, pauses of up to `max_gap` filled, runs below `min_frames` dropped. Contacts of feet,
/// of hands and seats, and places in patches are found by it.
pub fn hysteresis(weak: &[bool], strong: &[bool], min_frames: usize, max_gap: usize) -> Vec<bool> {
    let mut out = vec![false; weak.len()];
    for run in runs_where(0..weak.len(), |f| weak[f]).into_iter().filter(|run| strong[run.clone()].contains(&true)) {
        out[run].fill(true);
    }
    for gap in runs_where(0..out.len(), |f| !out[f]) {
        if gap.start > 0 && gap.end < out.len() && gap.len() <= max_gap {
            out[gap].fill(true);
        }
    }
    for run in runs_where(0..out.len(), |f| out[f]) {
        // Runs that the clip's ends cut may have lasted longer.
        if run.len() < min_frames && run.start > 0 && run.end < out.len() {
            out[run].fill(false);
        }
    }
    out
}

/// Cuts frames that are not `still` from both ends of every run.
pub fn trim(planted: &mut [bool], still: impl Fn(usize) -> bool) {
    for run in runs_where(0..planted.len(), |f| planted[f]) {
        let kept = run.clone().position(&still).map_or(run.end, |k| run.start + k);
        let end = run.clone().rev().find(|&f| still(f)).map_or(kept, |f| f + 1);
        planted[run.start..kept].fill(false);
        planted[end..run.end].fill(false);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;
    use throng_core::NUM_JOINTS;

    #[test]
    fn runs_are_trimmed_at_their_ends_alone() {
        let mut planted = bools("0111110111");
        let still = bools("0011011000");
        trim(&mut planted, |f| still[f]);
        assert_eq!(planted, bools("0011110000"));
    }

    fn bools(s: &str) -> Vec<bool> {
        s.chars().map(|c| c == '1').collect()
    }

    #[test]
    fn hysteresis_needs_a_strong_frame_fills_gaps_and_drops_blinks() {
        let weak = "011110001110100011000";
        let stro = "001000000000100010000";
        let want = "011110000000000000000";
        assert_eq!(hysteresis(&bools(weak), &bools(stro), 3, 1), bools(want));
        let weak = "0111011100";
        assert_eq!(hysteresis(&bools(weak), &bools(weak), 3, 1), bools("0111111100"));
        assert_eq!(hysteresis(&bools("1000001"), &bools("1000001"), 3, 1), bools("1000001"));
    }

    /// A body that hops on stiff legs: stands for half a second, then is in the air for half a second.
    fn hopping(rise: f32) -> Clip {
        let s = Skeleton::default();
        let n = 120;
        let up = |f: usize| {
            let phase = (f % 30) as f32 / 30.0;
            if phase < 0.5 { 0.0 } else { rise * ((phase - 0.5) * std::f32::consts::TAU).sin() }
        };
        Clip::new(
            "hop",
            30.0,
            (0..n).map(|f| s.offsets[0] + Vec3::Y * up(f)).collect(),
            vec![Quat::IDENTITY; n * NUM_JOINTS],
        )
    }

    #[test]
    fn feet_touch_while_they_stand_and_not_in_the_air() {
        let c = detect_contacts(&hopping(0.3), &Skeleton::default(), &ContactConfig::default());
        let all = Contacts(15);
        for (f, c) in c.iter().enumerate() {
            match f % 30 {
                1..=13 => assert_eq!(*c, all, "frame {f}"),
                17..=28 => assert_eq!(*c, Contacts::NONE, "frame {f}"),
                _ => {}
            }
        }
    }

    #[test]
    fn standing_still_is_contact_throughout() {
        let c = detect_contacts(&hopping(0.0), &Skeleton::default(), &ContactConfig::default());
        assert!(c.iter().all(|c| *c == Contacts(15)));
    }

    #[test]
    fn a_step_up_keeps_its_contacts() {
        let mut clip = hopping(0.3);
        for p in &mut clip.root_positions[60..] {
            p.y += 0.25;
        }
        let c = detect_contacts(&clip, &Skeleton::default(), &ContactConfig::default());
        assert_eq!(c[95], Contacts(15));
        assert_eq!(c[5], Contacts(15));
        assert_eq!(c[82], Contacts::NONE);
    }
}
