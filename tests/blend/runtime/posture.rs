//! Blended postures against quaternions blended one by one.

use super::made_up::{MadeUp, PHASES};
use glam::{Quat, Vec3};
use proptest::prelude::*;
use throng_core::blend::{BlendedPosture, PADDED_JOINTS, channel};
use throng_core::{Joint, NUM_JOINTS};

/// A space with references that differ from row to row, some of them antipodal to their neighbours.
fn with_references() -> MadeUp {
    let mut made_up = MadeUp::locomotion();
    for (k, row) in made_up.references.iter_mut().enumerate() {
        for j in 0..PADDED_JOINTS {
            let angle = 0.4 * (std::f32::consts::TAU * k as f32 / PHASES as f32 + j as f32).sin();
            let sign = if (k + j) % 3 == 0 { -1.0 } else { 1.0 };
            let q = Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), angle) * sign;
            for (c, v) in row.components.iter_mut().zip(q.to_array()) {
                c[j] = v;
            }
        }
    }
    made_up
}

/// A joint's orientation, blended one number at a time.
fn by_hand(made_up: &MadeUp, weights: &[f32], phase: f32, joint: usize) -> Quat {
    let n = made_up.examples.len();
    let at = phase * PHASES as f32;
    let (k, ratio) = (at as usize, at.fract());
    let row = |k: usize| {
        let k = k % PHASES;
        let mut log = Vec3::ZERO;
        for (e, w) in weights.iter().take(n).enumerate() {
            let v = &made_up.channels[k * n + e].values;
            log += *w * Vec3::from_array(channel::LOG.map(|c| v[c + joint]));
        }
        (Quat::from_array(made_up.references[k].components.map(|c| c[joint])), log)
    };
    let ((qa, va), (qb, vb)) = (row(k), row(k + 1));
    let qb = if qa.dot(qb) < 0.0 { -qb } else { qb };
    let reference = Quat::from_vec4(glam::Vec4::from(qa).lerp(glam::Vec4::from(qb), ratio)).normalize();
    reference * Quat::from_scaled_axis(2.0 * va.lerp(vb, ratio))
}

proptest! {
    #[test]
    fn postures_are_what_the_sums_say(
        weights in prop::collection::vec(-0.3f32..0.5, 20), phase in 0.0f32..0.999, turns in -3i32..3
    ) {
        let sum: f32 = weights.iter().map(|w| w.abs()).sum();
        let weights: Vec<f32> = weights.iter().map(|w| 1.5 * w / sum.max(1.5)).collect();
        let made_up = with_references();
        let space = made_up.space();
        let mut row = weights.clone();
        row.resize(space.stride(), 0.0);
        let mut out = [BlendedPosture::default()];
        space.blend_postures(&row, &[phase + turns as f32], &mut out).expect("a posture");
        for joint in Joint::ALL {
            let got = out[0].rotation(joint);
            prop_assert!(got.is_normalized());
            prop_assert!(got.dot(by_hand(&made_up, &weights, phase, joint.index())).abs() > 1.0 - 2e-5, "{joint:?}");
        }
        let n = made_up.examples.len();
        let (k, ratio) = ((phase * PHASES as f32) as usize, (phase * PHASES as f32).fract());
        for c in channel::HIPS..=channel::GYRATION {
            let sum = |k: usize| (0..n).map(|e| weights[e] * made_up.channels[k % PHASES * n + e].values[c]).sum::<f32>();
            let want = sum(k) + (sum(k + 1) - sum(k)) * ratio;
            prop_assert!((out[0].channel(c) - want).abs() < 1e-4);
        }
    }
}

#[test]
fn an_example_alone_is_itself_at_every_row() {
    let made_up = MadeUp::locomotion();
    let space = made_up.space();
    let n = made_up.examples.len();
    for (k, e) in [(0, 0), (5, 3), (31, 19), (16, 7)] {
        let mut weights = vec![0.0; space.stride()];
        weights[e] = 1.0;
        let mut out = [BlendedPosture::default()];
        space.blend_postures(&weights, &[k as f32 / PHASES as f32], &mut out).expect("a posture");
        let values = &made_up.channels[k * n + e].values;
        for j in 0..NUM_JOINTS {
            let q = Quat::from_scaled_axis(2.0 * Vec3::from_array(channel::LOG.map(|c| values[c + j])));
            assert!(out[0].rotation(Joint::ALL[j]).dot(q).abs() > 1.0 - 1e-5, "example {e}, row {k}, joint {j}");
        }
        assert!(out[0].vector(channel::LEFT_ANKLE).abs_diff_eq(Vec3::from_slice(&values[channel::LEFT_ANKLE..]), 1e-5));
    }
}

#[test]
fn a_cycle_closes() {
    let made_up = with_references();
    let space = made_up.space();
    let mut weights = vec![0.0; 2 * space.stride()];
    (weights[4], weights[space.stride() + 4]) = (1.0, 1.0);
    let mut out = [BlendedPosture::default(); 2];
    space.blend_postures(&weights, &[0.999_999, 0.0], &mut out).expect("postures");
    for joint in Joint::ALL {
        assert!(out[0].rotation(joint).dot(out[1].rotation(joint)).abs() > 1.0 - 1e-5);
    }
}

#[test]
fn slices_that_do_not_fit_are_refused() {
    let made_up = MadeUp::locomotion();
    let space = made_up.space();
    let mut out = [BlendedPosture::default(); 2];
    assert!(space.blend_postures(&[0.0; 24], &[0.0; 2], &mut out).is_err());
    assert!(space.blend_postures(&[0.0; 48], &[0.0; 1], &mut out).is_err());
    space.blend_postures(&[0.0; 48], &[f32::NAN, f32::INFINITY], &mut out).expect("any phase is taken");
}
