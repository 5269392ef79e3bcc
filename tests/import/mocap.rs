//! Real motion capture reads as bodies of plausible size on plausible ground. Skipped where it is not at hand.

use crate::common::mocap::recording;
use throng_core::Joint;
use throng_precompute::import::{ImportConfig, ImportedClip, RestPoseKind, read};
use throng_precompute::progress::Silent;

/// The clips of a folder of the recordings.
fn clips(folder: &str) -> Option<Vec<ImportedClip>> {
    let folder = recording(folder)?;
    let set = read(&[folder], &ImportConfig { strict: true, ..ImportConfig::default() }, &Silent).unwrap();
    assert!(set.skipped.is_empty());
    Some(set.clips)
}

/// Height of the lowest foot or toe joint in each of up to 200 frames, ascending.
fn foot_heights(i: &ImportedClip) -> Vec<f32> {
    use Joint::*;
    let feet: Vec<_> = [LeftFoot, LeftToe, RightFoot, RightToe].into_iter().filter_map(|r| i.roles.get(r)).collect();
    let step = i.clip.num_frames.div_ceil(200);
    let mut heights: Vec<f32> = (0..i.clip.num_frames)
        .step_by(step)
        .map(|f| {
            let world = i.clip.world(f);
            feet.iter().map(|&j| world[j].0.y).fold(f32::INFINITY, f32::min)
        })
        .collect();
    heights.sort_by(f32::total_cmp);
    heights
}

fn check(folder: &str, profile: &str, num_clips: usize, rest: RestPoseKind, heights: std::ops::Range<f32>) {
    let Some(clips) = clips(folder) else { return };
    assert_eq!(clips.len(), num_clips);
    for i in &clips {
        let name = &i.clip.name;
        assert!(heights.contains(&i.height), "{name}: {} m tall", i.height);
        assert_eq!((i.roles.profile.as_str(), i.rest_pose.kind), (profile, rest), "{name}");
        assert_eq!(i.up, throng_precompute::import::UpAxis::Y, "{name}");
        // Faults of the recordings are told.
        let told = usize::from(!i.glitches.is_empty());
        assert_eq!(i.warnings.messages.len(), told, "{name}: {:?}", i.warnings);
        let lowest = foot_heights(i)[0];
        assert!((-0.1..0.15).contains(&lowest), "{name}: the lowest foot is at {lowest} m");
    }
}

#[test]
fn cmu_clips_read() {
    for (subject, num_clips) in [("01", 14), ("02", 10), ("03", 4)] {
        check(&format!("cmu-asfamc/{subject}"), "CMU ASF", num_clips, RestPoseKind::TPose, 1.6..1.9);
    }
}

#[test]
fn snu_clips_read() {
    for (folder, num_clips) in [("single", 87), ("session23", 10), ("multi", 17)] {
        check(&format!("snu/{folder}"), "SNU", num_clips, RestPoseKind::TPose, 1.5..1.8);
    }
}

#[test]
fn bandai_namco_clips_read() {
    check("bandai-1", "Bandai-Namco", 174, RestPoseKind::Other, 1.4..1.8);
}
