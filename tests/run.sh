#!/bin/sh
# Sets up, builds and runs all tests of one or more presets (default: release).
#   tests/run.sh [PRESET...]
# Ends with ctest's summary; the exit code is 0 only if everything passed.
set -eu
cd "$(dirname "$0")/.."
[ $# -gt 0 ] || set -- release

# Waiting threads must not hold cores that others need.
export OMP_WAIT_POLICY=PASSIVE
cores=$(nproc)
# In CI a warning fails the build, and the API reference is not skipped. A sanitizer's reports name functions there, not
# lines, which take a tenth of its build or more.
in_ci=""
[ -z "${CI:-}" ] || in_ci="-DCMAKE_COMPILE_WARNING_AS_ERROR=ON -DFB_LINE_NUMBERS=OFF"

samples/setup.sh
[ -z "${CI:-}" ] || samples/setup.sh --docs
# In CI a scene of Godot is run where there is one: its headers are 22 MB of Debian's source package.
if [ -n "${CI:-}" ] && command -v godot3-server >/dev/null && [ ! -e build/gdnative ]; then
  bindings/godot/get_headers.sh build/gdnative || echo "note: without headers of Godot its scene is skipped" >&2
fi
for preset in "$@"; do
  case "$preset" in asan | tsan) samples/setup.sh --sanitizers ;; esac
done
if [ ! -d "${FB_SHARED_RIGS:-../shared/rigs}" ]; then
  echo "note: there is no ${FB_SHARED_RIGS:-../shared/rigs}; tests on real rigs will be skipped" >&2
fi

for preset in "$@"; do
  # shellcheck disable=SC2086 # two options or none
  cmake --preset "$preset" $in_ci
  cmake --build --preset "$preset" --parallel "$cores"
  ctest --preset "$preset" --parallel "$cores" --output-on-failure
done
