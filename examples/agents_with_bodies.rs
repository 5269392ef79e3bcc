//! A street with a corner: agents find their way round it, and blended bodies follow them.
//!
//! ```sh
//! cargo run --release -- build data/locomotion.toml
//! cargo run --release --example agents_with_bodies -- locomotion.throng ahead-neutral
//! ```

use glam::{Vec2, Vec3};
use std::path::Path;
use throng_runtime::blend::walkers::{Control, WalkerStart, Walkers, WalkersConfig};
use throng_runtime::crowd::{Agent, AtEnd, Crowd, CrowdConfig, Field, Go, Obstacle, Setup, Streets};
use throng_runtime::{Bundle, Cast, Inline, Planar};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let mut next = |default: &str| args.next().unwrap_or_else(|| default.into());
    run(next("locomotion.throng").as_ref(), &next("ahead-neutral"))
}

/// Sends twelve people round a house; who is there leaves.
pub fn run(bundle: &Path, space: &str) -> Result<(), Box<dyn std::error::Error>> {
    let house = Obstacle::Box { min: Vec3::new(-3.0, 0.0, -3.0), max: Vec3::new(3.0, 3.0, 3.0) };
    let goal = Vec3::new(0.0, 0.0, 8.0);
    let agents: Vec<Agent> = (0..12).map(|i| Agent::at(Vec3::new(i as f32 - 6.0, 0.0, -6.0))).collect();
    let mut crowd = Crowd::on_ground(Setup {
        agents,
        routes: Vec::new(),
        fields: vec![Field::COMMUTER],
        obstacles: vec![house.clone()],
        interests: Vec::new(),
        streets: Some(Streets::new(&[house], 0.4)?),
        config: CrowdConfig::default(),
    })?;
    let bundle = Bundle::open(bundle)?;
    let mut walkers = Walkers::with_capacity(bundle.blend(space)?, &[], WalkersConfig::default(), 12)?;
    let mut pairs = Vec::new();
    for agent in crowd.ids().collect::<Vec<_>>() {
        // Finds the way round the corner, or says that there is none.
        crowd.order(agent, Go::to(goal).within(2.0).then(AtEnd::Leave))?;
        let at = crowd.position(agent, 0.0).ok_or("the agent is there")?;
        pairs.push((agent, walkers.spawn(WalkerStart { root: Planar::new(at.x, at.z, 0.0), ..Default::default() })?));
    }
    for step in 1..=1800 {
        let now = f64::from(step) / 60.0;
        crowd.advance(now, &mut |_event| {})?;
        // Bodies follow their agents, and leave with them.
        for (agent, body) in std::mem::take(&mut pairs) {
            let (Some(at), Some(v)) = (crowd.position(agent, now), crowd.smooth_velocity(agent)) else {
                walkers.despawn(body)?;
                continue;
            };
            let (position, velocity) = (Some(Vec2::new(at.x, at.z)), Vec2::new(v.x, v.z));
            walkers.order(body, Control { position, velocity, ..Control::default() })?;
            pairs.push((agent, body));
        }
        walkers.step(1.0 / 60.0, &Inline)?;
    }
    println!("{} of 12 are still on their way", walkers.bodies().ids.len());
    Ok(())
}
