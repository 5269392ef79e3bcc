#!/usr/bin/env bash
# Which licences come with the programs? Writes THIRD-PARTY.md anew with cargo-about, or compares it with `--check`.
#
# `scripts/third-party.sh [--check]`; needs `cargo install --locked --features cli cargo-about`, settings are in about.toml. Whatever is
# there, every crate that goes into `throng` and `throng-viewer` has to be named; exits 1 where one is not.
set -euo pipefail
cd "$(dirname "$0")/.."
out=THIRD-PARTY.md
if [ "${1:-}" != --check ]; then
    command -v cargo-about > /dev/null || { echo "install it first: cargo install --locked --features cli cargo-about" >&2; exit 2; }
    made=$(mktemp)
    trap 'rm -f "$made"' EXIT
    # The workspace is what the two programs are made of.
    cargo about generate --locked --workspace --fail about.hbs > "$made"
    cat "$made" > "$out"
fi
missing=$(for program in throng throng-viewer; do
    cargo tree --locked -q -p $program -e normal --prefix none --format '{p}'
done | grep -v '(/' | awk '{ sub(/^v/, "", $2); print $1 " " $2 }' | sort -u | while read -r crate; do
    grep -qF -- "- $crate" "$out" || echo "$crate"
done)
if [ -n "$missing" ]; then
    printf '%s does not name:\n%s\nwrite it anew: scripts/third-party.sh\n' "$out" "$missing" >&2
    exit 1
fi
echo "$out names every crate of the programs"
