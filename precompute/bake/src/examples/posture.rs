//! Posture tables: references and channels of all examples, phase by phase (Kim, Kim and Shin 2003a, section 4.2.3).

use super::{Cycle, FractionalPose, displacement, reference};
use glam::{DQuat, Vec3};
use rayon::prelude::*;
use throng_core::blend::{ChannelRow, NUM_CHANNELS, PADDED_JOINTS, ReferenceRow, channel};
use throng_core::{Joint, NUM_JOINTS, Skeleton};

/// Posture tables of a space.
#[derive(Clone, Debug, PartialEq)]
pub struct Postures {
    /// Reference rows, one a phase.
    pub references: Vec<ReferenceRow>,
    /// Channel rows, one a phase and example.
    pub channels: Vec<ChannelRow>,
    /// Largest turn of a joint from its reference: joint, example and angle (rad).
    pub largest: (Joint, usize, f64),
}

/// Error of a reference that moves to the other side of the sphere over one cycle, so that rows cannot be interpolated.
#[derive(Clone, Debug, PartialEq)]
pub struct TwistedReference {
    /// The joint.
    pub joint: Joint,
    /// Phase after which it is discontinuous.
    pub phase: usize,
}

/// Resamples all cycles by generic time and splits their orientations into references and log-displacements.
///
/// # Errors
/// [`TwistedReference`] where examples differ so much that a joint's reference jumps from a phase to the next.
pub fn tabulate(cycles: &[&Cycle<'_>], skeleton: &Skeleton, num_phases: usize) -> Result<Postures, TwistedReference> {
    let phase = |row: usize| {
        let generic = row as f64 / num_phases as f64;
        let poses: Vec<FractionalPose> = cycles.iter().map(|c| c.pose(generic)).collect();
        let references: [DQuat; NUM_JOINTS] = std::array::from_fn(|j| {
            reference(&poses.iter().map(|p| p.rotations[j].as_dquat().normalize()).collect::<Vec<_>>())
        });
        let rows: Vec<ChannelRow> =
            cycles.iter().zip(&poses).map(|(c, p)| channels(c, p, generic, &references, skeleton)).collect();
        (references, rows)
    };
    let phases: Vec<_> = (0..num_phases).into_par_iter().map(phase).collect();
    let (mut references, channels): (Vec<_>, Vec<_>) = phases.into_iter().unzip();
    let channels = channels.concat();
    align_signs(&mut references)?;
    let largest = largest(&channels, cycles.len());
    Ok(Postures { references: references.iter().map(row).collect(), channels, largest })
}

/// The numbers of one example at one phase.
fn channels(
    cycle: &Cycle<'_>,
    pose: &FractionalPose,
    generic: f64,
    references: &[DQuat; NUM_JOINTS],
    skeleton: &Skeleton,
) -> ChannelRow {
    let mut values = [0.0f32; NUM_CHANNELS];
    for (j, r) in references.iter().enumerate() {
        let v = displacement(*r, pose.rotations[j].as_dquat().normalize()).as_vec3();
        channel::LOG.iter().zip(v.to_array()).for_each(|(at, v)| values[at + j] = v);
    }
    let mut put = |at: usize, v: Vec3| values[at..at + 3].copy_from_slice(&v.to_array());
    put(channel::HIPS, pose.hips);
    let ends = [
        (Joint::LeftFoot, channel::LEFT_ANKLE),
        (Joint::RightFoot, channel::RIGHT_ANKLE),
        (Joint::LeftHand, channel::LEFT_HAND),
        (Joint::RightHand, channel::RIGHT_HAND),
    ];
    let reach = Cycle::limb_positions(pose, skeleton, ends.map(|e| e.0));
    ends.iter().zip(reach).for_each(|((_, at), v)| put(*at, v));
    let twist = cycle.course.twist;
    let ([left, right], [left_hand, right_hand]) = (cycle.contacts(generic), cycle.hand_contacts(generic));
    for (at, v) in [
        (channel::RATE, cycle.rate(generic)),
        (channel::LEFT_CONTACT, left),
        (channel::RIGHT_CONTACT, right),
        (channel::LEFT_TOUCH, left_hand),
        (channel::RIGHT_TOUCH, right_hand),
        (channel::VELOCITY, twist.velocity.x),
        (channel::VELOCITY + 1, twist.velocity.y),
        (channel::GYRATION, twist.gyration),
    ] {
        values[at] = v as f32;
    }
    ChannelRow { values }
}

/// Flips signs so that neighbouring references lie on one side of the sphere, including the last and the first.
fn align_signs(references: &mut [[DQuat; NUM_JOINTS]]) -> Result<(), TwistedReference> {
    for joint in Joint::ALL {
        let j = joint.index();
        for phase in 1..references.len() {
            if references[phase][j].dot(references[phase - 1][j]) < 0.0 {
                references[phase][j] = -references[phase][j];
            }
        }
        for phase in 0..references.len() {
            let next = (phase + 1) % references.len();
            // Beyond a quarter turn, interpolation between two rows is meaningless.
            if references[phase][j].dot(references[next][j]) < std::f64::consts::FRAC_1_SQRT_2 {
                return Err(TwistedReference { joint, phase });
            }
        }
    }
    Ok(())
}

fn row(references: &[DQuat; NUM_JOINTS]) -> ReferenceRow {
    let mut components = [[0.0f32; PADDED_JOINTS]; 4];
    components[3] = [1.0; PADDED_JOINTS];
    for (j, q) in references.iter().enumerate() {
        let q = q.as_quat().normalize();
        q.to_array().iter().enumerate().for_each(|(k, v)| components[k][j] = *v);
    }
    ReferenceRow { components }
}

fn largest(channels: &[ChannelRow], num_examples: usize) -> (Joint, usize, f64) {
    let turn = |c: &ChannelRow, j: usize| {
        let squared: f32 = channel::LOG.iter().map(|at| c.values[at + j] * c.values[at + j]).sum();
        2.0 * f64::from(squared.sqrt())
    };
    let all = channels.iter().enumerate();
    let all = all.flat_map(|(i, c)| Joint::ALL.map(|j| (j, i % num_examples, turn(c, j.index()))));
    all.fold((Joint::Hips, 0, 0.0), |a, b| if b.2 > a.2 { b } else { a })
}
