#!/bin/sh
# Builds the addon for this machine: the module for Godot 3 or 4, with libfacebaker beside it, and its scripts. DIR becomes the
# folder addons/facebaker of a project; it must not be there yet. HEADERS holds gdnative_api_struct.gen.h (see
# get_headers.sh) or gdextension_interface.h; LIB is a build's lib/engines.
#   bindings/godot/build_addon.sh --godot 3|4 --headers HEADERS --libraries LIB --out DIR
set -eu
usage() { echo "usage: bindings/godot/build_addon.sh --godot 3|4 --headers HEADERS --libraries LIB --out DIR" >&2; exit 2; }
godot= headers= libraries= out=
while [ $# -gt 1 ]; do
  case $1 in
    --godot) godot=$2 ;;
    --headers) headers=$(realpath "$2") ;;
    --libraries) libraries=$(realpath "$2") ;;
    --out) out=$(realpath -m "$2") ;;
    *) usage ;;
  esac
  shift 2
done
case $godot in
  3) header=gdnative_api_struct.gen.h ;;
  4) header=gdextension_interface.h ;;
  *) usage ;;
esac
[ -n "$headers" ] && [ -n "$libraries" ] && [ -n "$out" ] || usage
[ -e "$headers/$header" ] || { echo "build_addon.sh: there is no $headers/$header" >&2; exit 1; }
[ -e "$libraries/libfacebaker.so" ] || { echo "build_addon.sh: there is no $libraries/libfacebaker.so" >&2; exit 1; }
# Exported projects have the library under this name alone.
soname=$(objdump -p "$libraries/libfacebaker.so" | awk '$1 == "SONAME" { print $2 }')
[ "$soname" = libfacebaker.so ] || {
  echo "build_addon.sh: $libraries/libfacebaker.so: modules look for it as $soname (its SONAME);" \
    "a build has one to pack in lib/engines" >&2
  exit 1
}
[ ! -e "$out" ] || { echo "build_addon.sh: $out exists already" >&2; exit 1; }
cd "$(dirname "$0")/../.."
mkdir -p "$(dirname "$out")"
part=$(mktemp -d "$out.XXXXXX")
trap 'rm -rf "$part"' EXIT
mkdir "$part/bin"
cp -L "$libraries/libfacebaker.so" "$part/bin/libfacebaker.so"
${CXX:-c++} -std=c++17 -O2 -fPIC -shared -fvisibility=hidden -Wall -Wextra -Werror -Icapi/include -isystem "$headers" \
  bindings/godot/src/godot_face.cpp "bindings/godot/src/godot${godot}_module.cpp" bindings/engine/face_pose.cpp \
  bindings/engine/render_surfaces.cpp -o "$part/bin/libfacebaker_godot$godot.so" -L"$part/bin" -lfacebaker \
  -Wl,-rpath,'$ORIGIN' -Wl,--no-undefined
cp bindings/godot/addon"$godot"/* LICENSE "$part/"
chmod 755 "$part"
mv "$part" "$out"
