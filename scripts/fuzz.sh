#!/usr/bin/env bash
# Does any reader fall over bytes that nobody thought of? Runs libFuzzer on the readers of `fuzz`, one after the other.
#
# `scripts/fuzz.sh [MINUTES] [READER ...]`: minutes each (1), of these readers (all of them). Inputs that led somewhere new
# are kept in fuzz/corpus, those that did harm in fuzz/artifacts; a further call goes on from there. Builds go to
# target/fuzz. Prints a row for each reader, and exits 1 where anything was found.
#
# cargo-fuzz is not needed: these are the flags that it sets. Other than a C++ compiler, neither is anything else.
set -euo pipefail
cd "$(dirname "$0")/.."
minutes=${1:-1}
shift $(($# > 0 ? 1 : 0))
readers=("$@")
[ ${#readers[@]} -gt 0 ] || readers=($(sed -n '/^\[\[bin\]\]/{n;s/name = "\(.*\)"/\1/p}' fuzz/Cargo.toml))
host=$(rustc -vV | sed -n 's/^host: //p')
target=$PWD/target/fuzz

# Good files first, made by a program that is not instrumented.
cargo run -q -p throng-checks -- seeds
coverage="-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4
    -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table
    -Cllvm-args=-sanitizer-coverage-trace-compares"
# Overflowing arithmetic and assertions count as findings, too.
RUSTFLAGS="$(echo $coverage) -Cdebug-assertions --cfg fuzzing" \
    cargo build -q --release --manifest-path fuzz/Cargo.toml --target "$host" --target-dir "$target" --bins

# Some readers write files and wait for the disk after each: in memory, where there is such a folder.
if [ -d /dev/shm ] && [ -w /dev/shm ]; then
    TMPDIR=$(mktemp -d /dev/shm/fuzz.XXXXXX)
    export TMPDIR
    trap 'rm -rf "$TMPDIR"' EXIT
fi

status=0
# Processor time of the program, and of the system for it (s).
TIMEFORMAT='%U %S'
printf '%-18s %11s %10s %9s %9s %9s\n' reader runs "cpu s" coverage corpus findings
for reader in "${readers[@]}"; do
    corpus=fuzz/corpus/$reader artifacts=fuzz/artifacts/$reader log=$target/$reader.log
    mkdir -p "$artifacts"
    # Every seed fits whole: one that is cut is refused at once, and its reader is never seen at work.
    largest=$(stat -c %s "$corpus"/seed_* | sort -n | tail -1)
    longest=$((largest * 5 / 4 > 65536 ? largest * 5 / 4 : 65536))
    runs=0 findings=0 covered=0 cpu=0
    end=$(awk -v now="$SECONDS" -v m="$minutes" 'BEGIN { printf "%d", now + 60 * m }')
    # libFuzzer stops at a finding; what is left of the time is for others. Ten of one reader are enough.
    while [ "$SECONDS" -lt "$end" ] && [ $findings -lt 10 ]; do
        code=0
        seconds=$({ time "$target/$host/release/$reader" "$corpus" -artifact_prefix="$artifacts/" \
            -max_total_time=$((end - SECONDS)) -timeout=30 -rss_limit_mb=3072 -max_len=$longest -print_final_stats=1 \
            > "$log" 2>&1; } 2>&1) || code=$?
        runs=$((runs + $(sed -n 's/^stat::number_of_executed_units: *//p' "$log" | tail -1)))
        cpu=$((cpu + $(awk '{ printf "%d", $1 + $2 }' <<< "$seconds")))
        most=$(grep -o 'cov: [0-9]*' "$log" | tail -1 | cut -d' ' -f2 || true)
        [ "${most:-0}" -le $covered ] || covered=$most
        [ $code -ne 0 ] || continue
        findings=$((findings + 1)) status=1
        grep -E "panicked at|ERROR: libFuzzer|Test unit written" -A1 "$log" | head -6 >&2 || true
    done
    printf '%-18s %11d %10d %9d %9d %9d\n' "$reader" $runs $cpu $covered "$(ls "$corpus" | wc -l)" $findings
done
exit $status
