#!/bin/sh
# Builds the GDExtension and runs a scene with it in Godot 4 of Debian sid: positions against the C interface's, bit for bit,
# vertex buffers against the engine's own, errors, signals, sliders, materials; headless, with a renderer (Mesa's, in Xvfb),
# and as an exported game, in folders of its own. The module is also called over stubs of the interface, with AddressSanitizer.
# As root: it makes a chroot of sid in ROOT (debootstrap), or goes on with the one that is there, and installs Godot in it: 1.2 GB.
#   bindings/godot/test4.sh [--root ROOT] [BUILD]
set -eu
cd "$(dirname "$0")/../.."
root=/var/tmp/facebaker-godot4
while [ $# -gt 0 ]; do
  case $1 in
    --root) root=$(realpath -m "$2"); shift ;;
    -*) echo "usage: bindings/godot/test4.sh [--root ROOT] [BUILD]" >&2; exit 2 ;;
    *) break ;;
  esac
  shift
done
build=$(realpath "${1:-build/release}")
[ "$(id -u)" -eq 0 ] || { echo "test4.sh: makes a chroot: run it as root" >&2; exit 2; }
options="-q -o DPkg::Lock::Timeout=600 -o Acquire::Check-Valid-Until=false"
if [ ! -e "$root/etc/debian_version" ]; then
  command -v debootstrap > /dev/null || apt-get $options install -y --no-install-recommends debootstrap
  debootstrap --variant=minbase sid "$root"
fi
# Mounts are those of this script, and go with it.
if [ -z "${FB_GODOT_MOUNTED:-}" ]; then
  FB_GODOT_MOUNTED=1 exec unshare --mount "$0" --root "$root" "$build"
fi
mount -t proc proc "$root/proc"
mount --bind /dev "$root/dev"
work=$(mktemp -d "$root/tmp/facebaker.XXXXXX")
trap 'rm -rf "$work"' EXIT
inside=${work#"$root"}
in_root() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 HOME="$inside/home" OMP_WAIT_POLICY=PASSIVE "$@"; }
if ! in_root sh -c 'command -v godot && command -v xvfb-run && command -v xauth' > /dev/null 2>&1; then
  in_root apt-get $options update || true  # the lists of a chroot that is some weeks old will do
  in_root env DEBIAN_FRONTEND=noninteractive \
    apt-get $options install -y --no-install-recommends godot libgomp1 xvfb xauth libgl1-mesa-dri libegl1 libgl1
fi
mkdir "$work/home" "$work/headers" "$work/project" "$work/game"
# Godot writes the header of its interface.
in_root sh -eu -c 'cd "$1" && godot --headless --dump-gdextension-interface' sh "$inside/headers" > "$work/log" 2>&1 &&
  [ -s "$work/headers/gdextension_interface.h" ] || { cat "$work/log"; exit 1; }

project=$work/project
cp bindings/godot/tests/project4/* "$project/"
mkdir "$project/addons" "$project/faces"
bindings/godot/build_addon.sh --godot 4 --headers "$work/headers" --libraries "$build/lib/engines" --out "$project/addons/facebaker"
${CC:-cc} -std=c99 -Wall -Wextra -Werror -O2 -Icapi/include bindings/engine/tests/dump_poses.c -o "$work/dump_poses" \
  -L"$build/lib" -lfacebaker -Wl,-rpath,"$build/lib"
for face in "$build"/fixtures/*.fbk "$build/golden/accepted/driven-exact-levels.fbk" "$build/../quickstart/sample.fbk"; do
  [ -e "$face" ] || continue  # the quickstart's, where it was run
  cp "$face" "$project/faces/"
  "$work/dump_poses" "$face" "$project/faces/$(basename "$face" .fbk).poses"
done
cp "$build/golden/rejected/corrupt-bit.fbk" "$project/faces/broken.bin"
mkdir "$project/.godot" # what the editor writes when it finds an extension
echo "res://addons/facebaker/facebaker.gdextension" > "$project/.godot/extension_list.cfg"
cp -r "$project" "$work/kept"

godot() { # godot FOLDER COMMAND...
  folder=$1
  shift
  timeout 600 chroot "$root" env -i PATH=/usr/bin:/bin LANG=C.UTF-8 HOME="$inside/home" OMP_WAIT_POLICY=PASSIVE \
    sh -eu -c 'cd "$1"; shift; exec "$@"' sh "$inside/$folder" "$@"
}
fail() { echo "FAILED: $*" >&2; exit 1; }
godot project godot --headless || fail "the scene, headless"
godot project xvfb-run -a -s "-screen 0 640x480x24" godot --rendering-driver opengl3 --audio-driver Dummy ||
  fail "the scene, with a renderer"

# The game that the editor exports, with the editor's program in place of the player that a release would have.
# A new project may need two calls: the first may end while Godot documents the extension (its issue 111048).
export_game() { godot project godot --headless --export-release linux "$inside/game/game" > "$work/log" 2>&1; }
export_game || true
[ -x "$work/game/game" ] || export_game || true
[ -x "$work/game/game" ] || { cat "$work/log"; fail "the export"; }
rm -r "$project"
ls "$work/game"
godot game ./game --headless || fail "the exported game"

${CXX:-c++} -std=c++17 -O1 -g -fsanitize=address -Wall -Wextra -Werror -isystem "$work/headers" \
  bindings/godot/tests/stubbed_godot4.cpp -o "$work/stubbed_godot4" -ldl
ASAN_OPTIONS=detect_leaks=0 "$work/stubbed_godot4" "$work/kept/addons/facebaker/bin/libfacebaker_godot4.so" \
  "$work/kept/faces/driven.fbk" "$work/kept/faces/driven.poses" "$work/kept/faces/broken.bin"
