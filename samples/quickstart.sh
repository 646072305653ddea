#!/bin/sh
# From a fresh Debian machine to a baked face: sets up, builds, then bakes, verifies, measures and poses the
# built-in sample face. Leaves sample.fbk and sample.png in build/quickstart.
#   samples/quickstart.sh [POSES]
set -eu
cd "$(dirname "$0")/.."
poses=${1:-8000}

export OMP_WAIT_POLICY=PASSIVE
samples/setup.sh
cmake --preset release
cmake --build --preset release --parallel "$(nproc)" \
  --target facebaker rig_sample libfacebaker libfacebaker_bake

facebaker=build/release/bin/facebaker
out=build/quickstart
mkdir -p "$out"
"$facebaker" bake sample --out "$out/sample.fbk" --recipe compact --use variant --poses "$poses" --levels 3
"$facebaker" verify "$out/sample.fbk"
"$facebaker" eval "$out/sample.fbk" sample
"$facebaker" pose "$out/sample.fbk" --beside sample --out "$out/sample.png" \
  --set jaw_open=0.3 --set smile_L=0.9 --set smile_R=0.7 --set brow_inner_L=0.5 --set brow_outer_L=0.8
echo "The baked face: $out/sample.fbk; beside the true rig: $out/sample.png"
