#!/bin/sh
# Writes faces and characters as glTF, validates them by Khronos' validator, and loads them by three.js, which must find
# the meshes, materials, textures, sockets and posed points that were there. Both come from npm into build/gltf. The
# validator has not heard of KHR_texture_basisu and warns of images in KTX2; three.js reads that extension.
#   tests/packager/validate_gltf.sh [FACEBAKER]
set -eu
cd "$(dirname "$0")/../.."
tool=$(realpath "${1:-build/release/bin/facebaker}")
scripts=$PWD/tests/packager/gltf
mkdir -p build/gltf
cd build/gltf
[ -d node_modules/gltf-validator ] && [ -d node_modules/three ] ||
  npm install --ignore-scripts --no-audit --no-fund gltf-validator three
cp "$scripts"/*.mjs .

node make_character.mjs character
node make_character.mjs compressed ktx2
node make_character.mjs skinned skin
node make_character.mjs driven driven
node make_character.mjs carried carried
for name in character compressed skinned; do
  "$tool" bake "$name" --recipe linear --out "$name.fbk" > /dev/null 2>&1
done
for name in driven carried; do  # joints that the controls drive
  "$tool" bake "$name" --recipe compact --out "$name.fbk" > /dev/null 2>&1
done
"$tool" sample sample --poses 40 --out sample > /dev/null 2>&1
"$tool" bake sample --recipe linear --out sample.fbk > /dev/null 2>&1

"$tool" pose sample.fbk --set jaw_open=0.5 --out sample.glb
"$tool" pose sample.fbk --control-targets --out sample-targets.glb
"$tool" pose sample.fbk --clip sample/dialogue.controls.npy --out sample-clip.glb
for name in character compressed skinned driven carried; do
  "$tool" pose "$name.fbk" --out "$name.glb"
  "$tool" pose "$name.fbk" --clip "$name/clip.npy" --fps 24 --out "$name-clip.glb"
  "$tool" pose "$name.fbk" --clip "$name/clip.npy" --fps 24 --tolerance 1e-3 --out "$name-rough.glb"
  "$tool" pose "$name.fbk" --clip "$name/clip.npy" --fps 24 --control-targets --out "$name-targets.glb"
  "$tool" pose "$name.fbk" --clip "$name/clip.npy" --out "$name.obj" > /dev/null
done
node validate.mjs ./*.glb
for name in character compressed skinned driven carried; do
  node load_in_three.mjs "$name.glb" "$name"
  node load_in_three.mjs "$name-clip.glb" "$name" 5e-4 "$name".0*.obj
  node load_in_three.mjs "$name-rough.glb" "$name" 5e-2 "$name".0*.obj
  node load_in_three.mjs "$name-targets.glb" "$name"
done
