#![no_main]
libfuzzer_sys::fuzz_target!(|data: &[u8]| drop(throng_precompute::damage::readers::fbx(data)));
