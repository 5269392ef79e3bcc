#!/usr/bin/env bash
# Is unsafe code sound? Runs tests of the runtime under Miri and under AddressSanitizer.
#
# `scripts/unsafe.sh [miri] [asan]`; both by default. Says what is skipped, and exits 1 where anything was found.
#
# Miri runs what neither maps files nor uses AVX2: the file format, base, policies and blending on arrays. `MIRI_TESTS`
# names other tests.
set -uo pipefail
cd "$(dirname "$0")/.."
parts=("$@")
[ ${#parts[@]} -gt 0 ] || parts=(miri asan)
status=0
for part in "${parts[@]}"; do
    case $part in
    miri)
        if ! cargo +nightly miri --version > /dev/null 2>&1; then
            echo "miri: skipped: there is no nightly toolchain with Miri (rustup +nightly component add miri)"
            continue
        fi
        # Miri would make arithmetic inexact at random, and reads no assembly.
        export MIRIFLAGS="-Zmiri-disable-isolation -Zmiri-permissive-provenance -Zmiri-deterministic-floats" PROPTEST_CASES=2
        for tests in ${MIRI_TESTS:-throng-base:snapshot throng-base:checksum throng-base:frame:: throng-base:simd throng-core:format:: throng-core:policy:: throng-core:blend::}; do
            crate=${tests%%:*} filter=${tests#*:}
            soft=throng-base/soft-floats
            [ "$crate" != throng-base ] || soft=soft-floats
            log=$(timeout "${MIRI_SECONDS:-3600}" cargo +nightly miri test -q -p "$crate" --lib --features "$soft" -- "$filter" 2>&1)
            code=$?
            case $code in
            0) echo "miri: $crate $filter: $(grep -o '[0-9]* passed' <<< "$log" | head -1)" ;;
            124) echo "miri: $crate $filter: skipped: it takes more than ${MIRI_SECONDS:-3600} s" ;;
            *) echo "miri: $crate $filter: FOUND"; grep -E "^error|Undefined Behavior|panicked|test result" <<< "$log" | head -10; status=1 ;;
            esac
        done ;;
    asan)
        host=$(rustc -vV | sed -n 's/^host: //p')
        # Unoptimised, as optimising a kernel with these checks takes ten minutes; its locals then need a larger stack than threads have.
        for crate in ${ASAN_CRATES:-throng-core throng-crowd}; do
            log=$(RUSTC_BOOTSTRAP=1 RUSTFLAGS=-Zsanitizer=address CARGO_PROFILE_DEV_DEBUG=0 CARGO_PROFILE_DEV_OPT_LEVEL=0 \
                RUST_MIN_STACK=67108864 ASAN_OPTIONS=detect_leaks=0 \
                cargo test -q -p "$crate" --lib --target "$host" --target-dir target/asan 2>&1)
            if [ $? -eq 0 ]; then
                echo "asan: $crate: $(grep -o '[0-9]* passed' <<< "$log" | head -1)"
            else
                echo "asan: $crate: FOUND"
                grep -E "^error|AddressSanitizer|panicked|test result" <<< "$log" | head -10
                status=1
            fi
        done ;;
    *) echo "expected miri or asan, found $part" >&2; exit 2 ;;
    esac
done
exit $status
