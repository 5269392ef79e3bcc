//! Plausibility of contacts: how often the feet stand, and how fast they are while they do.

use super::contacts::FOOT_PARTS;
use crate::clip::Clip;
use crate::stance::{self, StanceReport};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use throng_core::{Contacts, Skeleton};

/// Statistics of a clip's contacts. Walking has about 0.6 of each foot, running about 0.35.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ContactSanity {
    /// Share of the usable frames with the left heel or toe planted (0 to 1).
    pub left_share: f32,
    /// Share of the usable frames with the right heel or toe planted (0 to 1).
    pub right_share: f32,
    /// Mean speed of heels and toes while planted (m/s).
    pub mean_speed_mps: f32,
    /// 95th percentile of that speed (m/s).
    pub p95_speed_mps: f32,
    /// Distance of standing feet from the ground, whether contacts were found there or not.
    pub stance: StanceReport,
}

/// Measures the contacts of an annotated clip over its usable frames.
///
/// The speed is that of a heel or toe between neighbouring frames that both have it planted.
pub fn contact_sanity(clip: &Clip, skeleton: &Skeleton) -> ContactSanity {
    let (mut frames, mut left, mut right) = (0usize, 0usize, 0usize);
    let (mut speeds, mut far) = (Vec::new(), Vec::new());
    for range in clip.usable_ranges() {
        let mut before = None;
        let feet = range.clone().map(|f| clip.joint_positions(skeleton, f)).map(|p| stance::FEET.map(|j| p[j.index()]));
        far.extend(stance::standing_distances(&stance::lowest_feet(feet, skeleton, clip.rate_hz), clip.rate_hz));
        for f in range {
            let Some(contacts) = clip.contacts.get(f).copied() else { break };
            frames += 1;
            left += usize::from(contacts.any(Contacts::LEFT));
            right += usize::from(contacts.any(Contacts::RIGHT));
            let at = clip.joint_positions(skeleton, f);
            if let Some((was, positions)) = before.replace((contacts, at)) {
                let both = FOOT_PARTS.iter().filter(|(_, bit)| contacts.any(*bit) && Contacts::any(was, *bit));
                speeds.extend(both.map(|(j, _)| (at[j.index()] - positions[j.index()]).length() * clip.rate_hz as f32));
            }
        }
    }
    speeds.sort_by(f32::total_cmp);
    let share = |count: usize| if frames == 0 { 0.0 } else { count as f32 / frames as f32 };
    let mean = speeds.iter().fold(0.0, |a, b| a + b) / speeds.len().max(1) as f32;
    let p95 = speeds.get((speeds.len() * 95 / 100).min(speeds.len().saturating_sub(1))).copied().unwrap_or(0.0);
    ContactSanity {
        left_share: share(left),
        right_share: share(right),
        mean_speed_mps: mean,
        p95_speed_mps: p95,
        stance: StanceReport::from_distances(far),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clip::{Exclusion, ExclusionReason};
    use crate::stance::Grade;
    use glam::{Quat, Vec3};
    use throng_core::NUM_JOINTS;

    #[test]
    fn counts_shares_and_speeds_of_usable_frames() {
        let s = Skeleton::default();
        let clip = Clip {
            contacts: (0..20).map(|f| if f % 10 < 5 { Contacts::LEFT_TOE } else { Contacts::RIGHT }).collect(),
            excluded: vec![Exclusion { range: 15..20, reason: ExclusionReason::Still }],
            ..Clip::new(
                "slide",
                10.0,
                (0..20).map(|f| s.offsets[0] + Vec3::X * 0.1 * f as f32).collect(),
                vec![Quat::IDENTITY; 20 * NUM_JOINTS],
            )
        };
        let r = contact_sanity(&clip, &s);
        assert!((r.left_share - 10.0 / 15.0).abs() < 1e-6);
        assert!((r.right_share - 5.0 / 15.0).abs() < 1e-6);
        assert!((r.mean_speed_mps - 1.0).abs() < 1e-4 && (r.p95_speed_mps - 1.0).abs() < 1e-4);
    }

    #[test]
    fn feet_that_stand_above_or_below_the_ground_are_told() {
        let s = Skeleton::default();
        // Stands on the ground, then on something, then jumps for a tenth of a second.
        let of = |height: f32, share: usize| {
            let up = |f: usize| match f {
                _ if f < share => height,
                95..98 => 0.4,
                _ => 0.0,
            };
            let roots = (0..100).map(|f| s.offsets[0] + Vec3::Y * up(f)).collect();
            contact_sanity(&Clip::new("stands", 30.0, roots, vec![Quat::IDENTITY; 100 * NUM_JOINTS]), &s).stance
        };
        for (height, share, grade) in
            [(0.0, 0, Grade::Good), (0.2, 5, Grade::Good), (0.05, 50, Grade::Fair), (-0.07, 9, Grade::Poor)]
        {
            let found = of(height, share);
            assert_eq!(found.grade, grade, "{found:?}");
            assert!((found.worst_cm - 100.0 * height.abs()).abs() < 0.01, "{found:?}");
            assert_eq!(found.advice().is_some(), grade != Grade::Good);
        }
    }
}
