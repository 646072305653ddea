#!/bin/sh
# Prints how long a pose takes in Node and in Chromium beside the native library on SSE2, in the same run, and how large
# the npm package is.
#   bindings/web/bench.sh FACE.fbk
# After bindings/web/test.sh, which builds and installs what this needs.
set -eu
archive=$(realpath "$1")
cd "$(dirname "$0")/../../build/web"
export OMP_WAIT_POLICY=PASSIVE
./native_poses dump "$archive" 256 expected/bench.poses
node tests-built/bench_face.js "$archive" "$PWD/expected/bench.poses" "$PWD/native_poses"
