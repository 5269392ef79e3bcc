//! Policy characters: opens a bundle, places characters, steps them towards their targets, reads their poses.
//!
//! ```sh
//! cargo run --release -- demo
//! cargo run --release --example policy_characters -- demo.throng
//! ```

use glam::Vec3;
use std::path::Path;
use throng_runtime::characters::{Characters, CharactersConfig, Goal, MotionSet, Start};
use throng_runtime::{Bundle, Joint, NUM_JOINTS, Planar};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    run(std::env::args().nth(1).unwrap_or_else(|| "demo.throng".into()).as_ref())
}

/// Lets a hundred characters of a bundle walk for ten seconds.
pub fn run(bundle: &Path) -> Result<(), Box<dyn std::error::Error>> {
    // Mapped and checked once; all else borrows from it.
    let tables = Bundle::open(bundle)?;
    let motion_set = MotionSet::new(&tables);
    let approach = tables.find_policy("approach")?;

    // A row of characters, a metre apart, facing +Z, each in some state of the motion graph.
    let num_states = tables.graph().states.len() as u32;
    let starts: Vec<Start> =
        (0..100).map(|i| Start { root: Planar::new(i as f32, 0.0, 0.0), state: i * 7 % num_states }).collect();
    let targets: Vec<Vec3> = (0..100).map(|i| Vec3::new(i as f32, 0.0, 5.0)).collect();
    let mut characters = Characters::new(&motion_set, CharactersConfig::default(), &starts)?;

    // Ten seconds at 60 Hz. A step allocates nothing.
    let goals = [Goal { policy: approach, weight: 1.0, targets: &targets }];
    for _ in 0..600 {
        characters.step(&motion_set, 1.0 / 60.0, &goals)?;
    }

    // Joints in model space, for a renderer; the root places each character in the world.
    assert_eq!(characters.model_matrices().len(), 100 * NUM_JOINTS);
    let root = characters.root(0);
    let head = characters.joint_positions(0)[Joint::Head.index()];
    println!("character 0 stands at ({:.2}, {:.2}), its head {:.2} m above the ground", root.x, root.z, head.y);
    Ok(())
}
