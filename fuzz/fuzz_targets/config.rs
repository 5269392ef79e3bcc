//! The TOML files people write: build configs, sidecar files, skeleton profiles.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use throng_precompute::config::BuildConfig;
use throng_precompute::import::profile::Profile;

fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else { return };
    if let Ok(config) = BuildConfig::parse(text, Path::new("fuzz.toml")) {
        let written = config.to_toml().expect("what was read can be written");
        BuildConfig::parse(&written, Path::new("written.toml")).expect("what was written can be read");
    }
    let _ = Profile::parse(text, Path::new("profile.toml"));
});
