//! Running simulations of every kind of motion, into which damaged snapshots are put.

use super::{readers, repair};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Mutex, OnceLock};
use throng_core::characters::made_up;
use throng_core::format::AlignedBytes;
use throng_core::{Bundle, HitRecord, Inline, Joint};
use throng_lab::run::RunRecording;
use throng_simulation::{CompiledScene, Scene, Simulation};

/// Step of all simulations here (s).
pub(super) const DT: f64 = 1.0 / 30.0;
/// Simulated steps before a snapshot is taken.
const STEPS: usize = 40;

/// Groups of a scene, by the kind of motion; `FLOOR` and `BLEND` stand for files.
const SCENES: [(&str, &str); 6] = [
    (
        "policy",
        "[[groups]]\nmotion = \"policy\"\ncount = 5\nplace = { grid = { spacing_m = 4.0, distance_m = 0.9 } }\n\
         temperature = 0.3\nbehaviours = [{ name = \"approach\" }]\n\
         target = { height_m = 1.4, drag = [{ time_s = 0.7, x_m = 0.4 }] }\n",
    ),
    (
        "sparring",
        "[[groups]]\nmotion = \"sparring\"\ncount = 4\nplace = { grid = { spacing_m = 4.0, distance_m = 1.0 } }\n\
         temperature = 0.2\nbehaviours = [{ name = \"approach\", weight = 0.5 }]\n",
    ),
    (
        "patches",
        "[[groups]]\nmotion = \"patches\"\nbundle = \"FLOOR.throng\"\nworld = \"FLOOR.world\"\ncount = 4\ngoals = [\n\
         { share = 1.0, goal = { perform = { tag = \"sit\", seconds = [0.5, 1.5] } } },\n\
         { share = 1.0, goal = { roam = { seconds = [0.5, 2.0] } } },\n{ share = 1.0, goal = { visit = {} } },\n]\n",
    ),
    (
        "paths",
        "[[groups]]\nmotion = \"blend\"\nbundle = \"BLEND\"\ncount = 5\nspaces = [\"walks\"]\n\
         paths = { speeds = [0.0, 2.0], area_m = 20.0, seconds = [0.3, 1.0] }\n",
    ),
    (
        "agents",
        "[[groups]]\nmotion = \"blend\"\nbundle = \"BLEND\"\ncount = 5\nspaces = [\"walks\"]\n\
         place = { block = { from = [-9.0, -5.0], to = [-3.0, 5.0] } }\ngoal = { shift = { by = [2.5, 0.0] } }\n\
         at_end = \"leave\"\narrival_m = 1.0\n\n[[groups]]\nmotion = \"none\"\ncount = 9\n\
         place = { block = { from = [2.0, -6.0], to = [9.0, 6.0] } }\n\
         goal = { wander = { from = [-9.0, -6.0], to = [9.0, 6.0] } }\n\n[[environment.obstacles]]\n\
         wall = { points = [[0.0, -1.5], [0.0, 1.5]], radius_m = 0.2 }\n\n[[happenings]]\ntime_s = 1.0\n\
         near = { at = [4.0, 0.0], radius_m = 4.0 }\ngoal = { area = { from = [-9.0, -3.0], to = [-3.0, 3.0] } }\n\
         speed_mps = 2.0\npassed_on = true\n",
    ),
    (
        "air",
        "environment.space = \"air\"\nagents.routes = false\n\n[[groups]]\nmotion = \"none\"\ncount = 12\n\
         place = { block = { from = [-9.0, 0.0, -3.0], to = [-2.0, 5.0, 3.0] } }\n\
         goal = { shift = { by = [12.0, 0.0, 0.0] } }\n",
    ),
];

/// A running simulation and its snapshot.
pub(super) struct Running {
    sim: Simulation,
    good: Vec<u8>,
}

/// Boxers on made-up tables who strike ever further ahead of them.
pub(super) fn boxing() -> Bundle {
    Bundle::from_bytes(AlignedBytes::from_slice(&boxing_bytes())).expect("the made-up bundle opens")
}

/// The file of their bundle.
pub(super) fn boxing_bytes() -> Vec<u8> {
    let hit = |frame: u32, k: u32| HitRecord {
        frame,
        kind: 0,
        joint: Joint::LeftHand as u32,
        force: 1.0,
        position: [0.05 * (k as f32 - 2.0), 1.4, 0.3 + 0.15 * k as f32],
        speed_mps: 6.0,
        direction: [0.0, 0.0, 1.0],
        reserved: 0,
    };
    let hits: Vec<_> = [0, 20, 60, 80].iter().flat_map(|f| (0..5).map(move |k| hit(f + 1 + 2 * k, k))).collect();
    made_up::bytes(&hits, false)
}

/// The scene of a kind of motion.
fn compile(kind: &str) -> CompiledScene {
    let floor = readers::in_folder("floor", |_| ()).with_extension("");
    let _ = std::fs::write(floor.with_extension("throng"), throng_world::made_up_floor::bundle("made up"));
    let _ = std::fs::write(floor.with_extension("world"), &super::seeds::world()[0]);
    let blend: PathBuf = floor.with_file_name("blend.throng");
    let _ = std::fs::write(&blend, super::seeds::BLENDED);
    let groups = SCENES.iter().find(|s| s.0 == kind).map_or("", |s| s.1);
    let groups = groups.replace("FLOOR", &floor.to_string_lossy()).replace("BLEND", &blend.to_string_lossy());
    let scene = Scene::parse(&format!("bundle = \"own.throng\"\n{groups}"), std::path::Path::new("scene.toml"));
    scene.and_then(|s| s.compile(&boxing())).expect("a scene of this list")
}

/// The groups of the scenes, as seeds for the reader of scenes.
pub(super) fn texts() -> Vec<String> {
    SCENES.iter().map(|s| s.1.to_owned()).collect()
}

fn running(kind: &'static str) -> &'static Mutex<Running> {
    static ALL: OnceLock<Mutex<BTreeMap<&'static str, &'static Mutex<Running>>>> = OnceLock::new();
    let mut all = ALL.get_or_init(Mutex::default).lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    all.entry(kind).or_insert_with(|| {
        let mut sim = Simulation::new(&compile(kind)).expect("a scene of this list");
        (0..STEPS).for_each(|_| sim.step(DT).expect("a step"));
        let good = sim.snapshot();
        // As many as there are kinds of motion, for as long as the program runs.
        Box::leak(Box::new(Mutex::new(Running { sim, good })))
    })
}

/// A snapshot of a kind of motion.
pub(super) fn good(kind: &'static str) -> Vec<u8> {
    running(kind).lock().unwrap_or_else(std::sync::PoisonError::into_inner).good.clone()
}

/// A recording of a second of policy characters.
pub(super) fn recorded() -> Vec<u8> {
    let scene = compile("policy");
    let mut sim = Simulation::new(&scene).expect("a scene of this list");
    let mut recording = RunRecording::new(&scene, 1.0 / DT).expect("a scene of this list");
    for step in 1..=30 {
        sim.step_to(f64::from(step) * DT, &Inline).expect("a step");
        recording.observe(&sim, step == 30);
    }
    recording.bytes()
}

/// Runs the beginning of a recording again, as it is and with its checksum put right; true where it is one.
pub(super) fn replay(data: &[u8]) -> bool {
    static GOOD: OnceLock<(CompiledScene, Vec<u8>)> = OnceLock::new();
    let (scene, good) = GOOD.get_or_init(|| (compile("policy"), recorded()));
    [data.to_vec(), repair::snapshot(data, good)].iter().any(|bytes| {
        let Ok(recording) = RunRecording::parse(bytes) else { return false };
        let _ = recording.scene();
        let _ = recording.replay(scene, Some(recording.seconds.min(0.1)));
        true
    })
}

/// Restores bytes as they are, and with the checksums put right; true where they are accepted then.
pub(super) fn restore(kind: &'static str, data: &[u8]) -> bool {
    let (mut sim, good) = {
        let running = running(kind).lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        (running.sim.clone(), running.good.clone())
    };
    let before = sim.hash();
    for bytes in [data.to_vec(), repair::snapshot(data, &good)] {
        match sim.restore(&bytes) {
            Err(_) => assert!(sim.hash() == before, "nothing changes where a snapshot is refused"),
            Ok(()) => {
                // It may be impossible to go on, such as from a place that cannot be left; that is told.
                let went_on = (0..20).try_for_each(|_| sim.step(DT)).is_ok();
                if went_on {
                    readers::assert_finite(&sim);
                }
                let kept = sim.snapshot();
                let _ = sim.restore(&kept);
                return true;
            }
        }
    }
    false
}
