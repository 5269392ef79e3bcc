//! Where recordings are.

use std::path::{Path, PathBuf};

/// A file or a folder of the recordings: in `THRONG_MOCAP`, or in `shared/mocap` beside the repository; `None` with a word on standard
/// error where it is absent.
pub fn recording(name: &str) -> Option<PathBuf> {
    let mut above = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().map(|a| a.join("shared/mocap"));
    let folder = std::env::var_os("THRONG_MOCAP").map(PathBuf::from).or_else(|| above.find(|f| f.is_dir()));
    let path = folder.map(|f| f.join(name)).filter(|p| p.exists());
    if path.is_none() {
        eprintln!("skipped: the recordings (`{name}`) are absent; set THRONG_MOCAP to their folder");
    }
    path
}
