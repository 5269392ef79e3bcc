#!/usr/bin/env bash
# Are results the same everywhere? Compares the bytes of a bundle and the hashes of states at 1, 2 and 8 threads, of debug
# and release builds, of builds for this very processor, from two folders, on an emulated processor without AVX2, and of the
# runtime alone on aarch64, on wasm, and built with the engines that crowds are compared with.
#
# `scripts/equal-results.sh [VARIANT ...]` with some of debug, release, native, folder, emulated, aarch64, wasm, engines; all
# of them by default.
# Builds go to target/equal-results; prints a table, and exits 1 where anything differs.
set -euo pipefail
cd "$(dirname "$0")/.."
root=$PWD out=$PWD/target/equal-results
variants=("$@")
[ ${#variants[@]} -gt 0 ] || variants=(debug release native folder emulated aarch64 wasm engines)
mkdir -p "$out"

# Names of checks with the hashes that they found, one a line; seconds do not count.
results() {
    "$@" selftest --no-cache --mutants 1 --json | python3 -c '
import json, sys
for c in json.load(sys.stdin)["checks"]:
    if c["name"].startswith(("a bundle has", "equal states")):
        print(c["name"], "|", c["found"])
        if not c["ok"]:
            sys.exit("threads differ: " + c["name"])'
}

# Hashes of states that the runtime alone comes to, built for a target, with what runs it.
runtime() { # TARGET RUNNER...
    local target=$1
    shift
    cargo build -q -p throng-simulation --example state_hashes ${FEATURES:-} --target "$target"
    "$@" "$root/target/$target/debug/examples/state_hashes${SUFFIX:-}" all 300 "$out/made"
}
# The same here, once.
runtime_here() {
    local host
    host=$(rustc -vV | sed -n 's/^host: //p')
    [ -s "$out/runtime.txt" ] || runtime "$host" env > "$out/runtime.txt"
}
# Bundles are made here for all: what is compared is the runtime.
rm -rf "$out/runtime.txt" "$out/made"
mkdir -p "$out/made"
has_target() { rustc --print sysroot | xargs -I{} test -d "{}/lib/rustlib/$1/lib"; }

first=
status=0
elsewhere() { # NAME FILE
    if cmp -s "$out/runtime.txt" "$2"; then
        printf '%-10s equal (%s scenes of the runtime)\n' "$1" "$(wc -l < "$2")"
    else
        printf '%-10s DIFFERS\n' "$1"
        diff "$out/runtime.txt" "$2" | head -20 || true
        status=1
    fi
}
compare() { # NAME FILE
    if [ -z "$first" ]; then
        first=$2
        printf '%-10s %s results, the others are compared with these\n' "$1" "$(wc -l < "$2")"
    elif cmp -s "$first" "$2"; then
        printf '%-10s equal\n' "$1"
    else
        printf '%-10s DIFFERS\n' "$1"
        diff "$first" "$2" | head -20 || true
        status=1
    fi
}

for variant in "${variants[@]}"; do
    file=$out/$variant.txt
    case $variant in
    debug)
        cargo build -q -p throng
        results "$root/target/debug/throng" > "$file" ;;
    release)
        cargo build -q --release -p throng
        results "$root/target/release/throng" > "$file" ;;
    native)
        RUSTFLAGS="-C target-cpu=native" cargo build -q --release -p throng --target-dir "$out/native"
        results "$out/native/release/throng" > "$file" ;;
    folder)
        # The same sources from another folder, with paths of their own.
        rm -rf "$out/elsewhere/sources"
        mkdir -p "$out/elsewhere/sources"
        git ls-files -z | xargs -0 cp --parents -t "$out/elsewhere/sources"
        (cd "$out/elsewhere/sources" && cargo build -q -p throng --target-dir "$out/elsewhere/target")
        (cd "$out/elsewhere" && results "$out/elsewhere/target/debug/throng") > "$file" ;;
    emulated)
        if ! command -v qemu-x86_64 > /dev/null; then
            printf '%-10s skipped: there is no qemu-x86_64 (package qemu-user)\n' "$variant"
            continue
        fi
        binary=$root/target/release/throng
        [ -x "$binary" ] || binary=$root/target/debug/throng
        results qemu-x86_64 -cpu Nehalem "$binary" > "$file" ;;
    aarch64)
        target=aarch64-unknown-linux-gnu
        if ! { has_target $target && command -v qemu-aarch64 && command -v aarch64-linux-gnu-gcc; } > /dev/null; then
            printf '%-10s skipped: it needs rustup target add %s and the packages qemu-user, %s\n' "$variant" $target \
                "gcc-aarch64-linux-gnu, libc6-dev-arm64-cross"
            continue
        fi
        runtime_here
        CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc \
            runtime $target qemu-aarch64 -L /usr/aarch64-linux-gnu > "$file"
        elsewhere "$variant" "$file"
        continue ;;
    wasm)
        if ! { has_target wasm32-wasip1 && command -v node; } > /dev/null; then
            printf '%-10s skipped: it needs rustup target add wasm32-wasip1, and node\n' "$variant"
            continue
        fi
        runtime_here
        SUFFIX=.wasm runtime wasm32-wasip1 node --no-warnings scripts/wasi.mjs > "$file"
        elsewhere "$variant" "$file"
        continue ;;
    engines)
        # What is there to compare with changes nothing else: a snapshot of one build is read by the other.
        runtime_here
        FEATURES="--features fixed-steps" runtime "$(rustc -vV | sed -n 's/^host: //p')" env > "$file"
        elsewhere "$variant" "$file"
        continue ;;
    *)
        echo "expected debug, release, native, folder, emulated, aarch64, wasm or engines, found $variant" >&2
        exit 2 ;;
    esac
    compare "$variant" "$file"
done
exit $status
