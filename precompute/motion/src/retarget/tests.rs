use super::names::unique_names;
use super::*;
use crate::clip::Clip;
use crate::export::to_raw;
use crate::raw::{RawClip, RawJoint, SourceFormat};
use body::Roles;
use glam::Quat;
use proptest::prelude::*;
use throng_core::NUM_JOINTS;

/// Number of frames of the made-up motion.
const FRAMES: usize = 40;

/// Database rotations of a body that walks in a circle, bending knees and elbows, with feet flat in between.
fn motion(skeleton: &Skeleton) -> Clip {
    use Joint::*;
    let mut rotations = Vec::new();
    let mut root_positions = Vec::new();
    for f in 0..FRAMES {
        let t = f as f32 * 0.17;
        let swing = if f < 10 { 0.0 } else { t.sin() };
        let mut local = [Quat::IDENTITY; NUM_JOINTS];
        local[0] = Quat::from_rotation_y(0.05 * f as f32) * Quat::from_rotation_x(0.1 * swing);
        local[Spine.index()] = Quat::from_rotation_x(0.15 * swing);
        local[UpperChest.index()] = Quat::from_rotation_y(0.2 * swing);
        local[Head.index()] = Quat::from_rotation_y(-0.3 * swing);
        for (side, thigh, shin, arm, forearm) in [
            (1.0, LeftThigh, LeftShin, LeftUpperArm, LeftForearm),
            (-1.0, RightThigh, RightShin, RightUpperArm, RightForearm),
        ] {
            local[thigh.index()] = Quat::from_rotation_x(-0.5 * side * swing);
            local[shin.index()] = Quat::from_rotation_x(0.6 * swing.abs());
            local[arm.index()] = Quat::from_rotation_z(-1.2 * side) * Quat::from_rotation_x(0.4 * swing);
            local[forearm.index()] = Quat::from_rotation_y(-side * (0.2 + 0.5 * swing.abs()));
        }
        rotations.extend(local);
        root_positions.push(skeleton.offsets[0] + Vec3::new(0.02 * f as f32, 0.0, 0.01 * f as f32) * swing.abs());
    }
    let mut clip = Clip {
        name: "made".into(),
        source: "made.bvh".into(),
        mirrored: false,
        rate_hz: 30.0,
        root_positions,
        rotations,
        contacts: Vec::new(),
        excluded: Vec::new(),
        tags: Vec::new(),
        hits: Vec::new(),
        classes: Vec::new(),
        support: Vec::new(),
    };
    // The lower foot is always on the ground, so that there is a right answer to where the ground is.
    let rest = skeleton.rest_positions();
    for f in 0..FRAMES {
        let p = clip.joint_positions(skeleton, f);
        let clearance = |j: &Joint| p[j.index()].y - rest[j.index()].y;
        let lowest = [LeftFoot, LeftToe, RightFoot, RightToe].iter().map(clearance).fold(f32::INFINITY, f32::min);
        clip.root_positions[f].y -= lowest;
    }
    clip
}

/// The motion on a rig whose joints have other axes: each one's are turned by `axes` against the database's, and the
/// rest pose is whatever results from identity rotations. Joints in `left_out` play no role.
fn rig(clip: &Clip, skeleton: &Skeleton, axes: &[Quat; NUM_JOINTS], left_out: &[Joint]) -> (RawClip, Roles) {
    let mut raw = to_raw(clip, skeleton);
    raw.joints.truncate(NUM_JOINTS);
    let parent_axes = |j: Joint| j.parent().map_or(Quat::IDENTITY, |p| axes[p.index()]);
    raw.joints = Joint::ALL
        .map(|j| RawJoint {
            offset: parent_axes(j).inverse() * skeleton.offsets[j.index()],
            rest_rotation: Quat::IDENTITY,
            ..raw.joints[j.index()].clone()
        })
        .to_vec();
    raw.format = SourceFormat::Bvh;
    raw.translations.clear();
    raw.rotations.clear();
    for f in 0..clip.num_frames() {
        for j in Joint::ALL {
            let offset = raw.joints[j.index()].offset;
            raw.translations.push(if j == Joint::Hips { clip.root_positions[f] } else { offset });
            let local = clip.frame_rotations(f)[j.index()];
            raw.rotations.push((parent_axes(j).inverse() * local * axes[j.index()]).normalize());
        }
    }
    (raw, Joint::ALL.map(|j| (!left_out.contains(&j)).then_some(j.index())))
}

fn lay(raw: &RawClip, roles: &Roles, proportions: Proportions, align_ground: bool) -> ClipSet {
    let cfg = RetargetConfig { proportions, align_ground };
    retarget_sources(&[RetargetSource { clip: raw, roles, heading: None, turn: None }], &cfg, &mut Warnings::default())
        .unwrap()
}

/// Largest distance between a role's joint and the source's (m).
fn worst_distance(set: &ClipSet, raw: &RawClip, roles: &Roles) -> f32 {
    let mut worst = 0.0f32;
    for f in 0..raw.num_frames {
        let (world, retargeted) = (raw.world(f), set.clips[0].joint_positions(&set.skeleton, f));
        for j in Joint::ALL {
            if let Some(s) = roles[j.index()] {
                worst = worst.max((world[s].0 - retargeted[j.index()]).length());
            }
        }
    }
    worst
}

#[test]
fn a_performer_is_measured_on_the_first_ten_minutes_alone() {
    let s = Skeleton::default();
    let (raw, roles) = rig(&motion(&s), &s, &PLAIN, &[]);
    // 400 s a clip; the third one bends its knees the other way.
    let slow = RawClip { rate_hz: 0.1, ..raw };
    let mut odd = slow.clone();
    odd.rotations.iter_mut().for_each(|q| *q = q.inverse());
    let plan = |clips: &[&RawClip]| {
        let sources: Vec<RetargetSource> =
            clips.iter().map(|clip| RetargetSource { clip, roles: &roles, heading: None, turn: None }).collect();
        let mut plan = RetargetPlan::new(
            &sources,
            &*provide_from_memory(&sources),
            &RetargetConfig::default(),
            &mut Warnings::default(),
        )
        .unwrap();
        plan.set_floor(
            0,
            plan.find_floor(0, &*provide_from_memory(&sources)).unwrap(),
            &*provide_from_memory(&sources),
        )
        .unwrap();
        (plan.performers[0].measured_clips.clone(), serde_json::to_string(&plan.basis(0)).unwrap())
    };
    let two = plan(&[&slow, &slow]);
    assert_eq!(two.0, [0, 1]);
    assert_eq!(plan(&[&slow, &slow, &odd]), two);
    assert!(plan(&[&slow, &odd, &slow]).1 != two.1);
    assert_eq!(plan(&[&slow]).0, [0]);
}

const PLAIN: [Quat; NUM_JOINTS] = [Quat::IDENTITY; NUM_JOINTS];

#[test]
fn a_clip_on_the_database_skeleton_comes_back_as_it_was() {
    let s = Skeleton::default();
    let clip = motion(&s);
    let (raw, roles) = rig(&clip, &s, &PLAIN, &[]);
    let set = lay(&raw, &roles, Proportions::Default, true);
    for (f, p) in clip.root_positions.iter().enumerate() {
        assert!((set.clips[0].root_positions[f] - *p).length() < 1e-4, "frame {f}");
        for (j, (a, b)) in Joint::ALL.iter().zip(clip.frame_rotations(f).iter().zip(set.clips[0].frame_rotations(f))) {
            assert!(a.dot(*b).abs() > 1.0 - 1e-4, "frame {f}, {}: {a} {b}", j.name());
        }
    }
}

#[test]
fn a_rig_with_all_segments_along_one_axis_gives_the_same_rotations() {
    let s = Skeleton::default();
    let clip = motion(&s);
    // Each joint's X axis lies along its segment, the others square to the body, as in Bandai-Namco's and LAFAN1's.
    let mut axes = PLAIN;
    for j in Joint::ALL {
        use Joint::*;
        axes[j.index()] = match j {
            LeftThigh | LeftShin | RightThigh | RightShin => Quat::from_rotation_z(-std::f32::consts::FRAC_PI_2),
            LeftFoot | LeftToe | RightFoot | RightToe => Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2),
            Hips | Spine | Chest | UpperChest | Neck | Head => Quat::from_rotation_z(std::f32::consts::FRAC_PI_2),
            _ => Quat::IDENTITY,
        };
    }
    let (raw, roles) = rig(&clip, &s, &axes, &[]);
    let body = SourceBody::measure(&[RetargetSource { clip: &raw, roles: &roles, heading: None, turn: None }]);
    assert!(body.rest.is_none(), "the rest pose must not be a body");
    let set = lay(&raw, &roles, Proportions::Default, false);
    for f in 0..FRAMES {
        for (j, (a, b)) in Joint::ALL.iter().zip(clip.frame_rotations(f).iter().zip(set.clips[0].frame_rotations(f))) {
            assert!(a.dot(*b).abs() > 0.9995, "frame {f}, {}: {a} {b}", j.name());
        }
    }
}

#[test]
fn an_a_pose_facing_elsewhere_is_aligned() {
    use Joint::*;
    let s = Skeleton::default();
    let clip = motion(&s);
    // A rest pose with the arms lowered by 45 degrees that faces +X: axes are those of the rest pose.
    let turn = Quat::from_rotation_y(std::f32::consts::FRAC_PI_2);
    let lowered = |side: f32| Quat::from_rotation_z(-side * std::f32::consts::FRAC_PI_4);
    let mut axes = [turn.inverse(); NUM_JOINTS];
    for (side, arms) in [(1.0, [LeftUpperArm, LeftForearm, LeftHand]), (-1.0, [RightUpperArm, RightForearm, RightHand])]
    {
        arms.iter().for_each(|j| axes[j.index()] = lowered(side).inverse() * turn.inverse());
    }
    let (mut raw, roles) = rig(&clip, &s, &axes, &[]);
    raw.joints[0].offset = s.offsets[0];
    let set = lay(&raw, &roles, Proportions::Default, false);
    for f in 0..FRAMES {
        for (j, (a, b)) in Joint::ALL.iter().zip(clip.frame_rotations(f).iter().zip(set.clips[0].frame_rotations(f))) {
            assert!(a.dot(*b).abs() > 0.9995, "frame {f}, {}: {a} {b}", j.name());
        }
    }
}

#[test]
fn missing_roles_leave_the_others_in_place() {
    use Joint::*;
    let s = Skeleton::default();
    let still = |mut c: Clip| {
        // What is left out must not bend for the rest to hang rigidly.
        for f in 0..FRAMES {
            for j in [Chest, UpperChest, Neck, LeftClavicle, RightClavicle] {
                c.rotations[f * NUM_JOINTS + j.index()] = Quat::IDENTITY;
            }
        }
        c
    };
    let left_out = [Chest, UpperChest, Neck, LeftClavicle, RightClavicle, LeftHand, RightToe];
    let (raw, roles) = rig(&still(motion(&s)), &s, &PLAIN, &left_out);
    let set = lay(&raw, &roles, Proportions::Clip, false);
    assert!(worst_distance(&set, &raw, &roles) < 1e-4);
    assert!(set.skeleton.offsets.iter().all(|o| o.is_finite() && o.length() > 0.005));
}

#[test]
fn a_child_of_half_the_size_walks_half_as_far_on_the_ground() {
    let s = Skeleton::default();
    let clip = motion(&s);
    let small = Skeleton { offsets: s.offsets.map(|o| o * 0.5), tips: s.tips.map(|o| o * 0.5) };
    let mut half = clip.clone();
    // The file's floor lies at 0.3 m.
    half.root_positions.iter_mut().for_each(|p| *p = *p * 0.5 + Vec3::Y * 0.3);
    let (raw, roles) = rig(&half, &small, &PLAIN, &[]);
    let set = lay(&raw, &roles, Proportions::Default, true);
    for (a, b) in set.clips[0].root_positions.iter().zip(&clip.root_positions) {
        assert!((*a - *b).length() < 1e-4, "{a} {b}");
    }
}

#[test]
fn a_given_heading_of_the_rest_pose_turns_the_body() {
    let s = Skeleton::default();
    let (raw, roles) = rig(&motion(&s), &s, &PLAIN, &[]);
    let hips = |heading| {
        let sources = [RetargetSource { clip: &raw, roles: &roles, heading, turn: None }];
        let set = retarget_sources(&sources, &RetargetConfig::default(), &mut Warnings::default()).unwrap();
        set.clips[0].planar(0).heading
    };
    let found = hips(None);
    assert!((hips(Some(0.0)) - found).abs() < 1e-4);
    let quarter = std::f32::consts::FRAC_PI_2;
    assert!((hips(Some(quarter)) - found - quarter).abs() < 1e-3, "{} {found}", hips(Some(quarter)));
}

#[test]
fn clips_of_one_name_are_told_apart_by_folders() {
    let s = Skeleton::default();
    let (raw, roles) = rig(&motion(&s), &s, &PLAIN, &[]);
    let at = |path: &str| RawClip { path: path.into(), ..raw.clone() };
    let clips = [at("a/made.bvh"), at("b/made.bvh"), at("b/made.bvh")];
    let sources: Vec<RetargetSource> =
        clips.iter().map(|clip| RetargetSource { clip, roles: &roles, heading: None, turn: None }).collect();
    let mut warnings = Warnings::default();
    let names = unique_names(&sources, &mut warnings);
    assert_eq!(&names[..2], ["a/made", "b/made"]);
    assert_ne!(names[1], names[2]);
    assert!(
        warnings.messages[0].contains("the name `made`: their clips are called `a/made`, `b/made`"),
        "{warnings:?}"
    );
    // Names are relative to the folder that was given: what tells them apart stands before that.
    let within = |path: &str| RawClip { path: path.into(), name: "slow/made".into(), ..raw.clone() };
    let clips = [within("x/a/slow/made.bvh"), within("y/a/slow/made.bvh"), at("x/a/slow/other.bvh")];
    let sources: Vec<RetargetSource> =
        clips.iter().map(|clip| RetargetSource { clip, roles: &roles, heading: None, turn: None }).collect();
    let names = unique_names(&sources, &mut Warnings::default());
    assert_eq!(names, ["x/a/slow/made", "y/a/slow/made", "made"]);
}

#[test]
fn refuses_what_has_no_legs() {
    let s = Skeleton::default();
    let (raw, roles) = rig(&motion(&s), &s, &PLAIN, &[Joint::LeftShin]);
    let sources = [RetargetSource { clip: &raw, roles: &roles, heading: None, turn: None }];
    let e = retarget_sources(&sources, &RetargetConfig::default(), &mut Warnings::default()).unwrap_err().to_string();
    assert!(e.contains("made.bvh") && e.contains("left_shin") && e.contains("profile"), "{e}");
    let wrong = ExplicitProportions { offsets: [("left_shine".to_string(), [0.0; 3])].into() };
    assert!(wrong.skeleton().unwrap_err().to_string().contains("left_shine"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn own_proportions_reproduce_every_joint_whatever_the_axes(
        angles in prop::collection::vec(prop::array::uniform3(-3.0f32..3.0), NUM_JOINTS),
        lengths in prop::collection::vec(0.7f32..1.3, NUM_JOINTS),
    ) {
        let mut s = Skeleton::default();
        s.offsets.iter_mut().zip(&lengths).for_each(|(o, l)| *o *= *l);
        let mut axes = PLAIN;
        for (q, a) in axes.iter_mut().zip(&angles) {
            *q = Quat::from_scaled_axis(Vec3::from_array(*a));
        }
        let (raw, roles) = rig(&motion(&s), &s, &axes, &[]);
        let set = lay(&raw, &roles, Proportions::Clip, false);
        prop_assert!(worst_distance(&set, &raw, &roles) < 1e-4);
        let own = SkeletonGroup::measure_one(RetargetSource { clip: &raw, roles: &roles, heading: None, turn: None }).unwrap().own;
        prop_assert_eq!(&set.skeleton, &own);
        for f in 1..FRAMES {
            let pairs = set.clips[0].frame_rotations(f - 1).iter().zip(set.clips[0].frame_rotations(f));
            prop_assert!(pairs.into_iter().all(|(a, b)| a.dot(*b) > 0.0));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn feet_are_where_the_sources_are_whatever_the_proportions(
        lengths in prop::collection::vec(0.85f32..1.15, NUM_JOINTS),
    ) {
        use Joint::*;
        // Both legs are of one length, as the target's are. Straight ones fall short by what hips of another width take:
        // millimetres.
        let mut s = Skeleton::default();
        for j in Joint::ALL {
            s.offsets[j.index()] *= lengths[j.index().min(j.mirrored().index())];
        }
        let (raw, roles) = rig(&motion(&s), &s, &PLAIN, &[LeftToe, RightToe]);
        let set = lay(&raw, &roles, Proportions::Default, false);
        let own = SkeletonGroup::measure_one(RetargetSource { clip: &raw, roles: &roles, heading: None, turn: None }).unwrap().own;
        let scale = set.skeleton.leg_length() / own.leg_length();
        for foot in [LeftFoot, RightFoot] {
            let off = |f: usize| {
                let source = raw.world(f)[foot.index()].0;
                set.clips[0].joint_positions(&set.skeleton, f)[foot.index()] - source * scale
            };
            let first = off(0);
            prop_assert!(first.with_y(0.0).length() < 8e-3, "{first}");
            for f in 1..FRAMES {
                prop_assert!((off(f) - first).length() < 8e-3, "frame {f}: {} {first}", off(f));
            }
        }
    }
}

#[test]
fn written_back_and_read_again_nothing_moves() {
    let s = Skeleton::default();
    let clip = motion(&s);
    let raw = to_raw(&clip, &s);
    assert_eq!(raw.joints.len(), NUM_JOINTS + 3);
    for f in 0..FRAMES {
        let (world, want) = (raw.world(f), clip.joint_transforms(&s, f));
        for j in Joint::ALL {
            assert!((world[j.index()].0 - want[j.index()].0).length() < 1e-5);
        }
        let head = want[Joint::Head.index()];
        assert!((world[NUM_JOINTS].0 - (head.0 + head.1 * s.tips[0])).length() < 1e-5);
    }
}

/// A body that stands at places along a winding way, and hops from each to the next.
fn stops(skeleton: &Skeleton, stops: usize) -> Clip {
    let at = |k: usize| Vec3::new((0.7 * k as f32).sin(), 0.0, 0.25 * k as f32);
    let (mut roots, mut rotations) = (Vec::new(), Vec::new());
    for f in 0..stops * 15 {
        let (k, ratio) = (f / 15, ((f % 15) as f32 - 10.0).max(0.0) / 5.0);
        roots.push(skeleton.offsets[0] + at(k).lerp(at(k + 1), ratio));
        let mut local = [Quat::IDENTITY; NUM_JOINTS];
        local[0] = Quat::from_rotation_y(0.9 * (k as f32 + ratio));
        rotations.extend(local);
    }
    Clip::new("stops", 30.0, roots, rotations)
}

/// How far feet stand from the ground (m), and the body leans (rad), at most.
fn off_ground(set: &ClipSet) -> (f32, f32) {
    let clip = &set.clips[0];
    let lean = |f: usize| (clip.frame_rotations(f)[0] * Vec3::Y).angle_between(Vec3::Y);
    let lean = (0..clip.num_frames()).map(lean).fold(0.0, f32::max);
    (crate::annotate::contact_sanity(clip, &set.skeleton).stance.p95_cm / 100.0, lean)
}

#[test]
fn people_stand_upright_on_floors_that_were_tilted_or_drift() {
    let s = Skeleton::default();
    let (raw, roles) = rig(&stops(&s, 20), &s, &PLAIN, &[]);
    for k in 0..12 {
        let (degrees, distance, drift) = ([2.5, 4.0, 6.0, 8.0][k % 4], 0.7 * k as f32, [0.0, 0.006, -0.015][k / 4]);
        let tilt = Quat::from_axis_angle(Vec3::new(distance.cos(), 0.0, distance.sin()), f32::to_radians(degrees));
        let mut raw = raw.clone();
        for f in 0..raw.num_frames {
            let (hips, rise) = (f * NUM_JOINTS, Vec3::Y * (drift * f as f32 / 30.0));
            raw.translations[hips] = tilt * raw.translations[hips] + rise;
            raw.rotations[hips] = tilt * raw.rotations[hips];
        }
        let (far, lean) = off_ground(&lay(&raw, &roles, Proportions::Default, true));
        // On a way that leads on, some of what rises with time seems to rise with the way.
        assert!(far < 0.01 && lean < 0.02 + drift.abs(), "{degrees} degrees, {drift} m/s: {far} m, {lean} rad");
        let (far, _) = off_ground(&lay(&raw, &roles, Proportions::Default, false));
        assert!(far > 0.05, "{far}");
    }
}

#[test]
fn stairs_stay_stairs() {
    let s = Skeleton::default();
    let clip = stops(&s, 20);
    for (rise, every) in [(0.17, 1), (0.17, 3), (0.06, 2), (0.1, 4)] {
        let mut clip = clip.clone();
        for (f, p) in clip.root_positions.iter_mut().enumerate() {
            p.y += rise * (f / 15 / every) as f32;
        }
        let (raw, roles) = rig(&clip, &s, &PLAIN, &[]);
        let retargeted = lay(&raw, &roles, Proportions::Default, true);
        let climbed = |c: &Clip| c.root_positions[c.num_frames() - 1].y - c.root_positions[0].y;
        assert!((climbed(&retargeted.clips[0]) - climbed(&clip)).abs() < 1e-3, "{rise} m each {every}");
        assert!(off_ground(&retargeted).1 < 1e-3);
    }
}

#[test]
fn rest_poses_that_crouch_or_lean_are_aligned() {
    use Joint::*;
    let s = Skeleton::default();
    let clip = motion(&s);
    for (thigh, shin, lean) in [
        (10.0, 20.0, 0.0),
        (20.0, 34.0, 0.0),
        (34.0, 34.0, 0.0),
        (40.0, 43.0, 15.0),
        (0.0, 0.0, 13.0),
        (0.0, 0.0, 25.0),
        (0.0, 0.0, -14.0),
        (5.0, 33.0, 35.0),
        (30.0, 40.0, -13.0),
        (43.0, 43.0, 40.0),
    ] {
        // How the joints are turned in the rest pose; its feet stand flat.
        let turned = |j: Joint| match j {
            LeftThigh | RightThigh => Quat::from_rotation_x(-f32::to_radians(thigh)),
            LeftShin | RightShin => Quat::from_rotation_x(f32::to_radians(shin)),
            LeftFoot | LeftToe | RightFoot | RightToe => Quat::IDENTITY,
            _ => Quat::from_rotation_x(f32::to_radians(lean)),
        };
        let (raw, roles) = rig(&clip, &s, &Joint::ALL.map(|j| turned(j).inverse()), &[]);
        let body = SourceBody::measure(&[RetargetSource { clip: &raw, roles: &roles, heading: None, turn: None }]);
        assert!(body.rest.is_some(), "the rest pose must be a body");
        let set = lay(&raw, &roles, Proportions::Default, false);
        for f in 0..FRAMES {
            let both = clip.joint_transforms(&s, f).into_iter().zip(set.clips[0].joint_transforms(&set.skeleton, f));
            for (j, (a, b)) in Joint::ALL.iter().zip(both) {
                let off = a.1.angle_between(b.1).to_degrees();
                assert!(off < 3.5, "{thigh} {shin} {lean}, frame {f}, {}: {off} degrees", j.name());
            }
        }
    }
}
