#!/usr/bin/env bash
# Builds and tests the plugin for Bevy, which is a workspace of its own: format, tests, lints, and a picture of a crowd.
#
#   scripts/bevy.sh [PICTURE.png]
#
# By hand before a release: Bevy takes a quarter of an hour to build on two cores. With PICTURE.png, what is drawn is tested,
# too, on a GPU or Mesa's software adapter.
set -euo pipefail
cd "$(dirname "$0")/../bevy"
cargo fmt --check
cargo test
cargo clippy --all-targets -- -D warnings
bundle="$(ls ../data/golden/tables_v*.throng | sort -V | tail -1)"
if [ -n "${1:-}" ]; then
    cargo test --test picture -- --ignored --test-threads 1
    cargo run --example crowd -- "$bundle" --people 2000 --seconds 6 --png "$1"
fi
