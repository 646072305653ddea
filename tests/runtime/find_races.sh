#!/bin/sh
# Runs the sample crowd under ThreadSanitizer, each thread with its own scratch, and the engine's component, whose
# threads share one. Fails on any race. Builds only the runtime, with clang and without OpenMP, in build/races. The whole
# tree: tests/run.sh tsan.
#   tests/runtime/find_races.sh FACE.fbk
set -eu
face=$(realpath "$1")
cd "$(dirname "$0")/../.."
samples/setup.sh --sanitizers
cmake --preset tsan -B build/races -DFB_RUNTIME_ONLY=ON -DFB_OPENMP=OFF >/dev/null
cmake --build build/races --target crowd engine_component
TSAN_OPTIONS="halt_on_error=1 ${TSAN_OPTIONS:-}" build/races/bin/crowd "$face" 400 4
TSAN_OPTIONS="halt_on_error=1 ${TSAN_OPTIONS:-}" build/races/bin/engine_component "$face" 20 20 4
