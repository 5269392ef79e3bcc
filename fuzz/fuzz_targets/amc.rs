//! An ASF skeleton and an AMC motion in one input: read, and roles, units, axes and rest pose found.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use throng_fuzz::ASF_AMC_SEAM;
use throng_precompute::import::{self, ImportConfig, amc, asf};

fuzz_target!(|data: &[u8]| {
    let seam = data.windows(ASF_AMC_SEAM.len()).position(|w| w == ASF_AMC_SEAM);
    let (skeleton, motion) = match seam {
        Some(at) => (&data[..at], &data[at + ASF_AMC_SEAM.len()..]),
        None => (data, &b""[..]),
    };
    let Ok(skeleton) = asf::parse(skeleton, Path::new("fuzz.asf")) else { return };
    if let Ok(source) = amc::parse(motion, Path::new("fuzz.amc"), &skeleton) {
        let _ = import::interpret(source, &ImportConfig::default(), &[]);
    }
});
