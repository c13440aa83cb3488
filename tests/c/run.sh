#!/usr/bin/env bash
# Every test of the C and C++ interface: the header's drift check, ctest plain, under mpirun, with
# AddressSanitizer and UndefinedBehaviorSanitizer, and under Valgrind, and a stranger's project against
# an installed copy.
# The library is compiled as for the Rust tests, whose packages it shares, with checks of overflow.
# Environment: CARGO_TARGET_DIR (default: target), CATAMARAN_C_BUILD (default: there, c-tests).
set -euo pipefail

root=$(cd "$(dirname "$0")/../.." && pwd)
cd "$root"
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$root/target}
build=${CATAMARAN_C_BUILD:-$CARGO_TARGET_DIR/c-tests}
mkdir -p "$build"
kinds=()

quietly() { # LOG COMMAND...: the output is shown only if it fails
    local log="$build/$1.log"
    shift
    "$@" > "$log" 2>&1 || { cat "$log"; echo "failed: $*" >&2; exit 1; }
}
failed=0
tests() { # NAME BUILD_DIR CTEST_ARGUMENTS...: runs them and remembers the count and failures
    local name=$1 dir=$2
    shift 2
    (cd "$build/$dir" && ctest --output-on-failure "$@") | tee "$build/ctest-$name.log" || failed=1
    kinds+=("$name: $(grep -E 'tests passed|No tests' "$build/ctest-$name.log")")
}
configure() { # BUILD_DIR OPTIONS...
    local dir=$1
    shift
    quietly "configure-$dir" cmake -S . -B "$build/$dir" -DCMAKE_BUILD_TYPE=Debug \
        -DCATAMARAN_CARGO_TARGET_DIR="$CARGO_TARGET_DIR" -DCATAMARAN_CARGO_PROFILE=dev \
        -DCATAMARAN_CARGO_FEATURES=as-in-scripts-test "$@"
    quietly "build-$dir" cmake --build "$build/$dir" --parallel 2
}

mpi=OFF
if command -v mpicc > /dev/null && command -v mpirun > /dev/null; then mpi=ON; fi

cargo xtask header --check
cargo xtask fortran --check
kinds+=("header: include/catamaran.h and include/catamaran.f90 are up to date")
kinds+=("$(tests/c/abi.py)")

configure plain -DCATAMARAN_MPI=$mpi -DCATAMARAN_OPENCL=ON
tests c plain -L '^c$' -j 2
if [ $mpi = ON ]; then
    tests mpi plain -L '^mpi$'
else
    kinds+=("mpi: mpicc or mpirun not installed, left out")
fi
# Without OpenCL, whose drivers leak, and without MPI, so that the functions of both are tested
# without them too. scripts/test has compiled all but the C interface for the Rust tests.
configure asan -DCATAMARAN_SANITIZE=address,undefined
tests asan asan -L '^c$' -j 2
if command -v valgrind > /dev/null; then
    tests valgrind plain -L '^valgrind$' -j 2
else
    kinds+=("valgrind: not installed, left out")
fi

rm -rf "$build/prefix"
quietly install cmake --install "$build/plain" --prefix "$build/prefix"
tests/cmake_consumer/run.sh "$build/prefix" | tee "$build/consumer.log"
kinds+=("$(tail -n 1 "$build/consumer.log")")

echo
printf '%s\n' "${kinds[@]}"
exit $failed
