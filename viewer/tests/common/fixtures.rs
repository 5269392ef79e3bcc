//! Bundles, scenes and motion that tests are made with.

#[path = "boxing.rs"]
pub(crate) mod boxing;

#[path = "market.rs"]
pub(crate) mod market;

#[path = "meeting.rs"]
pub(crate) mod meeting;

#[path = "../../../tests/common/mocap.rs"]
pub(crate) mod mocap;

#[path = "paces.rs"]
pub(crate) mod paces;

#[path = "square.rs"]
pub(crate) mod square;

use crate::bundle::OpenBundle;
use crate::document::OngoingBuild;
use std::path::{Path, PathBuf};
use throng_core::format::VERSION;
use throng_precompute::run::BuildContext;

/// The bundle of the current version that every checkout has.
pub(crate) fn golden_path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../data/golden/tables_v{VERSION}.throng"))
}

/// The bundle that is always there.
pub(crate) fn golden() -> OpenBundle {
    OpenBundle::open(&golden_path()).unwrap()
}

/// Runs an opening function without any report.
pub(crate) fn quietly<T>(open: impl FnOnce(&BuildContext<'_>) -> T) -> T {
    OngoingBuild::default().run_with_cache(open)
}
