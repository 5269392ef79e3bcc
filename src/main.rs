//! The command line of Throng: one file per subcommand, which parses, calls and prints.

// It is also a target of libFuzzer, which has a `main` of its own: see `command_lines`.
#![allow(unexpected_cfgs, reason = "`fuzzing` is set by scripts/fuzz.sh")]
#![cfg_attr(fuzzing, no_main, allow(dead_code))]

mod allocations;
mod args;
mod bake;
mod bench;
mod build;
mod cache;
mod check;
#[cfg(any(test, fuzzing))]
#[path = "../tests/common/command_lines.rs"]
mod command_lines;
mod completions;
mod demo;
mod explain;
mod export;
mod figures;
mod help;
mod inspect;
mod keys;
mod level;
mod output;
mod plan;
mod progress;
mod query;
mod run;
mod schema;
mod selftest;
mod stitch;
mod synth;
mod verify;
mod view;

use clap::{FromArgMatches, Parser, Subcommand};
use std::process::ExitCode;
use throng_core::base::limit_threads;

/// Bakes motion capture into tables, and drives thousands of characters by looking things up.
#[derive(Parser)]
#[command(name = "throng", version, after_help = args::AFTER_HELP, disable_help_subcommand = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<MainCommand>,
}

#[derive(Subcommand)]
enum MainCommand {
    Demo(demo::Args),
    Synth(synth::Args),
    Build(build::Args),
    Bake(bake::Args),
    Inspect(inspect::Args),
    Verify(verify::Args),
    #[command(subcommand)]
    Query(query::QueryCommand),
    Stitch(stitch::Args),
    Level(level::Args),
    Check(check::Args),
    Run(run::Args),
    Explain(explain::Args),
    Plan(plan::Args),
    #[command(subcommand)]
    Bench(bench::BenchCommand),
    Export(export::Args),
    View(view::Args),
    Selftest(selftest::Args),
    Schema(schema::Args),
    Cache(cache::Args),
    Completions(completions::Args),
    Help(help::Args),
}

fn main() -> ExitCode {
    limit_threads();
    let matches = help::parser(std::env::args_os()).get_matches();
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|e| e.exit());
    let Some(command) = cli.command else { return exit_code(output::text(args::FIRST_STEPS)) };
    let done = match command {
        MainCommand::Demo(a) => demo::run(&a),
        MainCommand::Synth(a) => synth::run(&a),
        MainCommand::Build(a) => build::run(&a),
        MainCommand::Bake(a) => bake::run(&a),
        MainCommand::Inspect(a) => inspect::run(&a),
        MainCommand::Verify(a) => verify::run(&a),
        MainCommand::Query(a) => query::run(&a),
        MainCommand::Stitch(a) => stitch::run(&a),
        MainCommand::Level(a) => level::run(&a),
        MainCommand::Check(a) => check::run(&a),
        MainCommand::Run(a) => run::run(&a),
        MainCommand::Explain(a) => explain::run(&a),
        MainCommand::Plan(a) => plan::run(&a),
        MainCommand::Bench(a) => bench::run(&a),
        MainCommand::Export(a) => export::run(&a),
        // The viewer prints its own errors; its exit code is passed on.
        MainCommand::View(a) => return view::run(&a).unwrap_or_else(|e| exit_code(Err(e))),
        MainCommand::Selftest(a) => selftest::run(&a),
        MainCommand::Schema(a) => schema::run(&a),
        MainCommand::Cache(a) => cache::run(&a),
        MainCommand::Completions(a) => completions::run(&a),
        MainCommand::Help(a) => help::run(&a),
    };
    exit_code(done)
}

/// Prints an error, and gives the exit code.
fn exit_code(done: args::CommandResult) -> ExitCode {
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) if output::is_broken_pipe(e.as_ref()) => ExitCode::SUCCESS,
        Err(e) => {
            output::print_to_stderr(format_args!("error: {e}"));
            ExitCode::FAILURE
        }
    }
}
