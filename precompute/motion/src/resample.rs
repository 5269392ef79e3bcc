//! Clips at one rate, and their mirrored copies.

use crate::clip::{Clip, ClipHit, ClipSet, ClipTag, Exclusion, FrameRange};
use crate::error::{BuildError, Result, check_ranges, ensure};
use crate::mirror::mirror_clip;
use glam::Quat;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use throng_base::maths;
use throng_core::NUM_JOINTS;

/// Frame rate of the database, and whether each clip gets a mirrored copy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ResampleConfig {
    /// Frames a second of the database (Hz, 1 to 240).
    pub rate_hz: f64,
    /// Add to each clip a copy with left and right exchanged.
    pub mirror: bool,
}

impl Default for ResampleConfig {
    fn default() -> Self {
        Self { rate_hz: 30.0, mirror: true }
    }
}

/// Most frames of all clips, mirrored copies counted: 92 hours at 30 Hz.
const MAX_FRAMES: f64 = 1e7;

impl ResampleConfig {
    /// Checks the rate.
    ///
    /// # Errors
    /// [`BuildError::Key`] where it is out of its range.
    pub fn check(&self) -> Result<()> {
        check_ranges([("rate_hz", self.rate_hz, 1.0, 240.0)])
    }
}

/// Refuses more frames than a database may have.
///
/// - `seconds`: lengths of the clips (s).
///
/// # Errors
/// [`BuildError::Key`] with the number of frames that they would have.
pub fn check_length(seconds: impl Iterator<Item = f64>, cfg: &ResampleConfig) -> Result<()> {
    let copies = if cfg.mirror { 2.0 } else { 1.0 };
    let (mut total, mut frames) = (0.0, 0.0);
    for s in seconds {
        total += s;
        frames += copies * (s * cfg.rate_hz + 1.0);
    }
    let why = format!(
        "{total:.0} s of motion at {} Hz would be {frames:.0} frames, expected {MAX_FRAMES} at most. Take fewer clips, a \
         lower rate, or set `import.rate_hz` where files name a wrong one",
        cfg.rate_hz
    );
    ensure(frames <= MAX_FRAMES, || BuildError::key("resample.rate_hz", why))
}

/// Brings all clips to one rate and adds mirrored copies, each after its original.
///
/// Rotations by slerp, hips positions linearly, between the two frames on either side; a clip that has the rate
/// already, and every frame that falls on one of the source's (each one at 120 to 30 Hz), stays as it is. Nothing
/// is filtered: optical motion capture holds next to nothing above 15 Hz.
/// Clips keep their first frame; the last one is the last that lies within the clip. Contacts are the nearest
/// frame's; exclusions and tags keep their times.
///
/// # Errors
/// [`BuildError::Config`] for a rate outside its limits.
pub fn resample(clips: &ClipSet, cfg: &ResampleConfig) -> Result<ClipSet> {
    cfg.check().map_err(|e| e.within_key("resample"))?;
    check_length(clips.clips.iter().map(|c| c.num_frames() as f64 / c.rate_hz), cfg)?;
    let with_copy = |clip: &Clip| {
        let resampled = to_rate(clip, cfg.rate_hz);
        let copy = cfg.mirror.then(|| mirror_clip(&resampled));
        std::iter::once(resampled).chain(copy)
    };
    let resampled = clips.clips.par_iter().flat_map_iter(with_copy).collect();
    Ok(ClipSet { skeleton: clips.skeleton.clone(), clips: resampled })
}

/// One clip at another rate.
fn to_rate(clip: &Clip, rate_hz: f64) -> Clip {
    let n = clip.num_frames();
    if clip.rate_hz == rate_hz || n < 2 {
        return Clip { rate_hz, ..clip.clone() };
    }
    let step = clip.rate_hz / rate_hz;
    let num_frames = ((n - 1) as f64 / step + 1e-6).floor() as usize + 1;
    let mut root_positions = Vec::with_capacity(num_frames);
    let mut rotations: Vec<Quat> = Vec::with_capacity(num_frames * NUM_JOINTS);
    let mut contacts = Vec::new();
    for frame in 0..num_frames {
        let (a, b, ratio) = neighbours(frame as f64 * step, n);
        root_positions.push(clip.root_positions[a].lerp(clip.root_positions[b], ratio));
        for (joint, (p, q)) in clip.frame_rotations(a).iter().zip(clip.frame_rotations(b)).enumerate() {
            let r = if ratio == 0.0 { *p } else { maths::slerp_f32(*p, *q, ratio) };
            let flip = frame > 0 && rotations[(frame - 1) * NUM_JOINTS + joint].dot(r) < 0.0;
            rotations.push(if flip { -r } else { r });
        }
        if !clip.contacts.is_empty() {
            contacts.push(clip.contacts[if ratio < 0.5 { a } else { b }]);
        }
    }
    // The frames whose times lie in the range.
    let first = |f: usize| ((f as f64 / step - 1e-6).ceil().max(0.0) as usize).min(num_frames);
    let range = |r: &FrameRange| first(r.start)..first(r.end);
    let nearest = |f: usize| ((f as f64 / step).round() as usize).min(num_frames - 1);
    let hit = |h: &ClipHit| ClipHit { frame: nearest(h.frame), ..h.clone() };
    Clip {
        source: clip.source.clone(),
        mirrored: clip.mirrored,
        contacts,
        excluded: clip.excluded.iter().map(|e| Exclusion { range: range(&e.range), reason: e.reason }).collect(),
        tags: clip.tags.iter().map(|t| ClipTag { name: t.name.clone(), range: range(&t.range) }).collect(),
        hits: clip.hits.iter().map(hit).collect(),
        ..Clip::new(clip.name.clone(), rate_hz, root_positions, rotations)
    }
}

/// The frames on either side of a fractional one, and the ratio between them (0 where it falls on a frame).
fn neighbours(at: f64, num_frames: usize) -> (usize, usize, f32) {
    let nearest = at.round();
    if (at - nearest).abs() < 1e-6 {
        let a = (nearest as usize).min(num_frames - 1);
        return (a, a, 0.0);
    }
    let a = (at as usize).min(num_frames - 2);
    (a, a + 1, (at - a as f64) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clip::ExclusionReason;
    use glam::Vec3;
    use throng_core::Skeleton;

    /// Turns and travels steadily: `speed` metres and `turn` radians a second.
    fn steady(rate_hz: f64, num_frames: usize, speed: f32, turn: f32) -> Clip {
        let t = |f: usize| f as f32 / rate_hz as f32;
        Clip {
            excluded: vec![Exclusion { range: 0..num_frames / 3, reason: ExclusionReason::Still }],
            tags: vec![ClipTag { name: "all".into(), range: 0..num_frames }],
            ..Clip::new(
                "steady",
                rate_hz,
                (0..num_frames).map(|f| Vec3::new(0.0, 1.0, speed * t(f))).collect(),
                (0..num_frames).flat_map(|f| [Quat::from_rotation_y(turn * t(f)); NUM_JOINTS]).collect(),
            )
        }
    }

    fn set(clip: Clip) -> ClipSet {
        ClipSet { skeleton: Skeleton::default(), clips: vec![clip] }
    }

    #[test]
    fn a_rate_that_cannot_be_is_refused() {
        for rate_hz in [0.0, -30.0, f64::NAN, 1e9, 241.0] {
            let cfg = ResampleConfig { rate_hz, mirror: false };
            let e = resample(&set(steady(30.0, 10, 1.0, 1.0)), &cfg).unwrap_err();
            assert!(e.to_string().contains("rate_hz"), "{e}");
        }
    }

    #[test]
    fn more_frames_than_memory_holds_are_refused_before_they_are_made() {
        let slow = Clip { rate_hz: 1e-6, ..steady(30.0, 100, 1.0, 1.0) };
        let e = resample(&set(slow), &ResampleConfig::default()).unwrap_err().to_string();
        assert!(e.starts_with("resample.rate_hz: ") && e.contains("expected 10000000 at most"), "{e}");
    }

    #[test]
    fn an_unchanged_rate_changes_nothing() {
        let s = set(steady(30.0, 50, 1.0, 1.0));
        assert_eq!(resample(&s, &ResampleConfig { rate_hz: 30.0, mirror: false }).unwrap(), s);
    }

    #[test]
    fn every_fourth_frame_of_120_hz_is_taken_as_it_is() {
        let s = set(steady(120.0, 121, 1.0, 1.0));
        let r = resample(&s, &ResampleConfig { rate_hz: 30.0, mirror: false }).unwrap();
        assert_eq!(r.clips[0].num_frames(), 31);
        for f in 0..31 {
            assert_eq!(r.clips[0].root_positions[f], s.clips[0].root_positions[4 * f]);
            assert_eq!(r.clips[0].frame_rotations(f), s.clips[0].frame_rotations(4 * f));
        }
        assert_eq!(r.clips[0].excluded[0].range, 0..10);
        assert_eq!(r.clips[0].tags[0].range, 0..31);
    }

    #[test]
    fn steady_motion_stays_steady_at_any_rate() {
        for rate in [24.0, 25.0, 30.0, 59.94, 60.0, 100.0] {
            let r =
                resample(&set(steady(rate, 200, 1.3, 2.0)), &ResampleConfig { rate_hz: 30.0, mirror: false }).unwrap();
            let c = &r.clips[0];
            for f in 0..c.num_frames() {
                let t = f as f32 / 30.0;
                assert!((c.root_positions[f].z - 1.3 * t).abs() < 1e-4);
                assert!(c.frame_rotations(f)[5].dot(Quat::from_rotation_y(2.0 * t)).abs() > 1.0 - 1e-6);
            }
            let (old, new) = (199.0 / rate, (c.num_frames() - 1) as f64 / 30.0);
            assert!(new <= old + 1e-9 && new > old - 1.0 / 30.0);
        }
    }

    #[test]
    fn neighbours_keep_a_positive_dot_product_and_copies_follow_their_originals() {
        let mut clip = steady(50.0, 400, 1.0, 6.0);
        for q in clip.rotations.iter_mut().skip(7 * NUM_JOINTS) {
            *q = -*q;
        }
        let r = resample(&set(clip), &ResampleConfig::default()).unwrap();
        assert_eq!(r.clips[1].name, "steady~mirror");
        for c in &r.clips {
            for f in 1..c.num_frames() {
                assert!(c.frame_rotations(f - 1).iter().zip(c.frame_rotations(f)).all(|(p, q)| p.dot(*q) > 0.0));
            }
        }
    }
}
