//! Cycles that are not captured whole: one step and its mirrored image, and standing forth and back.

use super::made_up::{Puppet, SIX, config, fit, idle, six};
use glam::Quat;
use throng_core::blend::channel;
use throng_core::{Joint, NUM_JOINTS};
use throng_precompute::Clip;
use throng_precompute::clip::{Exclusion, ExclusionReason};

/// Some frames of a puppet's clip.
fn cut(puppet: &Puppet, first: usize, end: usize) -> Clip {
    let mut clip = puppet.clip();
    clip.root_positions = clip.root_positions[first..end].to_vec();
    clip.rotations = clip.rotations[first * NUM_JOINTS..end * NUM_JOINTS].to_vec();
    clip.contacts = clip.contacts[first..end].to_vec();
    clip.tags.clear();
    clip
}

#[test]
fn one_step_and_its_mirrored_image_make_a_cycle() {
    let (slow, fast) = (Puppet::new("slow", 1.0, 0.0), Puppet::new("fast", 2.0, 0.0));
    let whole = Puppet { name: "whole", velocity: [0.0, 1.01], ..slow.clone() };
    let text = "
        axes = [{ kind = 'speed' }]
        examples = [{ clip = 'slow', symmetric = true }, { clip = 'fast', symmetric = true }, { clip = 'whole' }]
        phases = 32
        min_distance = 0.0001";
    // The left foot strikes at frames 15 and 75, the right one at 45: the second clip has only the other step.
    let clips = vec![cut(&slow, 10, 56), cut(&fast, 40, 86), whole.clip()];
    let spaces = fit(clips, &config(text)).expect("a space");
    let space = &spaces.spaces[0];
    for (e, speed) in space.examples.iter().zip([1.0, 2.0, 1.01]) {
        assert!((e.velocity[1] - speed).abs() < 0.02 && e.velocity[0].abs() < 0.02 && e.gyration.abs() < 0.02, "{e:?}");
        assert!((e.duration_s - 1.0).abs() < 0.01, "{e:?}");
        let known = space.examples[2].keytimes;
        assert!(e.keytimes.iter().zip(known).all(|(a, b)| (a - b).abs() < 0.02), "{e:?}");
    }
    // The puppet is symmetric, so both are what the whole one is.
    let log = (0..Joint::ALL.len()).flat_map(|j| channel::LOG.map(|at| at + j));
    let channels: Vec<usize> = log.chain(channel::HIPS..channel::RATE).collect();
    for phase in 0..32 {
        let of = |example: usize| &space.channels[phase * 3 + example].values;
        for (example, &k) in [0, 1].iter().flat_map(|e| channels.iter().map(move |k| (*e, k))) {
            let apart = (of(example)[k] - of(2)[k]).abs();
            assert!(apart < 0.02, "example {example}, phase {phase}, channel {k}: {apart}");
        }
    }
}

#[test]
fn a_clip_without_a_whole_step_is_named() {
    let text = "axes = [{ kind = 'speed' }]\nexamples = [{ clip = 'slow', symmetric = true }, { clip = 'fast' }]";
    let clips = vec![cut(&Puppet::new("slow", 1.0, 0.0), 10, 40), Puppet::new("fast", 2.0, 0.0).clip()];
    let e = fit(clips, &config(text)).expect_err("half a step").to_string();
    assert!(e.contains("slow: frames 0 to 29 hold no whole step"), "{e}");
}

/// A slow lean that does not come back within the frames.
#[test]
fn who_stands_but_does_not_come_back_goes_forth_and_back() {
    let mut lean = idle();
    lean.name = "lean".into();
    lean.root_positions.iter_mut().enumerate().for_each(|(f, p)| p.x += 0.0005 * f as f32);
    for (f, pose) in lean.rotations.chunks_mut(NUM_JOINTS).enumerate() {
        pose[Joint::Chest.index()] = Quat::from_rotation_x(0.003 * f as f32);
        pose[Joint::UpperChest.index()] = Quat::from_rotation_x(0.01 * f as f32);
    }
    // A build leaves still ends of clips out of motion; here they are what is asked for.
    lean.excluded = vec![Exclusion { range: 0..lean.num_frames(), reason: ExclusionReason::Still }];
    let clips = [six(), vec![lean]].concat();
    let spaces = fit(clips, &config(&SIX.replace("'idle'", "'lean', frames = [0, 60]"))).expect("a space");
    let space = &spaces.spaces[0];
    let (phases, n) = (space.references.len(), space.examples.len());
    assert!(space.examples[5].duration_s >= 3.0);
    let of = |phase: usize| &space.channels[phase % phases * n + 5].values;
    for phase in 0..phases {
        for k in channel::HIPS..channel::RATE {
            assert!((of(phase)[k] - of(phases - phase)[k]).abs() < 1e-4, "phase {phase}, channel {k}");
        }
    }
    let distance = (of(phases / 2)[channel::HIPS] - of(0)[channel::HIPS]).abs();
    assert!(distance > 0.01, "it moves: {distance}");
}
