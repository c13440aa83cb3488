#!/usr/bin/env bash
# run.sh PREFIX: a stranger's project against the Catamaran installed in PREFIX, with CMake and with
# pkg-config; versions and components that are not there must be refused.
set -euo pipefail

prefix=$(cd "$1" && pwd)
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
done_count=0
step() { done_count=$((done_count + 1)); echo "consumer: $*"; }
fail() { cat "$work/log" >&2; echo "consumer: $*" >&2; exit 1; }

configure() { # BUILD_DIR OPTION...
    local build=$1
    shift
    cmake -S "$here" -B "$work/$build" -DCMAKE_PREFIX_PATH="$prefix" "$@" > "$work/log" 2>&1
}
runs() { # WHAT PROGRAM: it prints a product
    "$2" > "$work/out"
    test "$(cat "$work/out")" = "35 44 44 56"
    step "$1"
}

all=(openblas opencl hdf5 mpi blas)
configure build -DWANTED_VERSION=0.1 "-DOPTIONAL_COMPONENTS=$(IFS=';'; echo "${all[*]}")" ||
    fail "find_package"
cp "$work/log" "$work/components.log"
cmake --build "$work/build" > "$work/log" 2>&1 || fail "build"
for program in stranger_c stranger_static stranger_cpp; do
    runs "find_package, $program" "$work/build/$program"
done
if ldd "$work/build/stranger_static" | grep -q catamaran; then
    fail "stranger_static needs the shared library"
fi

# What the package says must be what the library says.
"$work/build/stranger_components" > "$work/present"
if [ -n "$(find "$prefix" -name libcatamaran_blas.so)" ]; then echo blas >> "$work/present"; fi
for component in "${all[@]}"; do
    if grep -qx "$component" "$work/present"; then
        grep -q "component $component: found" "$work/components.log" ||
            fail "component $component: not found as an optional one"
        configure build "-DWANTED_COMPONENTS=$component" -DOPTIONAL_COMPONENTS= ||
            fail "component $component: not found"
        step "component $component found"
    else
        grep -q "component $component: missing" "$work/components.log" ||
            fail "component $component: found, but the library does without"
        if configure build "-DWANTED_COMPONENTS=$component" -DOPTIONAL_COMPONENTS=; then
            fail "component $component: accepted, but the library does without"
        fi
        grep -q "missing components of catamaran: $component;" "$work/log" ||
            fail "component $component: the error does not name it"
        step "component $component refused"
    fi
done
if [ -e "$work/build/stranger_mpi" ]; then
    # As root too (Open MPI).
    OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 "$work/build/stranger_mpi" \
        > "$work/log" 2>&1 || fail "catamaran::mpi"
    step "catamaran::mpi"
fi
if [ -e "$work/build/stranger_fortran" ]; then
    runs "catamaran::fortran" "$work/build/stranger_fortran"
fi
if [ -e "$work/build/stranger_blas" ]; then runs "catamaran::blas" "$work/build/stranger_blas"; fi

for version in 9.9 0.2 1.0; do
    if configure "wrong$version" "-DWANTED_VERSION=$version"; then
        fail "find_package(catamaran $version) was accepted"
    fi
    grep -qE "version \"?$version|\"$version\"" "$work/log" || fail "find_package($version)"
    step "find_package, version $version refused"
done

pc_dir=$(dirname "$(find "$prefix" -name catamaran.pc)")
export PKG_CONFIG_PATH="$pc_dir"
lib_dir=$(pkg-config --variable=libdir catamaran)
# The flags are words.
# shellcheck disable=SC2046
cc -std=c99 -pedantic -Wall -Werror -o "$work/pc" "$here/main.c" \
    $(pkg-config --cflags --libs catamaran) -Wl,-rpath,"$lib_dir"
runs "pkg-config, shared" "$work/pc"
# While the major version is 0, every minor version has an ABI of its own.
abi=$(pkg-config --modversion catamaran | sed -E 's/^(0\.[0-9]+)\..*/\1/; t; s/\..*//')
readelf -d "$work/pc" | grep -q "NEEDED.*\[libcatamaran\.so\.${abi//./\\.}\]"
readelf -V "$work/pc" | grep -q "Name: CATAMARAN_$abi "
step "it needs libcatamaran.so.$abi and symbols of version CATAMARAN_$abi"
# shellcheck disable=SC2046
cc -o "$work/pc_static" "$here/main.c" $(pkg-config --cflags catamaran) \
    "$lib_dir/libcatamaran.a" $(pkg-config --static --libs catamaran | sed 's/-lcatamaran//')
runs "pkg-config --static" "$work/pc_static"
# Without any shared library; MPI has no static one, and what this program does not use goes.
# shellcheck disable=SC2046
cc -static -Wl,--gc-sections -o "$work/alone" "$here/main.c" $(pkg-config --cflags catamaran) \
    "$lib_dir/libcatamaran.a" $(pkg-config --static --libs catamaran |
        sed -E 's/-l(catamaran|mpi\S*)//g') > "$work/log" 2>&1 || fail "cc -static"
if ldd "$work/alone" > "$work/log" 2>&1; then fail "cc -static needs shared libraries"; fi
runs "cc -static" "$work/alone"
if pkg-config --exists 'catamaran >= 9.9'; then
    echo "pkg-config accepted version 9.9" >&2
    exit 1
fi
step "pkg-config, version 9.9 refused"
echo "consumer: $done_count passed"
