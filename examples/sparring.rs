//! Sparring: pairs strike at each other's heads, and blows that land are reported.
//!
//! ```sh
//! cargo run --release -- build data/boxing.toml
//! cargo run --release --example sparring -- boxing.throng
//! ```

use glam::Vec3;
use std::path::Path;
use throng_runtime::characters::Spawn;
use throng_runtime::sparring::{Sparring, SparringConfig};
use throng_runtime::{Bundle, CharacterGroup, Inline, Planar};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    run(std::env::args().nth(1).unwrap_or_else(|| "boxing.throng".into()).as_ref())
}

/// Lets two boxers spar for half a minute.
pub fn run(bundle: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let bundle = Bundle::open(bundle)?;
    // Policies to approach, strike and evade; their targets are updated at every step.
    let (punches, evade) = (bundle.policy("throw-punches")?, bundle.policy("evade")?);
    let fight = bundle
        .policy("approach")?
        .order_towards(Vec3::ZERO)
        .with_policy(punches.number(), 2.0)
        .with_policy(evade.number(), 1.0);
    let mut sparring = Sparring::with_capacity(&bundle, 1, SparringConfig::default())?;
    // Face to face, an arm's length apart.
    let roots = [Planar::IDENTITY, Planar::new(0.0, 0.9, std::f32::consts::PI)];
    let first = sparring.spawn(roots.map(Spawn::standing_at))?;
    for id in [first, sparring.opponent(first)?] {
        sparring.order(id, fight)?;
    }
    let mut num_landed = 0;
    for _ in 0..30 * 60 {
        sparring.step(1.0 / 60.0, &Inline)?;
        num_landed += sparring.events().len();
    }
    println!("{num_landed} blows landed or were blocked: {:?}", sparring.figures());
    Ok(())
}
