#!/bin/sh
# Soaks the runtime of a release build for an hour, or as long as is said; see soak.cpp.
#   tests/soak/run.sh [MINUTES [SEED [FACE.fbk...]]]
# Without faces: the archives of the tests and, if the quickstart was run, its face.
set -eu
cd "$(dirname "$0")/../.."
minutes=${1:-60}
seed=${2:-1}
[ $# -lt 2 ] || shift
[ $# -eq 0 ] || shift
samples/setup.sh
cmake --preset release >/dev/null
cmake --build --preset release --parallel "$(nproc)" --target soak
if [ $# -eq 0 ]; then
  set -- build/release/fixtures/tiny.fbk
  [ ! -f build/quickstart/sample.fbk ] || set -- "$@" build/quickstart/sample.fbk
fi
OMP_WAIT_POLICY=PASSIVE build/release/bin/soak build/release/lib/libfacebaker.so $((minutes * 60)) "$seed" "$@"
