//! The real window, under a virtual X server.

#![cfg(target_os = "linux")]

use crate::common::{adapter, golden};
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

/// A virtual X server, which ends with this.
struct Xvfb {
    server: Child,
    display: String,
}

impl Xvfb {
    /// On a free display, which the server chooses; none, with the reason printed, where there is no Xvfb.
    fn start() -> Option<Self> {
        let mut command = Command::new("Xvfb");
        command.args(["-displayfd", "1", "-screen", "0", "1280x800x24", "-nolisten", "tcp"]);
        let mut server = match command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn() {
            Ok(server) => server,
            Err(e) => {
                println!("skipped: Xvfb does not start ({e}); `apt-get install xvfb`");
                return None;
            }
        };
        let mut line = String::new();
        let stdout = server.stdout.take().expect("standard output is piped");
        BufReader::new(stdout).read_line(&mut line).expect("the server tells its display");
        let display = format!(":{}", line.trim());
        assert!(display.len() > 1, "Xvfb ended without a display");
        Some(Self { server, display })
    }
}

impl Drop for Xvfb {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

#[test]
fn the_window_opens_shows_frames_keeps_settings_and_closes() {
    if adapter().is_none() {
        return;
    }
    let Some(xvfb) = Xvfb::start() else { return };
    let home = tempfile::tempdir().expect("a folder");
    let run = |args: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_throng-viewer"))
            .args(args)
            .env("DISPLAY", &xvfb.display)
            .env_remove("WAYLAND_DISPLAY")
            .env("HOME", home.path())
            .env("XDG_DATA_HOME", home.path().join("data"))
            .env("XDG_RUNTIME_DIR", home.path())
            .output()
            .expect("the viewer starts")
    };
    let file = golden();
    let file = file.to_str().expect("a readable path");
    let shown = run(&[file, "--frames", "5", "--theme", "light", "--size", "800x500"]);
    let message = String::from_utf8_lossy(&shown.stderr).into_owned();
    if message.contains("could not be loaded") {
        println!("skipped: {message}");
        return;
    }
    assert_eq!(shown.status.code(), Some(0), "{message}");
    let kept = std::fs::read_to_string(home.path().join("data/throng-viewer/app.ron")).expect("settings are kept");
    assert!(kept.contains("Light") && kept.contains("golden/tables_v"), "{kept}");

    let absent = run(&["absent.throng", "--frames", "5"]);
    assert_eq!(absent.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&absent.stderr).contains("absent.throng"));
    let folder = tempfile::tempdir().expect("a folder");
    let broken = folder.path().join("broken.throng");
    std::fs::write(&broken, "no tables").expect("a file");
    let broken = run(&[broken.to_str().expect("a readable path"), "--frames", "5"]);
    assert_eq!(broken.status.code(), Some(1));
    let message = String::from_utf8_lossy(&broken.stderr).into_owned();
    assert!(message.contains("broken.throng") && message.contains("throng build"), "{message}");
}
