#!/bin/sh
# From a fresh Debian machine to a baked face: sets up, builds, then samples, bakes, verifies and poses the built-in
# sample face. Leaves sample.fbk and sample.png in build/quickstart.
#   samples/quickstart.sh [POSES]
set -eu
cd "$(dirname "$0")/.."
poses=${1:-3000}

export OMP_WAIT_POLICY=PASSIVE
samples/setup.sh
cmake --preset release
cmake --build --preset release --parallel "$(nproc)" \
  --target facebaker rig_sample libfacebaker libfacebaker_bake

facebaker=build/release/bin/facebaker
out=build/quickstart
mkdir -p "$out"
"$facebaker" sample sample --out "$out/data" --poses "$poses"
"$facebaker" bake "$out/data" --out "$out/sample.fbk" --recipe paper
"$facebaker" verify "$out/sample.fbk"
"$facebaker" pose "$out/sample.fbk" --beside sample --out "$out/sample.png"
echo "The baked face: $out/sample.fbk; beside the true rig: $out/sample.png"
