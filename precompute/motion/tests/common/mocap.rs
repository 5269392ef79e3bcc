//! Where recordings are.

use std::path::{Path, PathBuf};

/// A file or a folder of the recordings beside the repository, or in `THRONG_MOCAP`; `None` with a word on standard error
/// where it is absent.
pub fn recording(name: &str) -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/mocap");
    let path = std::env::var_os("THRONG_MOCAP").map_or_else(beside, PathBuf::from).join(name);
    if path.exists() {
        return Some(path);
    }
    eprintln!("skipped: no recordings at {}; set THRONG_MOCAP to their folder", path.display());
    None
}
