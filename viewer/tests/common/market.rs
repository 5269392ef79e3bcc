//! A small scene of people with graphs of three levels, messages that pass from one to another, and billboards.

use std::path::PathBuf;

/// A folder with the scene.
pub struct Market {
    folder: tempfile::TempDir,
}

impl Market {
    /// An empty folder.
    pub fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a folder") }
    }

    /// The scene, with so many people.
    pub fn scene(&self, count: usize) -> PathBuf {
        let path = self.folder.path().join("market.toml");
        std::fs::write(&path, text(count)).expect("a scene");
        path
    }
}

/// What the scene says.
pub fn text(count: usize) -> String {
    format!(
        r#"seed = 3
[agents]
meeting_m = 1.6
cell_m = 2.0

[[groups]]
name = "people"
motion = "none"
count = {count}
place = {{ block = {{ from = [-7.0, -5.0], to = [7.0, 5.0] }} }}
graph = "day"

[[environment.obstacles]]
wall = {{ points = [[-9.0, -6.0], [9.0, -6.0]] }}
[[environment.doors]]
name = "gate"
from = [-9.0, 6.0]
to = [-5.0, 6.0]
[[environment.doors]]
name = "back gate"
from = [5.0, 6.0]
to = [9.0, 6.0]

[[events]]
name = "opening"
at_s = 0.5
opens = ["gate"]
posted = true
fresh_s = 30.0
who = "me.number == 1"

[[events]]
name = "sale"
at_s = 1.0
who = "me.number < 2"
passed_on = true

[[places]]
name = "stall"
kind = "store"
at = [7.0, 0.0]
radius_m = 3.0
slots = [{{ at = [6.0, -1.0], facing = [8.0, -1.0] }}, {{ at = [6.0, 1.0], facing = [8.0, 1.0] }}]

[[rules]]
name = "write it down"
on = "sale"
do = [{{ post = "sale", cells = 0, for_s = 8 }}, {{ post = "sale", cells = 1, for_s = 20 }}]

[graphs.day]
level = "social"
start = "stroll"
edges = [
    {{ from = "stroll", to = "shop", on = "sale", when = "me.number != 3", probability = 0.8 }},
    {{ from = "shop", to = "stroll" }},
    {{ from = "shop", to = "stroll", on = "full" }},
]
[graphs.day.states]
stroll = {{ graph = "about" }}
shop = {{ do = [{{ buy = "stall", for_s = 1.5 }}, {{ release = true }}] }}

[graphs.about]
level = "spatial"
start = "here and there"
edges = [
    {{ from = "here and there", to = "rest" }},
    {{ from = "rest", to = "rest", on = "opening" }},
    {{ from = "rest", to = "here and there" }},
    {{ to = "rest", on = "enters", when = "place.name == 'stall' and place.free == 0" }},
]
[graphs.about.states]
"here and there" = {{ graph = "steps" }}
rest = {{ do = [{{ stay = 1.0 }}] }}

[graphs.steps]
level = "primitive"
start = "go"
edges = [
    {{ from = "go", to = "look round", probability = 0.7 }},
    {{ from = "go", to = "turn back", probability = 0.3 }},
    {{ from = "turn back", to = "look round" }},
    {{ from = "look round", to = "go", probability = 0.6 }},
]
[graphs.steps.states]
go = {{ do = [{{ roam = "me", within_m = 2.5 }}] }}
"turn back" = {{ do = [{{ go = "home", within_m = 1.0 }}] }}
"look round" = {{ do = [{{ stay = 0.4 }}] }}
"#
    )
}
