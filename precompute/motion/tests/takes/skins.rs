//! Characters with skins wear a take: soles stand on the ground, skin is not torn, figures keep a person's size.

use super::{pose, sized, take};
use crate::rigs::{rig, tables};
use crate::scenes::glb;
use glam::{Quat, Vec3};
use serde_json::json;
use std::path::{Path, PathBuf};
use throng_core::{Joint, Mat3x4, NUM_JOINTS, Skeleton};
use throng_motion::export::{ActorPose, Take, TakeWriter};
use throng_motion::import::{ImportConfig, bvh};
use throng_motion::raw::RawClip;
use throng_motion::wearer::{SkinnedFigure, Wearer, WornFit};

/// Depth of the soles of plain skins below the ankles (m).
const SOLE_M: f32 = 0.08;

/// Adds a tube from each joint to those below it, and soles below the feet.
///
/// - `sole_m`: depth of the soles below the ankles; `bare`: name of a joint that carries no skin.
fn add_skin(glb: &mut glb::Glb, clip: &RawClip, sole_m: f32, bare: &str) {
    let space = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let mut at = vec![Vec3::ZERO; clip.joints.len()];
    for (j, joint) in clip.joints.iter().enumerate() {
        at[j] = joint.parent.map_or(Vec3::ZERO, |p| at[p]) + joint.offset;
    }
    let named = |j: usize, words: &[&str]| words.iter().any(|w| clip.joints[j].name.to_lowercase().contains(w));
    // Targets of inverse kinematics carry none.
    let is_bare = |j: usize| {
        let name = &clip.joints[j].name;
        name.to_lowercase() == bare || name.starts_with("ik_") || name.contains("ＩＫ")
    };
    // Three corners for each triangle: the place of each, and the joint that moves it.
    let mut corners: Vec<(Vec3, usize)> = Vec::new();
    for (j, joint) in clip.joints.iter().enumerate().filter(|(j, _)| !is_bare(*j)) {
        if let Some(p) = joint.parent.filter(|&p| !is_bare(p)) {
            let ring = [Vec3::X, Vec3::Z, -Vec3::X].map(|v| 0.04 * v);
            for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                let (begin, end) = (|k: usize| (at[p] + ring[k], p), |k: usize| (at[j] + ring[k], j));
                corners.extend([begin(a), begin(b), end(a), end(a), begin(b), end(b)]);
            }
        }
        let foot = if named(j, &["foot", "ankle", "boot"]) {
            Some(j)
        } else {
            joint.parent.filter(|_| named(j, &["toe", "ball"]))
        };
        if let Some(foot) = foot {
            let ahead = if foot == j { [-0.06, 0.1] } else { [-0.02, 0.06] };
            let sole = |x: f32, z: f32| (Vec3::new(at[j].x + x, at[foot].y - sole_m, at[j].z + z), j);
            corners.extend([sole(0.03, ahead[0]), sole(-0.03, ahead[0]), sole(0.0, ahead[1])]);
        }
    }
    let flat = |of: &dyn Fn(&(Vec3, usize)) -> [f32; 4], width: usize| -> Vec<f32> {
        corners.iter().flat_map(|c| of(c)[..width].to_vec()).collect()
    };
    let places = flat(&|(p, _)| (space * *p).extend(0.0).to_array(), 3);
    let position = glb.accessor("VEC3", glb::FLOAT, &places, false);
    let joints = glb.accessor("VEC4", glb::FLOAT, &flat(&|(_, j)| [*j as f32, 0.0, 0.0, 0.0], 4), false);
    let weights = glb.accessor("VEC4", glb::FLOAT, &flat(&|_| [1.0, 0.0, 0.0, 0.0], 4), false);
    let part = json!({ "attributes": { "POSITION": position, "JOINTS_0": joints, "WEIGHTS_0": weights } });
    glb.json["meshes"][0]["primitives"] = json!([part]);
}

/// A character with a skin, below an armature in centimetres.
fn character(folder: &Path, table: &str, sole_m: f32, bare: &str) -> PathBuf {
    let style = rig::Style { moves: false, scale: 1.0, ..rig::Style::default() };
    let text = rig::bvh(&rig::parse(table), &style);
    let mut clip = bvh::parse(text.as_bytes(), &folder.join("rest.bvh")).unwrap().clip;
    // Ends of chains are no joints of a skin.
    clip.joints.iter_mut().filter(|j| j.is_end).for_each(|j| j.name += " tip");
    let mut glb = glb::Glb::new();
    glb.add(&clip, glb::Style { skin: true, armature: Some((0.01, false)), name: "one", ..glb::Style::default() });
    add_skin(&mut glb, &clip, sole_m, bare);
    let path = folder.join("character.glb");
    std::fs::write(&path, glb.glb()).unwrap();
    path
}

fn table(name: &str) -> &'static str {
    tables::RIGS.into_iter().chain(tables::DRAWN).find(|r| r.0 == name).unwrap().1
}

fn fit(path: &Path, take: &Take) -> WornFit {
    let wearer = Wearer::open(path, &ImportConfig::default()).unwrap();
    wearer.measure(take).unwrap().expect("its skin is read")
}

/// Somebody who stands, and steps from foot to foot, on ground at 0.
fn standing() -> (Take, ActorPose, Skeleton) {
    let skeleton = Skeleton::default();
    let still = ActorPose::from_rotations(&skeleton, skeleton.offsets[0], [Quat::IDENTITY; NUM_JOINTS]);
    let mut writer = TakeWriter::new(&std::env::temp_dir(), vec![(0, "one".into(), skeleton.clone())], 30.0).unwrap();
    (0..30).for_each(|_| writer.push(0, Some(still)).unwrap());
    (writer.into_take().unwrap(), still, skeleton)
}

/// Somebody who makes long strides on the spot.
fn strides() -> Take {
    let skeleton = Skeleton::default();
    let mut writer = TakeWriter::new(&std::env::temp_dir(), vec![(0, "one".into(), skeleton.clone())], 30.0).unwrap();
    for frame in 0..60 {
        let mut rotations = [Quat::IDENTITY; NUM_JOINTS];
        let swing = 0.6 * (0.2 * frame as f32).sin();
        rotations[Joint::LeftThigh.index()] = Quat::from_rotation_x(swing);
        rotations[Joint::RightThigh.index()] = Quat::from_rotation_x(-swing);
        let pose = ActorPose::from_rotations(&skeleton, skeleton.offsets[0], rotations);
        writer.push(0, Some(pose)).unwrap();
    }
    writer.into_take().unwrap()
}

/// Height of the lowest corner of a character in a pose (m).
fn lowest(figure: &SkinnedFigure, skeleton: &Skeleton, pose: &ActorPose) -> f32 {
    let mut matrices = vec![Mat3x4::default(); figure.num_frames()];
    figure.pose_matrices(skeleton, &pose.world_transforms(), &mut matrices);
    let of = |c: &throng_motion::wearer::SurfaceCorner| {
        matrices[usize::from(c.frames[0])].to_mat4().transform_point3(c.position).y
    };
    figure.surface().corners.iter().map(of).fold(f32::INFINITY, f32::min)
}

#[test]
fn soles_of_any_shoes_stand_on_the_ground() {
    let (take, still, skeleton) = standing();
    for name in ["Mixamo", "Unreal", "Rokoko", "Xsens", "game figure", "long shins"] {
        for sole_m in [0.03, 0.06, 0.09, 0.15] {
            let folder = tempfile::tempdir().unwrap();
            let path = character(folder.path(), table(name), sole_m, "root");
            let figure = SkinnedFigure::open(&path, &ImportConfig::default()).unwrap();
            let off = lowest(&figure, &skeleton, &still);
            assert!(off.abs() < 0.005, "{name}, soles {sole_m} m below the ankles: {off} m from the ground");
            let fit = fit(&path, &take);
            assert!(fit.soles_m.abs() < 0.005 && fit.fault().is_none(), "{name}, {sole_m}: {fit:?}");
        }
    }
}

/// As older versions of Biped have it: thighs hang on the spine, and the pelvis above it carries skin.
const OLD_BIPED: &str = "
Bip01;-;0 0.955 0;-
Bip01 Pelvis;Bip01;0 0.03 0;-
Bip01 Spine;Bip01 Pelvis;hips
Bip01 Spine1;Bip01 Spine;spine
Bip01 Spine2;Bip01 Spine1;upper_chest
Bip01 Neck;Bip01 Spine2;neck
Bip01 Head;Bip01 Neck;head
Bip01 {L,R} Clavicle;Bip01 Neck;left_clavicle
Bip01 {L,R} UpperArm;Bip01 {L,R} Clavicle;left_upper_arm
Bip01 {L,R} Forearm;Bip01 {L,R} UpperArm;left_forearm
Bip01 {L,R} Hand;Bip01 {L,R} Forearm;left_hand
Bip01 {L,R} Thigh;Bip01 Spine;left_thigh
Bip01 {L,R} Calf;Bip01 {L,R} Thigh;left_shin
Bip01 {L,R} Foot;Bip01 {L,R} Calf;left_foot
Bip01 {L,R} Toe0;Bip01 {L,R} Foot;left_toe";

#[test]
fn skin_above_the_spine_goes_with_the_body() {
    let (take, folder) = (take().0, tempfile::tempdir().unwrap());
    let fit = fit(&character(folder.path(), OLD_BIPED, SOLE_M, "none"), &take);
    assert!(fit.stretch_m < 0.2 && fit.fault().is_none(), "{fit:?}");
}

#[test]
fn skin_that_hangs_elsewhere_is_torn_and_refused() {
    let table = table("Mixamo").to_owned() + "\nBoot{L,R};mixamorig:Hips;left_foot;-\nHeel{L,R};Boot{L,R};0 0 -0.05;-";
    let (take, folder) = (strides(), tempfile::tempdir().unwrap());
    let style = rig::Style { moves: false, scale: 1.0, ..rig::Style::default() };
    let text = rig::bvh(&rig::parse(&table), &style);
    let clip = bvh::parse(text.as_bytes(), &folder.path().join("rest.bvh")).unwrap().clip;
    let mut glb = glb::Glb::new();
    glb.add(&clip, glb::Style { skin: true, armature: Some((0.01, false)), name: "one", ..glb::Style::default() });
    add_skin(&mut glb, &clip, SOLE_M, "none");
    // The skin of the feet is moved by boots that hang on the hips.
    let named = |name: &str| clip.joints.iter().position(|j| j.name.ends_with(name)).unwrap();
    let pairs = [("LeftFoot", "BootL"), ("RightFoot", "BootR")].map(|(foot, boot)| (named(foot), named(boot)));
    carry_by(&mut glb, |joint| pairs.iter().find(|p| p.0 == joint).map_or(joint, |p| p.1));
    let path = folder.path().join("boots.glb");
    std::fs::write(&path, glb.glb()).unwrap();
    let fit = fit(&path, &take);
    let fault = fit.fault().unwrap_or_else(|| panic!("{fit:?}"));
    assert!(fault.contains("its skin is torn") && fault.contains("Boot"), "{fault}");
}

/// Lets other joints carry the skin: that which `carrier` gives for each joint.
fn carry_by(glb: &mut glb::Glb, carrier: impl Fn(usize) -> usize) {
    let joints = glb.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"].as_u64().unwrap() as usize;
    let view = glb.json["accessors"][joints]["bufferView"].as_u64().unwrap() as usize;
    let begin = glb.json["bufferViews"][view]["byteOffset"].as_u64().unwrap() as usize;
    let length = glb.json["bufferViews"][view]["byteLength"].as_u64().unwrap() as usize;
    for bytes in glb.bytes[begin..begin + length].chunks_exact_mut(16) {
        let joint = f32::from_le_bytes(std::array::from_fn(|k| bytes[k]));
        bytes[..4].copy_from_slice(&(carrier(joint as usize) as f32).to_le_bytes());
    }
}

#[test]
fn skin_that_does_not_go_with_its_limb_is_refused_with_the_joint_that_keeps_it() {
    let (take, folder) = (take().0, tempfile::tempdir().unwrap());
    let style = rig::Style { moves: false, scale: 1.0, ..rig::Style::default() };
    let text = rig::bvh(&rig::parse(table("Mixamo")), &style);
    let clip = bvh::parse(text.as_bytes(), &folder.path().join("rest.bvh")).unwrap().clip;
    let hips = clip.joints.iter().position(|j| j.name.ends_with("Hips")).unwrap();
    // Nodes stand as the skin was bound.
    let clip = RawClip {
        rotations: vec![Quat::IDENTITY; clip.rotations.len()],
        translations: clip.joints.iter().map(|j| j.offset).collect::<Vec<_>>().repeat(clip.num_frames),
        ..clip
    };
    for (limb, ends) in [("", ["Foot", "Hand"]), ("Arm", ["Hand", "Hand"]), ("UpLeg", ["Foot", "Foot"])] {
        let mut glb = glb::Glb::new();
        glb.add(&clip, glb::Style { skin: true, name: "one", ..glb::Style::default() });
        add_skin(&mut glb, &clip, SOLE_M, "none");
        // All the skin of a limb is moved by the hips: no edge is stretched.
        let mut up = |j: usize| {
            std::iter::successors(Some(j), |&j| clip.joints[j].parent).any(|j| {
                let name = clip.joints[j].name.trim_start_matches("mixamorig:");
                limb.is_empty() || name.trim_start_matches("Left").trim_start_matches("Right") == limb
            })
        };
        let kept: Vec<bool> = (0..clip.joints.len()).map(&mut up).collect();
        carry_by(&mut glb, |joint| if kept[joint] { hips } else { joint });
        let path = folder.path().join("kept.glb");
        std::fs::write(&path, glb.glb()).unwrap();
        let fit = fit(&path, &take);
        let fault = fit.fault().unwrap_or_else(|| panic!("{limb}: {fit:?}"));
        assert!(ends.iter().any(|e| fault.contains(e)) && fault.contains("Hips`"), "{limb}: {fault}");
    }
}

#[test]
fn skin_over_two_roots_is_refused_by_the_joint_that_is_outside() {
    let folder = tempfile::tempdir().unwrap();
    let style = rig::Style { moves: false, scale: 1.0, ..rig::Style::default() };
    let text = rig::bvh(&rig::parse(table("Mixamo")), &style);
    let clip = bvh::parse(text.as_bytes(), &folder.path().join("rest.bvh")).unwrap().clip;
    let mut glb = glb::Glb::new();
    glb.add(&clip, glb::Style { skin: true, name: "one", ..glb::Style::default() });
    add_skin(&mut glb, &clip, SOLE_M, "none");
    let helmet = glb.push("nodes", json!({ "name": "Helmet", "translation": [0.0, 1.6, 0.0] }));
    glb.json["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(helmet));
    let skin = glb.json["skins"][0]["joints"].as_array_mut().unwrap();
    skin.push(json!(helmet));
    glb.json["skins"][0].as_object_mut().unwrap().remove("inverseBindMatrices");
    let path = folder.path().join("helmet.glb");
    std::fs::write(&path, glb.glb()).unwrap();
    let e = Wearer::open(&path, &ImportConfig::default()).err().expect("it is accepted").to_string();
    assert!(e.contains("`Helmet`") && e.contains("below"), "{e}");
}

/// A drawn figure: a big head and body on short legs.
const SHORT_LEGS: &str = "
Hips;-;0 0.5 0;hips
Spine;Hips;0 0.15 0;spine
Chest;Spine;0 0.25 0;upper_chest
Neck;Chest;0 0.2 0;neck
Head;Neck;0 0.1 0;head
Crown;Head;0 0.5 0;-
Shoulder.{L,R};Chest;0.03 0.13 0;left_clavicle
UpperArm.{L,R};Shoulder.{L,R};0.15 0 0;left_upper_arm
LowerArm.{L,R};UpperArm.{L,R};0.2 0 0;left_forearm
Hand.{L,R};LowerArm.{L,R};0.2 0 0;left_hand
UpperLeg.{L,R};Hips;0.1 -0.05 0;left_thigh
LowerLeg.{L,R};UpperLeg.{L,R};0 -0.19 0;left_shin
Foot.{L,R};LowerLeg.{L,R};0 -0.18 0;left_foot
Toe.{L,R};Foot.{L,R};0 -0.04 0.1;left_toe";

#[test]
fn short_legs_make_no_giant_and_reach_the_ground() {
    let folder = tempfile::tempdir().unwrap();
    let path = character(folder.path(), SHORT_LEGS, SOLE_M, "none");
    let (stand, still, skeleton) = standing();
    let stood = fit(&path, &stand);
    assert!((1.6..1.9).contains(&stood.height_m) && stood.fault().is_none(), "{stood:?}");
    let figure = SkinnedFigure::open(&path, &ImportConfig::default()).unwrap();
    let off = lowest(&figure, &skeleton, &still);
    assert!(off.abs() < 0.01, "{off} m from the ground");
    let walked = fit(&path, &take().0);
    assert!(walked.height_m < 1.9 && walked.stretch_m < 0.2, "{walked:?}");
    // Strides of such legs are short: the lower foot is where the motion's is.
    for frame in (0..90).step_by(3) {
        let pose = pose(&skeleton, 0, frame);
        let world = pose.world_transforms();
        let low = |j: Joint| world[j.index()].0.y - skeleton.rest_positions()[j.index()].y;
        let ground = [Joint::LeftToe, Joint::RightToe, Joint::LeftFoot, Joint::RightFoot].map(low);
        let ground = ground.into_iter().fold(f32::INFINITY, f32::min);
        let off = lowest(&figure, &skeleton, &pose) - ground;
        assert!((-0.08..0.08).contains(&off), "frame {frame}: {off} m from the ground");
    }
}

#[test]
fn characters_of_every_make_are_worn_without_tears() {
    let (take, mut worst) = (take().0, (0f32, 0f32));
    for (name, table) in tables::RIGS.into_iter().chain(tables::DRAWN).filter(|r| r.0 != "two roots") {
        let folder = tempfile::tempdir().unwrap();
        let fit = fit(&character(folder.path(), table, SOLE_M, "none"), &take);
        println!("{name:<20} {fit:?}");
        assert!(fit.fault().is_none(), "{name}: {fit:?}");
        worst = (worst.0.max(fit.stretch_m), worst.1.max(fit.soles_m.abs()));
    }
    assert!(worst.0 < 0.3 && worst.1 < 0.02, "{worst:?}");
    assert_eq!(sized(1.0), Skeleton::default());
}
