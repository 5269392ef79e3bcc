//! A mesh of the user's own is worn by everybody, upright, with feet where the simulation has them.

use crate::common::{golden, rig};
use clap::Parser;
use glam::Vec3;
use image::RgbImage;
use std::path::{Path, PathBuf};
use throng_viewer::args::Args;
use throng_viewer::document::UserOutfit;
use throng_viewer::headless::{Headless, save_png};

fn args(rest: &[&str]) -> Args {
    Args::try_parse_from(std::iter::once("throng-viewer").chain(rest.iter().copied())).expect("right arguments")
}

fn picture(args: &Args) -> RgbImage {
    let mut headless = Headless::new(args).expect("a picture can be drawn");
    for _ in 0..args.frames.unwrap_or(90) {
        headless.advance(false).expect("a frame");
    }
    headless.picture().expect("a picture")
}

/// Writes a picture where `PICTURES` names a folder, to be looked at.
fn keep(image: &RgbImage, name: &str) {
    if let Some(folder) = std::env::var_os("PICTURES") {
        save_png(image, &PathBuf::from(folder).join(name)).expect("a file");
    }
}

fn written(folder: &Path) -> PathBuf {
    let path = folder.join("me.glb");
    std::fs::write(&path, rig::glb()).expect("a file");
    path
}

#[test]
fn everybody_wears_the_mesh_of_a_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let own = written(folder.path());
    let (golden, own) = (golden().to_string_lossy().into_owned(), own.to_string_lossy().into_owned());
    for (view, name) in [("front", "body-front.png"), ("side", "body-side.png")] {
        let camera = format!("{view},distance=3.2,target=0:0.9:0");
        let line = |body: &str| {
            let all = [&golden, "--size", "400x400", "--panel", "none", "--characters", "1", "--body", body];
            picture(&args(&[&all[..], &["--camera", &camera, "--stage", "clip", "--frame", "20"]].concat()))
        };
        let (worn, made) = (line(&own), line("mannequin"));
        keep(&worn, name);
        // The rig is painted in one strong blue, which nothing else has.
        let blue = |image: &RgbImage| {
            let rgb: &[u8] = image;
            (0..rgb.len() / 3).filter(|&i| rgb[3 * i + 2] > 90 && rgb[3 * i] < rgb[3 * i + 2] / 2).collect::<Vec<_>>()
        };
        // So is an axis, which is there without it.
        let (worn, made) = (blue(&worn), blue(&made));
        let worn: Vec<usize> = worn.into_iter().filter(|i| !made.contains(i)).collect();
        assert!(worn.len() > 3000 && made.len() < 1000, "{view}: {} and {}", worn.len(), made.len());
        // From head to feet: taller than wide, and not all over the picture.
        let rows = [worn[0] / 400, worn[worn.len() - 1] / 400];
        let columns: Vec<usize> = worn.iter().map(|i| i % 400).collect();
        let (left, right) = (columns.iter().min().expect("some"), columns.iter().max().expect("some"));
        assert!(rows[1] - rows[0] > right - left, "{view}: {rows:?}, {left} to {right}");
    }
}

#[test]
fn feet_of_the_mesh_stand_where_those_of_the_motion_do() {
    use throng_core::{Joint, NUM_JOINTS, Skeleton};
    let folder = tempfile::tempdir().expect("a folder");
    let outfit = UserOutfit::open(&written(folder.path())).expect("a character");
    let skeleton = Skeleton::default();
    let rest = skeleton.rest_positions().map(|p| (p, glam::Quat::IDENTITY));
    let mut matrices = vec![throng_core::Mat3x4::default(); outfit.figure.num_frames()];
    outfit.figure.pose_matrices(&skeleton, &rest, &mut matrices);
    let (surface, mut off) = (outfit.figure.surface(), Vec::new());
    for joint in [Joint::LeftFoot, Joint::RightFoot, Joint::LeftHand, Joint::RightHand, Joint::Head] {
        // Each part of the rig is a box around its joint.
        let of = |c: &&throng_precompute::wearer::SurfaceCorner| rig::part_of(c.frames[0]) == Some(joint);
        let corners: Vec<Vec3> = surface
            .corners
            .iter()
            .filter(of)
            .map(|c| matrices[usize::from(c.frames[0])].to_mat4().transform_point3(c.position))
            .collect();
        assert!(!corners.is_empty(), "{joint:?}");
        let mut apart = corners.iter().sum::<Vec3>() / corners.len() as f32 - rest[joint.index()].0;
        if matches!(joint, Joint::LeftFoot | Joint::RightFoot) {
            apart.y = 0.0;
        }
        off.push((joint, apart.length()));
    }
    // Soles lie on the ground, however high its ankles are; hands and head follow the character's own proportions.
    let heights =
        surface.corners.iter().map(|c| matrices[usize::from(c.frames[0])].to_mat4().transform_point3(c.position).y);
    let lowest = heights.fold(f32::INFINITY, f32::min);
    assert!(lowest.abs() < 5e-3, "its soles are {lowest} m high");
    for (joint, off) in off {
        let most = if matches!(joint, Joint::LeftFoot | Joint::RightFoot) { 2e-3 } else { 0.25 };
        assert!(off < most, "{joint:?}: {off} m of {NUM_JOINTS} joints");
    }
}

#[test]
fn what_cannot_be_worn_is_said_with_the_way_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("a file");
        path.to_string_lossy().into_owned()
    };
    let parted = rig::glb_with(|json| json["images"] = serde_json::json!([{ "uri": "skin.png" }]));
    let painted = rig::glb_with(|json| {
        json["images"] = serde_json::json!([{ "uri": "data:image/webp;base64,UklGRgAAAABXRUJQ" }]);
        json["textures"] = serde_json::json!([{ "source": 0 }]);
        json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = serde_json::json!({ "index": 0 });
    });
    let compressed =
        rig::glb_with(|json| json["extensionsRequired"] = serde_json::json!(["KHR_draco_mesh_compression"]));
    let bare = rig::glb_with(|json| drop(json.as_object_mut().expect("an object").remove("skins")));
    for (name, bytes, say) in [
        ("text.glb", &b"hello"[..], "expected a glTF 2.0 document"),
        ("bare.glb", &bare, "no skin"),
        ("parted.glb", &parted, "one .glb file"),
        ("painted.glb", &painted, "PNG or JPEG"),
        ("compressed.glb", &compressed, "without compression"),
    ] {
        let path = file(name, bytes);
        let e = Headless::new(&args(&[&golden().to_string_lossy(), "--body", &path])).err().expect(name).to_string();
        assert!(e.contains("--body") && e.contains(name) && e.contains(say), "{name}: {e}");
    }
    let e = Headless::new(&args(&[&golden().to_string_lossy(), "--body", "nobody.glb"]))
        .err()
        .expect("no file")
        .to_string();
    assert!(e.contains("nobody.glb"), "{e}");
}
