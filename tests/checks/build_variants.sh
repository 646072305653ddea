#!/bin/sh
# Builds, with warnings as errors, what CI does not: everything with clang and without OpenMP, and the
# runtime alone.
#   tests/checks/build_variants.sh
set -eu
cd "$(dirname "$0")/../.."
samples/setup.sh --tsan
cmake --preset no-openmp -B build/clang -DCMAKE_BUILD_TYPE=Debug -DCMAKE_COMPILE_WARNING_AS_ERROR=ON \
  -DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++
cmake --build build/clang --parallel "$(nproc)"
cmake --preset runtime-only -DCMAKE_COMPILE_WARNING_AS_ERROR=ON
cmake --build --preset runtime-only --parallel "$(nproc)"
