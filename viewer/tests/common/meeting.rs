//! A small scene of a crowd: two groups that meet between two walls, a pillar, and something that moves.

use std::path::{Path, PathBuf};

/// A folder with a scene.
pub struct Meeting {
    folder: tempfile::TempDir,
}

impl Meeting {
    /// An empty folder.
    pub fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a folder") }
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// A scene on the ground with two groups of so many.
    pub fn scene(&self, each: usize) -> PathBuf {
        let text = format!(
            r#"
[[groups]]
motion = "none"
name = "to the right"
count = {each}
place = {{ block = {{ from = [-9.0, -3.0], to = [-2.0, 3.0] }} }}
goal = {{ shift = {{ by = [11.0, 0.0] }} }}
radius_m = [0.25, 0.35]

[[groups]]
motion = "none"
name = "to the left"
count = {each}
place = {{ block = {{ from = [2.0, -3.0], to = [9.0, 3.0] }} }}
goal = {{ shift = {{ by = [-11.0, 0.0] }} }}
at_end = "leave"

[[environment.obstacles]]
wall = {{ points = [[-11.0, -4.0], [11.0, -4.0]] }}

[[environment.obstacles]]
wall = {{ points = [[-11.0, 4.0], [11.0, 4.0]], radius_m = 0.1 }}

[[environment.obstacles]]
disc = {{ centre = [0.0, 1.0], radius_m = 0.5 }}

[[environment.obstacles]]
polygon = {{ corners = [[-0.6, -2.6], [0.6, -2.6], [0.0, -1.8]] }}

[[environment.obstacles]]
mover = {{ radius_m = 0.4, path = [{{ time_s = 0.0, at = [0.0, 9.0] }}, {{ time_s = 9.0, at = [9.0, 6.0] }}] }}
"#
        );
        self.write("meeting.toml", &text)
    }

    /// A scene in the air with two groups of so many.
    pub fn flock(&self, each: usize) -> PathBuf {
        let text = format!(
            r#"
[environment]
space = "air"

[[groups]]
motion = "none"
count = {each}
place = {{ block = {{ from = [-14.0, 2.0, -4.0], to = [-6.0, 8.0, 4.0] }} }}
goal = {{ shift = {{ by = [20.0, 0.0, 0.0] }} }}
radius_m = [0.4, 0.5]
speed_mps = [4.0, 4.0]
acceleration_mps2 = [10.0, 10.0]

[[groups]]
motion = "none"
count = {each}
place = {{ block = {{ from = [6.0, 2.0, -4.0], to = [14.0, 8.0, 4.0] }} }}
goal = {{ shift = {{ by = [-20.0, 0.0, 0.0] }} }}
radius_m = [0.4, 0.5]
speed_mps = [4.0, 4.0]
acceleration_mps2 = [10.0, 10.0]

[[environment.obstacles]]
box = {{ from = [-16.0, 0.0, -6.0], to = [16.0, 0.5, 6.0] }}

[[environment.obstacles]]
wall = {{ points = [[0.0, 0.0, 1.5], [0.0, 10.0, 1.5]], radius_m = 0.6 }}
"#
        );
        self.write("flock.toml", &text)
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.folder.path().join(name);
        std::fs::write(&path, text).expect("a scene");
        path
    }
}
