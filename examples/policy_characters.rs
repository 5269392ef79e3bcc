//! Policy characters: people enter, get their targets one by one, and walk there.
//!
//! ```sh
//! cargo run --release -- demo
//! cargo run --release --example policy_characters -- demo.throng
//! ```

use glam::Vec3;
use std::path::Path;
use throng_runtime::characters::{AvoidConfig, CharactersConfig, PolicyCharacters, Spawn};
use throng_runtime::{Bundle, CharacterGroup, Id, Inline, Joint, Planar};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    run(std::env::args().nth(1).unwrap_or_else(|| "demo.throng".into()).as_ref())
}

/// Lets two hundred characters of a bundle enter, and one of them walk for ten seconds.
pub fn run(bundle: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let bundle = Bundle::open(bundle)?;
    let approach = bundle.policy("approach")?;
    // They avoid each other: no character ever walks through another.
    let config = CharactersConfig { avoid: Some(AvoidConfig::default()), ..CharactersConfig::default() };
    let mut people = PolicyCharacters::with_capacity(&bundle, 200, config)?;
    let places = (0..200).map(|i| Planar::new(2.0 * (i % 20) as f32, 2.0 * (i / 20) as f32, 0.0));
    let ids = places.map(|root| people.spawn(Spawn::standing_at(root))).collect::<Result<Vec<Id>, _>>()?;

    // Only changes need an order. An order stays.
    let click = Vec3::new(30.0, 0.0, 25.0);
    people.order(ids[17], approach.order_towards(click))?;
    for _ in 0..600 {
        people.step(1.0 / 60.0, &Inline)?;
    }

    let body = people.bodies().get(ids[17]).ok_or("it is there")?;
    println!(
        "it stands at {:?}, its head at {:.2}: {:?}",
        body.root,
        body.position(Joint::Head),
        people.status(ids[17])?
    );
    Ok(())
}
