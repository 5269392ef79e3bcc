//! Blended walkers: they enter, get orders how to walk, report their steps, and leave.
//!
//! ```sh
//! cargo run --release -- build data/locomotion.toml
//! cargo run --release --example blended_walkers -- locomotion.throng ahead-neutral
//! ```

use glam::Vec2;
use std::path::Path;
use throng_runtime::body::BodyEventKind;
use throng_runtime::walkers::{Control, WalkerStart, Walkers, WalkersConfig};
use throng_runtime::{Bundle, CharacterGroup, Inline, Joint, Planar};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let mut next = |default: &str| args.next().unwrap_or_else(|| default.into());
    run(next("locomotion.throng").as_ref(), &next("ahead-neutral"))
}

/// Lets twenty people walk side by side, each a little faster than the last one.
pub fn run(bundle: &Path, space: &str) -> Result<(), Box<dyn std::error::Error>> {
    let bundle = Bundle::open(bundle)?;
    let mut walkers = Walkers::with_capacity(bundle.blend(space)?, &[], WalkersConfig::default(), 20)?;
    let mut ids = Vec::new();
    for i in 0..20 {
        let id = walkers.spawn(WalkerStart { root: Planar::new(i as f32, 0.0, 0.0), ..WalkerStart::default() })?;
        // An order stays until it is changed.
        walkers.order(id, Control::walk(Vec2::new(0.0, 0.8 + 0.02 * i as f32)))?;
        ids.push(id);
    }
    let mut num_steps = 0;
    for _ in 0..300 {
        walkers.step(1.0 / 60.0, &Inline)?;
        num_steps += walkers.events().iter().filter(|(_, e)| e.kind == BodyEventKind::Footstep).count();
    }
    let body = walkers.bodies().get(ids[19]).ok_or("the last one is there")?;
    println!("{num_steps} steps; the head of the last walker is at {:.2}", body.position(Joint::Head));
    walkers.despawn(ids[0])?;
    assert!(walkers.status(ids[0]).is_err(), "an id that has left is refused");
    Ok(())
}
