//! The command line of Throng: one file per subcommand, which parses, calls and prints.

mod allocations;
mod args;
mod bake;
mod bench;
mod build;
mod cache;
mod check;
mod completions;
mod demo;
mod explain;
mod export;
mod inspect;
mod keys;
mod output;
mod plan;
mod progress;
mod query;
mod renamed;
mod run;
mod schema;
mod selftest;
mod soak;
mod stitch;
mod synth;
mod verify;
mod view;

use clap::{Parser, Subcommand};
use std::process::ExitCode;
use throng_runtime::base::limit_threads;

/// Bakes motion capture into tables, and drives thousands of characters by looking things up.
#[derive(Parser)]
#[command(name = "throng", version, after_help = args::AFTER_HELP)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    Demo(demo::Args),
    Synth(synth::Args),
    Build(build::Args),
    Bake(bake::Args),
    Inspect(inspect::Args),
    Verify(verify::Args),
    Query(query::Args),
    Stitch(stitch::Args),
    Check(check::Args),
    Run(run::Args),
    Explain(explain::Args),
    Plan(plan::Args),
    Bench(bench::Args),
    Export(export::Args),
    View(view::Args),
    Selftest(selftest::Args),
    Soak(soak::Args),
    Schema(schema::Args),
    Cache(cache::Args),
    Completions(completions::Args),
}

fn main() -> ExitCode {
    limit_threads();
    let cli = Cli::try_parse().unwrap_or_else(|e| renamed::explain(e).exit());
    let Some(command) = cli.command else {
        return ended(output::text(args::FIRST_STEPS));
    };
    let done = match command {
        Command::Demo(a) => demo::run(&a),
        Command::Synth(a) => synth::run(&a),
        Command::Build(a) => build::run(&a),
        Command::Bake(a) => bake::run(&a),
        Command::Inspect(a) => inspect::run(&a),
        Command::Verify(a) => verify::run(&a),
        Command::Query(a) => query::run(&a),
        Command::Stitch(a) => stitch::run(&a),
        Command::Check(a) => check::run(&a),
        Command::Run(a) => run::run(&a),
        Command::Explain(a) => explain::run(&a),
        Command::Plan(a) => plan::run(&a),
        Command::Bench(a) => bench::run(&a),
        Command::Export(a) => export::run(&a),
        // The viewer prints its own errors; its exit code is passed on.
        Command::View(a) => match view::run(&a) {
            Ok(code) => return code,
            Err(e) => Err(e),
        },
        Command::Selftest(a) => selftest::run(&a),
        Command::Soak(a) => soak::run(&a),
        Command::Schema(a) => schema::run(&a),
        Command::Cache(a) => cache::run(&a),
        Command::Completions(a) => completions::run(&a),
    };
    ended(done)
}

/// Prints an error, and gives the exit code.
fn ended(done: args::Outcome) -> ExitCode {
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) if output::is_broken_pipe(e.as_ref()) => ExitCode::SUCCESS,
        Err(e) => {
            output::tell(format_args!("error: {e}"));
            ExitCode::FAILURE
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{CommandFactory, FromArgMatches};

    /// Words that are hard to take.
    const WORDS: [&str; 14] = [
        "",
        "-",
        "--",
        "-1",
        "0",
        "nan",
        "inf",
        "1e999",
        "18446744073709551616",
        "a,b",
        ",",
        "=",
        "\u{0}",
        "\u{1f980}",
    ];

    /// Command lines of every command with every flag of it, each with every hard word: they are parsed or refused.
    #[test]
    fn no_command_line_panics() {
        fn lines(command: &clap::Command, before: &[String], out: &mut Vec<Vec<String>>) {
            let before = [before, &[command.get_name().to_owned()]].concat();
            for arg in command.get_arguments() {
                for word in WORDS {
                    let flag = arg.get_long().map(|long| format!("--{long}"));
                    let joined = flag.iter().map(|f| format!("{f}={word}"));
                    let apart = flag.clone().into_iter().chain([word.to_owned()]);
                    out.push([&before[..], &joined.collect::<Vec<_>>()].concat());
                    out.push([&before[..], &apart.collect::<Vec<_>>(), &["file".into()]].concat());
                }
            }
            command.get_subcommands().for_each(|c| lines(c, &before, out));
        }
        let (mut command, mut all) = (Cli::command(), Vec::new());
        lines(&command, &[], &mut all);
        assert!(all.len() > 2000, "{} command lines", all.len());
        // As `Cli::try_parse_from`, which would make the parser anew for each.
        let mut parse = |line: &Vec<String>| Cli::from_arg_matches(&command.try_get_matches_from_mut(line)?);
        let parsed = all.iter().filter(|line| parse(line).is_ok()).count();
        assert!(parsed > 50 && parsed < all.len() / 2, "{parsed} of {} are accepted", all.len());
    }
}
