//! Characters of many makes wear a take: joints of the same body are where the motion has them.

use super::{pose, take};
use crate::rigs::{rig, tables};
use crate::scenes::glb;
use glam::{Quat, Vec3};
use rig::{Rest, RigPart};
use std::path::{Path, PathBuf};
use throng_core::{Joint, Skeleton};
use throng_motion::error::Result;
use throng_motion::export::{Take, TakeWriter};
use throng_motion::import::{ImportConfig, bvh, read_source};
use throng_motion::progress::Silent;
use throng_motion::raw::RawClip;
use throng_motion::wearer::{SkinnedFigure, Wearer};

/// A skinned character with the joints of a table, each with axes of its own, below an armature in centimetres.
fn character(folder: &Path, name: &'static str, table: &str, rest: Rest) -> PathBuf {
    let parts = rig::parse(table);
    let text = rig::bvh(&parts, &rig::Style { rest, moves: false, scale: 1.0, ..rig::Style::default() });
    let clip = bvh::parse(text.as_bytes(), &folder.join("rest.bvh")).unwrap().clip;
    let mut glb = glb::Glb::new();
    glb.add(&clip, glb::Style { skin: true, armature: Some((0.01, false)), name, ..glb::Style::default() });
    let path = folder.join(format!("{}.glb", name.replace(' ', "_")));
    std::fs::write(&path, glb.glb()).unwrap();
    path
}

/// Reads a character.
fn open(path: &Path) -> Result<Wearer> {
    Wearer::open(path, &ImportConfig::default())
}

/// Dresses a character and reads what is written, in its own joints.
fn worn(folder: &Path, wearer: &Wearer, take: &Take) -> Vec<RawClip> {
    let outfit = wearer.dress(take, folder, &Silent).unwrap();
    let mut bytes = Vec::new();
    outfit.glb(take).unwrap().write(&mut bytes).unwrap();
    let path = folder.join("worn.glb");
    std::fs::write(&path, bytes).unwrap();
    read_source(&path, None).unwrap().into_iter().map(|source| source.clip).collect()
}

/// Place of a joint by its name.
fn place(clip: &RawClip, name: &str) -> usize {
    clip.joints.iter().position(|j| j.name == name).unwrap_or_else(|| panic!("no joint {name}"))
}

/// Rigs hang shoulders on necks, and thighs on joints of their own: nothing else may be off (m).
const LIMIT_M: f32 = 0.016;

/// Joints whose places the motion says: those of limbs and what carries them.
fn is_limb(joint: Joint) -> bool {
    use Joint::*;
    !matches!(joint, Spine | Chest | UpperChest | Neck | Head | LeftClavicle | RightClavicle)
}

#[test]
fn rigs_of_every_make_stand_where_the_motion_stands() {
    let (take, skeletons) = take();
    let mut tried = 0;
    for (name, table) in tables::RIGS {
        let folder = tempfile::tempdir().unwrap();
        for rest in [Rest::TPose, Rest::APose] {
            let opened = open(&character(folder.path(), name, table, rest));
            if name == "two roots" {
                // Its arms end where forearms would: at rest, nothing tells them from horns.
                assert!(
                    opened
                        .err()
                        .is_some_and(|e| e.to_string().contains("its arms have no hands: nothing hangs on `L_Elbow`"))
                );
                continue;
            }
            let wearer = opened.unwrap_or_else(|e| panic!("{name}, {rest:?}: {e}"));
            let parts: Vec<RigPart> = rig::parse(table);
            let read = worn(folder.path(), &wearer, &take);
            assert_eq!(read.len(), 3, "{name}");
            for (a, clip) in read.iter().enumerate().take(2) {
                let off = farthest_limb(clip, &parts, &skeletons[a], a);
                assert!(off < LIMIT_M, "{name}, {rest:?}, actor {a}: {off} m");
            }
            tried += 1;
        }
    }
    assert_eq!(tried, 2 * (tables::RIGS.len() - 1));
}

fn farthest_limb(clip: &RawClip, parts: &[RigPart], skeleton: &Skeleton, actor: usize) -> f32 {
    let roles = parts.iter().filter_map(|p| Some((p.role.filter(|r| is_limb(*r))?, place(clip, &p.name))));
    let roles: Vec<(Joint, usize)> = roles.collect();
    let mut worst = 0f32;
    for frame in (0..clip.num_frames).step_by(17) {
        let (got, want) = (clip.world(frame), pose(skeleton, actor, frame).world_transforms());
        for (role, joint) in &roles {
            worst = worst.max(got[*joint].0.distance(want[role.index()].0));
        }
    }
    worst
}

#[test]
fn twist_joints_take_the_share_of_their_place() {
    let table = tables::RIGS.iter().find(|r| r.0 == "DAZ Genesis 8").unwrap().1;
    let folder = tempfile::tempdir().unwrap();
    let wearer = open(&character(folder.path(), "daz", table, Rest::TPose)).unwrap();
    let twists: Vec<&str> = wearer.twists().collect();
    assert_eq!(twists.len(), 6, "{twists:?}");
    // The left hand turns about the forearm, which lies along +X.
    let skeleton = Skeleton::default();
    let actors = vec![(0, "one".into(), skeleton.clone())];
    let mut writer = TakeWriter::new(folder.path(), actors, 30.0).unwrap();
    let angle = |frame: usize| 0.1 * frame as f32;
    for frame in 0..12 {
        let mut rotations = [Quat::IDENTITY; throng_core::NUM_JOINTS];
        rotations[Joint::LeftHand.index()] = Quat::from_rotation_x(angle(frame));
        let pose = throng_motion::export::ActorPose::from_rotations(&skeleton, skeleton.offsets[0], rotations);
        writer.push(0, Some(pose)).unwrap();
    }
    let read = worn(folder.path(), &wearer, &writer.into_take().unwrap());
    let (twist, forearm, hand) =
        (place(&read[0], "lForearmTwist"), place(&read[0], "lForearmBend"), place(&read[0], "lHand"));
    // The twist joint lies 0.12 m along a forearm of 0.255 m.
    let share = 0.12 / 0.255;
    for frame in 0..12 {
        let world = read[0].world(frame);
        let angle_of = |j: usize| {
            let v = world[j].1 * Vec3::Y;
            v.z.atan2(v.y)
        };
        assert!(angle_of(forearm).abs() < 1e-3);
        assert!((angle_of(hand) - angle(frame)).abs() < 1e-3, "hand {} at {frame}", angle_of(hand));
        assert!((angle_of(twist) - share * angle(frame)).abs() < 2e-3, "twist {} at {frame}", angle_of(twist));
    }
}

#[test]
fn what_cannot_be_worn_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |name: &str, bytes: &[u8], parts: &[&str]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let e = open(&path).err().unwrap_or_else(|| panic!("{name} is accepted")).to_string();
        assert!(e.contains(name) && parts.iter().all(|p| e.contains(p)), "{parts:?}: {e}");
    };
    refused("text.glb", b"hello", &["expected a glTF 2.0 document"]);
    let clip = |table: &str| {
        let text = rig::bvh(&rig::parse(table), &rig::Style { moves: false, ..rig::Style::default() });
        bvh::parse(text.as_bytes(), &folder.path().join("rest.bvh")).unwrap().clip
    };
    let mixamo = tables::RIGS.iter().find(|r| r.0 == "Mixamo").unwrap().1;
    let mut bare = glb::Glb::new();
    bare.add(&clip(mixamo), glb::Style::default());
    refused("bare.glb", &bare.glb(), &["no skin", "Export the mesh with the skeleton"]);
    let mut two = glb::Glb::new();
    for name in ["a", "b"] {
        two.add(&clip(mixamo), glb::Style { skin: true, armature: Some((0.01, false)), name, ..Default::default() });
    }
    refused("two.glb", &two.glb(), &["expected one character, found 2", "Export one"]);
    let chain = "a;-;0 1 0;-\nb;a;0 0.1 0;-\nc;b;0 0.1 0;-\nd;c;0 0.1 0;-\ne;d;0 0.1 0;-\nf;e;0 0.1 0;-\n\
                 g;f;0 0.1 0;-\nh;g;0 0.1 0;-\ni;h;0 0.1 0;-";
    let mut snake = glb::Glb::new();
    snake.add(&clip(chain), glb::Style { skin: true, ..glb::Style::default() });
    refused("snake.glb", &snake.glb(), &["no person"]);
    let mut parted = glb::Glb::new();
    parted.add(&clip(mixamo), glb::Style { skin: true, ..glb::Style::default() });
    parted.json["images"] = serde_json::json!([{ "uri": "skin.png" }]);
    refused("parted.glb", &parted.glb(), &["`skin.png`", "one .glb file"]);
    let mut flat = glb::Glb::new();
    flat.add(&clip(mixamo), glb::Style { skin: true, armature: Some((1.0, false)), ..glb::Style::default() });
    let armature = flat.json["nodes"].as_array().unwrap().iter().position(|n| n["name"] == "Armature").unwrap();
    flat.json["nodes"][armature]["scale"] = serde_json::json!([1.0, 1.0, 1e-10]);
    refused("flat.glb", &flat.glb(), &["above its hips has a scale of 0, or next to it"]);
}

#[test]
fn meshes_that_cannot_be_drawn_are_refused_by_name() {
    use serde_json::json;
    let folder = tempfile::tempdir().unwrap();
    let table = tables::RIGS.iter().find(|r| r.0 == "Mixamo").unwrap().1;
    let text = rig::bvh(&rig::parse(table), &rig::Style { moves: false, scale: 1.0, ..rig::Style::default() });
    let clip = bvh::parse(text.as_bytes(), &folder.path().join("rest.bvh")).unwrap().clip;
    let mut good = glb::Glb::new();
    good.add(&clip, glb::Style { skin: true, ..glb::Style::default() });
    let position = good.accessor("VEC3", glb::FLOAT, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0], false);
    let none = good.accessor("VEC4", glb::FLOAT, &[0.0; 12], false);
    let part = json!({ "attributes": { "POSITION": position, "JOINTS_0": none, "WEIGHTS_0": none } });
    good.json["meshes"][0]["primitives"] = json!([part, part]);
    let read = |change: &dyn Fn(&mut glb::Glb)| {
        let mut glb = glb::Glb { json: good.json.clone(), bytes: good.bytes.clone() };
        change(&mut glb);
        let path = folder.path().join("a.glb");
        std::fs::write(&path, glb.glb()).unwrap();
        SkinnedFigure::open(&path, &ImportConfig::default()).map_err(|e| e.to_string())
    };
    // Parts without a material share one.
    let surface = |figure: SkinnedFigure| (figure.surface().corners.len(), figure.surface().materials.len());
    assert_eq!(read(&|_| {}).map(surface), Ok((6, 1)));
    type Change<'a> = &'a dyn Fn(&mut glb::Glb);
    let changes: [(Change<'_>, &str); 4] = [
        (
            &|glb| {
                let skin = glb.push("skins", json!({ "joints": [] }));
                glb.push("nodes", json!({ "mesh": 0, "skin": skin }));
            },
            "expected joints in skin 1, found none",
        ),
        (
            &|glb| {
                let long = json!({ "componentType": glb::FLOAT, "count": u64::MAX, "type": "VEC3" });
                let long = glb.push("accessors", long);
                let index = glb.accessor("SCALAR", glb::FLOAT, &[0.0; 3], false);
                let part = json!({ "attributes": { "POSITION": long, "JOINTS_0": none, "WEIGHTS_0": none }, "indices": index });
                glb.json["meshes"][0]["primitives"][1] = part;
            },
            "part 1: a character may have 5000000 triangles at most",
        ),
        (
            &|glb| {
                glb.json["materials"] = json!(vec![json!({}); 65_537]);
                glb.json["meshes"][0]["primitives"][0]["material"] = json!(65_535);
                glb.json["meshes"][0]["primitives"][1]["material"] = json!(65_536);
            },
            "part 1: expected 65536 materials at most",
        ),
        (
            &|glb| {
                let view = glb.push("bufferViews", json!({ "buffer": 0, "byteLength": glb.bytes.len() }));
                let times = (1 << 30) / glb.bytes.len() + 1;
                glb.json["images"] = json!(vec![json!({ "bufferView": view }); times]);
            },
            "expected 1024 MiB at most in all images",
        ),
    ];
    for (change, expected) in changes {
        let e = read(change).map(surface).expect_err(expected);
        assert!(e.contains("a.glb: ") && e.contains(expected), "{expected}: {e}");
    }
}

#[test]
fn joints_without_a_role_rest() {
    let table = tables::RIGS.iter().find(|r| r.0 == "Mixamo").unwrap().1;
    let (take, folder) = (take().0, tempfile::tempdir().unwrap());
    let wearer = open(&character(folder.path(), "mixamo", table, Rest::APose)).unwrap();
    let read = worn(folder.path(), &wearer, &take);
    let index = place(&read[0], "mixamorig:LeftHandIndex2");
    let n = read[0].joints.len();
    for frame in 0..read[0].num_frames {
        let turn = read[0].rotations[frame * n + index];
        assert!(turn.angle_between(read[0].rotations[index]) < 1e-3);
    }
}
