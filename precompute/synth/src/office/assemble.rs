//! From a script to a clip: the walker's body, moved by the keys and onto the chair.

use super::hands::{self, HandFrame};
use super::{KeyedHandPose, KeyedPosture, MotionScript, SEAT, SeatedShare};
use crate::attitude::{Attitude, Trunk};
use crate::frame::{self, Samples};
use crate::side::{LateralSide, forward, leftward, over_ground};
use crate::walk::pelvis::{Pelvis, PelvisInput};
use crate::{SynthConfig, foot::FootShape, walk::assemble::ClipSignals, walk::footsteps};
use glam::DVec3;
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
        Self {
            body: script.body.sample(samples, &[], SOFT[0]),
            head: script.head.sample(samples, &[], SOFT[0]),
            hands: script.hands.each_ref().map(|hand| hand.sample(samples, &[], SOFT[1])),
            seated: samples.times.iter().map(|&t| seated_at(script, t)).collect(),
        }
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
    let shape = FootShape::from_skeleton(skeleton);
    let steps = footsteps::place_footsteps(shape, script.start, &script.steps, script.last_stand(), |_| 0.0, rng);
    let samples = Samples::for_clip(steps.duration, cfg.rate_hz);
    let keyed = KeyedSamples::sample_script(script, &samples);
    let move_pelvis = |pelvis: &mut Pelvis, input: &PelvisInput| move_hips(pelvis, input, &keyed);
    let bend_all = |trunk: &mut [Trunk]| {
        for (i, pose) in trunk.iter_mut().enumerate() {
            bend(pose, &keyed.body[i], keyed.head[i], keyed.seated[i].lean);
        }
    };
    let signals = ClipSignals::new(&steps, skeleton, &samples, cfg.variation, rng, move_pelvis, bend_all);
    let mut clip = frame::empty_clip(name, set, cfg);
    for i in samples.frames() {
        let mut pose = signals.pose(i);
        let held = HandFrame::chest_over_hips(pose.root, pose.hips, pose.trunk, signals.trunk[i][2], skeleton);
        for (k, side) in LateralSide::BOTH.into_iter().enumerate() {
            pose.arms[k] = hands::arm(side, &held, &pose.arms[k], &keyed.hands[k][i], skeleton);
        }
        frame::push_pose(&mut clip, &pose, contacts(script, samples.times[i]), skeleton);
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
    let hands = script.rests.iter().zip([Contacts::LEFT_HAND, Contacts::RIGHT_HAND]);
    for (_, bit) in hands.filter(|(rests, _)| rests.iter().any(|[from, to]| (*from..=*to).contains(&t))) {
        out.insert(bit);
    }
    out
}

/// Turns and moves the hips as keyed, over the feet, and then towards the seat.
fn move_hips(pelvis: &mut Pelvis, input: &PelvisInput, keyed: &KeyedSamples) {
    for (i, body) in keyed.body.iter().enumerate() {
        let h = pelvis.heading[i];
        let shift = leftward(h) * body.shift[0] + forward(h) * body.shift[1];
        pelvis.position[i] += over_ground(shift, 0.0);
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
fn bend(trunk: &mut Trunk, body: &KeyedPosture, head: Attitude, lean: f64) {
    let add = |a: Attitude, b: Attitude, share: f64| Attitude {
        yaw: a.yaw + share * b.yaw,
        pitch: a.pitch + share * b.pitch,
        list: a.list + share * b.list,
    };
    let chest = Attitude { pitch: body.chest.pitch + lean, ..body.chest };
    let head = Attitude { pitch: head.pitch + SHARED[1] * lean, ..head };
    let [spine, middle, upper, neck, top] = trunk;
    // The segments already contain their share of the hips' attitude.
    *spine = add(*spine, chest, 0.3);
    *middle = add(*middle, chest, 0.65);
    *upper = add(*upper, chest, 1.0);
    *neck = add(*neck, chest.mix(head, 0.45), 1.0);
    *top = add(*top, head, 1.0);
}
