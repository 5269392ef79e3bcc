#!/usr/bin/env bash
# Tests the Python package, or builds its wheel.
#
#   scripts/python.sh [OPTION ...]   builds the workspace as for development, puts the package together in an environment of
#                                    its own, and runs its tests; options go to `cargo build`
#   scripts/python.sh --wheel        builds an optimised wheel into target/wheels, without tests
#
# The whole workspace is built with its examples, so that what `cargo test --workspace` has built with the same options serves. Says why, and succeeds, where Python or its packages are not to be had.
set -euo pipefail
cd "$(dirname "$0")/.."
skip() { echo "python: skipped: $1"; exit 0; }
target="${CARGO_TARGET_DIR:-$PWD/target}"
command -v python3 >/dev/null || skip "there is no python3"
python3 -c 'import sys; sys.exit(sys.version_info < (3, 9))' || skip "python3 is older than 3.9"
venv="$target/python-venv"
python="$venv/bin/python"
[ -x "$python" ] || python3 -m venv "$venv" >/dev/null 2>&1 || skip "python3 cannot make environments (venv)"
"$python" -m pip --version >/dev/null 2>&1 || skip "there is no pip"
if [ "${1:-}" = --wheel ]; then
    "$python" -m pip install -q "maturin>=1.16,<2" || skip "maturin cannot be installed"
    "$venv/bin/maturin" build --release -m python/Cargo.toml --out "$target/wheels"
    exit
fi
"$python" -m pip install -q "numpy>=1.21" "gymnasium>=1.0" pytest mypy ||
    skip "packages cannot be installed (numpy, gymnasium, pytest, mypy)"
cargo build --workspace --lib --examples "$@"
package="$("$python" -c 'import sysconfig; print(sysconfig.get_path("platlib"))')/throng"
rm -rf "$package"
cp -r python/python/throng "$package"
for library in "$target"/debug/lib_throng.{so,dylib}; do
    [ ! -e "$library" ] || cp "$library" "$package/_throng.abi3.so"
done
"$python" -m pytest -q -p no:cacheprovider python/tests
