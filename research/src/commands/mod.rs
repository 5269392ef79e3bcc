//! The subcommands.

pub mod blend;
pub mod boxing;
pub mod crowd;
pub mod people;
pub mod plan;
pub mod quality;
pub mod steering;
pub mod world;

use crate::args::CacheArgs;
use crate::{output, progress};
use throng_precompute::error::BuildError;
use throng_precompute::run::BuildContext;

/// Makes something with the cache, a progress bar, and messages on standard error.
fn with<T>(cache: &CacheArgs, make: impl FnOnce(&BuildContext<'_>) -> T) -> Result<T, BuildError> {
    let (cache, progress) = (cache.cache()?, progress::BuildProgressBar::on_interrupt(cache.folder()));
    Ok(make(&BuildContext { cache: &cache, progress: &progress, report_news: &|news| output::print_to_stderr(news) }))
}
