//! A world of motion patches: ten people are sent near a place, each to a free spot of its own.
//!
//! ```sh
//! cargo run --release -- stitch data/worlds/playground-small.toml
//! cargo run --release --example patch_world -- playground.throng playground-small.world
//! ```

use glam::Vec3;
use std::path::Path;
use throng_runtime::world::{InhabitantGoal, Inhabitants, InhabitantsConfig, World, scatter_rest_nodes};
use throng_runtime::{Bundle, CharacterGroup, Error, Inline, Planar};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let mut next = |default: &str| args.next().unwrap_or_else(|| default.into());
    run(next("playground.throng").as_ref(), next("playground-small.world").as_ref())
}

/// Lets ten people live in a world for a minute.
pub fn run(bundle: &Path, world: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let bundle = Bundle::open(bundle)?;
    // Path costs lie in the file, so that this takes milliseconds.
    let world = World::open(world, &bundle)?;
    let mut kids = Inhabitants::new(&world, 10, InhabitantsConfig::default())?;
    // Distant places where a person can stand; all people roam until they get an order.
    for start in scatter_rest_nodes(world.graph(), 10, 1) {
        kids.spawn(start)?;
    }

    // Each person takes the nearest free place; one that finds none waits.
    let place = world.nearest_place(Vec3::ZERO, 20.0)?.at;
    for id in kids.ids().to_vec() {
        kids.order(id, InhabitantGoal::GoNear { place, within_m: 3.0 })?;
    }
    for _ in 0..60 * 60 {
        kids.step(1.0 / 60.0, &Inline)?;
    }
    for &id in kids.ids() {
        println!("{id}: {:?}", kids.status(id)?);
    }

    // An impossible order is an error at once, which names the person.
    let first = kids.ids()[0];
    let far = InhabitantGoal::GoNear { place: Vec3::new(500.0, 0.0, 0.0), within_m: 3.0 };
    assert!(matches!(kids.order(first, far), Err(Error::Value { who, .. }) if who == Some(first)));
    // One person is moved to the nearest free place beside another one, if there is any, and goes home.
    let other = kids.bodies().roots[1];
    if let Err(e) = kids.place(first, Planar::new(other.x, other.z, 0.0)) {
        println!("{e}");
    }
    kids.despawn(first)?;
    Ok(())
}
