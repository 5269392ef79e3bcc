//! `throng selftest`: a short self-test on this machine.

use crate::args::{CacheArgs, CommandResult};
use crate::{keys, output, progress};
use throng_checks::selftest::{self, SelftestConfig, SelftestReport};
use throng_core::base::error::ensure;

/// Check this build on this machine in about a minute: equal bytes and states at any number of threads, damaged input,
/// a short soak.
#[derive(clap::Args)]
#[command(after_long_help = keys::json_keys::<SelftestReport>())]
pub struct Args {
    /// Mutants of good files for every reader.
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..=100_000_000))]
    mutants: u64,
    /// Seed of everything random.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    cache: CacheArgs,
    /// Print one JSON object; `throng help keys` lists its keys.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> CommandResult {
    let config = SelftestConfig { mutants: args.mutants, seed: args.seed, ..SelftestConfig::default() };
    let folder = progress::ScratchFolder::new()?;
    let report = crate::run::with_build_context(&args.cache, |with| selftest::selftest(&config, folder.path(), with))?;
    if args.json {
        output::json(&report)?;
    } else {
        for check in &report.checks {
            let mark = if check.ok { "ok" } else { "FAILED" };
            output::text(format!("{mark:6}  {}: {} ({:.1} s)\n", check.name, check.found, check.seconds))?;
        }
        output::text(format!("{} checked, {} failed, {:.1} s\n", report.checked, report.failed, report.seconds))?;
    }
    ensure(report.failed == 0, || format!("{} of {} checks failed", report.failed, report.checked))?;
    Ok(())
}
