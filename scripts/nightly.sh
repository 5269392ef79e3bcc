#!/usr/bin/env bash
# What takes too long for every change: long tests, what scenes expect, the tests of research, and of the engines that crowds are compared with.
# Stops at the first failure.
set -euo pipefail
cd "$(dirname "$0")/.."
root=$PWD
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$root/target}"
export PROPTEST_RNG_SEED="${PROPTEST_RNG_SEED:-2007}"

echo "== advisories"
scripts/advisories.sh || [ $? -eq 2 ]

echo "== long tests"
cargo test --test all -- --ignored

echo "== scenes"
for scene in data/scenes/*.toml; do
    cargo run --release -p throng -- check "$scene" --run --seeds 5
done

echo "== research"
cargo test --manifest-path research/Cargo.toml

echo "== fixed steps"
cargo test -p throng-crowd --features fixed-steps
cargo test -p throng-simulation --features fixed-steps --lib
