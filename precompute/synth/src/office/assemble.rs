//! From a script to a clip: the walker's body, moved by the keys and onto the chair.

use super::super::SynthConfig;
use super::super::attitude::Attitude;
use super::super::foot::FootShape;
use super::super::frame::{self, ArmPose, BodyPose, Samples};
use super::super::side::{LateralSide, forward, leftward};
use super::super::walk::assemble::{ClipSignals, knees};
use super::super::walk::footsteps::{self, Footsteps};
use super::super::walk::pelvis::{Pelvis, PelvisInput};
use super::super::walk::trunk::TrunkPose;
use super::desk::SEAT;
use super::hands::{self, HandFrame};
use super::posture::{KeyedHandPose, KeyedPosture};
use super::script::MotionScript;
use super::seat::SeatedShare;
use glam::{DQuat, DVec3};
use rand::Rng;
use throng_core::{Contacts, Skeleton};
use throng_motion::clip::Clip;

/// Point that touches the seat, relative to the hips joint (m).
pub const BUTTOCKS: DVec3 = DVec3::new(0.0, -0.135, -0.03);
/// Shares of the chest's lean in the hips and the head.
const SHARED: [f64; 2] = [0.5, 0.5];
/// Smoothing of keyed postures, and of hands (s).
const SOFT: [f64; 2] = [0.06, 0.035];

/// Values of the keys at every sample.
struct KeyedSamples {
    body: Vec<KeyedPosture>,
    head: Vec<Attitude>,
    hands: [Vec<KeyedHandPose>; 2],
    seated: Vec<SeatedShare>,
}

impl KeyedSamples {
    fn sample_script(script: &MotionScript, samples: &Samples) -> Self {
        let (times, dt) = (&samples.times, samples.dt);
        let body =
            script.body.sample(times, &[0.0; 9], SOFT[0], dt).into_iter().map(KeyedPosture::from_channels).collect();
        let head = script.head.sample(times, &[0.0; 3], SOFT[0], dt).into_iter();
        let head = head.map(|[yaw, pitch, list]| Attitude { yaw, pitch, list }).collect();
        let hands = [0, 1].map(|i: usize| {
            let sampled = script.hands[i].sample(times, &[0.0; 15], SOFT[1], dt);
            sampled.into_iter().map(KeyedHandPose::from_channels).collect()
        });
        Self { body, head, hands, seated: times.iter().map(|&t| seated_at(script, t)).collect() }
    }
}

fn seated_at(script: &MotionScript, t: f64) -> SeatedShare {
    let next = script.sittings.partition_point(|s| s.down[0] <= t);
    next.checked_sub(1).map_or(SeatedShare::default(), |i| script.sittings[i].state_at(t))
}

/// Makes a clip of a set from a script.
pub fn clip(
    set: &str,
    name: String,
    script: &MotionScript,
    skeleton: &Skeleton,
    cfg: &SynthConfig,
    rng: &mut impl Rng,
) -> Clip {
    let steps = footsteps::place_footsteps(
        FootShape::from_skeleton(skeleton),
        script.start,
        &script.steps,
        script.last_stand(),
        rng,
    );
    let samples = Samples::for_clip(steps.duration, cfg.rate_hz);
    let poses = poses(script, &steps, &samples, skeleton, cfg.variation, rng);
    let mut clip = frame::empty_clip(name, set, cfg);
    for i in samples.frames() {
        frame::push_pose(&mut clip, &poses[i], skeleton);
        let frame = clip.contacts.len() - 1;
        clip.contacts[frame].insert(contacts(script, samples.times[i]));
    }
    frame::add_tags(&mut clip, script.tags.iter().copied());
    clip.tags.retain(|t| !t.range.is_empty());
    clip
}

/// Contacts of seat and hands at a time.
fn contacts(script: &MotionScript, t: f64) -> Contacts {
    let mut out = Contacts::NONE;
    if seated_at(script, t).carried {
        out.insert(Contacts::SEAT);
    }
    for (rests, bit) in script.rests.iter().zip([Contacts::LEFT_HAND, Contacts::RIGHT_HAND]) {
        if rests.iter().any(|[from, to]| (*from..=*to).contains(&t)) {
            out.insert(bit);
        }
    }
    out
}

fn poses(
    script: &MotionScript,
    steps: &Footsteps,
    samples: &Samples,
    skeleton: &Skeleton,
    variation: f64,
    rng: &mut impl Rng,
) -> Vec<BodyPose> {
    let keyed = KeyedSamples::sample_script(script, samples);
    let bend_all = |trunk: &mut [TrunkPose]| {
        for (i, pose) in trunk.iter_mut().enumerate() {
            bend(pose, &keyed.body[i], keyed.head[i], keyed.seated[i].lean);
        }
    };
    let move_pelvis = |pelvis: &mut Pelvis, input: &PelvisInput| move_hips(pelvis, input, &keyed);
    let s = ClipSignals::new(steps, skeleton, samples, variation, rng, move_pelvis, bend_all);
    let keys = |i: usize| [&keyed.hands[0][i], &keyed.hands[1][i]];
    let whole = |i: usize| pose(&s.pelvis, &s.trunk[i], s.arms[i], s.feet[i], keys(i), i, skeleton);
    (0..samples.times.len()).map(whole).collect()
}

/// Turns and moves the hips as keyed, over the feet, and then towards the seat.
fn move_hips(pelvis: &mut Pelvis, input: &PelvisInput, keyed: &KeyedSamples) {
    for (i, body) in keyed.body.iter().enumerate() {
        let h = pelvis.heading[i];
        let shift = leftward(h) * body.shift[0] + forward(h) * body.shift[1];
        pelvis.position[i] += DVec3::new(shift.x, 0.0, shift.y);
        pelvis.yaw[i] += body.hips.yaw;
        pelvis.pitch[i] += body.hips.pitch + SHARED[0] * keyed.seated[i].lean;
        // A lifted foot does not tilt the hips of a seated body.
        pelvis.list[i] = pelvis.list[i] * (1.0 - keyed.seated[i].down) + body.hips.list;
    }
    pelvis.stand_up(input);
    for (i, (body, seated)) in keyed.body.iter().zip(&keyed.seated).enumerate() {
        let sitting = SEAT - pelvis.rotation(i) * BUTTOCKS;
        let p = &mut pelvis.position[i];
        let away = sitting - *p;
        *p += DVec3::new(seated.back * away.x, seated.down * away.y, seated.back * away.z);
        p.y -= body.dip * (1.0 - seated.down);
    }
}

/// Bends the trunk by the keys: the spine shares the turn of the chest, the neck lies between chest and head.
fn bend(pose: &mut TrunkPose, body: &KeyedPosture, head: Attitude, lean: f64) {
    let add = |a: Attitude, b: Attitude, share: f64| Attitude {
        yaw: a.yaw + share * b.yaw,
        pitch: a.pitch + share * b.pitch,
        list: a.list + share * b.list,
    };
    let chest = Attitude { pitch: body.chest.pitch + lean, ..body.chest };
    let head = Attitude { pitch: head.pitch + SHARED[1] * lean, ..head };
    let [spine, middle, upper, neck, top] = &mut pose.segments;
    // The segments already contain their share of the hips' attitude.
    *spine = add(*spine, chest, 0.3);
    *middle = add(*middle, chest, 0.65);
    *upper = add(*upper, chest, 1.0);
    *neck = add(*neck, chest.mix(head, 0.45), 1.0);
    *top = add(*top, head, 1.0);
}

fn pose(
    pelvis: &Pelvis,
    trunk: &TrunkPose,
    hanging: [ArmPose; 2],
    feet: [super::super::foot::FootPose; 2],
    keyed: [&KeyedHandPose; 2],
    i: usize,
    skeleton: &Skeleton,
) -> BodyPose {
    let (root, hips) = (pelvis.position[i], pelvis.rotation(i));
    let world: [DQuat; 5] = trunk.segments.map(Attitude::rotation);
    let held = HandFrame::chest_over_hips(root, hips, world, trunk.upper_chest(), skeleton);
    let arms = [0, 1].map(|k: usize| hands::arm(LateralSide::BOTH[k], &held, &hanging[k], keyed[k], skeleton));
    BodyPose { root, hips, trunk: world, arms, feet, knees: knees(root, hips, &feet) }
}
