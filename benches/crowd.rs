//! What does a simulated second of a crowd cost, by events and by fixed steps, as it grows? `cargo bench --bench crowd`.

use throng_precompute::scene::crowd::{CrowdReport, CrowdRun, CrowdScene, Engine, own_scene, run};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // `cargo test` runs benches too: a small crowd is enough there.
    let whole = std::env::args().any(|a| a == "--bench");
    let seconds = Some(if whole { 15.0 } else { 0.5 });
    println!("{}", CrowdReport::HEADINGS);
    // Figure 6 of Kim, Kim and Shin 2003: more birds in the same corridor.
    let birds: &[usize] = if whole { &[100, 250, 500, 750, 1000] } else { &[20] };
    sweep("flock", birds, &Engine::ALL, seconds)?;
    // At equal density, the cost of a member should stay.
    let members: &[usize] = if whole { &[100, 1000, 10_000, 100_000] } else { &[20] };
    for scene in ["corridor", "circle", "ring"] {
        sweep(scene, members, &[Engine::Events], seconds)?;
        sweep(scene, &members[..members.len().min(2)], &[Engine::Occupancy, Engine::Fixed], seconds)?;
    }
    Ok(())
}

fn sweep(
    name: &str,
    members: &[usize],
    engines: &[Engine],
    seconds: Option<f64>,
) -> Result<(), Box<dyn std::error::Error>> {
    let scene = own_scene(name)?.ok_or("one of the project's own scenes")?;
    for &engine in engines {
        for &n in members {
            let scene = CrowdScene { engine, ..scene.resized(n) };
            let (report, _) = run(&scene, &CrowdRun { seconds, timed_apart: true, ..CrowdRun::default() })?;
            println!("{}", report.row());
        }
    }
    Ok(())
}
