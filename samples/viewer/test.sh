#!/bin/sh
# Tests the viewer and the pages of reports in headless Chromium (Debian's, installed where there is none) by Playwright
# and axe-core (npm, into build/viewer-test): a face is loaded and posed, 256 random poses of every mesh have the native
# bits, files that are broken are refused with a message, clips are played, links carry poses, and pages are accessible,
# wide and narrow, light and dark. Pictures of all of it end up in build/viewer-test/pictures, to be looked at.
#   samples/viewer/test.sh [--picture OUT | --drag-picture OUT] [FACE.fbk SOURCE]
# By default a face that is baked here, in about a minute. --picture and --drag-picture test nothing, and draw
# the pictures of docs/viewer.md, which are of the quickstart's face and of "sample", as .png or .jpg. Environment:
# FACEBAKER (build/release/bin/facebaker), VIEWER_PAGE (a built viewer; by default it is built), VIEWER_UNTIMED=1 on a
# machine that others use: the time to the first face is printed and not checked, VIEWER_ONLY (a pattern of tests to run).
set -eu
picture=
kind=
if [ "${1-}" = --picture ] || [ "${1-}" = --drag-picture ] && [ $# -ge 2 ]; then
  kind=$1
  picture=$(realpath -m "$2")
  shift 2
fi
[ $# -eq 0 ] || [ $# -eq 2 ] || { sed -n '2,12s/^# *//p' "$0" >&2; exit 2; }
here=$(realpath "$(dirname "$0")")
root=$(realpath "$here/../..")
tool=$(realpath "${FACEBAKER:-$root/build/release/bin/facebaker}")
work=$root/build/viewer-test
mkdir -p "$work"

if ! command -v "${CHROMIUM:-chromium}" >/dev/null; then
  as_root=
  [ "$(id -u)" -eq 0 ] || as_root=sudo
  $as_root apt-get -o DPkg::Lock::Timeout=600 -q install -y --no-install-recommends chromium >&2
fi
rm -f "$work"/*.mjs
cp "$here"/tests/*.mjs "$here"/tests/package.json "$work"
[ -d "$work/node_modules/playwright-core" ] && [ -d "$work/node_modules/axe-core" ] ||
  (cd "$work" && npm install --ignore-scripts --no-package-lock --no-audit --no-fund) >&2

page=$(realpath -m "${VIEWER_PAGE:-$root/build/viewer}")
[ -n "${VIEWER_PAGE-}" ] || "$here/build.sh" "$page" >&2

if [ $# -eq 2 ]; then
  face=$(realpath "$1") source=$2
else
  face=$work/face.fbk source=sample
  [ -f "$face" ] || "$tool" bake sample --recipe compact --poses 600 --epochs 4 --out "$face" >/dev/null
fi
for name in masked body; do
  [ ! -f "$work/$name.fbk" ] || continue
  node "$here/tests/make_glb.mjs" $name "$work/$name.glb"
  "$tool" bake "$work/$name.glb" --recipe linear --out "$work/$name.fbk" >/dev/null
done
jaw=$work/jaw.fbk # with a driven joint
if [ ! -f "$jaw" ]; then
  node "$here/tests/make_glb.mjs" jaw "$work/jaw.glb"
  "$tool" bake "$work/jaw.glb" --joints controls --recipe compact --poses 200 --epochs 1 --out "$jaw" >/dev/null
fi
export VIEWER_MASKED="$work/masked.fbk" VIEWER_BODY="$work/body.fbk"
export FACEBAKER="$tool" VIEWER_PAGE="$page" VIEWER_FACE="$face" VIEWER_SOURCE="$source" VIEWER_PICTURES="$work/pictures"
if [ -n "$picture" ]; then
  cd "$work"
  exec node draw_picture.mjs "$kind" "$picture"
fi
library=$(dirname "$tool")/../lib/libfacebaker.so
character=$root/tests/golden/2.0/accepted/character.fbk # of several meshes
dump() {
  PYTHONPATH="$root/bindings/python" FACEBAKER_LIBRARY="${FACEBAKER_LIBRARY:-$library}" \
    /usr/bin/python3 "$here/tests/dump_poses.py" "$1" 256 "$2"
}
dump "$face" "$work/poses"
dump "$character" "$work/character"
dump "$jaw" "$work/jaw"

[ $# -gt 0 ] || export VIEWER_DATA="$work/data" # of the sample face
if [ ! -f "$work/reports/eval/index.html" ]; then
  mkdir -p "$work/reports"
  [ -d "$work/data" ] || "$tool" sample sample --poses 60 --clip-budget 48 --out "$work/data" >/dev/null
  "$tool" compare "$work/data" --methods linear,compact --epochs 1 --report "$work/reports/compare" >/dev/null
  "$tool" bake "$work/data" --recipe linear --out "$work/small.fbk" --report "$work/reports/bake" >/dev/null
  "$tool" eval "$work/small.fbk" "$work/data" --report "$work/reports/eval" >/dev/null
fi

cd "$work"
export VIEWER_POSES="$work/poses" VIEWER_CHARACTER="$character" VIEWER_CHARACTER_POSES="$work/character" \
  VIEWER_JAW="$jaw" VIEWER_JAW_SOURCE="$work/jaw.glb" VIEWER_JAW_POSES="$work/jaw" VIEWER_REPORTS="$work/reports" \
  VIEWER_RIGHTS="$root/tests/fixtures/rights/cases.json"
node --test --test-concurrency=1 --test-name-pattern="${VIEWER_ONLY:-.}" *.test.mjs
echo "pictures: $work/pictures"
