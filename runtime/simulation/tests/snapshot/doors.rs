//! Captured people and doors: they wait before shut ones, go through open ones, and are never in one that shuts.

use super::{DT, differ, new, scenes, watch};
use throng_core::Inline;
use throng_simulation::Simulation;

/// Captured people in a yard whose only gate opens, and closes again.
const GATE: &str = r#"
[[groups]]
motion = "policy"
bundle = "GOLDEN"
count = 6
place = { block = { from = [-3.0, 62.0], to = [3.0, 66.0] } }
goal = { shift = { by = [0.0, -9.0] } }
behaviours = [{ name = "approach" }]

[[environment.obstacles]]
wall = { points = [[-1.0, 60.0], [-6.0, 60.0], [-6.0, 70.0], [6.0, 70.0], [6.0, 60.0], [1.0, 60.0]], radius_m = 0.1 }
[[environment.doors]]
name = "gate"
from = [-1.0, 60.0]
to = [1.0, 60.0]

[[events]]
name = "morning"
at_s = 0.8
opens = ["gate"]
[[events]]
name = "evening"
at_s = 2.2
closes = ["gate"]
"#;

/// Time after which each person is through the gate, until a time, and whether somebody was in the gate while it was shut (s).
///
/// - `shut`: true for times at which the gate is to be shut.
fn passages(sim: &mut Simulation, until_s: f64, shut: impl Fn(f64) -> bool) -> (Vec<Option<f64>>, bool) {
    let (mut through, mut was_in_it) = (vec![None; sim.num_characters()], false);
    while sim.time_s() < until_s {
        sim.step(DT).expect("it goes on");
        for (who, root) in sim.roots().enumerate() {
            let Some(root) = root else { continue };
            if root.z < 59.5 {
                through[who].get_or_insert(sim.time_s());
            }
            was_in_it |= shut(sim.time_s()) && root.x.abs() < 1.0 && (root.z - 60.0).abs() < 0.2;
        }
    }
    (through, was_in_it)
}

#[test]
fn captured_people_go_through_gates_once_they_open() {
    let agents = "[[groups]]\nmotion = \"none\"\ncount = 2\nplace = { block = { from = [-3.0, 66.5], to = [3.0, 68.0] } }\n\
        goal = { shift = { by = [0.0, -13.0] } }\n";
    for more in ["", agents] {
        let text = GATE.replace("at_s = 0.8", "at_s = 12.0").replace("at_s = 2.2", "at_s = 900.0") + more;
        let mut sim = new(&scenes::compile(&text, &scenes::boxing(0.0)));
        let (through, was_in_it) = passages(&mut sim, 90.0, |time_s| time_s < 12.0);
        assert!(!was_in_it && through.iter().flatten().all(|s| *s > 12.0), "shut until 12 s: {through:?}");
        let num_through = through.iter().flatten().count();
        let left = sim.roots().zip(&through).filter(|(_, through)| through.is_none()).map(|(root, _)| root);
        assert!(num_through >= 5, "{through:?}, left behind: {:?}", left.collect::<Vec<_>>());
    }
}

#[test]
fn a_snapshot_brings_doors_back_as_they_were() {
    let scene = scenes::compile(GATE, &scenes::boxing(0.0));
    let mut sim = new(&scene);
    // Before the gate opens, while it is open, and once it is shut again.
    let kept: Vec<_> = (0..4).map(|_| (sim.snapshot(), watch(&mut sim, 30, &Inline))).collect();
    for (second, (bytes, seen)) in kept.iter().enumerate() {
        for mut other in [new(&scene), sim.clone()] {
            other.restore(bytes).expect("it was saved");
            assert_eq!(differ(&watch(&mut other, 30, &Inline), seen), None, "from {second} s on");
        }
    }
}

#[test]
fn captured_people_stay_on_their_side_of_a_gate_that_has_shut() {
    let open = GATE.replace("name = \"gate\"", "name = \"gate\"\nopen = true");
    let text = open.replace("at_s = 0.8", "at_s = 900.0").replace("at_s = 2.2", "at_s = 1.0");
    let mut sim = new(&scenes::compile(&text, &scenes::boxing(0.0)));
    let (through, was_in_it) = passages(&mut sim, 30.0, |time_s| time_s > 4.0);
    // Who is before it as it is to shut still goes through.
    assert!(!was_in_it && through.iter().flatten().all(|s| *s < 6.0), "{through:?}");
    assert!(through.iter().filter(|s| s.is_none()).count() >= 4, "{through:?}");
}
