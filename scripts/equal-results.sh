#!/usr/bin/env bash
# Are results the same everywhere? Compares the bytes of a bundle and the hashes of states at 1, 2 and 8 threads, of debug
# and release builds, of builds for this very processor, from two folders, and on an emulated processor without AVX2.
#
# `scripts/equal-results.sh [VARIANT ...]` with some of debug, release, native, folder, emulated; all of them by default.
# Builds go to target/equal-results; prints a table, and exits 1 where anything differs.
set -euo pipefail
cd "$(dirname "$0")/.."
root=$PWD out=$PWD/target/equal-results
variants=("$@")
[ ${#variants[@]} -gt 0 ] || variants=(debug release native folder emulated)
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

first=
status=0
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
    *)
        echo "expected debug, release, native, folder or emulated, found $variant" >&2
        exit 2 ;;
    esac
    compare "$variant" "$file"
done
exit $status
