//! Drives a crowd: opens a bundle, places characters, steps them towards their targets, reads their poses.
//!
//! ```sh
//! cargo run --release -- demo
//! cargo run --release --example crowd -- demo.throng
//! ```

use glam::Vec3;
use throng_runtime::troupe::{Goal, Repertoire, Start, Troupe, TroupeConfig};
use throng_runtime::{Joint, NUM_JOINTS, Planar, Tables};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "demo.throng".into());

    // Mapped and checked once; all else borrows from it.
    let tables = Tables::open(&path)?;
    let repertoire = Repertoire::new(&tables);
    let approach = tables.find_policy("approach").ok_or("the bundle has no behaviour called approach")?;

    // A row of characters, a metre apart, facing +Z, each in some state of the motion graph.
    let num_states = tables.graph().states.len() as u32;
    let starts: Vec<Start> =
        (0..100).map(|i| Start { root: Planar::new(i as f32, 0.0, 0.0), state: i * 7 % num_states }).collect();
    let targets: Vec<Vec3> = (0..100).map(|i| Vec3::new(i as f32, 0.0, 5.0)).collect();
    let mut troupe = Troupe::new(&repertoire, TroupeConfig::default(), &starts)?;

    // Ten seconds at 60 Hz. A step allocates nothing.
    let goals = [Goal { policy: approach, weight: 1.0, targets: &targets }];
    for _ in 0..600 {
        troupe.step(&repertoire, 1.0 / 60.0, &goals)?;
    }

    // Joints in model space, for a renderer; the root places each character in the world.
    assert_eq!(troupe.model_matrices().len(), 100 * NUM_JOINTS);
    let root = troupe.root(0);
    let head = troupe.joint_positions(0)[Joint::Head.index()];
    println!("character 0 stands at ({:.2}, {:.2}), its head {:.2} m above the ground", root.x, root.z, head.y);
    Ok(())
}
