#!/bin/sh
# What a bake makes of a live rig with a budget of N calls, beside a folder of N recorded poses of the same rig, on clips
# that neither has seen: bench_rig_budget.sh [--epochs E] [--recipes "linear hero"] [--keep DIR] N...
# Prints a table in Markdown of the mse of each clip of the production rig, over the diagonal. Needs a release build with
# the targets facebaker, rig_production and record_production. A bake of hero takes from minutes to half an hour; what is
# in DIR already, from the same build, is not baked again.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
tool=$root/build/release/bin/facebaker
rig=$root/build/release/lib/rigs/librig_production.so
epochs=0 recipes="linear hero" keep=
while [ $# -gt 0 ]; do
  case $1 in
    --epochs) epochs=$2 ;;
    --recipes) recipes=$2 ;;
    --keep) keep=$2 ;;
    *) break ;;
  esac
  shift 2
done
[ $# -gt 0 ] || { echo "give the numbers of poses" >&2; exit 1; }
if [ -z "$keep" ]; then
  keep=$(mktemp -d)
  trap 'rm -rf "$keep"' EXIT
fi
mkdir -p "$keep"

# row RECIPE SOURCE N ARGUMENT...: bakes unless it is done, and prints a row.
row() {
  recipe=$1 source=$2 poses=$3
  shift 3
  face=$keep/$recipe.$source.$poses
  if [ ! -e "$face.fbk" ] && ! "$tool" bake "$@" --recipe "$recipe" --epochs "$epochs" --out "$face.fbk" \
      > "$face.log" 2>&1; then
    echo "| $recipe | $source | $poses | refused | | | | |"
    return
  fi
  "$tool" eval "$face.fbk" "$rig" 2> /dev/null | awk -F'|' -v row="$recipe | $source | $poses" \
    -v calls="$(awk -F'|' '/^. rig calls/ {gsub(/ /, "", $3); print $3}' "$face.log")" \
    -v seconds="$(awk -F'|' '/^. training, seconds/ {gsub(/ /, "", $3); print $3}' "$face.log")" '
    { gsub(/ /, "") }
    $2 == "talking" || $2 == "expressive" || $2 == "random" { mse[$2] = $6 }
    END { print "| " row " | " mse["talking"] " | " mse["expressive"] " | " mse["random"] " | " calls " | " seconds " |" }'
}

echo "| recipe | poses are | N | talking | expressive | random | rig calls | training, seconds |"
echo "| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: |"
for poses in "$@"; do
  recorded=$keep/recorded_$poses
  [ -e "$recorded/dataset.json" ] || "$root/build/release/bin/record_production" "$rig" "$recorded" "$poses" > /dev/null
  for recipe in $recipes; do
    row "$recipe" live "$poses" "$rig" --rig-budget "$poses"
    row "$recipe" recorded "$poses" "$recorded"
  done
done
