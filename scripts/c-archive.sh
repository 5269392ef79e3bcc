#!/usr/bin/env bash
# Packs the runtime for C and C++: headers, shared and static library, a file for pkg-config, the file for Unity.
#
#   scripts/c-archive.sh           target/c/throng-c-VERSION-MACHINE.tar.gz
#   scripts/c-archive.sh --test    the same, and compiles clients against the unpacked archive and runs them
#   PROFILE=dev scripts/c-archive.sh ...    without optimising
#
# On Linux and macOS. Whoever links the static library asks `pkg-config --static`.
set -euo pipefail
cd "$(dirname "$0")/.."
target="${CARGO_TARGET_DIR:-$PWD/target}"
profile="${PROFILE:-release}"
folder="$([ "$profile" = dev ] && echo debug || echo "$profile")"
machine="$(rustc -vV | sed -n 's/^host: //p')"
version="$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -1)"
# What the static library needs besides; the compiler knows.
needs="$(cargo rustc -q -p throng-capi --lib --profile "$profile" -- --print native-static-libs 2>&1 |
    sed -n 's/^note: native-static-libs: //p' | tail -1)"
cargo build -q -p throng-capi --profile "$profile"

name="throng-c-$version-$machine"
out="$target/c"
rm -rf "${out:?}/$name"
mkdir -p "$out/$name/include" "$out/$name/lib/pkgconfig" "$out/$name/unity"
cp capi/include/throng.h capi/include/throng.hpp "$out/$name/include/"
for library in libthrong_c.so libthrong_c.dylib libthrong_c.a; do
    if [ -e "$target/$folder/$library" ]; then cp "$target/$folder/$library" "$out/$name/lib/"; fi
done
cp capi/unity/Throng.cs "$out/$name/unity/"
cp capi/README.md LICENSE-MIT LICENSE-APACHE THIRD-PARTY.md "$out/$name/"
cat > "$out/$name/lib/pkgconfig/throng.pc" <<P
prefix=\${pcfiledir}/../..
libdir=\${prefix}/lib
includedir=\${prefix}/include

Name: throng
Description: Runtime of Throng: thousands of characters from tables of motion
Version: $version
Cflags: -I\${includedir}
Libs: -L\${libdir} -lthrong_c
Libs.private: $needs
P
tar -C "$out" -czf "$out/$name.tar.gz" "$name"
echo "$out/$name.tar.gz: $(du -k "$out/$name.tar.gz" | cut -f1) kB"
[ "${1:-}" = --test ] || exit 0

for tool in cc c++ pkg-config; do
    command -v "$tool" >/dev/null || { echo "c-archive: not tested: there is no $tool"; exit 0; }
done
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
tar -C "$work" -xzf "$out/$name.tar.gz"
export PKG_CONFIG_PATH="$work/$name/lib/pkgconfig"
bundle="$(ls data/golden/tables_v*.throng | sort -V | tail -1)"
printf 'bundle = "%s"\n[[groups]]\nmotion = "policy"\ncount = 12\nbehaviours = [{ name = "approach" }]\n' "$PWD/$bundle" > "$work/people.toml"
lib="$work/$name/lib"
read -ra flags <<< "$(pkg-config --cflags throng)"
read -ra shared <<< "$(pkg-config --libs throng) -Wl,-rpath,$lib"
read -ra static <<< "$(pkg-config --static --libs throng | sed "s|-lthrong_c|$lib/libthrong_c.a|")"
build() { "$1" "$2" -O1 -pthread "${flags[@]}" "capi/tests/clients/$3" "${@:5}" -o "$work/$4"; }
build cc -std=c11 client.c c "${shared[@]}"
build cc -std=c11 client.c c-static "${static[@]}"
build c++ -std=c++17 client.cpp cpp "${shared[@]}"
"$work/c" "$bundle" > "$work/c.txt"
"$work/c-static" "$bundle" > "$work/c-static.txt"
"$work/cpp" "$bundle" "$work/people.toml" > "$work/cpp.txt"
cmp "$work/c.txt" "$work/c-static.txt"
hash="$(grep '^hash' "$work/c.txt")"
grep -qx "$hash" "$work/cpp.txt" || { echo "c-archive: C and C++ differ" >&2; exit 1; }
echo "c-archive: C, C++ and a static C program built against the archive ran alike: $hash"
