//! Asks a policy for actions, without characters: the stored best action, and a ranking of all actions.
//!
//! ```sh
//! cargo run --release -- demo
//! cargo run --release --example query -- demo.throng
//! ```

use glam::Vec3;
use std::path::Path;
use throng_runtime::Bundle;
use throng_runtime::policy::{BestActionJob, LookAheadGoal, LookAheadJob, RankedActions};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    run(std::env::args().nth(1).unwrap_or_else(|| "demo.throng".into()).as_ref())
}

/// Asks the first policy of a bundle about three characters.
pub fn run(bundle: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let tables = Bundle::open(bundle)?;
    let policy = &tables.policies()[0];

    // Three characters in states 0, 1 and 2; targets in each one's own frame: X to its left, Z ahead.
    let states = [0, 1, 2];
    let targets = [Vec3::new(0.0, 0.0, 4.0), Vec3::new(3.0, 0.0, 0.0), Vec3::new(0.0, 0.0, -2.0)];

    // A single load each.
    let mut best = [0u8; 3];
    BestActionJob { policy, states: &states, targets: &targets, choice: 0, actions: &mut best }.run()?;

    // Every action, scored by its reward and the value of the state that it leads to; several behaviours could be summed.
    let mut ranked = [RankedActions::NONE; 3];
    let goals = [LookAheadGoal { policy, weights: &[1.0; 3], targets: &targets }];
    LookAheadJob { goals: &goals, states: &states, ranked: &mut ranked }.run()?;

    for i in 0..3 {
        let segment = tables.graph().segments_of(states[i])[usize::from(ranked[i].best())];
        let d = tables.graph().segments[segment as usize].displacement();
        println!(
            "state {}, target {}: stored action {}, looked ahead {} (score {:.4}), which moves ({:.2}, {:.2}) m and turns {:.0} degrees",
            states[i],
            targets[i],
            best[i],
            ranked[i].best(),
            ranked[i].scores[0],
            d.x,
            d.z,
            d.heading.to_degrees()
        );
    }
    Ok(())
}
