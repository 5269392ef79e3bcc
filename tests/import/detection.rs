//! Units, axes, rest poses and roles are found from the body, and can be overridden.

use super::body;
use glam::{Quat, Vec3};
use std::f32::consts::{FRAC_PI_2, PI};
use std::path::{Path, PathBuf};
use throng_core::Joint;
use throng_precompute::ImportError;
use throng_precompute::import::profile::{Profile, load_profiles};
use throng_precompute::import::{Forward, ImportConfig, ImportedClip, RestPoseKind, UpAxis, bvh, interpret, read};
use throng_precompute::inspect::inspect;
use throng_precompute::progress::Silent;

fn same(name: &str) -> String {
    name.to_owned()
}

fn import_with(text: &str, config: &ImportConfig, profiles: &[Profile]) -> Result<ImportedClip, ImportError> {
    interpret(bvh::parse(text.as_bytes(), Path::new("a.bvh"))?, config, profiles)
}

fn import(text: &str, config: &ImportConfig) -> ImportedClip {
    import_with(text, config, &load_profiles(&[]).unwrap()).unwrap()
}

fn to_z_up(v: Vec3) -> Vec3 {
    Vec3::new(v.x, -v.z, v.y)
}

fn position(i: &ImportedClip, role: Joint) -> Vec3 {
    i.clip.world(0)[i.roles.get(role).unwrap()].0
}

#[test]
fn units_follow_from_the_size_of_the_body() {
    for unit in [1.0, 0.1, 0.01, 0.001, 0.0254, 0.3048, 0.0254 / 0.45] {
        let i = import(&body::bvh(2, same, |v| v / unit as f32), &ImportConfig::default());
        assert_eq!(i.metres_per_unit, unit);
        assert!((1.6..1.85).contains(&i.height), "{unit}: {}", i.height);
        assert!((position(&i, Joint::Hips).y - 0.96).abs() < 1e-4);
        assert!(i.warnings.messages.is_empty(), "{:?}", i.warnings);
    }
    // No person is 0.7 m tall, but where the config says that this one is: others are taken as adults, which is told.
    let small = body::bvh(1, same, |v| v * 0.4);
    let taken = import(&small, &ImportConfig::default());
    assert!((1.7..1.8).contains(&taken.height), "{}", taken.height);
    assert!(taken.warnings.messages.iter().any(|w| w.contains("metres_per_unit")), "{:?}", taken.warnings);
    let meant = ImportConfig { metres_per_unit: Some(1.0), ..ImportConfig::default() };
    assert!((0.6..0.8).contains(&import(&small, &meant).height));
    let config = ImportConfig { metres_per_unit: Some(0.02), rate_hz: Some(60.0), ..ImportConfig::default() };
    let given = import(&body::bvh(1, same, |v| v * 50.0), &config);
    assert_eq!((given.metres_per_unit, given.clip.rate_hz), (0.02, 60.0));
}

#[test]
fn z_up_files_become_y_up_and_keep_facing() {
    let y = import(&body::bvh(2, same, |v| v), &ImportConfig::default());
    let z = import(&body::bvh(2, same, to_z_up), &ImportConfig::default());
    assert_eq!((y.up, z.up), (UpAxis::Y, UpAxis::Z));
    for role in Joint::ALL.into_iter().filter(|&r| y.roles.get(r).is_some()) {
        assert!(position(&y, role).distance(position(&z, role)) < 1e-5, "{}", role.name());
    }
    assert_eq!((y.rest_pose.kind, z.rest_pose.kind), (RestPoseKind::TPose, RestPoseKind::TPose));
    assert_eq!((y.facing, z.facing), (0.0, 0.0));
    let config = ImportConfig { up: Some(UpAxis::Y), ..ImportConfig::default() };
    assert!(position(&import(&body::bvh(1, same, to_z_up), &config), Joint::Head).y.abs() < 1e-5);
}

#[test]
fn a_body_that_lies_down_in_a_z_up_file_is_told_by_its_rest_pose() {
    let text = body::bvh(1, same, to_z_up);
    let mut lines: Vec<_> = text.lines().map(str::to_owned).collect();
    let last = lines.len() - 1;
    lines[last] = format!("0 0 0 0 0 90{}", " 0".repeat(3 * (body::BODY.len() - 1)));
    let i = import(&lines.join("\n"), &ImportConfig::default());
    assert_eq!(i.up, UpAxis::Z);
    assert!(i.findings.iter().any(|f| f.contains("the rest pose stands along it")), "{:?}", i.findings);
}

#[test]
fn the_heading_of_the_rest_pose_is_found_or_given() {
    for (heading, forward) in
        [(0.0, Forward::PosZ), (FRAC_PI_2, Forward::PosX), (-FRAC_PI_2, Forward::NegX), (PI, Forward::NegZ)]
    {
        let turned = body::bvh(2, same, |v| Quat::from_rotation_y(heading) * v);
        let i = import(&turned, &ImportConfig::default());
        let wrapped = (i.facing - heading).rem_euclid(2.0 * PI);
        assert!(wrapped.min(2.0 * PI - wrapped) < 1e-4, "{heading}: {}", i.facing);
        let given = import(&turned, &ImportConfig { forward: Some(forward), ..ImportConfig::default() });
        assert_eq!(given.facing, forward.heading());
    }
}

#[test]
fn lowered_arms_are_an_a_pose() {
    let lower = |v: Vec3| {
        let arm = v.x.abs() > 0.2;
        if arm { Quat::from_rotation_z(-0.8 * v.x.signum()) * v } else { v }
    };
    let i = import(&body::bvh(2, same, lower), &ImportConfig::default());
    assert_eq!(i.rest_pose.kind, RestPoseKind::APose);
    assert!(i.rest_pose.sentence.contains("arms -46 degrees"), "{}", i.rest_pose.sentence);
}

/// The body with every segment along +X at rest, as exporters with joint-local axes write it: joint j's axes are
/// turned by `axes[j]` in the T-pose, and the motion holds that T-pose.
fn along_x() -> String {
    let axes: Vec<Quat> = (0..body::BODY.len())
        .map(|j| {
            let child = body::BODY.iter().find(|(_, p, _)| *p == Some(j)).map_or(body::BODY[j].2, |b| b.2);
            let along = if j == 0 { Vec3::Y } else { Vec3::from(child).normalize() };
            let straight =
                if along.x.abs() > along.y.abs() { Vec3::X * along.x.signum() } else { Vec3::Y * along.y.signum() };
            Quat::from_rotation_arc(Vec3::X, straight)
        })
        .collect();
    let world: Vec<Vec3> = body::BODY.iter().fold(Vec::new(), |mut w: Vec<Vec3>, (_, p, o)| {
        w.push(p.map_or(Vec3::ZERO, |p| w[p]) + Vec3::from(*o));
        w
    });
    let mut clip = bvh::parse(body::bvh(3, same, |v| v).as_bytes(), Path::new("a.bvh")).unwrap().clip;
    let index: Vec<_> = body::BODY.iter().map(|b| clip.joints.iter().position(|j| j.name == b.0).unwrap()).collect();
    for (j, (_, parent, _)) in body::BODY.iter().enumerate() {
        let (offset, local) = match parent {
            None => (world[j], axes[j]),
            Some(p) => (axes[*p].inverse() * (world[j] - world[*p]), axes[*p].inverse() * axes[j]),
        };
        clip.joints[index[j]].offset = offset;
        for frame in 0..3 {
            let k = frame * clip.joints.len() + index[j];
            (clip.translations[k], clip.rotations[k]) = (offset, local);
        }
    }
    let mut text = Vec::new();
    throng_precompute::export::bvh::write_clip(&clip, &mut text).unwrap();
    String::from_utf8(text).unwrap()
}

#[test]
fn a_rest_pose_that_is_no_body_is_told() {
    let i = import(&along_x(), &ImportConfig::default());
    assert_eq!((i.rest_pose.kind, i.facing), (RestPoseKind::Other, 0.0));
    assert!(i.rest_pose.sentence.contains("not a standing body"), "{}", i.rest_pose.sentence);
}

#[test]
fn namespaces_do_not_hide_a_profile() {
    let i = import(&body::bvh(1, |n| format!("mixamorig:{n}"), |v| v * 100.0), &ImportConfig::default());
    assert_eq!(i.roles.profile, "Mixamo");
    let arm = i.roles.get(Joint::LeftUpperArm).map(|j| i.clip.joints[j].name.as_str());
    assert_eq!(arm, Some("mixamorig:LeftArm"));
}

/// Role by role, what is found for a renamed body must be what the original name means.
fn check_shape(rename: impl Fn(&str) -> String) {
    let i = import(&body::bvh(1, &rename, |v| v * 100.0), &ImportConfig::default());
    assert_eq!(i.roles.profile, throng_precompute::import::RoleMap::BY_SHAPE);
    assert!(i.warnings.messages.is_empty(), "{:?}", i.warnings);
    let expected = [
        "Hips",
        "Spine",
        "Spine1",
        "Spine2",
        "Neck",
        "Head",
        "LeftShoulder",
        "LeftArm",
        "LeftForeArm",
        "LeftHand",
        "RightShoulder",
        "RightArm",
        "RightForeArm",
        "RightHand",
        "LeftUpLeg",
        "LeftLeg",
        "LeftFoot",
        "LeftToeBase",
        "RightUpLeg",
        "RightLeg",
        "RightFoot",
        "RightToeBase",
    ];
    for (role, name) in Joint::ALL.into_iter().zip(expected) {
        let got = i.roles.get(role).map_or("", |j| i.clip.joints[j].name.as_str());
        assert_eq!(got, rename(name), "{}", role.name());
    }
}

#[test]
fn unknown_skeletons_are_mapped_by_shape_and_name() {
    check_shape(|n| n.replace("Left", "Left_").replace("Right", "Right_"));
    let side = |n: &str| if n.starts_with("Left") { "L" } else { "R" };
    let part = |n: &str| n.trim_start_matches("Left").trim_start_matches("Right").to_owned();
    check_shape(|n| match part(n).as_str() {
        "Hips" => "Bip01 Pelvis".into(),
        "UpLeg" => format!("Bip01 {} Thigh", side(n)),
        "Leg" => format!("Bip01 {} Calf", side(n)),
        "Shoulder" => format!("Bip01 {} Clavicle", side(n)),
        "Arm" => format!("Bip01 {} UpperArm", side(n)),
        "ToeBase" => format!("Bip01 {} Toe0", side(n)),
        p @ ("Foot" | "ForeArm" | "Hand") => format!("Bip01 {} {p}", side(n)),
        p => format!("Bip01 {p}"),
    });
    check_shape(|n| match part(n).as_str() {
        "Hips" => "pelvis".into(),
        "UpLeg" => format!("{}Hip", side(n)),
        "Leg" => format!("{}Knee", side(n)),
        "Foot" => format!("{}Ankle", side(n)),
        "ToeBase" => format!("{}Foot", side(n)),
        "Shoulder" => format!("{}Collar", side(n)),
        "Arm" => format!("{}Shoulder", side(n)),
        "ForeArm" => format!("{}Elbow", side(n)),
        "Hand" => format!("{}Wrist", side(n)),
        p => p.to_lowercase(),
    });
    check_shape(|n| match part(n).as_str() {
        "UpLeg" => format!("thigh_{}", side(n).to_lowercase()),
        "Leg" => format!("calf_{}", side(n).to_lowercase()),
        "ToeBase" => format!("ball_{}", side(n).to_lowercase()),
        "Shoulder" => format!("clavicle_{}", side(n).to_lowercase()),
        "Arm" => format!("upperarm_{}", side(n).to_lowercase()),
        "ForeArm" => format!("lowerarm_{}", side(n).to_lowercase()),
        p @ ("Hand" | "Foot") => format!("{}_{}", p.to_lowercase(), side(n).to_lowercase()),
        p => p.to_lowercase(),
    });
}

#[test]
fn a_joint_without_a_telling_name_is_found_by_its_place() {
    let text = body::bvh(1, |n| n.replace("LeftLeg", "Thing"), |v| v);
    let i = import_with(&text, &ImportConfig::default(), &load_profiles(&[]).unwrap()).unwrap();
    assert_eq!(i.roles.get(Joint::LeftShin).map(|j| i.clip.joints[j].name.as_str()), Some("Thing"));
}

#[test]
fn a_profile_that_names_too_little_is_refused_with_the_joints_there_are() {
    let profile = Profile::parse("name='Few'\nsource='test'\n[roles]\nhips='Hips'\nhead='Head'", Path::new("few.toml"));
    let few = ImportConfig { profile: Some("Few".into()), ..ImportConfig::default() };
    let e = import_with(&body::bvh(1, same, |v| v), &few, &[profile.unwrap()]).unwrap_err().to_string();
    assert!(e.contains("a.bvh: the profile `Few` names no joint for the role `left_thigh` among: Hips,"), "{e}");
}

#[test]
fn a_profile_of_the_user_decides_and_a_wrong_one_is_refused() {
    let mut toml = String::from("name = 'Mine'\nsource = 'test'\n[roles]\n");
    for (role, joint) in [
        ("hips", "Hips"),
        ("head", "Head"),
        ("left_upper_arm", "LeftArm"),
        ("right_upper_arm", "RightArm"),
        ("left_thigh", "LeftUpLeg"),
        ("left_shin", "Thing"),
        ("left_foot", "LeftFoot"),
        ("right_thigh", "RightUpLeg"),
        ("right_shin", "RightLeg"),
        ("right_foot", "RightFoot"),
    ] {
        toml += &format!("{role} = '{joint}'\n");
    }
    let profiles = [Profile::parse(&toml, Path::new("mine.toml")).unwrap()];
    let text = body::bvh(1, |n| n.replace("LeftLeg", "Thing"), |v| v);
    let i = import_with(&text, &ImportConfig::default(), &profiles).unwrap();
    assert_eq!((i.roles.profile.as_str(), i.roles.get(Joint::Spine)), ("Mine", None));
    let wanted = |name: &str| ImportConfig { profile: Some(name.into()), ..ImportConfig::default() };
    let e = import_with(&body::bvh(1, same, |v| v), &wanted("Mine"), &profiles).unwrap_err().to_string();
    assert!(e.contains("the profile `Mine` does not fit: no joint `Thing` for the role `left_shin`"), "{e}");
    let e = import_with(&text, &wanted("Yours"), &profiles).unwrap_err().to_string();
    assert!(e.contains("there is no skeleton profile `Yours`, only: Mine"), "{e}");
}

#[test]
fn one_bad_file_of_a_folder_is_skipped_or_stops_a_strict_build() {
    let dir = tempfile::tempdir().unwrap();
    for name in ["c", "a"] {
        std::fs::write(dir.path().join(format!("{name}.bvh")), body::bvh(2, same, |v| v)).unwrap();
    }
    std::fs::write(dir.path().join("b.bvh"), "HIERARCHY\nROOT").unwrap();
    let paths: Vec<PathBuf> = vec![dir.path().to_owned()];
    let set = read(&paths, &ImportConfig::default(), &Silent).unwrap();
    assert_eq!(set.clips.iter().map(|c| c.clip.name.as_str()).collect::<Vec<_>>(), ["a", "c"]);
    assert_eq!(set.skipped.len(), 1);
    assert!(set.skipped[0].to_string().contains("b.bvh:2:5:"), "{}", set.skipped[0]);
    let strict = ImportConfig { strict: true, ..ImportConfig::default() };
    assert!(read(&paths, &strict, &Silent).unwrap_err().to_string().contains("b.bvh:2:5:"));
    // Where no file is good, there is nothing to go on with: the error says why, strict or not.
    let bad = [dir.path().join("b.bvh")];
    assert!(read(&bad, &ImportConfig::default(), &Silent).unwrap_err().to_string().contains("b.bvh:2:5:"));
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads() {
    let dir = tempfile::tempdir().unwrap();
    for name in 0..9 {
        std::fs::write(dir.path().join(format!("{name}.bvh")), along_x()).unwrap();
    }
    let paths = [dir.path().to_owned()];
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| read(&paths, &ImportConfig::default(), &Silent).unwrap().clips)
    };
    let one = with(1);
    assert!(one == with(2) && one == with(8));
}

#[test]
fn a_report_names_roles_units_and_reasons() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.bvh");
    std::fs::write(&path, body::bvh(2, same, |v| v * 100.0)).unwrap();
    let report = inspect(&path, &ImportConfig::default()).unwrap();
    assert_eq!((report.format, report.frames, report.rate_hz, report.up), ("bvh", 2, 30.0, 'Y'));
    assert_eq!(report.roles["left_thigh"], "LeftUpLeg");
    let text = report.to_string();
    for part in ["2 frames at 30 Hz", "centimetres", "Y is up", "T-pose", "left_shin", "LeftLeg"] {
        assert!(text.contains(part), "no `{part}` in:\n{text}");
    }
    assert!(report.warnings.is_empty(), "{:?}", report.warnings);
    // Names that say nothing: the shape alone decides, which is told once, with the roles.
    let numbered = |n: &str| format!("Bone{:02}", body::BODY.iter().position(|b| b.0 == n).unwrap());
    std::fs::write(&path, body::bvh(2, numbered, |v| v)).unwrap();
    let report = inspect(&path, &ImportConfig::default()).unwrap();
    let told =
        |w: &&String| w.contains("by the shape of the skeleton alone: hips=Bone00") && w.contains("left_thigh=Bone14");
    assert_eq!(report.warnings.iter().filter(told).count(), 1, "{:?}", report.warnings);
    assert_eq!(report.profile, throng_precompute::import::RoleMap::BY_SHAPE);
}

#[test]
fn a_report_of_a_fast_clip_has_the_speeds_of_a_build_and_the_frames_of_the_file() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.bvh");
    let text = body::bvh(600, same, |v| v).replace("0.0333333", "0.00833333");
    std::fs::write(&path, text).unwrap();
    let report = inspect(&path, &ImportConfig::default()).unwrap();
    assert_eq!((report.frames, report.rate_hz), (600, 120.0));
    assert_eq!(report.excluded, [("T-pose".to_owned(), 0, 600)]);
}

#[test]
fn legs_without_length_are_refused_and_the_joint_is_named() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("a.bvh"), body::bvh(2, same, |v| v * 100.0)).unwrap();
    let tiny = ImportConfig { metres_per_unit: Some(1e-5), ..ImportConfig::default() };
    let e = read(&[dir.path().to_owned()], &ImportConfig { strict: true, ..tiny }, &Silent).unwrap_err().to_string();
    assert!(e.contains("a.bvh") && e.contains("LeftUpLeg") && e.contains("metres_per_unit"), "{e}");
}
