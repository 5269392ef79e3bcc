//! What is no regular file, or far too long, is refused at once, by every command that takes files.

use super::{BundleFolder, CONFIG, at, folder, text, throng_soon};
use std::process::Command;

/// Every argument that names a file to read: the command, with `{}` in place of a name without extension.
const READS: [&[&str]; 25] = [
    &["build", "{}.toml"],
    &["build", "CONFIG", "--input", "{}.bvh", "--strict"],
    &["build", "CONFIG", "--input", "{}.amc", "--strict"],
    &["inspect", "{}.throng"],
    &["inspect", "{}.bvh"],
    &["inspect", "CLIP", "{}.bvh", "--environment-out", "OUT"],
    &["inspect", "{}.amc", "--asf", "{}.asf"],
    &["verify", "{}.throng"],
    &["query", "action", "{}.throng", "--state", "0", "--target", "1,1"],
    &["query", "path", "{}.toml", "--from", "0,0", "--to", "1,1"],
    &["stitch", "{}.toml"],
    &["stitch", "WORLD", "--bundle", "{}.throng"],
    &["stitch", "WORLD"],
    &["run", "{}.toml"],
    &["run", "{}.throng"],
    &["run", "SCENE"],
    &["run", "SCENE", "--bundle", "{}.throng"],
    &["bench", "bundle", "{}.throng"],
    &["bench", "crowd", "--scene", "{}.toml"],
    &["export", "{}.throng", "--format", "graph-json"],
    &["export", "{}.throng", "--format", "policy-csv"],
    &["export", "{}.throng", "--format", "hits-csv"],
    &["export", "{}.bvh", "--format", "positions-csv"],
    &["export", "{}.bvh", "--format", "hits-csv"],
    &["export", "{}.amc", "--asf", "{}.asf", "--format", "bvh"],
];

/// Runs every command of [`READS`] in a folder with files `name.*`, and gives their messages to `check`.
fn each_refused(folder: &tempfile::TempDir, name: &str, reads: &[&[&str]], check: impl Fn(&[&str], &str)) {
    let place = BundleFolder::shared();
    std::fs::write(folder.path().join("config.toml"), CONFIG).expect("a config");
    let unit = "[[place]]\nunit = \"ground\"\nat = [0, 0, 0]\n";
    std::fs::write(folder.path().join("world.toml"), format!("bundle = \"{name}.throng\"\n{unit}")).expect("a world");
    let group = "[[groups]]\nmotion = \"policy\"\ncount = 1\nbehaviours = [{ name = \"approach\" }]\n";
    std::fs::write(folder.path().join("scene.toml"), format!("bundle = \"{name}.throng\"\n{group}")).expect("a scene");
    for args in reads {
        let args: Vec<String> = args
            .iter()
            .map(|&a| match a {
                "CONFIG" => at(folder, "config.toml"),
                "WORLD" => at(folder, "world.toml"),
                "SCENE" => at(folder, "scene.toml"),
                "OUT" => at(folder, "out.toml"),
                "CLIP" => place.first_clip(),
                a if a.starts_with("{}") => at(folder, &a.replace("{}", name)),
                a => a.to_owned(),
            })
            .collect();
        let args: Vec<&str> = args.iter().map(String::as_str).collect();
        let out = throng_soon(&args);
        let message = text(&out.stderr);
        assert_eq!(out.status.code(), Some(1), "{args:?}: {message}");
        check(&args, &message);
    }
}

#[cfg(unix)]
#[test]
fn a_pipe_in_place_of_a_file_is_refused_by_every_command() {
    let folder = folder();
    for extension in ["throng", "toml", "bvh", "amc", "asf"] {
        let path = at(&folder, &format!("pipe.{extension}"));
        if !Command::new("mkfifo").arg(path).status().is_ok_and(|s| s.success()) {
            eprintln!("skipped: there is no mkfifo");
            return;
        }
    }
    each_refused(&folder, "pipe", &READS, |args, message| {
        assert!(message.contains("pipe.") && message.contains("is a device or a pipe"), "{args:?}: {message}");
    });
}

#[test]
fn a_folder_in_place_of_a_file_is_refused_by_every_command() {
    let folder = folder();
    for extension in ["throng", "toml", "asf"] {
        std::fs::create_dir(folder.path().join(format!("folder.{extension}"))).expect("a folder");
    }
    let is_left_out = |a: &&str| a.ends_with(".bvh") || a.ends_with(".amc");
    let reads: Vec<&[&str]> = READS.into_iter().filter(|r| !r.iter().any(&is_left_out)).collect();
    each_refused(&folder, "folder", &reads, |args, message| {
        assert!(message.contains("folder.") && message.contains("is a folder"), "{args:?}: {message}");
    });
}

#[test]
fn a_text_of_a_gigabyte_is_refused_by_its_length() {
    let folder = folder();
    let file = std::fs::File::create(folder.path().join("zeros.toml")).expect("a file");
    if file.set_len(1 << 30).is_err() {
        eprintln!("skipped: there is no room for a file of 1 GiB, sparse or not");
        return;
    }
    let reads: Vec<&[&str]> = READS.into_iter().filter(|r| r.contains(&"{}.toml")).collect();
    assert_eq!(reads.len(), 5);
    each_refused(&folder, "zeros", &reads, |args, message| {
        assert!(message.contains("zeros.toml") && message.contains("17 MB at most"), "{args:?}: {message}");
    });
}
