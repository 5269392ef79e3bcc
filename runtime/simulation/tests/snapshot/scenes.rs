//! Small scenes of every kind of motion, on bundles that take no time to make.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use throng_core::characters::made_up;
use throng_core::format::AlignedBytes;
use throng_core::{Bundle, HitRecord, Joint};
use throng_simulation::{CompiledScene, Scene};
use throng_world::{PathCosts, WorldGraph, made_up_floor as made_up_world};

/// Where bundles are read from, and left where they are not there: those of one machine serve others, as baking rounds
/// otherwise elsewhere. None where everybody makes their own.
pub static MADE: OnceLock<PathBuf> = OnceLock::new();

fn made(name: &str, make: impl FnOnce() -> Vec<u8>) -> Vec<u8> {
    let Some(folder) = MADE.get() else { return make() };
    let path = folder.join(name);
    std::fs::read(&path).unwrap_or_else(|_| {
        let bytes = make();
        std::fs::write(&path, &bytes).expect("a file");
        bytes
    })
}

/// Boxers who strike in the first half of every segment, ever further ahead of them; `further` tells bundles apart (m).
pub fn boxing(further: f32) -> Bundle {
    let hit = |frame: u32, k: u32| HitRecord {
        frame,
        kind: 0,
        joint: Joint::LeftHand as u32,
        force: 1.0,
        position: [0.05 * (k as f32 - 2.0), 1.4, 0.3 + further + 0.15 * k as f32],
        speed_mps: 6.0,
        direction: [0.0, 0.0, 1.0],
        reserved: 0,
    };
    let starts = [0, 20, 60, 80];
    let hits: Vec<_> = starts.iter().flat_map(|f| (0..5).map(move |k| hit(f + 1 + 2 * k, k))).collect();
    let bytes = made(&format!("boxing-{further}.throng"), || made_up::bytes(&hits, false));
    Bundle::from_bytes(AlignedBytes::from_slice(&bytes)).expect("a sound bundle")
}

/// A bundle of motion patches and worlds of them, in a folder that is there while the tests run.
fn folder() -> &'static Path {
    static FOLDER: OnceLock<tempfile::TempDir> = OnceLock::new();
    let made = FOLDER.get_or_init(|| {
        // WASI has no folder of its own for these.
        let at = if cfg!(target_family = "wasm") { PathBuf::from("/tmp") } else { std::env::temp_dir() };
        let folder = tempfile::tempdir_in(at).expect("a temporary folder");
        let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).expect("a file");
        let tables = made_up_world::tables();
        write("floor.throng", &made("floor.throng", || made_up_world::bundle("made up")));
        for (name, rows) in [
            ("floor.world", ["#####", "#b##b", "###b#", "#####"]),
            ("other.world", ["#####", "#b#b##", "#####", "####"]),
        ] {
            let stitched = made(name, || {
                let world = made_up_world::world(&tables, &rows);
                let graph = WorldGraph::new(tables.patches(), &world.tables()).expect("a graph");
                let mut bytes = Vec::new();
                world.write(&PathCosts::bake(&graph).expect("path costs"), &mut bytes).expect("a world");
                bytes
            });
            write(name, &stitched);
        }
        folder
    });
    made.path()
}

/// The golden tables of the current version, which have a blend space.
fn golden() -> PathBuf {
    let name = format!("../../data/golden/tables_v{}.throng", throng_core::format::VERSION);
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(name)
}

pub const POLICY: &str = r#"
[[groups]]
motion = "policy"
count = 11
place = { grid = { centre = [60.0, 0.0], spacing_m = 4.0, distance_m = 0.9 } }
temperature = 0.3
behaviours = [{ name = "approach" }]
target = { height_m = 1.4, drag = [{ time_s = 0.7, x_m = 0.4 }, { time_s = 1.9, z_m = 0.3 }] }
"#;

pub const SPARRING: &str = r#"
[[groups]]
motion = "sparring"
count = 18
place = { grid = { centre = [-60.0, 0.0], spacing_m = 4.0, distance_m = 1.0 } }
temperature = 0.2
behaviours = [{ name = "approach", weight = 0.5 }]
"#;

pub const PATHS: &str = r#"
[[groups]]
motion = "blend"
bundle = "GOLDEN"
count = 19
spaces = ["walks", "walks"]
paths = { speeds = [0.0, 2.0], area_m = 20.0, seconds = [0.3, 1.0], centre = [0.0, 60.0] }
"#;

pub const PATCHES: &str = r#"
[[groups]]
motion = "patches"
bundle = "FOLDER/floor.throng"
world = "FOLDER/floor.world"
count = 5
goals = [
    { share = 1.0, goal = { perform = { tag = "sit", seconds = [0.5, 1.5] } } },
    { share = 1.0, goal = { roam = { seconds = [0.5, 2.0] } } },
    { share = 1.0, goal = { visit = {} } },
    { share = 0.3, goal = { perform = { tag = "give", seconds = [0.5, 3.0], with = "partner" } } },
]
"#;

/// Agents with bodies and without, who hear of something after a second, and tell it on.
pub const AGENTS: &str = r#"
[[groups]]
motion = "blend"
bundle = "GOLDEN"
count = 9
spaces = ["walks", "walks"]
place = { block = { from = [-9.0, -45.0], to = [-3.0, -35.0] } }
goal = { shift = { by = [2.5, 0.0] } }
at_end = "leave"
arrival_m = 1.0

[[groups]]
motion = "none"
count = 14
place = { block = { from = [2.0, -46.0], to = [9.0, -34.0] } }
goal = { wander = { from = [-9.0, -46.0], to = [9.0, -34.0] } }

[[environment.obstacles]]
wall = { points = [[0.0, -41.5], [0.0, -38.5]], radius_m = 0.2 }

[[environment.obstacles]]
mover = { radius_m = 0.4, path = [{ time_s = 0.0, at = [-15.0, -39.7] }, { time_s = 12.0, at = [12.0, -39.7] }] }

[[happenings]]
time_s = 1.0
near = { at = [4.0, -40.0], radius_m = 4.0 }
goal = { area = { from = [-9.0, -43.0], to = [-3.0, -37.0] } }
speed_mps = 2.0
passed_on = true

[[happenings]]
time_s = 2.5
goal = { area = { from = [3.0, -43.0], to = [9.0, -37.0] } }
"#;

/// Captured people who go to and fro, past each other.
pub const TRAVELLERS: &str = r#"
[[groups]]
motion = "policy"
count = 6
place = { block = { from = [-9.0, 60.0], to = [-4.0, 65.0] } }
goal = { shift = { by = [12.0, 0.0] } }
at_end = "again"
behaviours = [{ name = "approach" }]

[[groups]]
motion = "policy"
count = 6
place = { block = { from = [4.0, 60.5], to = [9.0, 65.5] } }
goal = { shift = { by = [-12.0, 0.0] } }
at_end = "again"
behaviours = [{ name = "approach" }]
"#;

pub const AIR: &str = r#"
environment.space = "air"
agents.routes = false

[[groups]]
motion = "none"
count = 16
place = { block = { from = [-9.0, 0.0, -3.0], to = [-2.0, 5.0, 3.0] } }
goal = { shift = { by = [12.0, 0.0, 0.0] } }

[[groups]]
motion = "none"
count = 16
place = { block = { from = [2.0, 0.0, -3.0], to = [9.0, 5.0, 3.0] } }
goal = { shift = { by = [-12.0, 0.0, 0.0] } }

[[happenings]]
time_s = 1.0
goal = { point = { at = [0.0, 9.0, 0.0] } }
"#;

/// People who queue, buy, greet, fear and are told, take things and put them down, through a door that opens, while others
/// enter.
pub const STORY: &str = r#"
agents.cell_m = 3.0

[[groups]]
name = "guests"
motion = "blend"
bundle = "GOLDEN"
count = 12
spaces = ["walks", "walks"]
place = { block = { from = [-9.0, 12.0], to = [-4.0, 18.0] } }
graph = "life"
source = { start = 8, rates = [[0.0, 3.0]], place = { block = { from = [-9.0, 19.0], to = [-4.0, 22.0] } } }

[[groups]]
name = "walkers"
motion = "none"
count = 10
place = { block = { from = [-2.0, 12.0], to = [4.0, 18.0] } }
goal = { wander = { from = [-3.0, 12.0], to = [5.0, 18.0] } }

[values.hunger]
start = [0.3, 0.6]
rate_per_s = 0.15

[values.mood]
start = [0.2, 0.9]
rest = 0.5
half_life_s = 2.0

[[relations]]
of = "guests"
to = "walkers"
share = 0.5
friendship = 0.8

[[environment.obstacles]]
wall = { points = [[-3.0, 11.0], [-3.0, 14.0]], radius_m = 0.1 }
[[environment.obstacles]]
wall = { points = [[-3.0, 16.0], [-3.0, 23.0]], radius_m = 0.1 }

[[environment.doors]]
name = "door"
from = [-3.0, 14.2]
to = [-3.0, 15.8]
radius_m = 0.1

[[places]]
name = "line"
at = [-4.5, 14.0]
queue = { points = [[-4.5, 14.0], [-9.0, 14.0]], spacing_m = 0.9 }
[[places]]
name = "till"
kind = "shop"
at = [-4.5, 12.5]
guidepost = true
slots = [{ at = [-4.5, 12.7], facing = [-4.5, 11.0] }]

[[things]]
name = "ball"
at = [0.0, 1.0, 15.0]
[[things]]
name = "cup"
at = [-6.0, 1.1, 16.0]
carried = "hanging"

[[events]]
name = "bell"
at_s = 0.8
who = "me.group == 'guests' and random < 0.5"
passed_on = true
opens = ["door"]
[[events]]
name = "night"
at_s = 2.4
closes = ["door"]
[[events]]
name = "scare"

[[rules]]
name = "greet"
on = "meets"
when = "friendship(me, other) > 0.3 and not other.busy"
pause_s = 3.0
do = [{ greet = "other", for_s = "0.5 + random" }, { add = "mood", by = 0.2 }]
[[rules]]
name = "fetch"
on = "bell"
when = "not taken('ball')"
who = ["walkers"]
do = [{ take = "ball", for_s = 1.0 }, { put = "ball", on = [2.0, 0.9, 15.0], for_s = 1.0 }]
[[rules]]
name = "drink"
on = "bell"
when = "not taken('cup')"
who = ["guests"]
do = [{ take = "cup", for_s = 2.0 }, { roam = "home", within_m = 1.0 }, { put = "cup", for_s = 1.0 }]
[[rules]]
name = "cry"
on = "mood > 0.8"
who = ["walkers"]
do = [{ convey = "scare", within_m = 4.0 }, { post = "scare", cells = 1, for_s = 3.0 }]
[[rules]]
name = "jump"
on = "scare"
when = "event.how == 'felt'"
priority = 1
do = [{ flee = "other", distance_m = 2.0, speed = 1.6 }]

[graphs.life]
level = "social"
start = "stroll"
edges = [
    { from = "stroll", to = "shop", on = "hunger > 0.7" },
    { from = "stroll", to = "out", on = "bell", probability = 0.4 },
    { from = "shop", to = "stroll" },
    { from = "shop", to = "stroll", on = "full" },
    { from = "out", to = "stroll", on = "night" },
    { from = "stroll", to = "stroll" },
]
[graphs.life.states]
stroll = { do = [{ roam = "home", within_m = 2.0 }, { stay = "random" }] }
shop = { do = [{ queue = "line", into = "till" }, { buy = "till", for_s = 0.7 }, { set = "hunger", to = 0.0 }, { release = true }] }
out = { do = [{ go = [0.0, 15.0] }, { leave = [3.0, 15.0] }] }
"#;

/// Groups of a scene, on a bundle of boxing.
pub fn compile(groups: &str, bundle: &Bundle) -> CompiledScene {
    let text = groups.replace("FOLDER", &folder().to_string_lossy()).replace("GOLDEN", &golden().to_string_lossy());
    let scene = Scene::parse(&format!("bundle = \"own.throng\"\n{text}"), Path::new("scene.toml"));
    scene.and_then(|s| s.compile(bundle)).unwrap_or_else(|e| panic!("{e}"))
}

/// A scene of each kind of motion, and one in which all of them meet.
pub fn all() -> Vec<(&'static str, CompiledScene)> {
    let boxing = boxing(0.0);
    let mixed = [POLICY, SPARRING, PATHS, PATCHES, AGENTS].concat();
    let hilly = format!("environment.hills_m = 1.5\n{PATHS}");
    let texts = [
        ("policy", POLICY),
        ("sparring", SPARRING),
        ("paths", &hilly),
        ("patches", PATCHES),
        ("agents", AGENTS),
        ("air", AIR),
        ("story", STORY),
        ("mixed", &mixed),
        ("travellers", TRAVELLERS),
    ];
    texts.map(|(name, text)| (name, compile(text, &boxing))).into()
}
