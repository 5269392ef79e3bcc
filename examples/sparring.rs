//! Sparring: pairs strike at each other's heads, and blows that land are told.
//!
//! ```sh
//! cargo run --release -- build data/boxing.toml
//! cargo run --release --example sparring -- boxing.throng
//! ```

use std::path::Path;
use throng_runtime::characters::{MotionSet, Start};
use throng_runtime::sparring::{Aim, Sparring, SparringConfig, SparringGoal};
use throng_runtime::{Bundle, Planar};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    run(std::env::args().nth(1).unwrap_or_else(|| "boxing.throng".into()).as_ref())
}

/// Lets two boxers spar for half a minute.
pub fn run(bundle: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let bundle = Bundle::open(bundle)?;
    let motion_set = MotionSet::new(&bundle);
    // Come near, strike, and be elsewhere when a blow lands.
    let goal = |name, weight, aim| {
        Ok::<_, throng_runtime::Error>(SparringGoal { policy: bundle.find_policy(name)?, weight, aim })
    };
    let goals = vec![
        goal("approach", 1.0, Aim::OpponentHead)?,
        goal("throw-punches", 2.0, Aim::OpponentHead)?,
        goal("evade", 1.0, Aim::OpponentThreat)?,
    ];
    // Face to face, an arm's length apart; characters 2k and 2k + 1 are opponents.
    let starts = [Planar::IDENTITY, Planar::new(0.0, 0.9, std::f32::consts::PI)].map(|root| Start { root, state: 0 });
    let mut sparring = Sparring::new(&motion_set, SparringConfig::new(goals), &starts)?;
    let mut num_landed = 0;
    for _ in 0..30 * 60 {
        sparring.step(&motion_set, 1.0 / 60.0)?;
        num_landed += sparring.landed().len();
    }
    let figures = sparring.figures();
    println!("{num_landed} blows landed or were blocked: {figures:?}");
    Ok(())
}
