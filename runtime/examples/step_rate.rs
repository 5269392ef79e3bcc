//! How long the steps of a scene take, for `python/examples/step_ratio.py` to compare with.
//!
//! ```sh
//! cargo run --release -p throng-runtime --features rayon --example step_rate -- SCENE.toml STEPS
//! ```

use std::time::Instant;
use throng_runtime::Planar;
use throng_runtime::simulation::{Scene, Simulation};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let scene = args.next().ok_or("expected SCENE.toml STEPS")?;
    let steps: usize = args.next().ok_or("expected the number of steps behind the scene")?.parse()?;
    let mut sim = Simulation::new(&Scene::load(&scene)?.open()?)?;
    let begin = Instant::now();
    for _ in 0..steps {
        sim.step(1.0 / 60.0)?;
    }
    let seconds = begin.elapsed().as_secs_f64() / steps as f64;
    let bits = |r: Planar| r.x.to_bits() ^ r.z.to_bits() ^ r.heading.to_bits();
    println!("{seconds} {}", sim.roots().flatten().map(bits).fold(0, |all, one| all ^ one));
    Ok(())
}
