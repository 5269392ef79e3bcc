//! `throng completions`: completions for a shell.

use crate::args::CommandResult;
use clap::CommandFactory;
use std::io::Write;

/// Print completions for a shell.
#[derive(clap::Args)]
pub struct Args {
    /// The shell.
    shell: clap_complete::Shell,
}

pub fn run(args: &Args) -> CommandResult {
    let mut out = Vec::new();
    clap_complete::generate(args.shell, &mut crate::Cli::command(), "throng", &mut out);
    std::io::stdout().write_all(&out)?;
    Ok(())
}
