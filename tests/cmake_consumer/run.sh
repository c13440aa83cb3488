#!/usr/bin/env bash
# run.sh PREFIX: a stranger's project against the Catamaran installed in PREFIX, with CMake and with
# pkg-config; a version that is not there must be refused.
set -euo pipefail

prefix=$(cd "$1" && pwd)
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
done_count=0
step() { done_count=$((done_count + 1)); echo "consumer: $*"; }

configure() { # BUILD_DIR VERSION
    cmake -S "$here" -B "$work/$1" -DCMAKE_PREFIX_PATH="$prefix" -DWANTED_VERSION="$2" \
        > "$work/log" 2>&1
}

configure build 0.1 || { cat "$work/log"; exit 1; }
cmake --build "$work/build" > "$work/log" 2>&1 || { cat "$work/log"; exit 1; }
for program in stranger_c stranger_static stranger_cpp; do
    "$work/build/$program" > "$work/out"
    test "$(cat "$work/out")" = "35 44 44 56"
    step "find_package, $program"
done
if ldd "$work/build/stranger_static" | grep -q catamaran; then
    echo "stranger_static needs the shared library" >&2
    exit 1
fi

for version in 9.9 0.2 1.0; do
    if configure "wrong$version" "$version"; then
        echo "find_package(catamaran $version) was accepted" >&2
        exit 1
    fi
    grep -qE "version \"?$version|\"$version\"" "$work/log" || { cat "$work/log"; exit 1; }
    step "find_package, version $version refused"
done

pc_dir=$(dirname "$(find "$prefix" -name catamaran.pc)")
export PKG_CONFIG_PATH="$pc_dir"
lib_dir=$(pkg-config --variable=libdir catamaran)
# The flags are words.
# shellcheck disable=SC2046
cc -std=c99 -pedantic -Wall -Werror -o "$work/pc" "$here/main.c" \
    $(pkg-config --cflags --libs catamaran) -Wl,-rpath,"$lib_dir"
"$work/pc" > "$work/out"
test "$(cat "$work/out")" = "35 44 44 56"
readelf -d "$work/pc" | grep -q 'NEEDED.*libcatamaran\.so\.0'
step "pkg-config, shared, needs libcatamaran.so.0"
# shellcheck disable=SC2046
cc -o "$work/pc_static" "$here/main.c" $(pkg-config --cflags catamaran) \
    "$lib_dir/libcatamaran.a" $(pkg-config --static --libs-only-l catamaran |
        sed 's/-lcatamaran//')
"$work/pc_static" > "$work/out"
test "$(cat "$work/out")" = "35 44 44 56"
step "pkg-config --static"
if pkg-config --exists 'catamaran >= 9.9'; then
    echo "pkg-config accepted version 9.9" >&2
    exit 1
fi
step "pkg-config, version 9.9 refused"
echo "consumer: $done_count passed"
