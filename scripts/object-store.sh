#!/usr/bin/env bash
# Is a cache in a store of objects as good as one in a folder? Builds and shards with a store that speaks the protocol of S3,
# and compares bundles and entries byte by byte: two shards at once, shards that are killed, objects that are damaged or cut
# off, a store that refuses, one that is away from the start, and one that goes away in the middle.
#
# `scripts/object-store.sh [N] [THRONG]`: kills N times (20), with a program that was built with the feature `object-store`
# (target/release/throng, or target/debug/throng). The store is moto, a stand-in for Amazon's: `pip install 'moto[server]'`;
# MOTO_SERVER names its program where it is not on the path. Without it, all is skipped.
# Prints a table, and exits 1 where anything was wrong.
set -euo pipefail
cd "$(dirname "$0")/.."
times=${1:-20}
throng=${2:-}
for built in target/release/throng target/debug/throng; do
    [ -n "$throng" ] || { [ ! -x "$built" ] || throng=$PWD/$built; }
done
[ -n "$throng" ] || { echo "build it first: cargo build --release --features object-store" >&2; exit 1; }
moto=${MOTO_SERVER:-$(command -v moto_server || true)}
[ -n "$moto" ] || { echo "skipped: no moto_server here (pip install 'moto[server]')"; exit 0; }
work=$(mktemp -d)
servers=()
trap 'for s in "${servers[@]}"; do kill "$s" 2> /dev/null || true; done; rm -rf "$work"' EXIT
cd "$work"
RANDOM=1
status=0

row() { # WHAT TRIED WRONG
    printf '%-44s %4d tried %4d wrong\n' "$1" "$2" "$3"
    [ "$3" -eq 0 ] || status=1
}

# A port that is free now.
port() { python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])'; }

# Starts a store, and waits until it answers; `server` is then its process.
start() { # PORT [NAME=VALUE]
    env "${@:2}" "$moto" -H 127.0.0.1 -p "$1" > "moto-$1.log" 2>&1 &
    server=$!
    servers+=("$server")
    for _ in $(seq 100); do
        ! curl -s -o /dev/null "http://127.0.0.1:$1/" || return 0
        sleep 0.2
    done
    echo "moto does not start: $(cat "moto-$1.log")" >&2
    exit 1
}

# A request that the store accepts.
signed() { curl -sf --aws-sigv4 aws:amz:us-east-1:s3 --user testing:testing "$@"; }

first=$(port)
start "$first"
export AWS_ENDPOINT_URL=http://127.0.0.1:$first AWS_ALLOW_HTTP=true AWS_REGION=us-east-1
export AWS_ACCESS_KEY_ID=testing AWS_SECRET_ACCESS_KEY=testing
bucket=$AWS_ENDPOINT_URL/motion
curl -sf -X PUT -o /dev/null "$bucket"
cache=s3://motion/walks/cache

"$throng" synth --minutes 2 --out clips > /dev/null 2>&1
cat > small.toml << 'TOML'
name = "small"
inputs = ["clips"]
[policy]
compare_samples = 100
[[behaviours]]
name = "approach"
grid = { rings = 6, angles = 8, radius = 6.0, inner_spacing = 0.5 }
TOML
build() { "$throng" build small.toml --out "$1" --cache "$2"; }
shard() { "$throng" bake small.toml --shard "$1" --cache "$2" --json; }
build whole.throng folder > /dev/null 2>&1

# Empties the store.
clear() { "$throng" cache clear --cache $cache > /dev/null; }

# Compares what the store keeps with the folder: how many entries differ, are missing, or are too many.
differ() {
    local wrong=0 entry
    for entry in folder/*; do
        # The report of a policy says how long it took.
        case $entry in */policy-*) continue ;; esac
        signed "$bucket/walks/cache/$(basename "$entry")" | cmp -s - "$entry" || wrong=$((wrong + 1))
    done
    [ "$("$throng" cache --cache $cache --json | python3 -c 'import json, sys; print(json.load(sys.stdin)["entries"])')" -eq \
        "$(ls folder | wc -l)" ] || wrong=$((wrong + 1))
    echo $wrong
}

# A build that fills the store, and one that finds all.
wrong=0
build out.throng $cache > /dev/null 2>&1 && cmp -s out.throng whole.throng || wrong=$((wrong + 1))
[ "$(differ)" -eq 0 ] || wrong=$((wrong + 1))
rm out.throng
"$throng" build small.toml --out out.throng --cache $cache --json > second.json 2> /dev/null || wrong=$((wrong + 1))
cmp -s out.throng whole.throng || wrong=$((wrong + 1))
python3 -c 'import json, sys; sys.exit(json.load(open("second.json"))["cached"] != ["motion", "graph", "policy"])' ||
    wrong=$((wrong + 1))
row "builds, entries as in a folder" 2 $wrong

# Two shards at once, each twice.
wrong=0
few=3
for ((i = 0; i < few; i++)); do
    clear
    for _ in 1 2; do
        shard 0/2 $cache > 0.json 2>&1 &
        other=$!
        shard 1/2 $cache > 1.json 2>&1 || wrong=$((wrong + 1))
        wait $other || wrong=$((wrong + 1))
    done
    grep -q '"done": true' 0.json && grep -q '"done": true' 1.json || wrong=$((wrong + 1))
    build out.throng $cache > /dev/null 2>&1 && cmp -s out.throng whole.throng || wrong=$((wrong + 1))
    [ "$(differ)" -eq 0 ] || wrong=$((wrong + 1))
done
row "two shards at once" $few $wrong

# Shards and builds that are killed at a random moment, and run again.
wrong=0
for ((i = 0; i < times; i++)); do
    clear
    if [ $((i % 2)) -eq 0 ]; then shard 0/2 $cache > /dev/null 2>&1 & else build out.throng $cache > /dev/null 2>&1 & fi
    killed=$!
    sleep "$(awk -v r=$RANDOM 'BEGIN { printf "%.3f", 2 * r / 32768 }')"
    kill -9 $killed 2> /dev/null || true
    wait $killed 2> /dev/null || true
    rm -f out.throng
    shard 0/2 $cache > /dev/null 2>&1 && shard 1/2 $cache > /dev/null 2>&1 || wrong=$((wrong + 1))
    build out.throng $cache > /dev/null 2>&1 && cmp -s out.throng whole.throng || wrong=$((wrong + 1))
    [ "$(differ)" -eq 0 ] || wrong=$((wrong + 1))
done
row "killed, and run again" "$times" $wrong

# Objects that are cut off or damaged count as absent, and are made anew.
wrong=0
entries=(folder/*)
for ((i = 0; i < times; i++)); do
    entry=${entries[$((RANDOM % ${#entries[@]}))]}
    size=$(stat -c %s "$entry")
    cp "$entry" damaged
    if [ $((i % 2)) -eq 0 ]; then
        truncate -s $((size * (RANDOM % 1000) / 1000)) damaged
    else
        printf "\\x$(printf %x $((RANDOM % 256)))" |
            dd of=damaged bs=1 seek=$(((RANDOM * 32768 + RANDOM) % size)) conv=notrunc status=none
    fi
    signed -X PUT -o /dev/null --data-binary @damaged "$bucket/walks/cache/$(basename "$entry")"
    rm -f out.throng
    build out.throng $cache > /dev/null 2>&1 && cmp -s out.throng whole.throng || wrong=$((wrong + 1))
done
row "objects cut off or damaged" "$times" $wrong

# What is refused says so, and no bundle is written.
refused() { # WHAT WANTED COMMAND...
    local what=$1 wanted=$2 wrong=0 code=0 message
    shift 2
    rm -f out.throng
    message=$("$@" 2>&1 > /dev/null) || code=$?
    [ $code -eq 1 ] && grep -q "^error: .*$wanted" <<< "$message" && [ ! -e out.throng ] || wrong=1
    [ $wrong -eq 0 ] || echo "$message"
    row "$what" 1 $wrong
}
refused "no such bucket" "Make the bucket first" build out.throng s3://nowhere/cache
refused "an address without a bucket" "expected s3://BUCKET/PREFIX" build out.throng s3://
second=$(port)
start "$second" INITIAL_NO_AUTH_ACTION_COUNT=0
refused "a store that refuses" "Check AWS_ACCESS_KEY_ID" \
    env AWS_ENDPOINT_URL="http://127.0.0.1:$second" "$throng" build small.toml --out out.throng --cache $cache
refused "a store that is away" "Check AWS_ENDPOINT_URL" \
    env AWS_ENDPOINT_URL="http://127.0.0.1:$(port)" "$throng" build small.toml --out out.throng --cache $cache

# The store goes away in the middle: a build says so and goes on without, a shard fails.
wrong=0
clear
build out.throng $cache > /dev/null 2> away.txt &
building=$!
while kill -0 $building 2> /dev/null && ! curl -s "$bucket?list-type=2&prefix=walks/cache/import-" | grep -q '<Key>'; do
    sleep 0.02
done
kill "${servers[0]}"
wait $building && cmp -s out.throng whole.throng && grep -q '^warning: .*not all is cached' away.txt || wrong=1
row "a build whose store goes away" 1 $wrong
exit $status
