#!/usr/bin/env bash
# Builds the wheel of the Python package, installs it into an environment of its own, and runs its tests.
#
#   scripts/python.sh            build as for development, and test
#   scripts/python.sh --wheel    build an optimised wheel into target/wheels, without tests
#
# Says why, and succeeds, where Python or its packages are not to be had.
set -euo pipefail
cd "$(dirname "$0")/.."
skip() { echo "python: skipped: $1"; exit 0; }
target="${CARGO_TARGET_DIR:-$PWD/target}"
command -v python3 >/dev/null || skip "there is no python3"
python3 -c 'import sys; sys.exit(sys.version_info < (3, 9))' || skip "python3 is older than 3.9"
venv="$target/python-venv"
[ -x "$venv/bin/python" ] || python3 -m venv "$venv" >/dev/null 2>&1 || skip "python3 cannot make environments (venv)"
"$venv/bin/python" -m pip --version >/dev/null 2>&1 || skip "there is no pip"
"$venv/bin/python" -m pip install -q "maturin>=1.16,<2" "numpy>=1.21" "gymnasium>=1.0" pytest mypy ||
    skip "packages cannot be installed (maturin, numpy, gymnasium, pytest, mypy)"
if [ "${1:-}" = --wheel ]; then
    "$venv/bin/maturin" build --release -m python/Cargo.toml --out "$target/wheels"
    exit
fi
wheels="$(mktemp -d)"
trap 'rm -rf "$wheels"' EXIT
"$venv/bin/maturin" build -m python/Cargo.toml --out "$wheels"
"$venv/bin/python" -m pip install -q --force-reinstall --no-deps "$wheels"/*.whl
"$venv/bin/python" -m pytest -q -p no:cacheprovider python/tests
