#!/bin/sh
# How bakes, archives, loading and poses grow with vertices, controls and poses, on the dense rig (see tests/rigs/dense):
#   bench_scale.sh [--build DIR] [--keep DIR] [ROW...]
# A ROW is divisions,controls,poses,recipe,use, such as 2,60,2000,compact,backlot; without any, those of the table in
# docs/large-faces.md, which take half an hour. Prints that table and the exponents. What is baked already in DIR of --keep is
# not baked again; loading and poses are measured anew, after all bakes, so that they may be run when the machine is
# quiet. Needs a release build with the targets facebaker and rig_dense, Python 3, and 12 GB of disk for 400,000 vertices.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
build=$root/build/release keep=
while [ $# -gt 0 ]; do
  case $1 in
    --build) build=$2 ;;
    --keep) keep=$2 ;;
    *) break ;;
  esac
  shift 2
done
if [ -z "$keep" ]; then
  keep=$(mktemp -d)
  trap 'rm -rf "$keep"' EXIT
fi
mkdir -p "$keep"
# One of vertices, controls and poses grows at a time.
[ $# -gt 0 ] || set -- 1,60,1000,compact,backlot 2,60,1000,compact,backlot 4,60,1000,compact,backlot \
  8,60,1000,compact,backlot 2,250,1000,compact,backlot 2,500,1000,compact,backlot 2,2000,1000,compact,backlot \
  2,60,4000,compact,backlot
for row in "$@"; do
  python3 "$root/tests/bench/measure_bake.py" "$build" "$keep" "$row"
done
python3 "$root/tests/bench/scale_table.py" "$build" "$keep" "$@"
