//! `people`: crowds beside people.

use crate::args::CommandResult;
use crate::{keys, output};
use throng_core::base::limits;
use throng_research::steering::{PeopleFigures, people};

/// Compare crowds with people: speed and flow over density, lanes, flow through gaps, stripes where streams cross.
///
/// Agents are in no hurry, and in a crowd as slow as the people there; they are 0.42 to 0.5 m wide with speeds of 1.34 +- 0.26 m/s.
#[derive(clap::Args)]
#[command(after_long_help = keys::json_keys::<PeopleFigures>())]
pub struct Args {
    /// Seed of places, sizes and speeds.
    #[arg(long, default_value_t = 1, allow_negative_numbers = true, value_parser = limits::number_parser::<u64>(&limits::SEED))]
    seed: u64,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Runs all rings, gaps and crossings.
pub fn run(args: &Args) -> CommandResult {
    let figures = people(args.seed, &|_| {}).map_err(throng_core::Error::from)?;
    if args.json {
        return output::json(&figures);
    }
    println!("1/m2  ways   m/s  people  1/(m s)  lanes");
    for r in &figures.results {
        let lanes = r.lanes_counted.map_or(String::new(), |n| format!("{n:.1}"));
        let (density, ways, people) = (r.density_per_m2, r.ways, r.weidmann_mps);
        println!("{density:4.1} {ways:5} {:5.2} {people:7.2} {:8.2}  {lanes}", r.speed_mps, r.flow_per_m_s);
    }
    println!("gap m  1/(m s)  longest wait s");
    for g in &figures.gaps {
        println!("{:5.1} {:8.2} {:8.1}", g.width_m, g.flow_per_m_s, g.longest_wait_s);
    }
    println!("stripes where two streams cross: {:.2}", figures.stripe_order);
    Ok(())
}
