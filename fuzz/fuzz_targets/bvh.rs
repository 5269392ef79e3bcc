//! A BVH file: read, and its roles, units, axes and rest pose found.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use throng_precompute::import::{self, ImportConfig, bvh};

fuzz_target!(|data: &[u8]| {
    if let Ok(source) = bvh::parse(data, Path::new("fuzz.bvh")) {
        let _ = import::interpret(source, &ImportConfig::default(), &[]);
    }
});
