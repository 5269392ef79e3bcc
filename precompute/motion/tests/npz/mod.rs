//! SMPL motion in `.npz` files: as NumPy writes it, in all its variants, and damaged.

use std::io::{Cursor, Write};
use std::path::Path;
use throng_core::Joint;
use throng_motion::ImportError;
use throng_motion::import::{ImportConfig, ImportedClip, UpAxis, interpret, npz, read_clip};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// An array as NumPy writes it.
fn npy(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let mut header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({shape}), }}");
    while !(10 + header.len() + 1).is_multiple_of(64) {
        header.push(' ');
    }
    header.push('\n');
    let mut out = b"\x93NUMPY\x01\x00".to_vec();
    out.extend((header.len() as u16).to_le_bytes());
    out.extend(header.as_bytes());
    out.extend(data);
    out
}

fn table(rows: usize, columns: usize, value: impl Fn(usize, usize) -> f64) -> Vec<u8> {
    let data: Vec<u8> = (0..rows * columns).flat_map(|k| value(k / columns, k % columns).to_le_bytes()).collect();
    npy("<f8", &format!("{rows}, {columns}"), &data)
}

/// A zip file without compression.
fn zip(files: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let mut out = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    for (name, content) in files {
        out.start_file(*name, options).unwrap();
        out.write_all(content).unwrap();
    }
    out.finish().unwrap().into_inner()
}

/// A body that stands upright in a world with Z up and walks along Y.
fn standing() -> Vec<(&'static str, Vec<u8>)> {
    let pose = |_: usize, k: usize| if k == 0 { std::f64::consts::FRAC_PI_2 } else { 0.0 };
    vec![
        ("poses.npy", table(30, 156, pose)),
        ("trans.npy", table(30, 3, |f, k| [0.0, 0.02 * f as f64, 0.93][k])),
        ("mocap_framerate.npy", npy("<i8", "", &120i64.to_le_bytes())),
        ("gender.npy", npy("<U6", "", &[0; 24])),
    ]
}

fn read(bytes: &[u8]) -> Result<ImportedClip, ImportError> {
    interpret(npz::parse(bytes, Path::new("a.npz"))?, &ImportConfig::default(), &[])
}

#[test]
fn a_standing_body_stands() {
    let i = read(&zip(&standing())).unwrap();
    assert_eq!((i.clip.rate_hz, i.clip.num_frames, i.up, i.metres_per_unit), (120.0, 30, UpAxis::Y, 1.0));
    assert!(Joint::ALL.into_iter().all(|j| i.roles.get(j).is_some()));
    let at = |f: usize, j: Joint| i.clip.world(f)[i.roles.get(j).unwrap()].0;
    assert!((1.6..1.9).contains(&i.height) && at(0, Joint::Head).y > 1.4, "{}", i.height);
    assert!(at(0, Joint::LeftHand).x > 0.6 && at(0, Joint::LeftToe).z > at(0, Joint::LeftFoot).z + 0.1);
    // Along +Y of a world with Z up is along -Z with Y up: backwards.
    assert!((at(29, Joint::Hips).z - at(0, Joint::Hips).z + 0.58).abs() < 1e-5);
    assert!(i.warnings.messages.is_empty(), "{:?}", i.warnings);
}

#[test]
fn what_is_missing_or_wrong_is_named() {
    let refused = |files: &[(&str, Vec<u8>)]| read(&zip(files)).unwrap_err().to_string();
    let without = |name: &str| standing().into_iter().filter(|(n, _)| !n.starts_with(name)).collect::<Vec<_>>();
    let with = |name: &'static str, content: Vec<u8>| {
        let mut files = without(name.trim_end_matches(".npy"));
        files.push((name, content));
        files
    };
    let parted = |width: usize, body: Vec<u8>| {
        let mut files = without("poses");
        files.extend([("root_orient.npy", table(30, width, |_, _| 0.0)), ("pose_body.npy", body)]);
        files
    };
    for (files, expected) in [
        (without("poses"), "there is no array `poses`, only: trans, mocap_framerate, gender"),
        (without("trans"), "there is no array `trans`"),
        (without("mocap"), "no frame rate is there: expected `mocap_framerate`"),
        (
            with("poses.npy", table(30, 60, |_, _| 0.0)),
            "expected 30 rows of 66 numbers or more of poses, found 60 a row",
        ),
        (with("poses.npy", table(29, 156, |_, _| 0.0)), "expected 30 rows"),
        (
            with("trans.npy", table(30, 2, |_, _| 0.0)),
            "`trans`: expected a table of 3 columns, found the shape [30, 2]",
        ),
        (with("trans.npy", table(30, 3, |_, _| f64::NAN)), "frame 0: expected numbers"),
        (parted(3, npy("<f8", &format!("0, {}", usize::MAX), &[])), "expected 30 rows"),
        (parted(6, table(30, 63, |_, _| 0.0)), "`root_orient`: expected a table of 3 columns, found 6"),
        (with("mocap_framerate.npy", npy("<f8", "", &0f64.to_le_bytes())), "expected 0.1 to 100000 Hz, found 0"),
        (with("poses.npy", npy(">f8", "1, 1", &[0; 8])), "little-endian), found `>f8`"),
        (with("poses.npy", npy("<f8", "30, 156", &[0; 8])), "its shape [30, 156] does not fit its 8 bytes"),
        (with("poses.npy", b"PK".to_vec()), "`poses`: it is no NumPy array"),
    ] {
        let e = refused(&files);
        assert!(e.contains("a.npz: ") && e.contains(expected) && e.contains("numpy.savez"), "{expected}: {e}");
    }
}

#[test]
fn little_that_is_compressed_cannot_ask_for_much_memory() {
    let mut out = ZipWriter::new(Cursor::new(Vec::new()));
    out.start_file("trans.npy", SimpleFileOptions::default()).unwrap();
    (0..300).for_each(|_| out.write_all(&vec![0; 1 << 20]).unwrap());
    let e = read(&out.finish().unwrap().into_inner()).unwrap_err().to_string();
    assert!(e.contains("`trans`: expected 82 MiB at most of a file of its size, found more"), "{e}");
}

#[test]
fn damaged_files_are_refused_or_the_same_and_none_panics() {
    let whole = zip(&standing());
    let good = read(&whole).unwrap();
    for length in (0..whole.len()).step_by(97) {
        assert!(read(&whole[..length]).is_err(), "{length}");
    }
    let mut at = 1;
    for k in 0..2000 {
        at = (at * 7919 + k) % whole.len();
        let mut bytes = whole.clone();
        bytes[at] ^= 1 << (k % 8);
        if let Ok(i) = read(&bytes) {
            assert_eq!(i.clip.rotations, good.clip.rotations, "byte {at}");
        }
    }
}

/// Set `THRONG_PYTHON` to a Python that has NumPy.
#[test]
fn files_that_numpy_wrote_have_their_joints_where_numpy_computes_them() {
    let Some(python) = std::env::var_os("THRONG_PYTHON") else {
        eprintln!("skipped: THRONG_PYTHON names no Python with NumPy");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let program = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/npz/write.py");
    assert!(std::process::Command::new(python).arg(program).arg(folder.path()).status().unwrap().success());
    let truth = std::fs::read_to_string(folder.path().join("truth.csv")).unwrap();
    let truth: Vec<Vec<f32>> = truth.lines().map(|l| l.split(',').map(|v| v.parse().unwrap()).collect()).collect();
    let read = |name: &str| read_clip(&folder.path().join(name), &ImportConfig::default());
    for (name, limit) in [("amass.npz", 1e-5), ("smplx.npz", 1e-5), ("packed.npz", 1e-5)] {
        let i = read(name).unwrap();
        assert_eq!((i.clip.rate_hz, i.clip.num_frames), (60.0, truth.len()));
        let mut worst = 0f32;
        for (f, row) in truth.iter().enumerate() {
            for (j, (p, _)) in i.clip.world(f).iter().enumerate() {
                worst = worst.max(p.distance(glam::Vec3::from_slice(&row[3 * j..])));
            }
        }
        println!("{name}: joints within {worst} m of NumPy's");
        assert!(worst < limit, "{name}: {worst} m");
    }
    for (name, expected) in [
        ("columns.npz", "stored by columns"),
        ("norate.npz", "no frame rate is there"),
        ("short.npz", "found 60 a row"),
    ] {
        let e = read(name).unwrap_err().to_string();
        assert!(e.contains(name) && e.contains(expected), "{e}");
    }
}

/// A T-pose of so many joints that moves ahead, as Kimodo writes it: each joint has the place of one of ours.
fn generated(width: usize, role: impl Fn(usize) -> Joint) -> Vec<(&'static str, Vec<u8>)> {
    let rest = throng_core::Skeleton::default().rest_positions();
    let floats = |shape: &str, values: Vec<f32>| {
        npy("<f4", shape, &values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>())
    };
    let turns = (0..20 * width * 9).map(|k| if k % 9 % 4 == 0 { 1.0 } else { 0.0 }).collect();
    let place = |f: usize, j: usize| rest[role(j).index()] + glam::Vec3::Z * 0.04 * f as f32;
    let places = (0..20 * width).flat_map(|k| place(k / width, k % width).to_array()).collect();
    vec![
        ("local_rot_mats.npy", floats(&format!("20, {width}, 3, 3"), turns)),
        ("posed_joints.npy", floats(&format!("20, {width}, 3"), places)),
    ]
}

/// The role of a joint of SOMA, of 77; fingers are where the hand is.
fn soma_role(joint: usize) -> Joint {
    use Joint::*;
    match joint {
        0..=3 => [Hips, Spine, Chest, UpperChest][joint],
        4 | 5 => Neck,
        6..=10 => Head,
        11..=38 => [LeftClavicle, LeftUpperArm, LeftForearm, LeftHand][(joint - 11).min(3)],
        39..=66 => [RightClavicle, RightUpperArm, RightForearm, RightHand][(joint - 39).min(3)],
        67..=71 => [LeftThigh, LeftShin, LeftFoot, LeftToe][(joint - 67).min(3)],
        _ => [RightThigh, RightShin, RightFoot, RightToe][(joint - 72).min(3)],
    }
}

fn soma30_role(joint: usize) -> Joint {
    let in_77 = match joint {
        0..=6 => joint,
        7..=9 => joint + 1,
        10..=15 => joint + 1,
        16..=21 => joint + 23,
        22..=25 => joint + 45,
        _ => joint + 46,
    };
    soma_role(in_77)
}

#[test]
fn what_kimodo_generates_is_read_with_its_own_lengths_and_at_its_rate() {
    let smpl = |j: usize| {
        use Joint::*;
        [
            Hips,
            LeftThigh,
            RightThigh,
            Spine,
            LeftShin,
            RightShin,
            Chest,
            LeftFoot,
            RightFoot,
            UpperChest,
            LeftToe,
            RightToe,
            Neck,
            LeftClavicle,
            RightClavicle,
            Head,
            LeftUpperArm,
            RightUpperArm,
            LeftForearm,
            RightForearm,
            LeftHand,
            RightHand,
        ][j]
    };
    let rest = throng_core::Skeleton::default().rest_positions();
    for files in [generated(77, soma_role), generated(30, soma30_role), generated(22, smpl)] {
        let i = read(&zip(&files)).unwrap();
        assert_eq!((i.clip.rate_hz, i.clip.num_frames, i.up), (30.0, 20, UpAxis::Y));
        for j in Joint::ALL {
            let at = i.clip.world(19)[i.roles.get(j).unwrap_or_else(|| panic!("no {}", j.name()))].0;
            let off = at.distance(rest[j.index()] + glam::Vec3::Z * 0.76);
            // Necks of two joints lie in one place here.
            assert!(off < 1e-4 || j == Joint::Neck, "{}: {off} m", j.name());
        }
        assert!(i.findings.iter().any(|f| f.contains("as Kimodo's models make")), "{:?}", i.findings);
    }
    let mut named = generated(22, smpl);
    named.push(("fps.npy", npy("<f8", "", &60f64.to_le_bytes())));
    assert_eq!(read(&zip(&named)).unwrap().clip.rate_hz, 60.0);
    let refused = |files: &[(&str, Vec<u8>)]| read(&zip(files)).unwrap_err().to_string();
    assert!(refused(&generated(34, |_| Joint::Hips)).contains("it is motion of a robot"));
    assert!(
        refused(&generated(50, |_| Joint::Hips)).contains("expected 77 or 30 joints (SOMA) or 22 (SMPL-X), found 50")
    );
    assert!(refused(&generated(22, smpl)[..1]).contains("there is no array `posed_joints`"));
    let mut skewed = generated(22, smpl);
    let at = skewed[0].1.len() - 36;
    skewed[0].1[at..at + 4].copy_from_slice(&2f32.to_le_bytes());
    assert!(refused(&skewed).contains("frame 19, joint 21: expected a rotation"), "{}", refused(&skewed));
}

#[test]
fn smpl_motion_in_a_world_with_y_up_stands() {
    let mut files = standing();
    files[0].1 = table(30, 156, |_, _| 0.0);
    files[1].1 = table(30, 3, |f, k| [0.0, 0.93, 0.02 * f as f64][k]);
    let i = read(&zip(&files)).unwrap();
    let at = |f: usize, j: Joint| i.clip.world(f)[i.roles.get(j).unwrap()].0;
    assert!(at(0, Joint::Head).y > 1.4 && (at(29, Joint::Hips).z - at(0, Joint::Hips).z - 0.58).abs() < 1e-5);
}
