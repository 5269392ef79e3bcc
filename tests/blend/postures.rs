//! The posture tables against the puppets they were made from.

use super::made_up::{Puppet, RATE_HZ, SIX, config, fit, six};
use glam::{Quat, Vec3};
use throng_core::blend::{ChannelRow, channel};
use throng_core::{Joint, NUM_JOINTS, Skeleton};
use throng_precompute::clip::joint_transforms;
use throng_precompute::examples::RawBlendSpace;
use throng_precompute::examples::average::{exponential, reference};

fn space() -> RawBlendSpace {
    fit(six(), &config(SIX)).expect("a space").spaces.remove(0)
}

/// Puppet of an example of [`six`].
fn puppet(number: usize) -> Puppet {
    match number {
        0 => Puppet::new("slow", 0.8, 0.0),
        1 => Puppet::new("slow_left", 0.8, 0.7),
        2 => Puppet::new("fast", 1.6, 0.0),
        3 => Puppet { period: 0.8, swing: 0.6, ..Puppet::new("fast_left", 1.6, 0.7) },
        _ => Puppet { period: 0.9, ..Puppet::new("fast_right", 1.6, -0.7) },
    }
}

fn row(space: &RawBlendSpace, phase: usize, example: usize) -> &ChannelRow {
    &space.channels[phase * space.examples.len() + example]
}

/// Rotations of an example at a phase, put together again as a step does.
fn rotations(space: &RawBlendSpace, phase: usize, example: usize) -> [Quat; NUM_JOINTS] {
    let (reference, v) = (&space.references[phase], &row(space, phase, example).values);
    std::array::from_fn(|j| {
        let log = Vec3::from_array(channel::LOG.map(|at| v[at + j]));
        Quat::from_array(reference.components.map(|c| c[j])) * exponential(log.as_dvec3()).as_quat()
    })
}

fn vector(row: &ChannelRow, at: usize) -> Vec3 {
    Vec3::from_slice(&row.values[at..at + 3])
}

/// Time of the puppet at a phase: strikes lie halfway between frames.
fn time(space: &RawBlendSpace, example: usize, phase: usize) -> f32 {
    let e = &space.examples[example];
    (e.first_frame as f32 - 0.5) / RATE_HZ + e.duration_s * phase as f32 / space.references.len() as f32
}

#[test]
fn references_and_displacements_give_back_every_example() {
    let space = space();
    for example in 0..5 {
        for phase in 0..space.references.len() {
            let (_, expected) = puppet(example).pose(time(&space, example, phase));
            for (j, (a, b)) in rotations(&space, phase, example).iter().zip(expected).enumerate() {
                assert!(a.angle_between(b) < 0.03, "example {example}, phase {phase}, joint {j}: {a}, {b}");
            }
        }
    }
}

#[test]
fn hips_and_ends_of_limbs_are_in_the_facing_frame() {
    let (space, skeleton) = (space(), Skeleton::default());
    for example in 0..5 {
        for phase in 0..space.references.len() {
            let (hips, local) = puppet(example).pose(time(&space, example, phase));
            let row = row(&space, phase, example);
            let near = |at: usize, p: Vec3| {
                assert!(vector(row, at).distance(p) < 0.02, "example {example}, phase {phase}, channel {at}")
            };
            near(channel::HIPS, hips);
            let all = joint_transforms(&skeleton, Vec3::ZERO, |j| local[j]);
            near(channel::LEFT_ANKLE, all[Joint::LeftFoot.index()].0);
            near(channel::RIGHT_ANKLE, all[Joint::RightFoot.index()].0);
            near(channel::LEFT_HAND, all[Joint::LeftHand.index()].0);
            near(channel::RIGHT_HAND, all[Joint::RightHand.index()].0);
        }
    }
}

#[test]
fn rates_are_positive_and_add_up_to_the_cycle() {
    let space = space();
    let phases = space.references.len();
    for (i, e) in space.examples.iter().enumerate() {
        let rates: Vec<f32> = (0..phases).map(|p| row(&space, p, i).values[channel::RATE]).collect();
        assert!(rates.iter().all(|r| *r > 0.0));
        assert!((rates.iter().sum::<f32>() / phases as f32 - e.duration_s).abs() < 1e-4, "example {i}");
    }
}

#[test]
fn contacts_are_those_of_the_feet() {
    let space = space();
    for example in 0..5 {
        let p = puppet(example);
        for phase in 0..space.references.len() {
            let t = time(&space, example, phase);
            let values = &row(&space, phase, example).values;
            let feet = [(channel::LEFT_CONTACT, p.phase(t)), (channel::RIGHT_CONTACT, p.phase(t) - p.right)];
            for (at, part) in feet {
                let part = part.rem_euclid(1.0);
                // But for two frames around strikes and offs.
                let edge = [0.0, p.duty, 1.0].iter().any(|e| (part - e).abs() * p.period < 2.0 / RATE_HZ);
                let stands = f32::from(u8::from(part < p.duty));
                assert!(edge || values[at] == stands, "example {example}, phase {phase}: {} at {part}", values[at]);
            }
        }
    }
    for phase in 0..space.references.len() {
        let idle = row(&space, phase, 5);
        assert_eq!((idle.values[channel::LEFT_CONTACT], idle.values[channel::RIGHT_CONTACT]), (1.0, 1.0));
    }
}

/// The last row continues in the first: a step over the seam is no larger than the others.
#[test]
fn cycles_are_closed() {
    let space = space();
    let phases = space.references.len();
    for example in 0..space.examples.len() {
        let step = |phase: usize| {
            let (a, b) = (rotations(&space, phase, example), rotations(&space, (phase + 1) % phases, example));
            let turn = a.iter().zip(&b).map(|(a, b)| a.angle_between(*b)).fold(0.0, f32::max);
            let hips = |p: usize| vector(row(&space, p % phases, example), channel::HIPS);
            (turn, hips(phase).distance(hips(phase + 1)))
        };
        let inside = (0..phases - 1).map(step).fold((0.0f32, 0.0f32), |a, b| (a.0.max(b.0), a.1.max(b.1)));
        let seam = step(phases - 1);
        assert!(
            seam.0 < 1.2 * inside.0 + 0.01 && seam.1 < 1.2 * inside.1 + 0.003,
            "example {example}: {seam:?}, {inside:?}"
        );
    }
}

/// Weights of one example alone give that example, whatever the reference is; equal weights of two give what lies half
/// way between them, as the reference of the two does.
#[test]
fn blends_of_two_lie_between_them() {
    let space = space();
    for phase in [0, 7, 21] {
        let (a, b) = (rotations(&space, phase, 0), rotations(&space, phase, 3));
        for j in 0..NUM_JOINTS {
            let log = |e: usize| Vec3::from_array(channel::LOG.map(|at| row(&space, phase, e).values[at + j]));
            let middle = Quat::from_array(space.references[phase].components.map(|c| c[j]))
                * exponential((0.5 * (log(0) + log(3))).as_dvec3()).as_quat();
            let expected = reference(&[a[j].as_dquat(), b[j].as_dquat()]).as_quat();
            assert!(middle.angle_between(expected) < 0.02, "phase {phase}, joint {j}");
        }
    }
}
