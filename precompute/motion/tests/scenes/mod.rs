//! Scene files: glTF in every way that the format has for motion, FBX, what Blender writes of both, and damaged files.

mod blender;
mod damaged;
pub mod glb;

use crate::rigs::{rig, tables};
use glam::{Quat, Vec3};
use glb::{BYTE, Glb, SHORT, Style};
use std::collections::BTreeMap;
use std::path::Path;
use throng_motion::Warnings;
use throng_motion::annotate::Sidecars;
use throng_motion::import::{
    ImportConfig, RestPoseKind, SourceClip, bvh, gltf, interpret, read_by, read_clip, read_source,
};
use throng_motion::progress::Silent;
use throng_motion::raw::RawClip;
use throng_motion::retarget::{self, RetargetConfig};

/// A body that walks, in metres.
fn walk() -> RawClip {
    let table = tables::RIGS.iter().find(|(name, _)| *name == "Mixamo").expect("a rig of Mixamo").1;
    let text = rig::bvh(&rig::parse(table), &rig::Style { scale: 1.0, ..rig::Style::default() });
    let mut clip = bvh::parse(text.as_bytes(), Path::new("walk.bvh")).unwrap().clip;
    let ends = clip.joints.iter().filter(|j| j.is_end).count();
    // Nodes have no ends that are no joints.
    assert!(ends > 0);
    clip.joints.iter_mut().for_each(|j| j.is_end = false);
    clip
}

fn parse(glb: &Glb) -> Vec<SourceClip> {
    gltf::parse(&glb.glb(), Path::new("dances.glb")).unwrap()
}

/// The only clip of a document.
fn only(glb: &Glb) -> RawClip {
    let mut all = parse(glb);
    assert_eq!(all.len(), 1);
    all.swap_remove(0).clip
}

/// Farthest that a joint of one clip is from the joint of that name in another one (m).
fn farthest(found: &RawClip, truth: &RawClip) -> f32 {
    assert_eq!(found.num_frames, truth.num_frames);
    let of = |name: &str| truth.joints.iter().position(|j| j.name == name);
    let pairs: Vec<(usize, usize)> =
        found.joints.iter().enumerate().filter_map(|(j, joint)| Some((j, of(&joint.name)?))).collect();
    assert!(pairs.len() * 3 > 2 * truth.joints.iter().filter(|j| !j.is_end).count(), "{} joints", pairs.len());
    let mut worst = 0f32;
    for f in 0..truth.num_frames {
        let (a, b) = (found.world(f), truth.world(f));
        worst = pairs.iter().fold(worst, |worst, &(i, j)| worst.max(a[i].0.distance(b[j].0)));
    }
    worst
}

const STYLE: fn() -> Style = Style::default;

#[test]
fn every_way_of_writing_motion_gives_the_same_joints_and_the_same_rest() {
    let truth = walk();
    let centimetres = Some((0.01, false));
    for (what, style, limit) in [
        ("linear", STYLE(), 1e-5),
        ("step", Style { interpolation: "STEP", ..STYLE() }, 1e-5),
        ("spline", Style { interpolation: "CUBICSPLINE", ..STYLE() }, 1e-5),
        ("sixteen bits", Style { rotations: SHORT, ..STYLE() }, 1e-3),
        ("eight bits", Style { rotations: BYTE, ..STYLE() }, 0.05),
        ("sparse", Style { sparse: true, ..STYLE() }, 1e-5),
        ("plain axes", Style { own_axes: false, ..STYLE() }, 1e-5),
        ("armature", Style { armature: centimetres, ..STYLE() }, 1e-5),
        ("matrix", Style { armature: Some((0.01, true)), ..STYLE() }, 1e-5),
        ("way above", Style { armature: centimetres, root_above: true, ..STYLE() }, 1e-5),
        ("skin", Style { skin: true, ..STYLE() }, 1e-5),
        ("all", Style { skin: true, sparse: true, armature: centimetres, root_above: true, ..STYLE() }, 1e-5),
    ] {
        let mut glb = Glb::new();
        glb.add(&truth, style);
        let found = only(&glb);
        assert_eq!((found.rate_hz, found.num_frames), (30.0, rig::FRAMES), "{what}");
        let worst = farthest(&found, &truth);
        assert!(worst < limit, "{what}: {worst} m");
        // A joint that is at rest is not turned, whatever its axes are: so offsets are those of the clip.
        let of = |name: &str| truth.joints.iter().find(|j| j.name == name).unwrap();
        let root = found.joints.iter().position(|j| j.name == truth.joints[0].name).unwrap();
        for joint in found.joints[root + 1..].iter() {
            let off = joint.offset.distance(of(&joint.name).offset);
            assert!(off < 1e-5, "{what}: {} rests {off} m from where it should", joint.name);
        }
    }
}

#[test]
fn a_skin_tells_the_rest_pose_and_a_body_is_found() {
    let truth = walk();
    let mut glb = Glb::new();
    glb.add(&truth, Style { skin: true, armature: Some((0.01, false)), ..STYLE() });
    let i = interpret(parse(&glb).swap_remove(0), &ImportConfig::default(), &[]).unwrap();
    assert_eq!((i.rest_pose.kind, i.metres_per_unit), (RestPoseKind::TPose, 1.0));
    assert!(i.findings.iter().any(|f| f == "30 frames a second: most keys are that far apart."), "{:?}", i.findings);
    let of_bvh = interpret(
        SourceClip { clip: truth, declared_metres_per_unit: None, findings: Vec::new(), warnings: Default::default() },
        &ImportConfig::default(),
        &[],
    );
    let of_bvh = of_bvh.unwrap();
    let names = |i: &throng_motion::import::ImportedClip| {
        i.roles.pairs(&i.clip.joints).map(|(role, name)| (role, name.to_owned())).collect::<Vec<_>>()
    };
    assert_eq!(names(&i), names(&of_bvh));
    assert!((i.height - of_bvh.height).abs() < 1e-3);
}

/// A skeleton whose root has keys at some times.
fn keyed(interpolation: &'static str, times: &[f32], path: &str, values: Vec<f32>) -> RawClip {
    let mut glb = Glb::new();
    glb.add(&walk(), STYLE());
    glb.json["animations"] = serde_json::json!([]);
    glb.animation(Style { interpolation, ..STYLE() }, times, &[(0, path, values)]);
    only(&glb)
}

#[test]
fn between_keys_values_are_those_of_the_format() {
    // Keys a second apart are no frames: 30 of them a second, from the first to the last.
    let times = [0.5f32, 1.5, 2.5];
    let places = vec![0.0, 1.0, 0.0, 2.0, 1.0, 0.0, 2.0, 3.0, 0.0];
    let linear = keyed("LINEAR", &times, "translation", places.clone());
    let step = keyed("STEP", &times, "translation", places);
    assert_eq!((linear.num_frames, linear.rate_hz), (61, 30.0));
    let quarter = |s: f32| Quat::from_rotation_y(s * std::f32::consts::FRAC_PI_2).to_array();
    // The second key as the same rotation on the other side: the shortest way leads there, too.
    let turns = [quarter(0.0), quarter(1.0).map(|v| -v), quarter(2.5)].concat();
    let turned = keyed("LINEAR", &times, "rotation", turns);
    // x = t^3 and z = t between 0.5 and 2.5, as tangent before, value and tangent after.
    let cube = |t: f32| [[3.0 * t * t, 0.0, 1.0], [t * t * t, 1.0, t], [3.0 * t * t, 0.0, 1.0]].concat();
    let mut glb = Glb::new();
    glb.add(&walk(), STYLE());
    glb.json["animations"] = serde_json::json!([]);
    glb.animation(STYLE(), &times, &[(0, "translation", vec![0.0; 9])]);
    let output = glb.accessor("VEC3", glb::FLOAT, &times.map(cube).concat(), false);
    let sampler = &mut glb.json["animations"][0]["samplers"][0];
    sampler["output"] = serde_json::json!(output);
    sampler["interpolation"] = serde_json::json!("CUBICSPLINE");
    let cubic = only(&glb);
    for f in 0..61 {
        let t = f as f32 / 30.0;
        let at = |clip: &RawClip| clip.translations[f * clip.joints.len()];
        let want = if t <= 1.0 { Vec3::new(2.0 * t, 1.0, 0.0) } else { Vec3::new(2.0, 1.0 + 2.0 * (t - 1.0), 0.0) };
        assert!(at(&linear).distance(want) < 1e-5, "linear at {t}: {} not {want}", at(&linear));
        let held = [Vec3::new(0.0, 1.0, 0.0), Vec3::new(2.0, 1.0, 0.0), Vec3::new(2.0, 3.0, 0.0)][f / 30];
        assert_eq!(at(&step), held, "step at {t}");
        let s = t + 0.5;
        let want = Vec3::new(s * s * s, 1.0, s);
        assert!(at(&cubic).distance(want) < 1e-4, "cubic at {t}: {} not {want}", at(&cubic));
        let angle = if t <= 1.0 { t } else { 1.0 + 1.5 * (t - 1.0) } * std::f32::consts::FRAC_PI_2;
        // Turned against its first frame: the axes at rest are another matter.
        let [first, now] = [0, f].map(|f| turned.rotations[f * turned.joints.len()]);
        let off = now * first.inverse() * Quat::from_rotation_y(-angle);
        assert!(2.0 * off.xyz().length() < 1e-3, "turned at {t}");
    }
}

#[test]
fn several_animations_and_several_bodies_are_several_clips() {
    let truth = walk();
    let mut glb = Glb::new();
    let armature = Some((0.01, false));
    glb.add(&truth, Style { skin: true, armature, name: "A/lice", ..STYLE() });
    glb.add(&truth, Style { skin: true, armature, name: "Bob", ..STYLE() });
    let root = truth.joints.len() * 2;
    let names = |glb: &Glb| parse(glb).into_iter().map(|c| c.clip.name).collect::<Vec<_>>();
    assert_eq!(names(&glb), ["dances/A_lice/ArmatureA_lice", "dances/Bob/ArmatureBob"]);
    assert!(parse(&glb).iter().all(|c| farthest(&c.clip, &truth) < 1e-5));
    // One animation that moves both; then another one of the second body, with a name that is taken.
    let channels = |i: usize| glb.json["animations"][i].clone();
    let (first, second) = (channels(0), channels(1));
    let mut both = first.clone();
    let offset = first["samplers"].as_array().unwrap().len();
    both["samplers"].as_array_mut().unwrap().extend(second["samplers"].as_array().unwrap().clone());
    for channel in second["channels"].as_array().unwrap() {
        let mut channel = channel.clone();
        channel["sampler"] = serde_json::json!(channel["sampler"].as_u64().unwrap() as usize + offset);
        both["channels"].as_array_mut().unwrap().push(channel);
    }
    glb.json["animations"] = serde_json::json!([both]);
    assert_eq!(names(&glb), ["dances/ArmatureA_lice", "dances/ArmatureBob"]);
    glb.json["animations"] = serde_json::json!([second, second]);
    assert_eq!(names(&glb), ["dances/Bob", "dances/Bob 2"]);
    assert!(root > 0);

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("dances.glb");
    std::fs::write(&path, glb.glb()).unwrap();
    let config = ImportConfig::default();
    let read = |path: &Path| read_by(&|_, read| read(), &[path.to_path_buf()], &config, &Silent).unwrap();
    let set = read(&path);
    let clips = retarget::retarget_clips(&set.clips, &RetargetConfig::default(), &mut Warnings::default()).unwrap();
    let clip_names: Vec<String> = clips.clips.iter().map(|c| c.name.clone()).collect();
    let sidecars = || Sidecars::collect(&set, &clip_names, &BTreeMap::new());
    assert!(sidecars().is_ok());
    std::fs::write(path.with_extension("toml"), "exclude = [[0.0, 1.0]]\n").unwrap();
    let e = sidecars().unwrap_err().to_string();
    assert!(e.contains("dances.glb holds several clips") && e.contains("[clips.\"dances/Bob\"]"), "{e}");
    let clip_names = |path: &Path| read(path).clips.into_iter().map(|c| c.clip.name).collect::<Vec<_>>();
    assert_eq!(clip_names(folder.path()), ["dances/Bob", "dances/Bob 2"]);
    assert_eq!(clip_names(&path.join("Bob 2")), ["dances/Bob 2"]);
    assert_eq!(read_clip(&path.join("Bob"), &config).unwrap().clip.path, path.join("Bob"));
    let e = read_clip(&path, &config).unwrap_err().to_string();
    assert!(e.contains("dances.glb: expected one clip, found 2") && e.contains("dances.glb/Bob 2"), "{e}");
    let e = read_clip(&path.join("Carol"), &config).unwrap_err().to_string();
    assert!(e.contains("there is no clip `Carol`") && e.contains("dances.glb/Bob 2"), "{e}");
}

#[test]
fn a_body_that_is_none_is_left_out_and_told_beside_one_that_is() {
    let truth = walk();
    let mut glb = Glb::new();
    glb.add(&truth, Style { armature: Some((1.0, false)), name: "Alice", skin: true, ..STYLE() });
    // As many joints, all of them in a row: a chain.
    let mut chain = truth.clone();
    for (j, joint) in chain.joints.iter_mut().enumerate() {
        (joint.parent, joint.name) = (j.checked_sub(1), format!("link {j}"));
    }
    glb.add(&chain, Style { armature: Some((1.0, false)), name: "Rope", skin: true, ..STYLE() });
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    std::fs::write(&path, glb.glb()).unwrap();
    let read = |strict| {
        let config = ImportConfig { strict, ..ImportConfig::default() };
        read_by(&|_, read| read(), std::slice::from_ref(&path), &config, &Silent)
    };
    let set = read(false).unwrap();
    assert_eq!((set.clips.len(), set.skipped.len()), (1, 0));
    let told = &set.clips[0].warnings.messages;
    assert!(told.iter().any(|w| w.contains("Rope") && w.ends_with("It is left out.")), "{told:?}");
    assert!(read(true).is_err());
}

#[test]
fn numbers_beside_a_document_are_found_in_folders_and_archives() {
    let truth = walk();
    let mut glb = Glb::new();
    glb.add(&truth, STYLE());
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("a.gltf"), glb.gltf("b%20b.bin")).unwrap();
    std::fs::write(at("b b.bin"), &glb.bytes).unwrap();
    let mut zip = zip::ZipWriter::new(std::fs::File::create(at("c.zip")).unwrap());
    for (name, bytes) in [("in/a.gltf", glb.gltf("b%20b.bin")), ("in/b b.bin", glb.bytes.clone())] {
        zip.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
        std::io::Write::write_all(&mut zip, &bytes).unwrap();
    }
    zip.finish().unwrap();
    for (path, beside) in [(at("a.gltf"), at("b b.bin")), (at("c.zip/in/a.gltf"), at("c.zip/in/b b.bin"))] {
        let found = read_source(&path, None).unwrap().swap_remove(0).clip;
        assert!(farthest(&found, &truth) < 1e-5);
        assert_eq!(throng_motion::import::read_along(&path, None), [beside]);
    }
}
