//! What Blender writes of a clip is that clip, joint by joint.

use super::{farthest, read_source, walk};
use std::path::Path;
use std::process::Command;
use throng_motion::export;
use throng_motion::import::bvh;

/// Set `THRONG_PYTHON` to a Python that has Blender as a module (`pip install bpy`).
#[test]
fn files_that_blender_wrote_have_the_joints_of_the_clip_that_it_was_given() {
    let blender = |args: &[&Path]| {
        let python = std::env::var_os("THRONG_PYTHON").ok_or("THRONG_PYTHON names no Python with Blender")?;
        let has = Command::new(&python).args(["-c", "import bpy"]).output().is_ok_and(|o| o.status.success());
        if !has {
            return Err("the Python of THRONG_PYTHON has no module bpy");
        }
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scripts/blender.py");
        let done = Command::new(python).arg(script).args(args).args(["--metres", "0.01"]).output().unwrap();
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        Ok(())
    };
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let mut text = Vec::new();
    export::bvh::write_clip(&walk(), &mut text).unwrap();
    std::fs::write(at("walk.bvh"), &text).unwrap();
    if let Err(why) = blender(&[&at("out"), &at("walk.bvh")]) {
        eprintln!("skipped: {why}");
        return;
    }
    let mut truth = bvh::parse(&text, Path::new("walk.bvh")).unwrap().clip;
    truth.translations.iter_mut().for_each(|t| *t *= 0.01);
    let formats: &[&str] = if cfg!(feature = "fbx") { &["glb", "fbx"] } else { &["glb"] };
    for name in formats.iter().flat_map(|f| [format!("walk.{f}"), format!("skinned/walk.{f}")]) {
        let mut clips = read_source(&at("out").join(&name), None).unwrap();
        assert_eq!(clips.len(), 1, "{name}");
        let clip = clips.swap_remove(0).clip;
        assert_eq!(clip.rate_hz.round(), 30.0, "{name}");
        let worst = farthest(&clip, &truth);
        println!("{name}: joints within {worst} m of the clip's");
        assert!(worst < 1e-4, "{name}: {worst} m");
    }
}
