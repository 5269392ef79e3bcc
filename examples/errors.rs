//! Errors: each names the item and the character, the expected and the found value, and a remedy.
//!
//! ```sh
//! cargo run --release -- build data/locomotion.toml
//! cargo run --release --example errors -- locomotion.throng ahead-neutral
//! ```

use glam::{Vec2, Vec3};
use std::path::Path;
use throng_runtime::crowd::{Obstacle, Streets};
use throng_runtime::walkers::{Control, WalkerStart, Walkers, WalkersConfig};
use throng_runtime::{Bundle, CharacterGroup, Error};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let mut next = |default: &str| args.next().unwrap_or_else(|| default.into());
    run(next("locomotion.throng").as_ref(), &next("ahead-neutral"))
}

/// Makes the usual mistakes.
pub fn run(bundle: &Path, space: &str) -> Result<(), Box<dyn std::error::Error>> {
    let bundle = Bundle::open(bundle)?;
    println!("{}", Bundle::open("no-such.throng").expect_err("a file that is not there"));

    // A wrong name: the error lists the existing ones.
    let unknown = bundle.blend("wlaks").expect_err("a wrong name");
    assert!(matches!(&unknown, Error::Unknown { known, .. } if known.iter().any(|name| name == space)));
    println!("{unknown}");

    // A bad number: the error names the walker, and nothing changes.
    let mut walkers = Walkers::with_capacity(bundle.blend(space)?, &[], WalkersConfig::default(), 1)?;
    let id = walkers.spawn(WalkerStart::default())?;
    let bad = walkers.order(id, Control::walk(Vec2::new(f32::NAN, 0.0))).expect_err("not a number");
    assert!(matches!(bad, Error::Value { who: Some(who), .. } if who == id));
    println!("{bad}");

    // No more room, and the id of a walker that has left.
    let full = walkers.spawn(WalkerStart::default()).expect_err("a full group");
    walkers.despawn(id)?;
    let gone = walkers.status(id).expect_err("an id that has left");
    assert!(matches!((&full, &gone), (Error::Full { capacity: 1 }, Error::Gone(_))));
    println!("{full}\n{gone}");

    // A goal in a wall.
    let wall = Obstacle::Box { min: Vec3::new(4.0, 0.0, -1.0), max: Vec3::new(6.0, 3.0, 1.0) };
    let unreachable =
        Streets::new(&[wall], 0.4)?.route(Vec3::ZERO, Vec3::new(5.0, 0.0, 0.0)).expect_err("a goal in a wall");
    println!("{unreachable}");
    Ok(())
}
