//! Programs that others wrote read what is written: NumPy, USD with its validators, Blender, Khronos' validator.

use super::{glb, take};
use std::path::PathBuf;
use std::process::Command;
use throng_motion::export::{Take, bvh, usda, write_amass, write_npz};

fn script(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scripts").join(name)
}

/// Runs a program, prints what it says, and wants it to succeed.
fn run(command: &mut Command) {
    let done = command.output().expect("it starts");
    let said = String::from_utf8_lossy(&done.stdout).into_owned();
    println!("{said}");
    assert!(done.status.success(), "{said}{}", String::from_utf8_lossy(&done.stderr));
}

/// Set `THRONG_PYTHON` to a Python that has NumPy, and for more of it `usd-core` and Blender (`pip install numpy usd-core bpy`).
#[test]
fn numpy_usd_and_blender_find_every_joint_where_it_was() {
    let Some(python) = std::env::var_os("THRONG_PYTHON") else {
        eprintln!("skipped: THRONG_PYTHON names no Python with NumPy, usd-core and Blender");
        return;
    };
    let (take, folder) = (take().0, tempfile::tempdir().unwrap());
    type Writer = fn(&Take, &mut Vec<u8>);
    let writers: [(&str, Writer); 8] = [
        ("take.npz", |t, w| write_npz(t, w).unwrap()),
        ("take.glb", |t, w| w.extend(glb(t))),
        ("take.usda", |t, w| usda(t, false, w).unwrap()),
        ("instances.usda", |t, w| usda(t, true, w).unwrap()),
        ("take-11.bvh", |t, w| bvh::write_actor(t, 1, w).unwrap()),
        ("take-12.bvh", |t, w| bvh::write_actor(t, 2, w).unwrap()),
        ("smpl-11.npz", |t, w| write_amass(t, 1, w).unwrap()),
        ("smpl-12.npz", |t, w| write_amass(t, 2, w).unwrap()),
    ];
    let mut check = Command::new(python);
    check.arg(script("check-exports.py")).current_dir(folder.path());
    for (name, write) in writers {
        let mut bytes = Vec::new();
        write(&take, &mut bytes);
        std::fs::write(folder.path().join(name), bytes).unwrap();
        check.arg(name);
    }
    run(&mut check);
}

/// Set `THRONG_GLTF_VALIDATOR` to a folder in which `npm install gltf-validator` was run.
#[test]
fn khronos_validator_finds_no_error_and_no_warning() {
    let Some(place) = std::env::var_os("THRONG_GLTF_VALIDATOR") else {
        eprintln!("skipped: THRONG_GLTF_VALIDATOR names no folder with the package gltf-validator");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("take.glb");
    std::fs::write(&file, glb(&take().0)).unwrap();
    run(Command::new("node").arg(script("validate-gltf.mjs")).arg(&file).current_dir(place));
}
