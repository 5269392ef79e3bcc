#!/usr/bin/env bash
# Do the crates that Throng is built from have known faults? Asks the RustSec database, and prints of which day its copy is.
#
# `scripts/advisories.sh [DATABASE]`: a clone of the database, which is not changed; else a copy is fetched. Needs `cargo install
# --locked cargo-deny`. deny.toml lists the advisories that are known, with reasons. Exits 1 where there is another one, and 2 where
# nothing was checked.
set -euo pipefail
cd "$(dirname "$0")/.."
from=${1:-}
not_checked() {
    echo "advisories were NOT checked: $1" >&2
    exit 2
}
command -v cargo-deny > /dev/null || not_checked "cargo-deny is not there (cargo install --locked cargo-deny)"
command -v git > /dev/null || not_checked "git is not there"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
host=https://github.com/rustsec/advisory-db
url=${from:-$host}
GIT_TERMINAL_PROMPT=0 timeout 120 git clone -q "$url" "$work/db" 2> "$work/why" ||
    not_checked "no copy of the database from $url: $(tail -1 "$work/why")"
day=$(git -C "$work/db" log -1 --format=%cs)
[ -n "$day" ] && [ -d "$work/db/crates" ] || not_checked "$url is no database of advisories"
oldest=$(date -d '90 days ago' +%F 2> /dev/null || date -v-90d +%F)
[[ ! $day < $oldest ]] || not_checked "the copy of the database is of $day, more than 90 days old"
echo "database of $day, commit $(git -C "$work/db" rev-parse --short HEAD)"

# cargo-deny takes databases from hosts alone, on this branch: git gives it the copy in place of the host's.
git -C "$work/db" checkout -q -B main
export GIT_CONFIG_COUNT=1 GIT_CONFIG_KEY_0="url.file://$work/db.insteadOf" GIT_CONFIG_VALUE_0=$host
keys="db-path = \"$work/own\"\ndb-urls = [\"$host\"]\ngit-fetch-with-cli = true"
sed "s|^\[advisories\]|&\n$keys|" deny.toml > "$work/deny.toml"
out=$(cargo deny --workspace --config "$work/deny.toml" check advisories 2>&1) && { echo "$out"; exit 0; }
echo "$out" >&2
# It has not come as far as a verdict.
grep -q '^advisories FAILED' <<< "$out" || not_checked "cargo-deny failed"
exit 1
