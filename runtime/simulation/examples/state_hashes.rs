//! Hashes of the states that small scenes of every kind of motion end in: the same on every machine.
//!
//! `cargo run -p throng-simulation --example state_hashes [SCENE|all] [STEPS] [FOLDER]`; `scripts/equal-results.sh` compares
//! them. Bundles are read from FOLDER, and left there where they are not there.

#[path = "../tests/snapshot/scenes.rs"]
mod scenes;

use throng_simulation::Simulation;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let wanted = args.next().unwrap_or("all".into());
    let steps: usize = args.next().map_or(Ok(300), |s| s.parse())?;
    if let Some(folder) = args.next() {
        scenes::MADE.get_or_init(|| folder.into());
    }
    for (name, scene) in scenes::all() {
        if wanted == "all" || wanted == name {
            let mut sim = Simulation::new(&scene)?;
            (0..steps).try_for_each(|_| sim.step(1.0 / 30.0))?;
            println!("{name} {steps} steps {:016x}", sim.hash());
        }
    }
    Ok(())
}
