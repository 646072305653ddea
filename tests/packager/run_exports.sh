#!/bin/sh
# Exports faces of the recipes hero, compact, linear and paper, baked here from the sample face, and reads them back by
# what others wrote: ONNX by ONNX Runtime, USD by three.js' loader, glTF by Khronos' validator. All three come from npm
# into build/exports. The recipes take minutes.
#   tests/packager/run_exports.sh [FACEBAKER [RECIPE...]]
set -eu
cd "$(dirname "$0")/../.."
tool=$(realpath "${1:-build/release/bin/facebaker}")
[ $# -eq 0 ] || shift
[ $# -gt 0 ] || set -- hero compact linear paper
tests=$PWD/tests/packager
mkdir -p build/exports
cd build/exports
[ -d node_modules/onnxruntime-node ] && [ -d node_modules/three ] && [ -d node_modules/gltf-validator ] ||
  npm install --ignore-scripts --no-audit --no-fund onnxruntime-node three gltf-validator
cp "$tests"/onnx/run_onnx.mjs "$tests"/usd/read_usda.mjs "$tests"/gltf/validate.mjs .

[ -d data ] || "$tool" sample sample --poses 1200 --out data > /dev/null
for recipe in "$@"; do
  [ -f "$recipe.fbk" ] || "$tool" bake data --recipe "$recipe" --epochs 4 --out "$recipe.fbk" > /dev/null
  mkdir -p "$recipe"
  /usr/bin/python3 -B "$tests/onnx/write_poses.py" "$tool" "$recipe.fbk" "$recipe"
  node run_onnx.mjs "$recipe/face.onnx" "$recipe/poses.npy" "$recipe/poses.mdd"
done

face=$1.fbk
clip=data/dialogue.controls.npy
"$tool" export "$face" face.glb
"$tool" export "$face" clip.glb --clip "$clip"
"$tool" export "$face" skinned.glb --skinned --clip "$clip"
"$tool" export "$face" skinned-controls.glb --skinned
node validate.mjs face.glb clip.glb skinned.glb skinned-controls.glb
"$tool" export "$face" clip.usda --clip "$clip"
"$tool" export "$face" clip.mdd --clip "$clip"
node read_usda.mjs clip.usda clip.mdd
