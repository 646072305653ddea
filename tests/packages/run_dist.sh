#!/bin/sh
# Loads what build_dist.py made, each package as its user would, from an empty folder without environment variables: C on Linux
# x86-64, on AArch64 by QEMU and on Windows by Wine, which must give the same bits; Python from the wheel, C# from the NuGet
# package with Mono, JavaScript from the npm package in Node, Godot's addon, Unreal's build rules, the add-on for Blender, the tool.
#   tests/packages/run_dist.sh [--again] [--build BUILD] [DIST]
# DIST is a folder of build_dist.py, by default build/dist; it is made where it is not there. BUILD is a built tree of the project,
# by default build/release, for the fixtures that Godot's tests pose. --again: builds all of it a second time, from a clone of another name, and compares the bytes.
# What is not installed or not in DIST is skipped, and said; the last line counts. What runs elsewhere is not tested here: macOS,
# phones, Unity, Unreal; Python on AArch64 and Windows.
set -eu
cd "$(dirname "$0")/../.."
root=$PWD again="" build=build/release
while [ $# -gt 0 ]; do
  case $1 in
    --again) again=1 ;;
    --build) build=$2; shift ;;
    -*) echo "usage: tests/packages/run_dist.sh [--again] [--build BUILD] [DIST]" >&2; exit 2 ;;
    *) break ;;
  esac
  shift
done
build=$(realpath -m "$build")
dist=$(realpath -m "${1:-build/dist}")
[ -d "$dist" ] || packager/packages/build_dist.py "$dist"
version=$(head -n 1 VERSION)
face=$root/tests/golden/2.0/accepted/tiny.fbk
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
passed=0 skipped=0
fail() { echo "FAILED: $*" >&2; exit 1; }
pass() { passed=$((passed + 1)); echo "passed: $*"; }
skip() { skipped=$((skipped + 1)); echo "skipped: $*"; }
# alone FOLDER COMMAND...: as on another machine: in an empty folder, with PATH and HOME alone in the environment
alone() {
  empty=$(mktemp -d "$work/empty.XXXXXX")
  (cd "$empty" && env -i PATH=/usr/bin:/bin HOME="$empty" OMP_WAIT_POLICY=PASSIVE "$@")
}
there() { # there NAME: the one file of that name, which may have a pattern
  for found in "$dist"/$1; do [ -e "$found" ] && return 0; done
  return 1
}
unpack() { # unpack FILE: into a folder of its own, which it names
  folder=$(mktemp -d "$work/unpacked.XXXXXX")
  case $1 in
    *.tar.gz | *.tgz) tar -xzf "$1" -C "$folder" ;;
    *) python3 -B -m zipfile -e "$1" "$folder" ;;
  esac
  echo "$folder"
}

(cd "$dist" && sha256sum --check --quiet SHA256SUMS) || fail "SHA256SUMS"
[ "$(find "$dist" -type f | wc -l)" -eq $(($(wc -l < "$dist/SHA256SUMS") + 1)) ] || fail "SHA256SUMS does not name every file"
python3 -B tests/packages/check_dist.py "$dist" || fail "notices"
pass "checksums and notices"

# --- C, on three platforms -------------------------------------------------------------------------------------------
hashes=
# poses NAME HASH: compares with the others
poses() {
  case $2 in ????????????????) ;; *) fail "$1: \"$2\" is no hash" ;; esac
  [ -z "$hashes" ] || [ "$hashes" = "$2" ] || fail "$1 gives $2 and not $hashes"
  hashes=$2
  pass "$1: $2"
}
program=tests/determinism/hash_archive.c
if there "facebaker-runtime-$version-linux-x64.tar.gz"; then
  prefix=$(unpack "$found")/facebaker-runtime-$version-linux-x64
  cmake -S tests/consumers/app -B "$work/app" -D CMAKE_PREFIX_PATH="$prefix" -D HELLO="$root/samples/hello_face/hello_face.c" > "$work/log" &&
    cmake --build "$work/app" >> "$work/log" || { cat "$work/log"; fail "find_package"; }
  alone "$work/app/hello" "$face" jaw_open 1 > "$work/log" || fail "find_package: $(cat "$work/log")"
  cc -std=c99 $program -I"$prefix/include" "$prefix/lib/engines/libfacebaker.so" -Wl,-rpath,"$prefix/lib/engines" -lm -o "$work/hash"
  poses "C on Linux x86-64" "$(alone "$work/hash" 200 "$face" 2> "$work/log")"
else skip "C on Linux x86-64: not in $dist"; fi
if ! there "facebaker-runtime-$version-linux-arm64.tar.gz"; then skip "C on Linux AArch64: not in $dist"
elif ! command -v qemu-aarch64-static > /dev/null || ! command -v aarch64-linux-gnu-gcc > /dev/null; then
  skip "C on Linux AArch64: needs qemu-user-static and gcc-aarch64-linux-gnu"
else
  arm64=$(unpack "$found")/facebaker-runtime-$version-linux-arm64
  aarch64-linux-gnu-gcc -std=c99 $program -I"$arm64/include" "$arm64/lib/engines/libfacebaker.so" -lm \
    -Wl,-rpath,"$arm64/lib/engines" -o "$work/hash-arm64"
  poses "C on Linux AArch64, by QEMU" "$(alone qemu-aarch64-static -cpu max -L /usr/aarch64-linux-gnu "$work/hash-arm64" 200 "$face" 2> "$work/log")"
fi
wine=$(command -v wine64 || find /usr/lib/wine -name wine64 2> /dev/null | head -n 1)
if ! there "facebaker-runtime-$version-windows-x64.zip"; then skip "C on Windows: not in $dist"
elif [ -z "$wine" ] || ! command -v x86_64-w64-mingw32-gcc-posix > /dev/null; then skip "C on Windows: needs wine64 and gcc-mingw-w64-x86-64-posix"
else
  windows=$(unpack "$found")/facebaker-runtime-$version-windows-x64
  mkdir "$work/windows"
  cp "$windows/bin/facebaker.dll" "$work/windows/"
  for library in libfacebaker.dll.a facebaker.lib; do # MinGW's and the one for other compilers
    x86_64-w64-mingw32-gcc-posix -std=c99 -D__USE_MINGW_ANSI_STDIO=1 $program -I"$windows/include" "$windows/lib/$library" -o "$work/windows/hash.exe"
    hash=$(alone env WINEDEBUG=-all WINEPREFIX="$work/wine" "$wine" "$work/windows/hash.exe" 200 "$face" 2> "$work/log" | tr -d '\r')
    poses "C on Windows, by Wine, with $library" "$hash"
  done
fi

# --- Languages: the bits of one vertex ------------------------------------------------------------------------------
bits=
# vertex NAME BITS
vertex() {
  case $2 in ????????????????????????) ;; *) fail "$1: \"$2\" is no vertex" ;; esac
  [ -z "$bits" ] || [ "$bits" = "$2" ] || fail "$1 gives $2 and not $bits"
  bits=$2
  pass "$1: $2"
}
if there "facebaker-$version-py3-none-manylinux*_x86_64.whl"; then
  /usr/bin/python3 -m venv --system-site-packages --without-pip "$work/venv"
  /usr/bin/python3 -m pip --python "$work/venv/bin/python3" install --quiet --no-index --no-deps --disable-pip-version-check "$found"
  vertex "Python from the wheel" "$(alone "$work/venv/bin/python3" -c '
import sys, facebaker
assert facebaker.__file__.startswith(sys.prefix), facebaker.__file__
face = facebaker.load(sys.argv[1])
pose = face.pose({face.controls[0].name: 0.7})
print(face.evaluate(pose)[0].tobytes().hex())' "$face")"
else skip "Python: not in $dist"; fi
if ! there "FaceBaker.$version.nupkg"; then skip "C#: not in $dist"
elif ! command -v mcs > /dev/null || [ ! -e /usr/lib/mono/4.5/Facades/netstandard.dll ]; then skip "C#: needs mono-devel"
else
  package=$(unpack "$found")
  mkdir "$work/mono"
  cp "$package/lib/netstandard2.1/FaceBaker.dll" "$package/runtimes/linux-x64/native/libfacebaker.so" "$work/mono/"
  mcs -r:"$work/mono/FaceBaker.dll" -r:/usr/lib/mono/4.5/Facades/netstandard.dll -out:"$work/mono/VertexBits.exe" tests/packages/VertexBits.cs
  vertex "C# from the NuGet package, with Mono" "$(alone mono "$work/mono/VertexBits.exe" "$face")"
  platforms=$(cd "$package/runtimes" && for rid in *; do echo "$rid"; done | sed 's/^win-/windows-/; s/^osx$/macos/')
  # shellcheck disable=SC2086 # names of platforms
  python3 -B bindings/csharp/tests/check_nuget.py "$found" $platforms > "$work/log" || { cat "$work/log"; fail "the NuGet package"; }
  pass "$(cat "$work/log")"
fi
if ! there "facebaker-$version.tgz"; then skip "JavaScript: not in $dist"
elif ! command -v npm > /dev/null; then skip "JavaScript: needs node and npm"
else
  mkdir "$work/node"
  echo '{ "private": true, "type": "module" }' > "$work/node/package.json"
  (cd "$work/node" && npm install --offline --no-audit --no-fund --omit=peer "$found" > "$work/log" 2>&1) || { cat "$work/log"; fail "npm install"; }
  cat > "$work/node/bits.js" << 'END'
import { readFile } from "node:fs/promises";
import { load } from "facebaker";
const face = await load(await readFile(process.argv[2]));
const controls = face.createPose();
controls[0] = 0.7;
console.log(Buffer.from(face.evaluate(controls).slice(0, 3).buffer).toString("hex"));
END
  vertex "JavaScript from the npm package, in Node" "$(alone "$(command -v node)" "$work/node/bits.js" "$face")"
fi

# --- Engines ---------------------------------------------------------------------------------------------------------
# fixtures FOLDER: faces, and poses of them by the C interface, which the engines' tests compare with
fixtures() {
  mkdir -p "$1"
  [ -e "$work/dump_poses" ] || cc -std=c99 -O2 bindings/engine/tests/dump_poses.c -I"$prefix/include" \
    "$prefix/lib/engines/libfacebaker.so" -Wl,-rpath,"$prefix/lib/engines" -o "$work/dump_poses"
  for one in "$build"/fixtures/*.fbk; do
    cp "$one" "$1/"
    "$work/dump_poses" "$one" "$1/$(basename "$one" .fbk).poses"
  done
  cp "$root/tests/golden/2.0/rejected/corrupt-bit.fbk" "$1/broken.bin"
}
if ! there "facebaker_godot3-$version.zip"; then skip "Godot 3: not in $dist"
elif ! command -v godot3-server > /dev/null || [ -z "${prefix-}" ] || [ ! -d "$build/fixtures" ]; then
  skip "Godot 3: needs godot3-server, the runtime for Linux and $build/fixtures"
else
  addon=$(unpack "$found")
  cp -r bindings/godot/tests/project "$work/godot3"
  cp -r "$addon/addons" "$work/godot3/"
  fixtures "$work/godot3/faces"
  mkdir -p "$work/home/.local/share" "$work/home/.config" "$work/home/.cache"
  alone env HOME="$work/home" timeout 90 godot3-server --path "$work/godot3" > "$work/log" 2>&1 || { cat "$work/log"; fail "the scene in Godot 3"; }
  pass "Godot 3: $(tail -n 1 "$work/log")"
fi
headers=$root/build/gdextension
if ! there "facebaker_godot4-$version.zip"; then skip "Godot 4: not in $dist"
elif [ ! -e "$headers/gdextension_interface.h" ] || [ -z "${prefix-}" ] || [ ! -d "$build/fixtures" ]; then
  skip "Godot 4: needs $headers, the runtime for Linux and $build/fixtures"
else
  addon=$(unpack "$found")
  fixtures "$work/godot4"
  c++ -std=c++17 -O1 -isystem "$headers" bindings/godot/tests/stubbed_godot4.cpp -o "$work/godot4/stubbed" -ldl
  alone "$work/godot4/stubbed" "$addon/addons/facebaker/bin/libfacebaker_godot4.so" "$work/godot4/driven.fbk" "$work/godot4/driven.poses" \
    "$work/godot4/broken.bin" > "$work/log" 2>&1 || { cat "$work/log"; fail "the module for Godot 4"; }
  pass "Godot 4, over stubs: $(tail -n 1 "$work/log")"
fi
if ! there "facebaker_unreal-$version.zip"; then skip "Unreal: not in $dist"
elif ! command -v mcs > /dev/null; then skip "Unreal: needs mono-mcs"
else
  plugin=$(unpack "$found")/FaceBaker
  mcs -langversion:latest -out:"$work/rules.exe" "$plugin"/Source/*/*.Build.cs bindings/unreal/tests/*.cs
  mono "$work/rules.exe" "$plugin" > "$work/log" 2>&1 || { cat "$work/log"; fail "the plugin for Unreal"; }
  pass "Unreal: $(cat "$work/log")"
fi
if there "org.facebaker.unity-$version.tgz"; then
  package=$(unpack "$found")/package
  python3 -B bindings/csharp/tests/check_package.py "$package" > "$work/log" 2>&1 || { cat "$work/log"; fail "the Unity package"; }
  pass "Unity: $(tail -n 1 "$work/log")"
else skip "Unity: not in $dist"; fi

# --- The tool --------------------------------------------------------------------------------------------------------
if there "facebaker-$version-Linux-*.tar.gz"; then
  tool=$(unpack "$found")
  alone "$tool"/*/bin/facebaker verify "$face" > "$work/log" 2>&1 || { cat "$work/log"; fail "the tool"; }
  pass "the tool: $(tail -n 1 "$work/log")"
else skip "the tool: not in $dist"; fi
if there "facebaker_blender-$version-*.zip"; then
  addon=$(unpack "$found")/facebaker_blender/carried
  chmod +x "$addon"/bin/* # the add-on does so
  alone "$addon/bin/facebaker" verify "$face" > "$work/log" || fail "the tool of the add-on for Blender: $(cat "$work/log")"
  vertices=$(alone env PYTHONPATH="$addon" /usr/bin/python3 -B -c '
import sys, facebaker
assert facebaker.__file__.startswith(sys.argv[2]), facebaker.__file__
print(facebaker.load(sys.argv[1]).vertex_count)' "$face" "$addon") || fail "the Python package of the add-on for Blender"
  pass "the add-on for Blender: $vertices vertices"
else skip "the add-on for Blender: not in $dist"; fi
if there "facebaker-$version-source.tar.gz"; then
  [ -s "$(unpack "$found")/facebaker-$version/capi/include/facebaker/facebaker.h" ] || fail "the source archive is not whole"
  pass "the source archive"
else skip "the source archive: not in $dist"; fi

if there "facebaker_vcpkg-$version.zip"; then
  cmake -D PORT="$(unpack "$found")/facebaker" -D OUT="$work/vcpkg" -P tests/packages/vcpkg_stubs.cmake > "$work/log" 2>&1 ||
    { tail -n 20 "$work/log"; fail "the port for vcpkg"; }
  [ -e "$work/vcpkg/package/lib/libfacebaker.so" ] || fail "the port for vcpkg installs no library"
  pass "the port for vcpkg, over stubs of vcpkg"
else skip "the port for vcpkg: not in $dist"; fi

if [ -n "$again" ]; then
  git clone --quiet "$root" "$work/another_name"
  mkdir "$work/another_name/build"
  for kept in cross gdnative gdextension viewer; do
    [ ! -e "build/$kept" ] || cp -r "build/$kept" "$work/another_name/build/"
  done
  parts=$(awk '{ print $2 }' "$dist/SHA256SUMS" | sed -n 's/.*source.*/source/p; s/.*-runtime-.*/runtime/p; s/.*_vcpkg-.*/vcpkg/p; s/.*nupkg/nupkg/p
    s/.*unity-.*/unity/p; s/.*unreal-.*/unreal/p; s/.*godot3-.*/godot3/p; s/.*godot4-.*/godot4/p; s/.*blender-.*/blender/p
    s/.*\.whl/wheels/p; s/.*-Linux-.*gz/linux/p; s/^facebaker-[0-9.]*\.tgz/npm/p' | sort -u | paste -sd,)
  viewer=--without-viewer
  [ ! -e "$work/another_name/build/viewer" ] || viewer=
  # shellcheck disable=SC2086
  "$work/another_name/packager/packages/build_dist.py" --only "$parts" $viewer "$work/second" > "$work/log" 2>&1 || { tail -n 40 "$work/log"; fail "building again"; }
  grep -v '\.deb$' "$dist/SHA256SUMS" | diff - "$work/second/SHA256SUMS" || fail "a second build, from another folder, gives other bytes"
  pass "a second build gives the same bytes"
fi
echo "$passed passed, $skipped skipped"
