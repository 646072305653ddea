#!/bin/sh
# Bakes glTF and VRM files as they are, and compares what is read of them with three.js' own evaluation of the files
# (npm, into build/gltf): frames of animations, and other poses. Then measures the baked faces. Prints a line of figures
# a file and way to read its joints; fails where three.js shows anything else.
#   tests/packager/compare_three.sh FILE...
# Environment: FACEBAKER (build/release/bin/facebaker), POSES (sampled, 60), RECIPE (compact), EPOCHS (4),
# CONTROL_JOINTS (names of joints that are controls, in place of all that animations move).
set -eu
[ $# -gt 0 ] || { sed -n '2,7s/^# *//p' "$0" >&2; exit 2; }
here=$(realpath "$(dirname "$0")")
root=$(realpath "$here/../..")
tool=$(realpath "${FACEBAKER:-$root/build/release/bin/facebaker}")
work=$root/build/gltf
mkdir -p "$work"
[ -d "$work/node_modules/three" ] ||
  (cd "$work" && npm install --ignore-scripts --no-audit --no-fund gltf-validator three)
cp "$here"/gltf/*.mjs "$work"
failed=0
for file; do
  file=$(realpath "$file")
  for joints in ignore controls; do
    name=$(basename "$file")-$joints
    options="--joints $joints"
    if [ $joints = controls ]; then for joint in ${CONTROL_JOINTS-}; do options="$options --control-joint $joint"; done; fi
    out=$work/three-$name
    rm -rf "$out" "$out.fbk"
    if ! "$tool" sample "$file" $options --poses "${POSES:-60}" --clip-budget 400 --out "$out" \
      > "$out.log" 2>&1; then
      echo "$name: $(tail -1 "$out.log")"
      continue
    fi
    node "$work/compare_with_three.mjs" "$file" "$out" || failed=1
    "$tool" bake "$file" $options --recipe "${RECIPE:-compact}" --epochs "${EPOCHS:-4}" --out "$out.fbk" \
      > "$out.log" 2>&1 || { echo "$name: $(tail -1 "$out.log")"; failed=1; continue; }
    "$tool" eval "$out.fbk" "$file" $options --json "$out.json" > /dev/null 2>> "$out.log"
    node -e 'const [name, json, fbk] = process.argv.slice(1), { total } = JSON.parse(fs.readFileSync(json));
      console.log(`${name}: baked into ${fs.statSync(fbk).size} bytes, mse ${total.mse.toExponential(2)}, ` +
        `max ${total.max.toExponential(2)} of the diagonal on ${total.frames ?? "all"} frames`);' "$name" "$out.json" "$out.fbk"
    grep -h "measured on\|are drawn" "$out.log" | tail -1 || true
  done
done
exit $failed
