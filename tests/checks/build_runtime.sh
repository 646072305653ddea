#!/bin/sh
# Builds the runtime alone, without OpenMP, and not optimised, with warnings as errors; runs its tests on the archives of the
# release build, and compares its interface with that of the last release.
#   tests/checks/build_runtime.sh          after tests/run.sh release
set -eu
cd "$(dirname "$0")/../.."
samples/setup.sh
build=build/runtime-debug
cmake --preset runtime-only -B $build -DCMAKE_COMPILE_WARNING_AS_ERROR=ON -DFB_OPENMP=OFF -DFB_ABI_INFO=ON \
  -DCMAKE_BUILD_TYPE=Debug -DCMAKE_C_FLAGS_DEBUG=-O0 -DCMAKE_CXX_FLAGS_DEBUG=-O0 \
  -DFB_FIXTURES="$PWD/build/release/fixtures"
cmake --build $build --parallel "$(nproc)"
ctest --test-dir $build --parallel "$(nproc)" --output-on-failure
tests/abi/check.sh $build
