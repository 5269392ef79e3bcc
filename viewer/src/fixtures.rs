//! Bundles, scenes and motion that tests are made with.

#[path = "../tests/common/boxing.rs"]
pub(crate) mod boxing;

#[path = "../tests/common/market.rs"]
pub(crate) mod market;

#[path = "../tests/common/meeting.rs"]
pub(crate) mod meeting;

#[path = "../../tests/common/mocap.rs"]
pub(crate) mod mocap;

#[path = "../tests/common/paces.rs"]
pub(crate) mod paces;

#[path = "../tests/common/square.rs"]
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
