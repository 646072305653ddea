#!/bin/sh
# Tests the Blender add-on in Blender, which it installs (Debian, 3.4) where there is none. Takes about three minutes; with
# --rigify it also bakes Rigify's human with the sample face, as docs/blender.md tells, and prints the figures: 22
# minutes of processor time. --keep DIR keeps what that makes.
#   bindings/blender/test.sh [--rigify] [--keep DIR] [BUILD]
set -eu
cd "$(dirname "$0")/../.."
rigify= keep=
while [ $# -gt 0 ]; do
  case $1 in
    --rigify) rigify=yes ;;
    --keep) keep=$(realpath -m "$2"); shift ;;
    -*) echo "usage: bindings/blender/test.sh [--rigify] [--keep DIR] [BUILD]" >&2; exit 2 ;;
    *) break ;;
  esac
  shift
done
build=$(realpath "${1:-build/release}")
if ! command -v blender > /dev/null; then
  as_root=
  [ "$(id -u)" -eq 0 ] || as_root=sudo
  $as_root apt-get -o DPkg::Lock::Timeout=600 -q update
  $as_root env DEBIAN_FRONTEND=noninteractive \
    apt-get -o DPkg::Lock::Timeout=600 -q install -y --no-install-recommends blender
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
FACEBAKER_SAMPLE=$keep/sample blender -b --factory-startup -P bindings/blender/tests/in_blender.py --
if command -v mypy > /dev/null; then
  (cd bindings/blender && mypy --strict --ignore-missing-imports --allow-subclassing-any --cache-dir "$keep/mypy" facebaker_blender)
fi
[ -n "$rigify" ] || exit 0

[ -e "$keep/face.blend" ] || blender -b --factory-startup --python-exit-code 1 -P bindings/blender/tests/rigify_face.py \
  -- "$keep/sample" "$keep/face.blend" > "$keep/scene.log" 2>&1
blender -b "$keep/face.blend" --factory-startup -P bindings/blender/facebaker_blender/headless.py -- \
  bake --out "$keep/face.fbk" --collections 0,1,2 --recipe compact --rig-budget 48000 \
  --json "$keep/measure.json" --preview "$keep/preview.blend" --picture "$keep/preview.png"
