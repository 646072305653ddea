#!/bin/sh
# Exports faces of the recipes hero, compact, linear and paper, baked here from the sample face, and golden ones with
# exact poses and driven joints, and reads them back by what others wrote: ONNX by ONNX Runtime, USD by three.js' loader,
# glTF by Khronos' validator. All three come from npm into build/exports. The recipes take minutes.
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

# read_onnx FACE.fbk NAME
read_onnx() {
  mkdir -p "$2"
  /usr/bin/python3 -B "$tests/onnx/write_poses.py" "$tool" "$1" "$2"
  node run_onnx.mjs "$2/face.onnx" "$2/poses.npy" "$2/poses.mdd"
}
for golden in 2.0/accepted/exact-poses 2.1/accepted/driven 2.1/accepted/driven-exact-levels; do
  face=$tests/../golden/$golden.fbk name=$(basename "$golden")
  read_onnx "$face" "$name"
  "$tool" export "$face" "$name/face.glb"
  "$tool" export "$face" "$name/skinned.glb" --skinned --clip "$name/poses.npy"
  node validate.mjs "$name/face.glb" "$name/skinned.glb"
done
[ -d data ] || "$tool" sample sample --poses 1200 --out data > /dev/null
for recipe in "$@"; do
  [ -f "$recipe.fbk" ] || "$tool" bake data --recipe "$recipe" --epochs 4 --out "$recipe.fbk" > /dev/null
  read_onnx "$recipe.fbk" "$recipe"
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
