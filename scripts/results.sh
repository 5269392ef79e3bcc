#!/usr/bin/env bash
# Measures what docs/results.md claims: runs each of its commands, and writes what it prints to docs/results/NAME.json.
#
# `scripts/results.sh [PROGRAM [NAME ...]]`: the program is target/release/throng where none is given; with names, only those
# files are written. Times mean something where nothing else runs; it takes about ten minutes on two cores.
# Bundles, worlds and pictures go to target/results.
set -euo pipefail
cd "$(dirname "$0")/.."
root=$PWD
program=$(realpath "${1:-target/release/throng}")
shift || true
wanted=" $* "
[ -x "$program" ] || { echo "there is no $program: cargo build --release" >&2; exit 1; }
mkdir -p docs/results target/results
cd target/results
rm -rf data
cp -r "$root/data" data

measure() { # NAME ARGUMENT...
    local name=$1 start=$SECONDS
    shift
    [ "$wanted" = "  " ] || [[ $wanted == *" $name "* ]] || return 0
    printf '%-14s throng %s ... ' "$name" "$*"
    if ! "$program" "$@" --json > "$name.json" 2> "$name.log"; then
        echo "failed:"
        tail -5 "$name.log"
        exit 1
    fi
    mv "$name.json" "$root/docs/results/"
    echo "$((SECONDS - start)) s"
}

[ -e demo.throng ] || "$program" demo > demo.log 2>&1
measure demo demo
measure bundle bench bundle demo.throng
measure detail bench bundle demo.throng --lod --characters 1000,10000
measure motion bench motion demo.throng
measure targets run demo.throng
measure unaware run demo.throng --no-avoid
for scene in target pair 30; do
    measure "boxing-$scene" run "data/scenes/boxing-$scene.toml" --seconds 60
done
measure office run data/scenes/office.toml --seconds 60
measure logo run data/scenes/logo.toml --seconds 20
measure walkers run data/scenes/blend-walkers.toml
measure crowd bench crowd --scene all --agents 1000 --seconds 15
measure crowd-many bench crowd --scene corridor,circle --agents 1000,100000 --seconds 4
measure scenario bench scenario
measure museum run data/scenes/museum.toml
measure tea run data/scenes/tea.toml
measure plan bench plan --seeds 30 --recheck 0 --poses 10000
measure selftest selftest

cd "$root"
{
    printf '{\n  "processor": "%s",\n' "$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)"
    printf '  "cores": %s,\n  "rust": "%s",\n' "$(nproc)" "$(rustc --version)"
    printf '  "commit": "%s"\n}\n' "$(git rev-parse --short HEAD)"
} > docs/results/machine.json
