//! A world of motion patches: people roam, one of them is sent to a place.
//!
//! ```sh
//! cargo run --release -- stitch data/worlds/playground-small.toml
//! cargo run --release --example patch_world -- playground.throng playground-small.world
//! ```

use glam::Vec3;
use std::path::Path;
use throng_runtime::Bundle;
use throng_runtime::world::World;
use throng_runtime::world::inhabitants::{Inhabitants, InhabitantsConfig, Wish, scatter};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let mut next = |default: &str| args.next().unwrap_or_else(|| default.into());
    run(next("playground.throng").as_ref(), next("playground-small.world").as_ref())
}

/// Lets ten people live in a world for half a minute.
pub fn run(bundle: &Path, world: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let bundle = Bundle::open(bundle)?;
    // Path costs lie in the file, so that this takes milliseconds.
    let world = World::open(world, &bundle)?;

    // Places far from each other where somebody can stand; everybody roams until told otherwise.
    let starts = scatter(world.graph(), 10, 1);
    let mut people = Inhabitants::new(&world, InhabitantsConfig::default(), &starts)?;
    people.set_wish(0, Wish::GoToPlace { place: Vec3::ZERO })?;
    for _ in 0..30 * 60 {
        people.step(1.0 / 60.0)?;
    }

    let root = people.characters().root(0);
    println!(
        "{} people; the first one is at ({:.1}, {:.1}): {:?}",
        starts.len(),
        root.x,
        root.z,
        people.status(0).doing
    );
    Ok(())
}
