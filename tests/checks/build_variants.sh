#!/bin/sh
# Builds, with warnings as errors, what the tests of CI leave out: everything with clang and without OpenMP, and the
# runtime alone with gcc, whose interface is compared with that of the last release. Not optimised, because nothing of it is
# run; with clang many sources of a library at once (a unity build takes half of the time).
#   tests/checks/build_variants.sh
set -eu
cd "$(dirname "$0")/../.."
samples/setup.sh --tsan

# build NAME OPTION...: configures and builds build/NAME.
build() {
  folder=build/$1
  shift
  cmake "$@" -B "$folder" -DCMAKE_COMPILE_WARNING_AS_ERROR=ON \
    -DCMAKE_BUILD_TYPE=Debug -DCMAKE_C_FLAGS_DEBUG=-O0 -DCMAKE_CXX_FLAGS_DEBUG=-O0
  cmake --build "$folder" --parallel "$(nproc)"
}
build clang --preset no-openmp -DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_UNITY_BUILD=ON \
  -DCMAKE_UNITY_BUILD_BATCH_SIZE=16 -DCMAKE_EXE_LINKER_FLAGS=-fuse-ld=gold
build runtime-debug --preset runtime-only -DFB_ABI_INFO=ON
tests/abi/check.sh build/runtime-debug
