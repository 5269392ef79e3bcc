//! The command line of Throng: one file per subcommand, which parses, calls and prints.

mod args;
mod bench;
mod build;
mod completions;
mod demo;
mod export;
mod inspect;
mod keys;
mod output;
mod progress;
mod query;
mod renamed;
mod run;
mod schema;
mod stitch;
mod synth;
mod verify;
mod view;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Bakes motion capture into tables, and drives thousands of characters by looking things up.
#[derive(Parser)]
#[command(name = "throng", version, after_help = args::AFTER_HELP)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Demo(demo::Args),
    Synth(synth::Args),
    Build(build::Args),
    Inspect(inspect::Args),
    Verify(verify::Args),
    Query(query::Args),
    Stitch(stitch::Args),
    Run(run::Args),
    Bench(bench::Args),
    Export(export::Args),
    View(view::Args),
    Schema(schema::Args),
    Completions(completions::Args),
}

fn main() -> ExitCode {
    let cli = Cli::try_parse().unwrap_or_else(|e| renamed::explain(e).exit());
    let done = match cli.command {
        Command::Demo(a) => demo::run(&a),
        Command::Synth(a) => synth::run(&a),
        Command::Build(a) => build::run(&a),
        Command::Inspect(a) => inspect::run(&a),
        Command::Verify(a) => verify::run(&a),
        Command::Query(a) => query::run(&a),
        Command::Stitch(a) => stitch::run(&a),
        Command::Run(a) => run::run(&a),
        Command::Bench(a) => bench::run(&a),
        Command::Export(a) => export::run(&a),
        // The viewer prints its own errors; its exit code is passed on.
        Command::View(a) => match view::run(&a) {
            Ok(code) => return code,
            Err(e) => Err(e),
        },
        Command::Schema(a) => schema::run(&a),
        Command::Completions(a) => completions::run(&a),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) if output::is_broken_pipe(e.as_ref()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("error: {e}");
            ExitCode::FAILURE
        }
    }
}
