//! `boxing`: the figures of Lee and Lee (2004) beside those of a build.

use crate::args::{CacheArgs, CommandResult};
use crate::{output, progress};
use std::path::PathBuf;
use throng_precompute::config::BuildConfig;
use throng_precompute::files;
use throng_precompute::pipeline;
use throng_research::paper::{compare_with_paper, markdown};

/// Bake a config with hits, and set its figures beside those of Lee and Lee (2004), section 6.
#[derive(clap::Args)]
pub struct Args {
    /// Config (`.toml`).
    #[arg(value_name = "CONFIG", default_value = "data/boxing.toml")]
    config: PathBuf,
    /// Bundle to write; it goes with a temporary folder where absent.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Write the figures as Markdown.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    #[command(flatten)]
    cache: CacheArgs,
}

pub fn run(args: &Args) -> CommandResult {
    files::check_targets(&args.report, [&args.config].into_iter().chain(&args.out))?;
    let folder = progress::ScratchFolder::new()?;
    let out = args.out.clone().unwrap_or_else(|| folder.path().join("boxing.throng"));
    let config = BuildConfig::load(&args.config)?;
    let bar = progress::BuildProgressBar::on_interrupt(args.cache.folder());
    let built = pipeline::build(&config, &out, &args.cache.cache()?, &bar);
    drop(bar);
    let built = built.map_err(|e| e.in_file(&args.config))?;
    output::warnings(&built.skipped, &built.warnings);
    if let Some(path) = &args.report {
        let text = markdown(&built);
        files::write_atomically(path, |w| w.write_all(text.as_bytes()))?;
    }
    let lines = compare_with_paper(&built);
    let heads = std::iter::once(["", "Lee and Lee 2004", "this build"]);
    output::columns(heads.chain(lines.iter().map(|l| [&*l.figure, l.paper, &*l.here])))
}
