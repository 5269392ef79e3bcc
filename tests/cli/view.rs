//! `throng view` hands everything on to the viewer, or says how to build it.

use super::{folder, text};
use std::path::PathBuf;
use std::process::Command;

/// A copy of the command line in a folder of its own.
fn lonely_throng(folder: &tempfile::TempDir) -> PathBuf {
    let alone = folder.path().join(format!("throng{}", std::env::consts::EXE_SUFFIX));
    // A file that is being copied cannot be started by another thread; a link can.
    let built = env!("CARGO_BIN_EXE_throng");
    std::fs::hard_link(built, &alone).or_else(|_| std::fs::copy(built, &alone).map(|_| ())).expect("a copy");
    alone
}

#[test]
fn the_viewer_is_asked_for_where_it_is_not_built() {
    let folder = folder();
    let alone = lonely_throng(&folder);
    let out = Command::new(&alone).args(["view", "a.throng", "--png", "a.png"]).output().expect("the copy starts");
    assert_eq!(out.status.code(), Some(1));
    // The one of the profile that is run: a release viewer lies elsewhere than this executable.
    let profile = if cfg!(debug_assertions) { "" } else { " --release" };
    let command = format!("`cargo build{profile} -p throng-viewer`");
    assert!(text(&out.stderr).contains(&command));
    let help = Command::new(&alone).args(["view", "--help"]).output().expect("the copy starts");
    assert_eq!(help.status.code(), Some(0));
    assert!(text(&help.stdout).contains(&command));
    let keys = Command::new(&alone).args(["help", "keys", "view"]).output().expect("the copy starts");
    assert_eq!(keys.status.code(), Some(1));
    assert!(text(&keys.stderr).contains(&command));
}

#[cfg(unix)]
#[test]
fn the_viewer_gets_all_arguments_and_gives_its_exit_code() {
    let folder = folder();
    let alone = lonely_throng(&folder);
    std::os::unix::fs::symlink("/bin/sh", folder.path().join("throng-viewer")).expect("a shell in its place");
    let view = |script: &str| {
        let args = ["view", "-c", script, "a b.throng", "--png", "x.png", "--help", "-5", "--", "c"];
        Command::new(&alone).args(args).output().expect("the copy starts")
    };
    for code in [0, 1, 2] {
        let out = view(&format!("echo \"$0|$*\"; echo said >&2; exit {code}"));
        assert_eq!(out.status.code(), Some(code));
        assert!(text(&out.stdout).starts_with("a b.throng|--png x.png --help -5 "), "{}", text(&out.stdout));
        assert_eq!(text(&out.stderr), "said\n");
    }
    let killed = view("kill -9 $$");
    assert_eq!(killed.status.code(), Some(1));
    assert!(text(&killed.stderr).contains("ended unexpectedly"));
}
