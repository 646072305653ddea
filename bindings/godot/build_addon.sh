#!/bin/sh
# Builds the addon: the module for Godot 3 or 4, with libfacebaker beside it, and its scripts. DIR becomes the folder
# addons/facebaker of a project; it must not be there yet. HEADERS holds gdnative_api_struct.gen.h (see get_headers.sh) or
# gdextension_interface.h; LIB is a build's lib/engines.
#   bindings/godot/build_addon.sh --godot 3|4 --headers HEADERS --libraries LIB [--linux-arm64 LIB] [--windows-x64 LIB] --out DIR
# With --linux-arm64 and --windows-x64 the addon has modules and libraries for these as well, cross-compiled; LIB is then
# the folder of libfacebaker.so or facebaker.dll for them. CXX in the environment is the compiler for this machine.
set -eu
usage() {
  sed -n 's/^#   /usage: /p' "$0" >&2
  exit 2
}
fail() { echo "build_addon.sh: $*" >&2; exit 1; }
godot= headers= libraries= arm64= windows= out=
while [ $# -gt 1 ]; do
  case $1 in
    --godot) godot=$2 ;;
    --headers) headers=$(realpath "$2") ;;
    --libraries) libraries=$(realpath "$2") ;;
    --linux-arm64) arm64=$(realpath "$2") ;;
    --windows-x64) windows=$(realpath "$2") ;;
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
[ -e "$headers/$header" ] || fail "there is no $headers/$header"
[ ! -e "$out" ] || fail "$out exists already"
cd "$(dirname "$0")/../.."
mkdir -p "$(dirname "$out")"
part=$(mktemp -d "$out.XXXXXX")
trap 'rm -rf "$part"' EXIT
mkdir "$part/bin"

# module COMPILER LIBRARY FOLDER MODULE OPTION...: the module in a folder of the addon, linked with the library beside it
module() {
  compiler=$1 library=$2 folder=$part/$3 name=$4
  shift 4
  [ -e "$library" ] || fail "there is no $library"
  mkdir -p "$folder"
  cp -L "$library" "$folder/"
  $compiler -std=c++17 -O2 -shared -fvisibility=hidden -Wall -Wextra -Werror -Icapi/include -isystem "$headers" \
    bindings/godot/src/godot_face.cpp "bindings/godot/src/godot${godot}_module.cpp" bindings/engine/face_pose.cpp \
    bindings/engine/render_surfaces.cpp bindings/engine/shared_archives.cpp -o "$folder/$name" "$@"
}
# linux COMPILER LIB FOLDER
linux() {
  # Exported projects have the library under this name alone.
  soname=$(readelf -d "$2/libfacebaker.so" | sed -n 's/.*(SONAME).*\[\(.*\)\]/\1/p') || soname=
  [ ! -e "$2/libfacebaker.so" ] || [ "$soname" = libfacebaker.so ] ||
    fail "$2/libfacebaker.so: modules look for it as $soname (its SONAME); a build has one to pack in lib/engines"
  module "$1" "$2/libfacebaker.so" "$3" "libfacebaker_godot$godot.so" -fPIC -L"$part/$3" -lfacebaker \
    -Wl,-rpath,'$ORIGIN' -Wl,--no-undefined
}
linux "${CXX:-c++}" "$libraries" bin
# GDNative's header asks for x86's calling convention on every processor.
[ -z "$arm64" ] || linux "aarch64-linux-gnu-g++ -Wno-attributes" "$arm64" bin/linux-arm64
# The compiler's runtime is linked into the module, as it is into the library. The linker would take time and the name of the
# output's folder into the file.
[ -z "$windows" ] || module x86_64-w64-mingw32-g++-posix "$windows/facebaker.dll" bin "facebaker_godot$godot.dll" \
  "$windows/facebaker.dll" -static -s -Wl,--no-insert-timestamp \
  -Wl,--disable-auto-image-base
cp bindings/godot/addon"$godot"/* LICENSE "$part/"
python3 -B packager/packages/notices.py "$part" "$(head -n 1 VERSION)" "$libraries/libfacebaker.so" \
  ${arm64:+"$arm64/libfacebaker.so"} ${windows:+"$windows/facebaker.dll"}
chmod 755 "$part"
mv "$part" "$out"
