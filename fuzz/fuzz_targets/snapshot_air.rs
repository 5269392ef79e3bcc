#![no_main]
libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let _ = throng_checks::damage::readers::snapshot_air(data);
});
