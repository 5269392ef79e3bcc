#!/usr/bin/env bash
# What is left when things go wrong? Kills builds, stitches and runs at random moments, lets writing fail at a file size,
# fills the disk, damages the cache, lets clocks differ and folders be slow, and runs two builds at once. After each, the
# output must be absent or whole, and a further build must give the same bytes as an undisturbed one.
#
# `scripts/faults.sh [N] [THRONG]`: N times each (500), with a program (target/release/throng, or target/debug/throng).
# Kills count where they ended the program, and go on until there are N.
# Prints a table, and exits 1 where anything was wrong.
set -euo pipefail
cd "$(dirname "$0")/.."
times=${1:-500}
throng=${2:-}
for built in target/release/throng target/debug/throng; do
    [ -n "$throng" ] || { [ ! -x "$built" ] || throng=$PWD/$built; }
done
[ -n "$throng" ] || { echo "build it first: cargo build --release" >&2; exit 1; }
units=$PWD/data/units/playground.toml
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
RANDOM=1
status=0

cat > small.toml << 'TOML'
name = "small"
synth = { set = "walk", minutes = 1.0 }
[resample]
mirror = true
[policy]
compare_samples = 100
[[behaviours]]
name = "approach"
grid = { rings = 6, angles = 8, radius = 6.0, inner_spacing = 0.5 }
TOML
cat > tiles.toml << TOML
name = "tiles"
behaviours = []
synth = { set = "walk", minutes = 3.0 }
[resample]
mirror = true
[graph]
enabled = false
[patches]
units = "$units"
[[patches.tiles]]
unit = "ground"
TOML
cat > floor.toml << 'TOML'
bundle = "tiles.throng"
config = "tiles.toml"
[[place]]
unit = "ground"
at = [0, 0, 0]
repeat = [7, 1, 7]
step = [[2.8, 0, 0], [0, 0, 0], [0, 0, 2.8]]
TOML

build() { "$throng" build small.toml --out "$1" --cache "$2"; }
stitch() { "$throng" stitch floor.toml --out "$1" --cache cache; }
build whole.throng cache > /dev/null 2>&1
stitch whole.world > /dev/null 2>&1

row() { # WHAT TRIED INTERRUPTED WRONG
    printf '%-34s %6d tried %6d disturbed %4d wrong\n' "$1" "$2" "$3" "$4"
    [ "$4" -eq 0 ] || status=1
}

# Milliseconds that a command takes.
duration() {
    local begin
    begin=$(date +%s%N)
    "$@" > /dev/null 2>&1
    echo $((($(date +%s%N) - begin) / 1000000 + 1))
}

# Starts a command and kills it at a random moment; fails where it had ended before.
kill_once() { # MILLISECONDS COMMAND...
    local most=$1 pid code=0
    shift
    "$@" > /dev/null 2>&1 &
    pid=$!
    sleep "$(awk -v m="$most" -v r=$RANDOM 'BEGIN { printf "%.4f", m * r / 32768000 }')"
    kill -9 $pid 2> /dev/null || true
    wait $pid 2> /dev/null || code=$?
    [ $code -eq 137 ]
}

# Kills a command at random moments: its output is then absent or the whole one.
kills() { # WHAT WHOLE OUT COMMAND...
    local what=$1 whole=$2 out=$3 wrong=0 killed=0 tried=0 most
    shift 3
    most=$(duration "$@")
    while [ $killed -lt "$times" ] && [ $tried -lt $((4 * times)) ]; do
        rm -rf "$out" killed-cache
        tried=$((tried + 1))
        kill_once "$most" "$@" && killed=$((killed + 1))
        [ ! -e "$out" ] || cmp -s "$out" "$whole" || wrong=$((wrong + 1))
    done
    "$@" > /dev/null 2>&1 && cmp -s "$out" "$whole" || wrong=$((wrong + 1))
    row "$what" "$tried" "$killed" "$wrong"
}
kills "builds killed" whole.throng out.throng \
    "$throng" build small.toml --out out.throng --cache killed-cache
kills "stitches killed" whole.world out.world "$throng" stitch floor.toml --out out.world --cache cache
# A picture is whole or absent, too.
picture=("$throng" run whole.throng --characters 20 --seconds 2 --png out.png)
"${picture[@]}" > /dev/null 2>&1 && mv out.png whole.png
kills "recordings killed" whole.png out.png "${picture[@]}"

# Builds killed with one cache, which keeps what the killed ones left.
wrong=0 killed=0 tried=0 most=$(duration build out.throng shared-cache)
while [ $killed -lt "$times" ] && [ $tried -lt $((4 * times)) ]; do
    # Most of them begin with nothing: with a whole cache, a build is over in a moment.
    [ $((tried % 3)) -eq 2 ] || rm -rf shared-cache
    rm -f out.throng
    tried=$((tried + 1))
    kill_once "$most" "$throng" build small.toml --out out.throng --cache shared-cache && killed=$((killed + 1))
    build out.throng shared-cache > /dev/null 2>&1 && cmp -s out.throng whole.throng || wrong=$((wrong + 1))
done
row "builds after a killed one" "$tried" "$killed" "$wrong"

# No file may grow beyond some size: as on a full disk, writing fails in the middle.
wrong=0 failed=0 kb=$(($(stat -c %s whole.throng) / 1024))
few=$((times < 40 ? times : 40))
for ((i = 0; i < few; i++)); do
    rm -rf out.throng full-cache
    # The words come through a pipe, which has no size.
    if message=$( (trap '' XFSZ; ulimit -f $((kb * i / few)); build out.throng full-cache) 2>&1); then
        cmp -s out.throng whole.throng || wrong=$((wrong + 1))
    else
        failed=$((failed + 1))
        [ ! -e out.throng ] && grep -q "^error: " <<< "$message" || wrong=$((wrong + 1))
    fi
done
row "writing fails" "$few" "$failed" "$wrong"

# A disk that is full, for real: a tmpfs of a few pages, where the system lets us mount one.
wrong=0 failed=0 few=$((times < 20 ? times : 20))
mkdir -p disk
if unshare -rm mount -t tmpfs -o size=64k tmpfs disk 2> /dev/null; then
    for ((i = 0; i < few; i++)); do
        code=0
        message=$(unshare -rm bash -c "mount -t tmpfs -o size=$((4 + kb * i / few))k tmpfs disk
            '$throng' build small.toml --out disk/out.throng --no-cache 2>&1
            code=\$?
            [ \$code -eq 0 ] && { cmp -s disk/out.throng whole.throng || exit 99; }
            [ \$code -ne 0 ] && [ -n \"\$(ls -A disk)\" ] && exit 98
            exit \$code") || code=$?
        if [ $code -ne 0 ]; then
            failed=$((failed + 1))
            [ $code -eq 1 ] && grep -q "^error: .*disk/" <<< "$message" || wrong=$((wrong + 1))
        fi
    done
    row "the disk is full" "$few" "$failed" "$wrong"
else
    echo "the disk is full: skipped: no tmpfs can be mounted here (unshare -rm)"
fi

# The disk of the cache is full: a build goes on without and says so, a share of it fails and says so.
"$throng" synth --set walk --minutes 1 --out clips > /dev/null 2>&1
cat > files.toml << 'TOML'
name = "files"
inputs = ["clips"]
[policy]
compare_samples = 100
[[behaviours]]
name = "approach"
grid = { rings = 6, angles = 8, radius = 6.0, inner_spacing = 0.5 }
TOML
"$throng" build files.toml --out files.throng --no-cache > /dev/null 2>&1
wrong=0 failed=0 few=$((times < 20 ? times : 20))
if unshare -rm mount -t tmpfs -o size=64k tmpfs disk 2> /dev/null; then
    for ((i = 0; i < few; i++)); do
        code=0
        unshare -rm bash -c "mount -t tmpfs -o size=$((4 + 6000 * i / few))k tmpfs disk
            '$throng' build files.toml --out out.throng --cache disk/cache > messages.txt 2>&1 || exit 99
            cmp -s out.throng files.throng || exit 98
            grep -q '^warning: .*cached' messages.txt || exit 0
            rm -rf disk/cache
            '$throng' bake files.toml --shard 0/1 --cache disk/cache > messages.txt 2>&1 && exit 0
            grep -q '^error: .*disk/cache' messages.txt && exit 1 || exit 97" || code=$?
        [ $code -eq 0 ] || failed=$((failed + 1))
        [ $code -le 1 ] || wrong=$((wrong + 1))
    done
    row "the disk of the cache is full" "$few" "$failed" "$wrong"
else
    echo "the disk of the cache is full: skipped: no tmpfs can be mounted here (unshare -rm)"
fi

# Shares at once, with what a command puts before each; then a build.
shares() { # FIRST SECOND: words before the program
    rm -rf shared-cache out.throng
    for _ in 1 2; do
        $1 "$throng" bake files.toml --shard 0/2 --cache shared-cache > /dev/null 2>&1 &
        local other=$!
        $2 "$throng" bake files.toml --shard 1/2 --cache shared-cache > /dev/null 2>&1 || return 1
        wait $other || return 1
    done
    $1 "$throng" build files.toml --out out.throng --cache shared-cache --json 2> /dev/null > report.json || return 1
    grep -q '"files_kept": 0' report.json && return 1
    cmp -s out.throng files.throng
}

# Clocks that differ by days, and a folder that is slow: each call that opens, renames or removes a file waits 20 ms.
few=$((times < 10 ? times : 10))
if command -v faketime > /dev/null; then
    wrong=0
    for ((i = 0; i < few; i++)); do
        shares "faketime -f -$((RANDOM % 9))d" "faketime -f +$((RANDOM % 9))d" || wrong=$((wrong + 1))
    done
    row "clocks that differ" "$few" "$few" "$wrong"
else
    echo "clocks that differ: skipped: no faketime here (apt-get install faketime)"
fi
if command -v strace > /dev/null; then
    wrong=0 slow="strace -f -qq -o /dev/null -e trace=openat,rename,unlink,flock"
    slow+=" -e inject=openat,rename,unlink,flock:delay_enter=20000"
    few=$((times < 5 ? times : 5))
    for ((i = 0; i < few; i++)); do
        shares "$slow" "$slow" || wrong=$((wrong + 1))
    done
    row "a slow folder" "$few" "$few" "$wrong"
else
    echo "a slow folder: skipped: no strace here (apt-get install strace)"
fi

# A damaged entry of the cache counts as absent.
wrong=0 damaged=0
for ((i = 0; i < times; i++)); do
    entries=(cache/*)
    entry=${entries[$((RANDOM % ${#entries[@]}))]}
    size=$(stat -c %s "$entry")
    if [ $((i % 3)) -eq 0 ]; then
        truncate -s $((size * (RANDOM % 1000) / 1000)) "$entry"
    else
        printf "\\x$(printf %x $((RANDOM % 256)))" |
            dd of="$entry" bs=1 seek=$(((RANDOM * 32768 + RANDOM) % (size > 0 ? size : 1))) conv=notrunc status=none
    fi
    damaged=$((damaged + 1))
    rm -f out.throng
    build out.throng cache > /dev/null 2>&1 && cmp -s out.throng whole.throng || wrong=$((wrong + 1))
done
row "cache entries damaged" "$times" "$damaged" "$wrong"

# Two builds at once, with one cache and one output.
wrong=0
few=$((times < 50 ? times : 50))
for ((i = 0; i < few; i++)); do
    rm -rf out.throng both-cache
    build out.throng both-cache > /dev/null 2>&1 &
    first=$!
    build out.throng both-cache > /dev/null 2>&1 || wrong=$((wrong + 1))
    wait $first || wrong=$((wrong + 1))
    cmp -s out.throng whole.throng || wrong=$((wrong + 1))
done
row "two builds at once" "$few" "$few" "$wrong"

left=$(find . -name '.throng-??????*' -type f | wc -l)
echo "temporary files left by killed programs: $left"
exit $status
