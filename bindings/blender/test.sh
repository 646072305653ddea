#!/bin/sh
# Tests the Blender add-on in Blender: the one that BLENDER names, by default `blender`, which is installed (Debian) where
# there is none. Takes about five minutes; with --rigify it also bakes Rigify's human with the sample face, as
# docs/blender.md tells, and prints the figures: 22 minutes of processor time. --keep DIR keeps what that makes. Words after
# -- are the tests to run, such as preview_tests or preview_tests.PreviewTest.
#   [BLENDER=PROGRAM] bindings/blender/test.sh [--rigify] [--keep DIR] [BUILD] [-- TEST...]
set -eu
cd "$(dirname "$0")/../.."
rigify= keep= build=build/release
while [ $# -gt 0 ]; do
  case $1 in
    --) shift; break ;;
    --rigify) rigify=yes ;;
    --keep) keep=$(realpath -m "$2"); shift ;;
    -*) echo "usage: bindings/blender/test.sh [--rigify] [--keep DIR] [BUILD] [-- TEST...]" >&2; exit 2 ;;
    *) build=$1 ;;
  esac
  shift
done
build=$(realpath "$build")
blender=${BLENDER:-blender}
if ! command -v "$blender" > /dev/null; then
  [ "$blender" = blender ] || { echo "$blender: no such program" >&2; exit 1; }
  as_root=
  [ "$(id -u)" -eq 0 ] || as_root=sudo
  $as_root apt-get -o DPkg::Lock::Timeout=600 -q update
  $as_root env DEBIAN_FRONTEND=noninteractive \
    apt-get -o DPkg::Lock::Timeout=600 -q install -y --no-install-recommends blender python3-numpy
fi
if [ -z "$keep" ]; then
  keep=$(mktemp -d)
  trap 'rm -rf "$keep"' EXIT
fi
mkdir -p "$keep"
export FACEBAKER_TOOL="${FACEBAKER_TOOL:-$build/bin/facebaker}"
export FACEBAKER_LIBRARY="${FACEBAKER_LIBRARY:-$build/lib/libfacebaker.so}" OMP_WAIT_POLICY=PASSIVE
export PYTHONDONTWRITEBYTECODE=1

[ -e "$keep/sample/dataset.json" ] || "$FACEBAKER_TOOL" sample sample --poses 20 --out "$keep/sample" > /dev/null 2>&1
FACEBAKER_SAMPLE=$keep/sample "$blender" -b --factory-startup --python-exit-code 1 -P bindings/blender/tests/in_blender.py -- "$@"
if command -v mypy > /dev/null; then
  (cd bindings/blender && mypy --strict --ignore-missing-imports --allow-subclassing-any --cache-dir "$keep/mypy" facebaker_blender)
fi
[ -n "$rigify" ] || exit 0

[ -e "$keep/face.blend" ] || "$blender" -b --factory-startup --python-exit-code 1 -P bindings/blender/tests/rigify_face.py \
  -- "$keep/sample" "$keep/face.blend" > "$keep/scene.log" 2>&1
case $("$blender" --version | head -n 1) in
  "Blender 3"*) collections=0,1,2 ;;
  *) collections="Face,Face (Primary),Face (Secondary)" ;;
esac
"$blender" -b "$keep/face.blend" --factory-startup -P bindings/blender/facebaker_blender/headless.py -- \
  bake --out "$keep/face.fbk" --collections "$collections" --recipe compact --rig-budget 48000 \
  --json "$keep/measure.json" --preview "$keep/preview.blend" --picture "$keep/preview.png"
