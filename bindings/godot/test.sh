#!/bin/sh
# Builds the GDNative module for Godot 3.x and runs a scene in godot3-server, which it installs (Debian) where there is none:
# positions against the C interface's, bit for bit, errors, signals, sliders, materials; then once more as an exported game, in a
# folder of its own. GDNative's headers are taken from Debian's source
# package of Godot (22 MB), or from the folder --headers names. With --gdextension HEADER (gdextension_interface.h of Godot
# 4.2 or later) it also calls the module for Godot 4 over stubs of that interface. Takes a minute.
# --offline installs and fetches nothing, and ends with 77 where Godot or the folder of --headers is missing.
#   bindings/godot/test.sh [--offline] [--headers DIR] [--gdextension HEADER] [BUILD]
set -eu
cd "$(dirname "$0")/../.."
headers= extension= offline=
while [ $# -gt 0 ]; do
  case $1 in
    --offline) offline=1 ;;
    --headers) headers=$(realpath -m "$2"); shift ;;
    --gdextension) extension=$(realpath "$2"); shift ;;
    -*) echo "usage: bindings/godot/test.sh [--offline] [--headers DIR] [--gdextension HEADER] [BUILD]" >&2; exit 2 ;;
    *) break ;;
  esac
  shift
done
build=$(realpath "${1:-build/release}")
if [ -n "$offline" ]; then
  command -v godot3-server > /dev/null || { echo "skipped: there is no godot3-server"; exit 77; }
  [ -e "$headers/gdnative_api_struct.gen.h" ] || { echo "skipped: there are no headers in $headers (get_headers.sh)"; exit 77; }
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
if ! command -v godot3-server > /dev/null; then
  as_root=
  [ "$(id -u)" -eq 0 ] || as_root=sudo
  $as_root apt-get -o DPkg::Lock::Timeout=600 -q update
  $as_root env DEBIAN_FRONTEND=noninteractive \
    apt-get -o DPkg::Lock::Timeout=600 -q install -y --no-install-recommends godot3-server
fi
[ -n "$headers" ] || { bindings/godot/get_headers.sh "$work/headers"; headers=$work/headers; }

bindings/godot/build_addon.sh --godot 3 --headers "$headers" --libraries "$build/lib/engines" --out "$work/addon"
project=$work/project
cp -r bindings/godot/tests/project "$project"
mkdir "$project/addons" "$project/faces"
mv "$work/addon" "$project/addons/facebaker"
${CC:-cc} -std=c99 -Wall -Wextra -Werror -O2 -Icapi/include bindings/engine/tests/dump_poses.c -o "$work/dump_poses" \
  -L"$build/lib" -lfacebaker -Wl,-rpath,"$build/lib"
for face in "$build"/fixtures/*.fbk "$build/golden/accepted/driven-exact-levels.fbk" "$build/../quickstart/sample.fbk"; do
  [ -e "$face" ] || continue  # the quickstart's, where it was run
  cp "$face" "$project/faces/"
  "$work/dump_poses" "$face" "$project/faces/$(basename "$face" .fbk).poses"
done
cp "$build/golden/rejected/corrupt-bit.fbk" "$project/faces/broken.bin"
bindings/engine/tests/run_packed.sh "$work/project" "$build" timeout 90 godot3-server --path . ||
  { echo "the scene failed" >&2; exit 1; }

# The game that Godot's editor exports, with the server in place of the player that a release would have.
mkdir "$work/game"
HOME=$project/home timeout 90 godot3-server --path "$project" --export linux "$work/game/game" > "$work/export.log" 2>&1 ||
  { cat "$work/export.log"; exit 1; }
mv "$project" "$work/moved"
bindings/engine/tests/run_packed.sh "$work/game" "$build" timeout 90 ./game ||
  { echo "the exported game failed" >&2; exit 1; }

[ -z "$extension" ] || {
  bindings/godot/build_addon.sh --godot 4 --headers "$(dirname "$extension")" --libraries "$build/lib/engines" \
    --out "$work/addon4"
  ${CXX:-c++} -std=c++17 -O1 -g -fsanitize=address -Wall -Wextra -Werror -isystem "$(dirname "$extension")" \
    bindings/godot/tests/stubbed_godot4.cpp -o "$work/stubbed_godot4" -ldl
  ASAN_OPTIONS=detect_leaks=0 "$work/stubbed_godot4" "$work/addon4/bin/libfacebaker_godot4.so" \
    "$work/moved/faces/driven.fbk" "$work/moved/faces/driven.poses" "$work/moved/faces/broken.bin"
  echo "the module for Godot 4 was called over stubs, and not run in Godot"
}
