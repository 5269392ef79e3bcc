#!/usr/bin/env python3
"""What does the runtime cost in instructions?

`scripts/cost.py` builds `benches/cost.rs`, lets Callgrind count the instructions of each case and prints them per unit
(a character and step, a query, an event, an evaluation) beside those of `docs/results/cost.json`. It fails where a case
takes more than 3 % more, and asks for a new table where one takes more than 3 % less: `scripts/cost.py --write`. Counts
depend on the compiler, on the target and on whether the processor has AVX2: where these are others than those of the
table, counts are printed and nothing fails. `--twice` counts everything twice and fails where the counts differ.

Needs Python 3.9 and Valgrind; without Valgrind it runs the cases uncounted, and says so.
"""
import argparse
import concurrent.futures
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TABLE = ROOT / "docs" / "results" / "cost.json"
# The largest part by which a count may differ from the table.
LIMIT = 0.03
# An environment of its own: the size of another one would move the stack. Memory is copied and filled by vector instructions whatever the
# processor does best, as Callgrind counts each byte of the instructions that repeat.
ENVIRONMENT = {
    "LC_ALL": "C",
    "GLIBC_TUNABLES": "glibc.cpu.x86_rep_movsb_threshold=1000000000:glibc.cpu.x86_rep_stosb_threshold=1000000000",
}


def build():
    """Builds the program, and returns its path."""
    command = "cargo build --profile bench --features cost --bin cost --message-format json-render-diagnostics".split()
    built = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True)
    messages = (json.loads(line) for line in built.stdout.splitlines())
    return [m["executable"] for m in messages if m.get("executable")][-1]


def described():
    """What counts depend on beside the sources."""
    verbose = subprocess.run(["rustc", "-vV"], cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True).stdout
    fields = dict(line.split(": ", 1) for line in verbose.splitlines() if ": " in line)
    cpu = Path("/proc/cpuinfo")
    flags = cpu.read_text().split() if cpu.exists() else []
    return {"rustc": fields["release"], "host": fields["host"], "avx2": "avx2" in flags}


def count(program, folder, case):
    """Counts the instructions of a case: name, unit, and instructions of one unit."""
    with tempfile.TemporaryDirectory(dir=folder) as own:
        out = Path(own) / "out"
        callgrind = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={out}", "--toggle-collect=cost::counted_region*"]
        ran = subprocess.run(
            [*callgrind, program, "--bundles", ".", "--case", case],
            cwd=folder, env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )
        if ran.returncode != 0:
            sys.exit(f"{case}: failed\n{ran.stderr}")
        totals = [line for line in out.read_text().splitlines() if line.startswith(("summary:", "totals:"))]
    instructions = int(totals[-1].split()[1])
    if instructions == 0:
        sys.exit(f"{case}: no instructions were counted; Callgrind has not found the function `counted_region`")
    name, units, unit = ran.stdout.strip().split("\t")
    return name, {"unit": unit, "instructions": round(instructions / int(units), 1)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help=f"write {TABLE.relative_to(ROOT)} anew")
    parser.add_argument("--twice", action="store_true", help="count everything twice, and fail where counts differ")
    args = parser.parse_args()
    program = build()
    if not shutil.which("valgrind"):
        subprocess.run([program], check=True)
        print("skipped: counts of instructions, which need Valgrind (apt-get install valgrind)")
        return 0

    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([program, "--bake", folder], check=True)
        names = subprocess.run([program, "--list"], stdout=subprocess.PIPE, text=True, check=True).stdout.split()
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            runs = [dict(pool.map(lambda case: count(program, folder, case), names)) for _ in range(1 + args.twice)]
    got = runs[0]
    if runs[-1] != got:
        sys.exit(f"counts of two runs differ:\n{got}\n{runs[-1]}")

    machine = described()
    table = json.loads(TABLE.read_text()) if TABLE.exists() else {}
    known = table.get("cases", {})
    judged = all(table.get(key) == value for key, value in machine.items())
    print(f"{'case':<12} {'instructions':>12} {'table':>12} {'change':>8}  per")
    more, less = [], sorted(known.keys() - got.keys())
    for name, case in got.items():
        before = known.get(name, {}).get("instructions")
        change = case["instructions"] / before - 1.0 if before else None
        if change is None or change < -LIMIT:
            less.append(name)
        elif change > LIMIT:
            more.append(name)
        beside = f"{before:>12.1f} {100.0 * change:>+7.1f}%" if before else f"{'':>12} {'new':>8}"
        print(f"{name:<12} {case['instructions']:>12.1f} {beside}  {case['unit']}")
    if args.write:
        TABLE.parent.mkdir(parents=True, exist_ok=True)
        TABLE.write_text(json.dumps({**machine, "cases": got}, indent=2) + "\n")
        print(f"wrote {TABLE.relative_to(ROOT)}")
    elif not judged:
        print(f"not judged: the table is of {({key: table.get(key) for key in machine})}, this is {machine}")
    else:
        if less:
            print(f"new, gone or cheaper than in the table: {', '.join(less)}. Write it anew: scripts/cost.py --write")
        if more:
            print(f"more than {100.0 * LIMIT:.0f} % dearer than in the table: {', '.join(more)}", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
