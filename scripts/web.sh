#!/usr/bin/env bash
# Builds the page with the demo bundle into target/web/page, and serves it.
#
#   scripts/web.sh [PORT]        http://localhost:8000/
#   scripts/web.sh --build       build alone, and say the sizes
#   scripts/web.sh --compare     build the module alone, and compare a thousand people and agents in it with a native run
#   scripts/web.sh --test        build, and try it in headless Chromium; says why it is skipped where there is none
#
# Needs npm, and of rustup the target wasm32-unknown-unknown, which it adds.
set -euo pipefail
cd "$(dirname "$0")/.."
target="${CARGO_TARGET_DIR:-$PWD/target}"
out="$target/web/page"
if [ "${1:-}" = --test ]; then
    chromium="$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)"
    [ -n "$chromium" ] || { echo "web: skipped: there is no Chromium (Debian: apt-get install chromium)"; exit 0; }
fi
module() {
    rustup target add wasm32-unknown-unknown >/dev/null 2>&1 || true
    RUSTFLAGS="-C target-feature=+simd128" cargo build -q -p throng-web --profile web --target wasm32-unknown-unknown
}
if [ "${1:-}" = --compare ]; then
    command -v node >/dev/null || { echo "web: there is no node; install Node.js" >&2; exit 1; }
    module
    mkdir -p "$target/web"
    bundle="$(ls data/golden/tables_v*.throng | sort -V | tail -1)"
    cargo run -q -p throng-web --example records -- "$bundle" 1000 600 > "$target/web/records"
    exec node scripts/compare-web.mjs "$target/wasm32-unknown-unknown/web/throng_web.wasm" "$bundle" 1000 600 "$target/web/records"
fi
command -v npm >/dev/null || { echo "web: there is no npm; install Node.js" >&2; exit 1; }
mkdir -p "$out"
module
cp "$target/wasm32-unknown-unknown/web/throng_web.wasm" "$out/"
# A pinned version of what draws, and of what packs it.
(cd "$target/web" && { [ -e package.json ] || echo '{ "private": true }' > package.json; } &&
    npm install --silent --no-audit --no-fund three@0.170.0 esbuild@0.28.2 puppeteer-core@24.10.0 >/dev/null)
NODE_PATH="$target/web/node_modules" "$target/web/node_modules/.bin/esbuild" web/page/main.js --bundle --minify --format=esm \
    --log-level=warning --outfile="$out/main.js"
cp web/page/index.html "$out/"
if [ ! -e "$out/demo.throng" ]; then
    (cd "$out" && CARGO_TARGET_DIR="$target" cargo run -q --release --manifest-path "$OLDPWD/Cargo.toml" -- demo >/dev/null)
fi
node - "$out" <<'P'
const [fs, zlib, path] = [require('fs'), require('zlib'), require('path')];
const sum = [0, 0, 0];
for (const name of ['throng_web.wasm', 'main.js', 'index.html']) {
    const bytes = fs.readFileSync(path.join(process.argv[2], name));
    const sizes = [bytes, zlib.gzipSync(bytes, { level: 9 }), zlib.brotliCompressSync(bytes)].map((b) => b.length);
    sizes.forEach((size, k) => { sum[k] += size; });
    console.log(`${name}: ${sizes.map((size) => Math.round(size / 1000)).join(', ')} kB (as it is, by gzip, by brotli)`);
}
console.log(`together without the bundle: ${sum.map((size) => Math.round(size / 1000)).join(', ')} kB`);
P
case "${1:-}" in
--build) ;;
--test) NODE_PATH="$target/web/node_modules" node scripts/check-web.cjs "$out" "$chromium" "${2:-}" ;;
*) echo "http://localhost:${1:-8000}/" && exec python3 -m http.server --bind 127.0.0.1 --directory "$out" "${1:-8000}" ;;
esac
