//! The command line of the experiments: one file per subcommand, which parses, calls and prints.

mod commands;
// Modules of the product's command line.
#[path = "../../src/args.rs"]
#[allow(dead_code, reason = "the product's commands use the rest")]
mod args;
#[path = "../../src/bench/crowd.rs"]
mod bench_crowd;
#[path = "../../src/figures.rs"]
mod figures;
#[path = "../../src/keys.rs"]
mod keys;
#[path = "../../src/output.rs"]
#[allow(dead_code, reason = "the product's commands use the rest")]
mod output;
#[path = "../../src/progress.rs"]
#[allow(dead_code, reason = "the product's commands use the rest")]
mod progress;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use commands::{blend, boxing, crowd, people, plan, quality, steering, world};
use std::process::ExitCode;
use throng_core::base::limit_threads;

/// Compares Throng with other methods, with people, and with the figures of papers.
#[derive(Parser)]
#[command(name = "throng-research", version, after_help = args::AFTER_HELP)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Blend(blend::Args),
    Boxing(boxing::Args),
    Crowd(crowd::Args),
    People(people::Args),
    Plan(plan::Args),
    Quality(quality::Args),
    Steering(steering::Args),
    World(world::Args),
}

fn main() -> ExitCode {
    limit_threads();
    let parser = Cli::command().mut_subcommands(args::accept_negative_numbers);
    let cli = Cli::from_arg_matches(&parser.get_matches()).unwrap_or_else(|e| e.exit());
    let done = match cli.command {
        Command::Blend(a) => blend::run(&a),
        Command::Boxing(a) => boxing::run(&a),
        Command::Crowd(a) => crowd::run(&a),
        Command::People(a) => people::run(&a),
        Command::Plan(a) => plan::run(&a),
        Command::Quality(a) => quality::run(&a),
        Command::Steering(a) => steering::run(&a),
        Command::World(a) => world::run(&a),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) if output::is_broken_pipe(e.as_ref()) => ExitCode::SUCCESS,
        Err(e) => {
            output::print_to_stderr(format_args!("error: {e}"));
            ExitCode::FAILURE
        }
    }
}
