//! Saving and restoring: the same for every cast. What follows is the same, bit by bit.
//!
//! ```sh
//! cargo run --release -- build data/locomotion.toml
//! cargo run --release --example snapshot -- locomotion.throng ahead-neutral
//! ```

use glam::Vec2;
use std::path::Path;
use throng_runtime::blend::walkers::{Control, WalkerStart, Walkers, WalkersConfig};
use throng_runtime::{Bundle, Cast, Inline};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let mut next = |default: &str| args.next().unwrap_or_else(|| default.into());
    run(next("locomotion.throng").as_ref(), &next("ahead-neutral"))
}

/// Saves a walker, lets it walk on, goes back, and lets it walk again.
pub fn run(bundle: &Path, space: &str) -> Result<(), Box<dyn std::error::Error>> {
    let bundle = Bundle::open(bundle)?;
    let mut walkers = Walkers::with_capacity(bundle.blend(space)?, &[], WalkersConfig::default(), 4)?;
    let id = walkers.spawn(WalkerStart::default())?;
    walkers.order(id, Control::walk(Vec2::new(0.0, 1.0)))?;
    walk_a_second(&mut walkers)?;

    let mut bytes = Vec::new();
    walkers.save(&mut bytes);
    let then = walkers.hash();
    walk_a_second(&mut walkers)?;
    let later = walkers.hash();
    walkers.load(&bytes)?;
    assert_eq!(walkers.hash(), then);
    walk_a_second(&mut walkers)?;
    assert_eq!(walkers.hash(), later, "the second second repeats");

    // Damaged bytes are refused, and nothing changes.
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    println!("{} bytes; damaged ones: {}", bytes.len(), walkers.load(&bytes).expect_err("a checksum"));
    assert_eq!(walkers.hash(), later);
    Ok(())
}

fn walk_a_second(walkers: &mut Walkers) -> throng_runtime::Result<()> {
    (0..60).try_for_each(|_| walkers.step(1.0 / 60.0, &Inline))
}
