//! Quirks of real files, with results solved by hand.

use glam::Vec3;
use std::path::Path;
use throng_precompute::import::{SourceClip, amc, asf, bvh};

pub const BVH: &str = "HIERARCHY\nROOT Hips\n{\n OFFSET 0 10 0\n CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n JOINT Knee\n {\n  OFFSET 0 -5 0\n  CHANNELS 3 Xrotation Yrotation Zrotation\n  End Site\n  {\n   OFFSET 0 -4 0\n  }\n }\n}\nMOTION\nFrames: 2\nFrame Time: 0.0333333\n1 2 3 0 0 0 90 0 0\n0 0 0 90 90 0 0 0 0\n";

pub const ASF: &str = ":version 1.10\n:name T\n:units\n  mass 1.0\n  length 0.45\n  angle deg\n:documentation\n  free text, even begin\n:root\n  order TX TY TZ RX RY RZ\n  axis XYZ\n  position 0 0 0\n  orientation 0 0 0\n:bonedata\n  begin\n    id 1\n    name thigh\n    direction 0 -1 0\n    length 4\n    axis 0 0 90 XYZ\n    dof rx rz\n    limits (-160.0 20.0)\n           (-70.0 70.0)\n  end\n  begin\n    id 2\n    name fixed\n    direction 1 0 0\n    length 2\n    axis 0 0 0 xyz\n  end\n:hierarchy\n  begin\n    root thigh\n    thigh fixed\n  end\n";

pub const AMC: &str = "#!OML:ASF x.asf\n:FULLY-SPECIFIED\n:DEGREES\n1\nroot 1 2 3 0 0 0\nthigh 90 0\n2\nroot 1 2 3 0 0 90\nthigh -1.6201e-014 0\n";

pub fn parse_bvh(text: &str) -> SourceClip {
    bvh::parse(text.as_bytes(), Path::new("a.bvh")).unwrap()
}

fn parse_amc(asf_text: &str, amc_text: &str) -> SourceClip {
    let skeleton = asf::parse(asf_text.as_bytes(), Path::new("a.asf")).unwrap();
    amc::parse(amc_text.as_bytes(), Path::new("a.amc"), &skeleton).unwrap()
}

fn assert_at(source: &SourceClip, frame: usize, joint: &str, expected: [f32; 3]) {
    let j = source.clip.joints.iter().position(|j| j.name == joint).unwrap_or_else(|| panic!("no joint {joint}"));
    let at = source.clip.world(frame)[j].0;
    assert!(at.distance(Vec3::from(expected)) < 1e-5, "{joint} at {at}, expected {expected:?}");
}

#[test]
fn bvh_rotations_apply_in_channel_order() {
    let s = parse_bvh(BVH);
    assert_eq!((s.clip.num_frames, s.clip.rate_hz), (2, 30.0));
    // Root channels replace the offset. The knee turns by 90 degrees about X: -Y goes to -Z.
    assert_at(&s, 0, "Hips", [1.0, 2.0, 3.0]);
    assert_at(&s, 0, "Knee", [1.0, -3.0, 3.0]);
    assert_at(&s, 0, "Knee_end", [1.0, -3.0, -1.0]);
    // Rz(90) Rx(90): -Y goes to -Z by the inner X, and Z keeps -Z.
    assert_at(&s, 1, "Knee", [0.0, 0.0, -5.0]);
}

#[test]
fn bvh_quirks_of_line_ends_case_names_and_numbers_change_nothing() {
    let plain = parse_bvh(BVH);
    let named = BVH.replace("JOINT Knee", "joint mixamorig:Left Knee");
    let quirky = [
        BVH.replace('\n', "\r\n"),
        BVH.replace('\n', "\r"),
        BVH.replace(' ', "\t"),
        BVH.trim_end().to_owned(),
        format!("\u{feff}{BVH}\n\n \n"),
        BVH.replace("Frames: 2", "Frames:\t2").replace("MOTION\n", "MOTION\n\n"),
        BVH.replace("1 2 3 0 0 0", "1 +2.0 3e0 -0 .0 0"),
        BVH.replace("ROOT", "root").replace("End Site", "end site").replace("CHANNELS", "Channels").replace("Xr", "xR"),
        BVH.replace("\n{\n", " {\n").replace("\n }", "}"),
    ];
    for text in quirky {
        let s = parse_bvh(&text);
        assert_eq!(s.clip, plain.clip, "{text}");
    }
    let tiny = parse_bvh(&BVH.replace("1 2 3 0 0 0", "1 2 3 1.2e-014 0 -1.2E-14"));
    assert_at(&tiny, 0, "Knee_end", [1.0, -3.0, -1.0]);
    let s = parse_bvh(&named);
    assert_eq!(s.clip.joints[1].name, "mixamorig:Left Knee");
    assert_eq!(s.clip.joints[2].name, "mixamorig:Left Knee_end");
}

#[test]
fn bvh_position_channels_replace_offsets_axis_by_axis_on_any_joint() {
    let text = BVH
        .replace("CHANNELS 3 Xrotation Yrotation Zrotation", "CHANNELS 4 Zposition Xrotation Yrotation Zrotation")
        .replace("1 2 3 0 0 0 90 0 0", "1 2 3 0 0 0 7 90 0 0")
        .replace("0 0 0 90 90 0 0 0 0", "0 0 0 0 0 0 0 0 0 0");
    assert_at(&parse_bvh(&text), 0, "Knee", [1.0, -3.0, 10.0]);
}

#[test]
fn bvh_of_several_roots_and_joints_without_channels_reads() {
    let text = "HIERARCHY\nROOT A\n{\nOFFSET 0 0 0\nCHANNELS 1 Yrotation\nJOINT B\n{\nOFFSET 1 0 0\nCHANNELS 0\n}\n}\nROOT C\n{\nOFFSET 5 0 0\nCHANNELS 3 Xposition Yposition Zposition\n}\nMOTION\nFrames: 1\nFrame Time: .01\n90 4 5 6";
    let s = parse_bvh(text);
    assert_eq!(s.clip.rate_hz, 100.0);
    assert_at(&s, 0, "B", [0.0, 0.0, -1.0]);
    assert_at(&s, 0, "C", [4.0, 5.0, 6.0]);
}

#[test]
fn bvh_names_in_latin_1_are_kept() {
    let bytes: Vec<u8> = BVH.replace("Knee", "Kn\u{e9}").chars().map(|c| c as u8).collect();
    let s = bvh::parse(&bytes, Path::new("a.bvh")).unwrap();
    assert_eq!(s.clip.joints[1].name, "Kn\u{e9}");
}

#[test]
fn asf_segments_turn_about_their_own_axes() {
    let s = parse_amc(ASF, AMC);
    assert_eq!((s.clip.num_frames, s.clip.rate_hz), (2, 120.0));
    assert!((s.declared_metres_per_unit.unwrap() - 0.0254 / 0.45).abs() < 1e-12);
    assert_at(&s, 0, "thigh", [1.0, 2.0, 3.0]);
    // The thigh's own X axis is the global Y (axis 0 0 90), about which its direction -Y does not move,
    // while the next segment's +X goes to -Z.
    assert_at(&s, 0, "fixed", [1.0, -2.0, 3.0]);
    assert_at(&s, 0, "fixed_end", [1.0, -2.0, 1.0]);
    // The root turns by 90 degrees about Z: -Y goes to +X.
    assert_at(&s, 1, "fixed", [5.0, 2.0, 3.0]);
    assert_at(&s, 1, "fixed_end", [5.0, 4.0, 3.0]);
}

#[test]
fn asf_dialects_read_alike() {
    let plain = parse_amc(ASF, AMC);
    let lower = ASF.replace("TX TY TZ RX RY RZ", "tx ty tz rx ry rz").replace("XYZ", "xyz");
    for (skeleton, motion) in [
        (lower.as_str(), AMC.to_owned()),
        (&ASF.replace('\n', "\r\n"), AMC.replace('\n', "\r\n")),
        (&ASF.replace(' ', "\t"), AMC.trim_end().to_owned()),
        (ASF.trim_end(), format!("\u{feff}{AMC}\n\n# the end\n")),
        (ASF, AMC.replace(":DEGREES", ":degrees\n:FRAME-RANGE 1-2")),
        (ASF, AMC.replace("\n1\n", "\n150\n").replace("\n2\n", "\n151\n")),
    ] {
        assert_eq!(parse_amc(skeleton, &motion).clip, plain.clip, "{motion}");
    }
    let timed = parse_amc(ASF, &AMC.replace(":DEGREES", ":SAMPLES-PER-SECOND 30\n:DEGREES"));
    assert_eq!(timed.clip.rate_hz, 30.0);
    let radians = AMC.replace(":DEGREES", ":RADIANS").replace("90", "1.5707963267948966");
    assert_at(&parse_amc(ASF, &radians), 1, "fixed_end", [5.0, 4.0, 3.0]);
}

#[test]
fn asf_root_order_says_what_the_numbers_are() {
    let skeleton = ASF.replace("TX TY TZ RX RY RZ", "RZ TZ TX");
    let motion = AMC.replace("root 1 2 3 0 0 0", "root 90 3 1").replace("root 1 2 3 0 0 90", "root 0 0 0");
    assert_at(&parse_amc(&skeleton, &motion), 0, "fixed", [5.0, 0.0, 3.0]);
}
