//! `steering`: how crowds get on, on grounds that steering was tuned on and on others.

use crate::args::{CommandResult, fail};
use crate::{keys, output};
use serde::Serialize;
use throng_core::base::limits;
use throng_crowd::{CrowdSetup, SteeringConfig};
use throng_research::steering::{self, CASES, Case, SteeringFigures};

/// Measure how crowds get on: corridors, bends, crossings, doors, posts, rooms and rings.
///
/// Some of the grounds were looked at while the constants of steering were chosen; the others, marked `held_out`, judge
/// them. `--sweep` changes one constant at a time and shows what it is worth there.
#[derive(clap::Args)]
#[command(after_long_help = keys::json_keys::<SteeringComparison>())]
pub struct Args {
    /// Names of grounds; `all`, `tuned` or `held_out`.
    #[arg(long, value_delimiter = ',', default_value = "all", value_name = "NAME,...")]
    scene: Vec<String>,
    /// Seed of places, sizes, speeds and grounds by chance.
    #[arg(long, default_value_t = 1, allow_negative_numbers = true, value_parser = limits::number_parser::<u64>(&limits::SEED))]
    seed: u64,
    /// Number of runs of each, with seeds one after the other; the one with the median speed is told in full.
    #[arg(long, value_name = "N", default_value_t = 1, allow_negative_numbers = true, value_parser = limits::number_parser::<u32>(&limits::REPEATS))]
    repeats: u32,
    /// Simulated time in place of that of each ground.
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = limits::number_parser::<f64>(&limits::SECONDS))]
    seconds: Option<f64>,
    /// Other constants of steering, as `throng schema` names them.
    #[arg(long, value_delimiter = ',', value_name = "NAME=VALUE,...")]
    set: Vec<String>,
    /// Constants of steering to halve and double, one at a time, on the grounds that were held out; `all` of them.
    #[arg(long, value_delimiter = ',', value_name = "NAME,...")]
    sweep: Vec<String>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// What is printed.
#[derive(Serialize, schemars::JsonSchema)]
struct SteeringComparison {
    /// Each ground.
    results: Vec<Row>,
    /// Each constant that was changed.
    sweep: Vec<Swept>,
}

/// A ground.
#[derive(Serialize, schemars::JsonSchema)]
struct Row {
    /// Its name.
    scene: String,
    /// Not looked at while steering was tuned.
    held_out: bool,
    #[serde(flatten)]
    figures: SteeringFigures,
    /// Least, median and largest speed of all repeats (m/s).
    speed_range_mps: [f64; 3],
    /// Fewest, median and most agents that ever stood for 10 s, of all repeats.
    stuck_range: [usize; 3],
}

/// A constant that was changed.
#[derive(Serialize, schemars::JsonSchema)]
struct Swept {
    /// Its name.
    constant: String,
    /// Its value.
    value: f64,
    /// Mean speed over all grounds that were held out (m/s).
    speed_mps: f64,
    /// The same with the default (m/s).
    default_speed_mps: f64,
    /// Agents that ever stood for 10 s there, in all.
    stuck: usize,
    /// The same with the default.
    default_stuck: usize,
}

/// Runs all that was asked for.
pub fn run(args: &Args) -> CommandResult {
    let changes = args.set.iter().map(|s| parse(s)).collect::<Result<Vec<_>, _>>()?;
    let cases = chosen(&args.scene)?;
    let (mut results, mut sweep) = (Vec::new(), Vec::new());
    if args.sweep.is_empty() {
        if !args.json {
            println!("{}", steering::HEADINGS);
        }
        for case in cases {
            let row = measure(case, args, &changes)?;
            if !args.json {
                println!("{}", steering::row(&row.scene, &row.figures));
            }
            results.push(row);
        }
    } else {
        sweep = swept(args)?;
    }
    if args.json { output::json(&SteeringComparison { results, sweep }) } else { Ok(()) }
}

fn measure(case: &Case, args: &Args, changes: &[(String, f64)]) -> Result<Row, Box<dyn std::error::Error>> {
    let mut all = Vec::new();
    for repeat in 0..u64::from(args.repeats) {
        let mut setup = case.setup(args.seed.wrapping_add(repeat));
        changes.iter().try_for_each(|(name, value)| change(&mut setup, name, *value))?;
        let seconds = args.seconds.unwrap_or(case.seconds);
        all.push(steering::run(setup, seconds, &mut |_, _, _, _| {}).map_err(throng_core::Error::from)?);
    }
    let mut stuck: Vec<usize> = all.iter().map(|f| f.stuck).collect();
    stuck.sort_unstable();
    all.sort_by(|a, b| a.speed_mps.total_cmp(&b.speed_mps));
    let (median, last) = (all.len() / 2, all.len() - 1);
    Ok(Row {
        scene: case.name.to_owned(),
        held_out: case.held_out,
        speed_range_mps: [0, median, last].map(|i| all[i].speed_mps),
        stuck_range: [0, median, last].map(|i| stuck[i]),
        figures: all.swap_remove(median),
    })
}

/// Halves and doubles constants.
fn swept(args: &Args) -> Result<Vec<Swept>, Box<dyn std::error::Error>> {
    let defaults = numbers();
    let is_all = args.sweep.iter().any(|n| n == "all");
    let chosen: Vec<_> = defaults.iter().filter(|(n, _)| is_all || args.sweep.contains(n)).cloned().collect();
    if let Some(odd) = args.sweep.iter().find(|n| *n != "all" && !defaults.iter().any(|d| d.0 == **n)) {
        return fail(format!("--sweep {odd}: expected one of {}", names(&defaults)));
    }
    let total = |changes: &[(String, f64)]| -> Result<(f64, usize), Box<dyn std::error::Error>> {
        let held = CASES.iter().filter(|c| c.held_out);
        let rows = held.map(|c| measure(c, args, changes)).collect::<Result<Vec<_>, _>>()?;
        let speed = rows.iter().map(|r| r.figures.speed_mps).sum::<f64>() / rows.len() as f64;
        Ok((speed, rows.iter().map(|r| r.figures.stuck).sum()))
    };
    let (default_speed_mps, default_stuck) = total(&[])?;
    if !args.json {
        println!(
            "constant                      value    m/s  stuck\ndefaults                            {default_speed_mps:6.3} {default_stuck:6}"
        );
    }
    let mut out = Vec::new();
    for (constant, default) in chosen {
        for value in [0.5 * default, 2.0 * default] {
            // Some cannot be halved or doubled.
            let mut probe = CrowdSetup::default();
            let is_within =
                change(&mut probe, &constant, value).is_ok() && throng_crowd::Crowd::on_ground(probe).is_ok();
            if default == 0.0 || !is_within {
                continue;
            }
            let (speed_mps, stuck) = total(&[(constant.clone(), value)])?;
            if !args.json {
                println!("{constant:28} {value:6.2} {speed_mps:6.3} {stuck:6}");
            }
            out.push(Swept { constant: constant.clone(), value, speed_mps, default_speed_mps, stuck, default_stuck });
        }
    }
    Ok(out)
}

/// All constants that are single numbers, with their defaults.
fn numbers() -> Vec<(String, f64)> {
    let all = serde_json::to_value(SteeringConfig::default()).unwrap_or_default();
    let fields = all.as_object().into_iter().flatten();
    fields.filter_map(|(name, value)| Some((name.clone(), value.as_f64()?))).collect()
}

fn names(numbers: &[(String, f64)]) -> String {
    numbers.iter().map(|n| n.0.as_str()).collect::<Vec<_>>().join(", ")
}

/// A constant and its value.
fn parse(text: &str) -> Result<(String, f64), Box<dyn std::error::Error>> {
    let both = text.split_once('=').and_then(|(name, value)| Some((name.to_owned(), value.parse().ok()?)));
    let known = numbers();
    match both.filter(|(name, _)| known.iter().any(|n| n.0 == *name)) {
        Some(both) => Ok(both),
        None => fail(format!("--set {text}: expected NAME=VALUE, of {}", names(&known))),
    }
}

/// Changes a constant of a crowd.
fn change(setup: &mut CrowdSetup, name: &str, value: f64) -> CommandResult {
    let mut all = serde_json::to_value(setup.config.steering)?;
    all[name] = if all[name].is_u64() { (value.round() as u64).into() } else { value.into() };
    setup.config.steering = serde_json::from_value(all)?;
    Ok(())
}

/// The grounds of some names.
fn chosen(names: &[String]) -> Result<Vec<&'static Case>, Box<dyn std::error::Error>> {
    let is_known =
        |n: &&String| ["all", "tuned", "held_out"].contains(&n.as_str()) || CASES.iter().any(|c| c.name == **n);
    if let Some(odd) = names.iter().find(|n| !is_known(n)) {
        let known: Vec<_> = CASES.iter().map(|c| c.name).collect();
        return fail(format!("--scene {odd}: expected all, tuned, held_out or one of {}", known.join(", ")));
    }
    let is_chosen = |case: &&Case| {
        let of = |n: &String| n == "all" || n == case.name || n == if case.held_out { "held_out" } else { "tuned" };
        names.iter().any(of)
    };
    Ok(CASES.iter().filter(is_chosen).collect())
}
