//! Damaged files are refused with file, line, column and the way out, and nothing makes a reader panic.

use super::formats::{AMC, ASF, BVH};
use std::path::Path;
use throng_precompute::ImportError;
use throng_precompute::import::{amc, asf, bvh};

fn bvh_error(text: &str) -> String {
    bvh::parse(text.as_bytes(), Path::new("a.bvh")).expect_err(text).to_string()
}

fn asf_error(text: &str) -> String {
    asf::parse(text.as_bytes(), Path::new("a.asf")).expect_err(text).to_string()
}

fn amc_error(text: &str) -> String {
    let skeleton = asf::parse(ASF.as_bytes(), Path::new("a.asf")).unwrap();
    amc::parse(text.as_bytes(), Path::new("a.amc"), &skeleton).expect_err(text).to_string()
}

/// Every edit of a good text must be refused with a message that starts and continues as given.
fn check(good: &str, error: fn(&str) -> String, cases: &[(&str, &str, &str)]) {
    for (from, to, message) in cases {
        assert!(good.contains(from), "the text has no `{from}`");
        let e = error(&good.replacen(from, to, 1));
        assert!(e.starts_with(message), "`{from}` -> `{to}`:\n  got      {e}\n  expected {message}");
        assert!(e.split(". ").count() > 1, "no way out in: {e}");
    }
}

#[test]
fn bvh_faults_are_named_by_place() {
    check(
        BVH,
        bvh_error,
        &[
            ("HIERARCHY", "HIERARCHIE", "a.bvh:1:1: expected `HIERARCHY`, found `HIERARCHIE`"),
            ("ROOT", "BONE", "a.bvh:2:1: expected `ROOT`, found `BONE`"),
            ("ROOT Hips\n{", "ROOT\n{", "a.bvh:2:5: expected the name of a joint, found the end of the line"),
            ("ROOT Hips\n{", "ROOT Hips", "a.bvh:3:2: expected `{`, found `OFFSET`"),
            ("OFFSET 0 10 0", "OFFSET 0 10", "a.bvh:4:13: expected the z of an offset, found the end of the line"),
            ("OFFSET 0 10 0", "OFFSET 0 1,5 0", "a.bvh:4:11: expected the y of an offset, found `1,5`"),
            ("CHANNELS 6", "CHANNELS 99999999999", "a.bvh:5:11: expected at most 6 channels, found `99999999999`"),
            ("Xposition", "Xscale", "a.bvh:5:13: expected a channel: Xposition"),
            ("CHANNELS 3", "CHANNELS 4", "a.bvh:10:3: expected a channel"),
            ("Yposition", "Xposition", "a.bvh:5:23: expected each position channel once, found `Xposition`"),
            (
                "  }\n }\n}",
                "  }\n }",
                "a.bvh:15:1: expected `OFFSET`, `CHANNELS`, `JOINT`, `End Site` or `}`, found `MOTION`",
            ),
            ("  }\n }\n}", "  }\n }\n}}", "a.bvh:15:2: expected `ROOT` or `MOTION`, found `}`"),
            ("Frames: 2", "Frames: 4", "a.bvh:21:1: expected the line of frame 3 of 4, found the end of the file"),
            (
                "1 2 3 0 0 0 90 0 0",
                "1 2 3 0 0 0 90 0 0\n1 2 3 0 0 0 90 0 0\n1 2 3 0 0 0 90 0 0",
                "a.bvh:22:1: expected the end of the file after 2 frames, found `0`",
            ),
            ("Frames: 2", "Frames: 99999999999", "a.bvh:21:1: expected the line of frame 3 of 99999999999"),
            ("Frames: 2", "Frames: 0", "a.bvh:17:9: expected at least one frame, found `0`"),
            ("Frames: 2", "Frames: -2", "a.bvh:17:9: expected the number of frames, found `-2`"),
            ("0.0333333", "0", "a.bvh:18:13: expected seconds between"),
            ("0.0333333", "inf", "a.bvh:18:13: expected the seconds of a frame, found `inf`"),
            (
                "1 2 3 0 0 0 90 0 0",
                "1 2 3 0 0 0 90 0",
                "a.bvh:19:17: expected number 9 of 9 of frame 1 of 2, found the end of the line",
            ),
            (
                "1 2 3 0 0 0 90 0 0",
                "1 2 3 0 0 0 90 0 0 5",
                "a.bvh:19:20: expected 9 numbers, one per channel, found `5`",
            ),
            (
                "1 2 3 0 0 0 90 0 0",
                "1 2 nan 0 0 0 90 0 0",
                "a.bvh:19:5: expected number 3 of 9 of frame 1 of 2, found `nan`",
            ),
            (
                "1 2 3 0 0 0 90 0 0",
                "1 2 1e300 0 0 0 90 0 0",
                "a.bvh:19:5: expected number 3 of 9 of frame 1 of 2, found `1e300`",
            ),
        ],
    );
}

#[test]
fn asf_faults_are_named_by_place() {
    check(
        ASF,
        asf_error,
        &[
            (
                ":bonedata",
                ":bones",
                "a.asf:34:10: expected the name of a segment in `:bonedata`, or `root`, found `thigh`",
            ),
            ("length 0.45", "length 0", "a.asf:5:10: expected a length above 0, found `0`"),
            ("angle deg", "angle grad", "a.asf:6:9: expected `deg` or `rad`, found `grad`"),
            ("order TX TY TZ", "order TX TX TZ", "a.asf:10:12: expected `tx`"),
            (
                "direction 0 -1 0",
                "direction 0 -1",
                "a.asf:18:19: expected a direction, three numbers, found the end of the line",
            ),
            ("length 4", "length four", "a.asf:19:12: expected a length, found `four`"),
            ("axis 0 0 90 XYZ", "axis 0 0 90 XXZ", "a.asf:20:17: expected an axis order such as `XYZ`, found `XXZ`"),
            ("dof rx rz", "dof rx l", "a.asf:21:12: expected `tx`"),
            ("    name fixed\n", "", "a.asf:30:3: expected `name`"),
            ("name fixed", "name thigh", "a.asf:27:10: expected a name that no other segment has, found `thigh`"),
            ("thigh fixed", "thigh other", "a.asf:35:11: expected the name of a segment"),
            ("thigh fixed", "thigh thigh", "a.asf:35:11: expected a segment that has no parent yet, found `thigh`"),
            (
                "    thigh fixed\n",
                "",
                "a.asf:27:10: expected every segment in `:hierarchy`, found `fixed` without a way to the root",
            ),
        ],
    );
}

#[test]
fn amc_faults_are_named_by_place() {
    check(
        AMC,
        amc_error,
        &[
            ("\n1\n", "\n", "a.amc:4:1: expected the number of the first frame, found `root`"),
            ("\n2\n", "\n3\n", "a.amc:7:1: expected frame 2, found `3`"),
            ("thigh 90 0", "thigh 90", "a.amc:6:9: expected 2 numbers on this line, found the end of the line"),
            ("thigh 90 0", "thigh 90 0 1", "a.amc:6:12: expected 2 numbers on this line, found `1`"),
            ("thigh 90 0", "thigh 90 x", "a.amc:6:10: expected 2 numbers on this line, found `x`"),
            (
                "thigh 90 0",
                "thihg 90 0",
                "a.amc:6:1: expected a frame number or the name of a joint, found `thihg`. a.asf has no such joint. Did you mean `thigh`?",
            ),
            ("thigh 90 0\n", "", "a.amc:4:1: expected a line for `thigh` in frame 1, found a frame without it"),
            (
                "thigh 90 0\n",
                "thigh 90 0\nthigh 90 0\n",
                "a.amc:7:1: expected each joint once in frame 1, found `thigh`",
            ),
            ("thigh -1.6201e-014 0\n", "", "a.amc:7:1: expected a line for `thigh` in frame 2"),
            (":DEGREES", ":SAMPLES-PER-SECOND 0", "a.amc:3:21: expected a rate between"),
        ],
    );
    assert!(amc_error(":DEGREES\n").starts_with("a.amc:2:1: expected at least one frame"));
}

#[test]
fn utf_16_is_refused_by_name() {
    let bytes: Vec<u8> = std::iter::once(0xfeff).chain(BVH.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    let e = bvh::parse(&bytes, Path::new("a.bvh")).unwrap_err().to_string();
    assert!(e.contains("a.bvh: the text is UTF-16. Save the file as UTF-8"), "{e}");
}

/// Texts made of a good one by cutting it short and by changing one byte.
fn damaged(text: &str) -> impl Iterator<Item = Vec<u8>> + '_ {
    let cut = (0..text.len()).map(|n| text.as_bytes()[..n].to_vec());
    let changed = (0..text.len()).flat_map(move |i| {
        [0u8, b'{', b'}', b'\n', b'9', b'e', b':', 0xff].into_iter().map(move |b| {
            let mut bytes = text.as_bytes().to_vec();
            bytes[i] = b;
            bytes
        })
    });
    cut.chain(changed)
}

/// A result is fine, and so is an error with a place; nothing else.
fn assert_placed<T>(result: Result<T, ImportError>) {
    if let Err(ImportError::Syntax { line, column, .. }) = result {
        assert!(line > 0 && column > 0);
    }
}

#[test]
fn no_damage_makes_a_reader_panic() {
    let skeleton = asf::parse(ASF.as_bytes(), Path::new("a.asf")).unwrap();
    damaged(BVH).for_each(|b| assert_placed(bvh::parse(&b, Path::new("a.bvh"))));
    damaged(AMC).for_each(|b| assert_placed(amc::parse(&b, Path::new("a.amc"), &skeleton)));
    for bytes in damaged(ASF) {
        if let Ok(skeleton) = asf::parse(&bytes, Path::new("a.asf")) {
            assert_placed(amc::parse(AMC.as_bytes(), Path::new("a.amc"), &skeleton));
        }
    }
}

#[test]
fn every_prefix_that_loses_a_number_is_refused_or_loses_its_last_row() {
    let body = BVH.trim_end();
    let rows: Vec<usize> = body.match_indices('\n').map(|(at, _)| at).collect();
    let last_row = rows[rows.len() - 1];
    // Cutting inside the last number or after it still leaves all numbers.
    for n in 0..body.len() - 1 {
        match bvh::parse(&body.as_bytes()[..n], Path::new("a.bvh")) {
            Ok(read) => assert!(n >= last_row && read.clip.num_frames == 1, "{:?}", &body[..n]),
            Err(_) => assert!(n != last_row, "{:?}", &body[..n]),
        }
    }
}

#[test]
fn many_joints_that_never_move_do_not_multiply_into_memory() {
    let joints = "JOINT a\n{\nCHANNELS 0\n}\n".repeat(4000);
    let text = format!(
        "HIERARCHY\nROOT r\n{{\nCHANNELS 1 Xposition\n{joints}}}\nMOTION\nFrames: 50000\nFrame Time: 0.1\n{}",
        "0\n".repeat(50_000)
    );
    assert!(bvh_error(&text).contains("too large a clip"));
    let deep = "JOINT a\n{\n".repeat(100_000);
    assert!(bvh_error(&format!("HIERARCHY\nROOT r\n{{\n{deep}")).contains("at most 4096 joints"));
}
