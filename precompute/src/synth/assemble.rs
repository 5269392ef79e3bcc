//! Puts the parts of the rig together, sample by sample, into a clip.

use super::SynthConfig;
use super::arms::{self, ArmInput, ArmPose};
use super::balance::centre_of_mass;
use super::foot::{FootPose, FootShape};
use super::footsteps::Footsteps;
use super::leg::LegShape;
use super::pelvis::{self, Pelvis, PelvisInput};
use super::side::Side;
use super::signal::{interpolate, smooth};
use super::trunk::{self, Drift, TrunkPose};
use crate::clip::Clip;
use glam::{DQuat, DVec2, DVec3};
use rand::{Rng, RngExt};
use throng_runtime::{Contacts, Joint, NUM_JOINTS, Skeleton};

/// The rig works at least this often, so that its filters do not depend on the clip's rate. [Unit: Hz]
const WORKING_RATE: f64 = 120.0;

/// All signals of a clip at the working rate.
struct Signals {
    feet: Vec<[FootPose; 2]>,
    pelvis: Pelvis,
    trunk: Vec<TrunkPose>,
    arms: Vec<[ArmPose; 2]>,
}

/// Makes a clip from its footsteps.
pub fn clip(name: String, steps: &Footsteps, skeleton: &Skeleton, cfg: &SynthConfig, rng: &mut impl Rng) -> Clip {
    let oversampling = (WORKING_RATE / cfg.rate_hz).ceil() as usize;
    let dt = 1.0 / (cfg.rate_hz * oversampling as f64);
    let num_frames = (steps.duration * cfg.rate_hz).floor() as usize + 1;
    let times: Vec<f64> = (0..(num_frames - 1) * oversampling + 1).map(|i| i as f64 * dt).collect();
    let signals = signals(steps, skeleton, &times, dt, cfg.variation, rng);
    let mut clip = Clip {
        name,
        source: format!("throng synth walk, seed {}", cfg.seed),
        mirrored: false,
        rate_hz: cfg.rate_hz,
        root_positions: Vec::with_capacity(num_frames),
        rotations: Vec::with_capacity(num_frames * NUM_JOINTS),
        contacts: Vec::with_capacity(num_frames),
        excluded: Vec::new(),
        tags: Vec::new(),
        hits: Vec::new(),
    };
    for frame in 0..num_frames {
        push_frame(&mut clip, &signals, frame * oversampling, skeleton);
    }
    clip
}

fn signals(
    steps: &Footsteps,
    skeleton: &Skeleton,
    times: &[f64],
    dt: f64,
    variation: f64,
    rng: &mut impl Rng,
) -> Signals {
    let frames = |seconds: f64| (seconds / dt).round() as usize;
    let feet: Vec<_> = times.iter().map(|&t| [0, 1].map(|s: usize| steps.feet[s].pose(t))).collect();
    let load: Vec<f64> = times.iter().map(|&t| interpolate(&steps.load, t)).collect();
    let mass = centre_of_mass(steps, &FootShape::of(skeleton), times, dt);
    let speed = speed(&mass, dt, frames(0.13));
    let joint = |j: Joint| skeleton.offsets[j.index()].as_dvec3();
    let pelvis = pelvis::follow(&PelvisInput {
        feet: &feet,
        load: &load,
        mass: &mass,
        speed: &speed,
        hips: [joint(Joint::LeftThigh), joint(Joint::RightThigh)],
        leg: leg_shape(skeleton),
        dt,
    });
    let drift = drift(steps.duration, times, dt, &speed, variation, rng);
    let trunk = trunk::balance(&pelvis, &speed, &mass, &drift, dt);
    let chest_pitch: Vec<f64> = trunk.iter().map(|t| t.upper_chest().pitch).collect();
    let arms = arms::swing(&ArmInput {
        apart: &pelvis.apart,
        speed: &speed,
        chest_pitch: &chest_pitch,
        drift: &drift,
        liveliness: [0, 1].map(|_| 1.0 + variation * rng.random_range(-0.08..0.08)),
        dt,
    });
    Signals { feet, pelvis, trunk, arms }
}

fn leg_shape(skeleton: &Skeleton) -> LegShape {
    let length = |j: Joint| f64::from(skeleton.offsets[j.index()].length());
    LegShape { thigh: length(Joint::LeftShin), shin: length(Joint::LeftFoot) }
}

/// Speed of the centre of mass, smoothed over about a step.
fn speed(mass: &[DVec2], dt: f64, radius: usize) -> Vec<f64> {
    let n = mass.len();
    let raw: Vec<f64> = (0..n)
        .map(|i| {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(n - 1));
            (mass[b] - mass[a]).length() / ((b - a).max(1) as f64 * dt)
        })
        .collect();
    smooth(&raw, radius)
}

/// Slow random changes of gaze, and breathing. Who walks looks around less.
fn drift(duration: f64, times: &[f64], dt: f64, speed: &[f64], variation: f64, rng: &mut impl Rng) -> Drift {
    let frames = |seconds: f64| (seconds / dt).round() as usize;
    let mut wander = |amount: f64, every: f64| -> Vec<f64> {
        let (mut t, mut knots) = (0.0, Vec::new());
        while t < duration + every {
            knots.push((t, variation * rng.random_range(-amount..amount)));
            t += every * rng.random_range(0.6..1.4);
        }
        let raw: Vec<f64> = times.iter().map(|&t| interpolate(&knots, t)).collect();
        smooth(&raw, frames(0.15))
    };
    let (gaze, nod) = (wander(0.2, 1.6), wander(0.04, 1.9));
    let arms = [wander(0.06, 1.7), wander(0.06, 1.7)];
    let calm = |x: Vec<f64>| x.iter().zip(speed).map(|(x, v)| x * (1.0 - 0.65 * v.min(1.0))).collect();
    let phase = rng.random_range(0.0..std::f64::consts::TAU);
    let breath = times.iter().map(|t| (phase + t * std::f64::consts::TAU * 0.27).sin()).collect();
    Drift { gaze: calm(gaze), nod: calm(nod), arms: arms.map(calm), breath }
}

/// Adds the pose of one sample to the clip.
fn push_frame(clip: &mut Clip, signals: &Signals, i: usize, skeleton: &Skeleton) {
    let mut local = [DQuat::IDENTITY; NUM_JOINTS];
    let hips = signals.pelvis.rotation(i);
    let root = signals.pelvis.position[i];
    local[Joint::Hips.index()] = hips;
    pose_trunk(&mut local, hips, &signals.trunk[i]);
    pose_arms(&mut local, &signals.arms[i]);
    let mut contacts = Contacts::NONE;
    for side in Side::BOTH {
        let foot = &signals.feet[i][side.index()];
        pose_leg(&mut local, side, root, hips, foot, skeleton);
        contacts.insert(foot.contacts(side));
    }
    let last = clip.rotations.len().checked_sub(NUM_JOINTS);
    for (j, q) in local.into_iter().enumerate() {
        let q = q.as_quat().normalize();
        let flip = last.is_some_and(|l| clip.rotations[l + j].dot(q) < 0.0);
        clip.rotations.push(if flip { -q } else { q });
    }
    clip.root_positions.push(root.as_vec3());
    clip.contacts.push(contacts);
}

fn pose_trunk(local: &mut [DQuat; NUM_JOINTS], hips: DQuat, trunk: &TrunkPose) {
    const CHAIN: [Joint; 5] = [Joint::Spine, Joint::Chest, Joint::UpperChest, Joint::Neck, Joint::Head];
    let mut parent = hips;
    for (joint, segment) in CHAIN.into_iter().zip(&trunk.segments) {
        let world = segment.rotation();
        local[joint.index()] = parent.inverse() * world;
        parent = world;
    }
}

fn pose_arms(local: &mut [DQuat; NUM_JOINTS], arms: &[ArmPose; 2]) {
    use Joint::*;
    const CHAINS: [[Joint; 4]; 2] =
        [[LeftClavicle, LeftUpperArm, LeftForearm, LeftHand], [RightClavicle, RightUpperArm, RightForearm, RightHand]];
    for (arm, chain) in arms.iter().zip(CHAINS) {
        for (joint, q) in chain.into_iter().zip([arm.clavicle, arm.upper_arm, arm.forearm, arm.hand]) {
            local[joint.index()] = q;
        }
    }
}

fn pose_leg(
    local: &mut [DQuat; NUM_JOINTS],
    side: Side,
    root: DVec3,
    hips: DQuat,
    foot: &FootPose,
    skeleton: &Skeleton,
) {
    use Joint::*;
    let [thigh, shin, ankle, toe] = match side {
        Side::Left => [LeftThigh, LeftShin, LeftFoot, LeftToe],
        Side::Right => [RightThigh, RightShin, RightFoot, RightToe],
    };
    let hip = root + hips * skeleton.offsets[thigh.index()].as_dvec3();
    let (body, _) = throng_runtime::Planar::split(root.as_vec3(), hips.as_quat());
    let to_foot = f64::from(throng_runtime::planar::wrap_angle((foot.yaw - f64::from(body.heading)) as f32));
    let facing = f64::from(body.heading) + 0.6 * to_foot;
    let leg = leg_shape(skeleton).solve(hip, foot.ankle, facing);
    let knee = DQuat::from_rotation_x(leg.knee);
    local[thigh.index()] = hips.inverse() * leg.thigh;
    local[shin.index()] = knee;
    local[ankle.index()] = (leg.thigh * knee).inverse() * foot.rotation();
    local[toe.index()] = DQuat::from_rotation_x(foot.toe_pitch - foot.pitch);
}
