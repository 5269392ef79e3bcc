//! Check of everything that a task did, by the means of [`crate::recheck`].

use super::{Pin, PlannedLimb, StageActor, TaskStage, ThingPlacement, TrunkLean, gaze, hand_joint, lean};
use crate::recheck::{OtherClip, RATE_HZ, Recheck, RecheckReport, limit_excess, place_at};
use crate::rotation::{Rigid, angle_between};
use crate::setup::{AllowedContact, SELF_PRESS_M};
use crate::{balance::distance_off_feet, limits::JointLimits};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;
use throng_base::maths;
use throng_core::{Contacts, Joint};
use throng_motion::Clip;

/// Tolerance of grips and targets (m).
const GRIP_M: f64 = 1e-4;
/// Tolerance of their rotations (rad).
const GRIP_RAD: f64 = 1e-3;
/// Tolerance of objects that stay upright (rad).
const TILT_RAD: f64 = 5e-3;
/// Tolerance of planted feet (m).
const PLANTED_M: f64 = 1e-3;
/// Greatest speed of heads that turn aside (rad/s).
const HEAD_RATE: f64 = 5.0;
/// Tolerance of gazes, where necks reach (rad).
const GAZE_RAD: f64 = 0.3;
/// Tolerance of limits and speeds of trunks (rad, rad/s).
const LEAN_RAD: f64 = 5e-3;
/// Tolerated depth of parts in what they do not hold (m).
const PENETRATION_M: f64 = 1e-3;

/// Checks every limb that was planned, grips and targets, and that all else is unchanged.
pub(super) fn check_stage(stage: &TaskStage<'_>) -> RecheckReport {
    let mut report = RecheckReport::default();
    for (who, actor) in stage.actors.iter().enumerate() {
        let planned: Vec<&PlannedLimb> = stage.planned_limbs.iter().filter(|p| p.character == who).collect();
        let limbs = planned.iter().flat_map(|p| p.limb.joints().map(|j| (j, p.window_s)));
        let gazes = stage.gazes.iter().filter(|l| l.character == who);
        let heads = gazes.flat_map(|l| gaze::JOINTS.map(|j| (j, [l.times_s[0], l.times_s[2]])));
        let leans = || stage.leans.iter().filter(|l| l.character == who);
        let trunks = leans().flat_map(|l| lean::leaned_joints(l).map(|j| (j, l.window_s)));
        let hips = leans().filter(|l| l.moves_hips).map(|l| (Joint::Hips, l.window_s));
        let spans: Vec<(Joint, [f64; 2])> = limbs.chain(heads).chain(trunks).chain(hips).collect();
        leans().for_each(|l| check_trunk(actor, l, &mut report));
        crate::recheck::check_unchanged(&actor.before, &actor.clip, &spans, &mut report);
        pieces(stage, who).iter().for_each(|piece| recheck_piece(stage, who, piece, &mut report));
        check_planted_feet(actor, &mut report);
        if stage.task.balance {
            check_balance(actor, &planned, &mut report);
        }
    }
    check_grips(stage, &mut report);
    check_tilts(stage, &mut report);
    check_gazes(stage, &mut report);
    report
}

/// Windows of planned limbs: overlapping ones of a limb are merged, and cut where the limb takes or lays down something.
fn pieces(stage: &TaskStage<'_>, who: usize) -> Vec<PlannedLimb> {
    let mut out: Vec<PlannedLimb> = Vec::new();
    for limb in crate::linkage::Limb::ALL {
        let of = |p: &&PlannedLimb| p.character == who && p.limb == limb;
        let mut cuts: Vec<f64> = stage.planned_limbs.iter().filter(of).flat_map(|p| p.window_s).collect();
        cuts.sort_by(f64::total_cmp);
        cuts.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
        for w in cuts.windows(2) {
            let middle = 0.5 * (w[0] + w[1]);
            let inside = |p: &&PlannedLimb| of(p) && p.window_s[0] < middle && middle < p.window_s[1];
            if let Some(p) = stage.planned_limbs.iter().find(inside) {
                out.push(PlannedLimb { window_s: [w[0], w[1]], ..p.clone() });
            }
        }
    }
    out
}

fn recheck_piece<'s>(stage: &'s TaskStage<'_>, who: usize, piece: &PlannedLimb, report: &mut RecheckReport) {
    let (actor, limb) = (&stage.actors[who], piece.limb);
    let Some(limits) = actor.limits.limb_limits(limb) else { return };
    // Poses of the clip at the ends of any plan of the limb are admitted.
    let ends = stage.planned_limbs.iter().filter(|p| p.character == who && p.limb == piece.limb).flat_map(|p| p.ends);
    let admitted = |i: usize| ends.clone().fold(limits[i], |l: JointLimits, end| l.widened_to_admit(end.0[i]));
    let planned: Vec<(Joint, JointLimits)> =
        piece.limb.joints().into_iter().enumerate().map(|(i, j)| (j, admitted(i))).collect();
    let mut around = stage.surroundings_of_limb(who, piece.limb, piece.window_s);
    // Contacts that another character is allowed with this one hold both ways.
    let name = |i: usize| stage.task.characters[i].name.as_str();
    let touched = stage.contacts.iter().filter(|(by, _, a)| *by != who && a.other == name(who));
    let both_ways = |by: usize, a: &AllowedContact| AllowedContact { part: None, other: name(by).into(), ..a.clone() };
    around.allowed.extend(touched.map(|(by, _, a)| both_ways(*by, a)));
    let others = stage.actors.iter().enumerate().filter(|(i, a)| *i != who && a.worn.is_none());
    let other = |(i, StageActor { clip, skeleton, shape, .. }): (usize, &'s StageActor)| OtherClip {
        name: name(i),
        clip,
        skeleton,
        capsules: &shape.capsules,
    };
    let others: Vec<OtherClip<'_>> = others.map(other).collect();
    let recheck = Recheck {
        skeleton: &actor.skeleton,
        before: &actor.before,
        after: &actor.clip,
        span_s: piece.window_s,
        planned: &planned,
        capsules: &actor.shape.capsules,
        held: &around.held,
        solids: &around.solids,
        others: &others,
        allowed: &around.allowed,
        penetration_m: PENETRATION_M,
        self_press_m: SELF_PRESS_M,
    };
    recheck.check_span(report);
}

/// Checks that bending trunks stay within limits, and within speed limits or the clip's speed.
fn check_trunk(actor: &StageActor, leaned: &TrunkLean, report: &mut RecheckReport) {
    let rate_hz = actor.clip.rate_hz;
    let frames = leaned.window_s.map(|t| ((t * rate_hz).round() as usize).min(actor.clip.num_frames() - 1));
    for joint in lean::SPINE {
        let Some(limits) = actor.limits.joints[joint.index()] else { continue };
        let of = |clip: &Clip, f: usize| clip.frame_rotations(f)[joint.index()];
        for f in frames[0]..=frames[1] {
            let [was, is] = [&actor.before, &actor.clip].map(|c| limit_excess(&limits, of(c, f)));
            let speed = |c: &Clip| match f {
                0 => 0.0,
                _ => angle_between(of(c, f - 1).as_dquat().normalize(), of(c, f).as_dquat().normalize()) * rate_hz,
            };
            let [was_at, is_at] = [&actor.before, &actor.clip].map(speed);
            let mut wrong = |what| report.add_violation(f as f64 / rate_hz, what);
            if is > was.max(0.0) + LEAN_RAD {
                wrong(format!("{} bends {is:.3} rad past its limits", joint.name()));
            }
            if is_at > limits.speed.max(was_at) * (1.0 + LEAN_RAD) + LEAN_RAD {
                wrong(format!("{} bends at {is_at:.2} rad/s", joint.name()));
            }
        }
    }
}

/// Measures how much farther the weight is off the feet than in the clip, while something was planned.
fn check_balance(actor: &StageActor, planned: &[&PlannedLimb], report: &mut RecheckReport) {
    let off = |clip: &Clip, f: usize| {
        let places =
            clip.joint_transforms(&actor.skeleton, f).map(|(position, rotation)| Rigid::from_joint(position, rotation));
        distance_off_feet(&actor.skeleton, &places, actor.before.contacts.get(f).copied().unwrap_or_default())
    };
    for f in 0..actor.clip.num_frames() {
        let t = f as f64 / actor.clip.rate_hz;
        if planned.iter().any(|p| p.window_s[0] <= t && t <= p.window_s[1])
            && let (Some(was), Some(is)) = (off(&actor.before, f), off(&actor.clip, f))
        {
            report.off_balance_m = report.off_balance_m.max(is - was);
        }
    }
}

/// Checks that planted feet stay in place.
fn check_planted_feet(actor: &StageActor, report: &mut RecheckReport) {
    let feet = [(Joint::LeftFoot, Contacts::LEFT), (Joint::RightFoot, Contacts::RIGHT)];
    for (frame, contacts) in actor.before.contacts.iter().enumerate() {
        for (foot, _) in feet.into_iter().filter(|(_, mask)| contacts.any(*mask)) {
            let [a, b] = [&actor.before, &actor.clip].map(|c| c.joint_transforms(&actor.skeleton, frame)[foot.index()]);
            let moved = f64::from(a.0.distance(b.0));
            if moved > PLANTED_M {
                let what = format!("{} stands and moved by {moved:.4} m", foot.name());
                report.add_violation(frame as f64 / actor.before.rate_hz, what);
            }
        }
    }
}

/// Checks that heads which look aside stay where necks allow, turn no faster than heads do, and face their target as far as
/// that goes.
fn check_gazes(stage: &TaskStage<'_>, report: &mut RecheckReport) {
    for sample in &stage.gazes {
        let actor = &stage.actors[sample.character];
        let rate_hz = actor.clip.rate_hz;
        let frames = sample.times_s.map(|t| (t * rate_hz).round() as usize);
        // Rotation of the head away from the clip, relative to the chest.
        let turned = |frame: usize| {
            let [a, b] = [&actor.before, &actor.clip].map(|clip| {
                let all = clip.joint_transforms(&actor.skeleton, frame);
                maths::compose(all[Joint::UpperChest.index()].1.inverse(), all[Joint::Head.index()].1)
            });
            maths::compose(a.inverse(), b).normalize().as_dquat()
        };
        let mut violation = |frame: usize, what: String| report.add_violation(frame as f64 / rate_hz, what);
        for frame in frames[0] + 1..=frames[2].min(actor.clip.num_frames() - 1) {
            let [before, after] = [frame - 1, frame].map(turned);
            let speed = angle_between(before.normalize(), after.normalize()) * rate_hz;
            if speed > HEAD_RATE {
                violation(frame, format!("head turns aside at {speed:.2} rad/s, at most {HEAD_RATE}"));
            }
        }
        let all = actor.clip.joint_transforms(&actor.skeleton, frames[1]);
        let [chest, head] = [Joint::UpperChest, Joint::Head].map(|j| all[j.index()]);
        let to = (sample.target.as_vec3() - head.0).normalize_or(Vec3::Z);
        let face = head.1 * Vec3::Z;
        let off = f64::from(face.angle_between(to));
        // Turn of the neck from the chest to the sides, up and down; a target behind that is not faced.
        let angles = |v: Vec3| [v.x.atan2(v.z), v.y.atan2(v.x.hypot(v.z))].map(f64::from);
        let ([wanted, up], [chest, _]) = (angles(to), angles(chest.1 * Vec3::Z));
        let aside = (wanted - chest + PI).rem_euclid(2.0 * PI) - PI;
        let past = [aside.abs() - gaze::FARTHEST[0], up.abs() - gaze::FARTHEST[1]].map(|x| x.max(0.0));
        let beyond = past[0].hypot(past[1]);
        if off > beyond + GAZE_RAD {
            violation(frames[1], format!("head looks {off:.2} rad past what is reached for"));
        }
        report.gaze_off_rad = report.gaze_off_rad.max(off - beyond);
    }
}

/// Checks that objects which have to stay upright do so, all the way to their place.
fn check_tilts(stage: &TaskStage<'_>, report: &mut RecheckReport) {
    for step in &stage.task.steps {
        let (Some(level_rad), Some(thing)) = (step.level_rad, step.object) else { continue };
        let actor = &stage.actors[step.character];
        let [from_s, at_s, _] = step.times_s.map(|t| (t * actor.clip.rate_hz).round() / actor.clip.rate_hz);
        let there = |p: &Pin| (p.character, p.limb) == (step.character, step.limb) && (p.time_s - at_s).abs() < 1e-6;
        let ThingPlacement::OnJoint { joint, offset, .. } = stage.placement_at(thing, 0.5 * (from_s + at_s)) else {
            continue;
        };
        if !stage.pins.iter().any(there) {
            continue;
        }
        let tilt = |sample: usize| {
            let time_s = from_s + sample as f64 / RATE_HZ;
            let up = place_at(&actor.clip, &actor.skeleton, *joint, time_s).compose(*offset).rotation * DVec3::Y;
            (up.angle_between(DVec3::Y), time_s)
        };
        let (most, time_s) = (0..=((at_s - from_s) * RATE_HZ) as usize)
            .map(tilt)
            .fold((0.0, from_s), |a, b| if b.0 > a.0 { b } else { a });
        if most > level_rad + TILT_RAD {
            let name = &stage.task.things[thing].name;
            let what = format!("`{name}` tilts by {most:.3} rad, {level_rad:.3} rad at most");
            report.add_violation(time_s, what);
        }
    }
}

/// Checks that hands are at their targets, and things where they are taken, let go and passed on.
fn check_grips(stage: &TaskStage<'_>, report: &mut RecheckReport) {
    let compare = |report: &mut RecheckReport, time_s: f64, what: String, a: &Rigid, b: &Rigid| {
        let (apart, turned) = (a.position.distance(b.position), angle_between(a.rotation, b.rotation));
        if apart > GRIP_M || turned > GRIP_RAD {
            let what = format!("{what} is off by {apart:.5} m and {turned:.4} rad");
            report.add_violation(time_s, what);
        }
    };
    for pin in &stage.pins {
        let at = joint_in_clip(&stage.actors[pin.character], hand_joint(pin.limb), pin.time_s);
        compare(report, pin.time_s, format!("{} at its target", hand_joint(pin.limb).name()), &at, &pin.target);
    }
    for (thing, life) in stage.task.things.iter().zip(&stage.placements) {
        for pair in life.windows(2) {
            let time_s = pair[1].from_s;
            let [a, b] = [&pair[0].placement, &pair[1].placement].map(|at| match at {
                ThingPlacement::OnJoint { character, joint, offset, .. } => {
                    joint_in_clip(&stage.actors[*character], *joint, time_s).compose(*offset)
                }
                at => stage.resolve_placement(at, time_s, 0),
            });
            compare(report, time_s, format!("`{}` as it changes hands", thing.name), &a, &b);
        }
        for (k, stretch) in life.iter().enumerate() {
            let ThingPlacement::OnJoint { character, joint, second: Some(second), .. } = &stretch.placement else {
                continue;
            };
            let actor = &stage.actors[*character];
            let (rate_hz, end_s) = (actor.clip.rate_hz, life.get(k + 1).map_or(actor.end_s(), |next| next.from_s));
            let frames = [stretch.from_s, end_s].map(|t| (t * rate_hz).round() as usize);
            for frame in frames[0]..=frames[1].min(actor.clip.num_frames() - 1) {
                let time_s = frame as f64 / rate_hz;
                let [first, other] = [*joint, hand_joint(second.limb)].map(|j| joint_in_clip(actor, j, time_s));
                let what = format!("{} at `{}`", hand_joint(second.limb).name(), thing.name);
                compare(report, time_s, what, &first.compose(second.grip), &other);
            }
            let num_samples = ((end_s - stretch.from_s) * RATE_HZ) as usize;
            for sample in 0..=num_samples {
                let time_s = stretch.from_s + sample as f64 / RATE_HZ;
                let [first, other] =
                    [*joint, hand_joint(second.limb)].map(|j| place_at(&actor.clip, &actor.skeleton, j, time_s));
                let off_m = first.transform_point(second.grip.position).distance(other.position);
                report.second_hand_off_m = report.second_hand_off_m.max(off_m);
            }
        }
    }
}

/// Transform of a joint by the clip's own kinematics, at the nearest frame.
fn joint_in_clip(actor: &StageActor, joint: Joint, time_s: f64) -> Rigid {
    let frame = ((time_s * actor.clip.rate_hz).round().max(0.0) as usize).min(actor.clip.num_frames() - 1);
    let (position, rotation) = actor.clip.joint_transforms(&actor.skeleton, frame)[joint.index()];
    Rigid::from_joint(position, rotation)
}
