//! A street with a corner: people find their way round it, each with a blended body.
//!
//! ```sh
//! cargo run --release -- build data/locomotion.toml
//! cargo run --release --example agents_with_bodies -- locomotion.throng ahead-neutral
//! ```

use glam::Vec3;
use std::path::Path;
use throng_runtime::crowd::{Agent, AgentOrder, AtEnd, Crowd, CrowdSetup, ForceField, Obstacle, Streets};
use throng_runtime::simulation::Pedestrians;
use throng_runtime::walkers::WalkersConfig;
use throng_runtime::{Bundle, CharacterGroup, Inline, Joint};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let mut next = |default: &str| args.next().unwrap_or_else(|| default.into());
    run(next("locomotion.throng").as_ref(), &next("ahead-neutral"))
}

/// Sends twelve people around a house; a person that has arrived leaves.
pub fn run(bundle: &Path, space: &str) -> Result<(), Box<dyn std::error::Error>> {
    let house = Obstacle::Box { min: Vec3::new(-3.0, 0.0, -3.0), max: Vec3::new(3.0, 3.0, 3.0) };
    let setup =
        CrowdSetup { fields: vec![ForceField::COMMUTER], ..CrowdSetup::in_streets(&Streets::new(&[house], 0.4)?, 12) };
    let crowd = Crowd::on_ground(setup)?;
    let mut people = Pedestrians::new(crowd, Bundle::open(bundle)?.blend(space)?, &[], WalkersConfig::default())?;
    for i in 0..12 {
        let id = people.spawn(Agent::standing_at(Vec3::new(i as f32 - 6.0, 0.0, -6.0)))?;
        // Finds a path around the corner, or fails if there is none.
        people.order(id, AgentOrder::to_goal(Vec3::new(0.0, 0.0, 8.0)).with_arrival(2.0).then_at_end(AtEnd::Leave))?;
    }
    let inside = people.order(people.bodies().ids[0], AgentOrder::to_goal(Vec3::ZERO));
    println!("into the house: {}", inside.expect_err("no way leads there"));
    for step in 1..=1800 {
        people.step(1.0 / 60.0, &Inline)?;
        for (id, what) in people.events() {
            println!("{:4.1} s: {id}: {what:?}", f64::from(step) / 60.0);
        }
    }
    // A person that has left has no body any more.
    for &id in people.bodies().ids {
        let head = people.bodies().get(id).ok_or("a body")?.position(Joint::Head);
        println!("{id} is still on its way: {:?}, its head at {head:.1}", people.status(id)?);
    }
    Ok(())
}
