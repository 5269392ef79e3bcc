//! What does a simulated second of a crowd cost, by events and by fixed steps, as it grows? `cargo bench --bench
//! crowd`.

use throng_precompute::run::{Figures, own_scene, run_agents};
use throng_runtime::crowd::Scheme;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // `cargo test` runs benches too: a small crowd is enough there.
    let whole = std::env::args().any(|a| a == "--bench");
    let seconds = Some(if whole { 15.0 } else { 0.5 });
    println!("{}", Figures::HEADINGS);
    // Figure 6 of Kim, Kim and Shin 2003a: more birds in the same corridor.
    let birds: &[usize] = if whole { &[100, 250, 500, 750, 1000] } else { &[20] };
    sweep("flock", birds, &[Scheme::Registration, Scheme::Occupancy, Scheme::Fixed], seconds)?;
    // At equal density, the cost of an agent should stay.
    let agents: &[usize] = if whole { &[100, 1000, 10_000, 100_000] } else { &[20] };
    for scene in ["corridor", "circle", "ring"] {
        sweep(scene, agents, &[Scheme::Registration], seconds)?;
        sweep(scene, &agents[..agents.len().min(2)], &[Scheme::Occupancy, Scheme::Fixed], seconds)?;
    }
    Ok(())
}

fn sweep(
    name: &str,
    agents: &[usize],
    engines: &[Scheme],
    seconds: Option<f64>,
) -> Result<(), Box<dyn std::error::Error>> {
    let scene = own_scene(name)?.ok_or("one of the project's own scenes")?;
    for &engine in engines {
        for &n in agents {
            let mut scene = scene.resized(n);
            scene.agents.engine = engine;
            println!("{}", run_agents(&scene.open()?, seconds, 1)?.row(name));
        }
    }
    Ok(())
}
