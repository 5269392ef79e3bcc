//! Saving and restoring a whole simulation: time, all characters, their bodies, and the events that they know of. Later
//! steps are the same, bit by bit.
//!
//! ```sh
//! cargo run --release -- build data/locomotion.toml
//! cargo run --release --example snapshot -- locomotion.throng ahead-neutral
//! ```

use std::path::Path;
use throng_runtime::Bundle;
use throng_runtime::simulation::{Scene, Simulation};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let mut next = |default: &str| args.next().unwrap_or_else(|| default.into());
    run(next("locomotion.throng").as_ref(), &next("ahead-neutral"))
}

/// People cross a square. After half a second a happening sends them back.
const SCENE: &str = r#"
bundle = "locomotion.throng"

[[groups]]
motion = "blend"
count = 12
spaces = ["SPACE"]
place = { block = { from = [-8.0, -4.0], to = [-4.0, 4.0] } }
goal = { shift = { by = [12.0, 0.0] } }

[[happenings]]
time_s = 0.5
goal = { area = { from = [-8.0, -4.0], to = [-4.0, 4.0] } }
"#;

/// Saves a scene, lets it go on, goes back, and lets it go on again.
pub fn run(bundle: &Path, space: &str) -> Result<(), Box<dyn std::error::Error>> {
    let scene = Scene::parse(&SCENE.replace("SPACE", space), "square.toml".as_ref())?;
    let scene = scene.compile(&Bundle::open(bundle)?)?;
    let mut people = Simulation::new(&scene)?;
    step_one_second(&mut people)?;

    let mut bytes = people.snapshot();
    step_one_second(&mut people)?;
    let later = people.hash();

    // Into a new simulation of the same scene, such as after a restart, or into the one that runs.
    let mut others = Simulation::new(&scene)?;
    for simulation in [&mut others, &mut people] {
        simulation.restore(&bytes)?;
        step_one_second(simulation)?;
        assert_eq!(simulation.hash(), later, "the same second repeats");
    }

    // Damaged bytes, and those of another scene or bundle, are refused, and nothing changes.
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    println!("{} bytes; damaged ones: {}", bytes.len(), people.restore(&bytes).expect_err("a checksum"));
    assert_eq!(people.hash(), later);
    Ok(())
}

/// Simulates one second.
fn step_one_second(people: &mut Simulation) -> throng_runtime::Result<()> {
    (0..60).try_for_each(|_| people.step(1.0 / 60.0))
}
