#!/bin/sh
# Evaluates archives with many builds of the runtime, and fails unless all of them give the same bits:
# gcc -O0, -O2, -O3 and clang, each with every instruction set of this processor, 1 to 8 threads and a host that rounds
# up; Windows under Wine, AArch64 under QEMU, WebAssembly under node, these from the archives on. Reports what is skipped
# because it is not installed.
#   tests/determinism/compare_machines.sh BUILD_DIR [ARCHIVE...]
# BUILD_DIR is a built tree of the project; without archives its fixture is used.
#   --install first (Debian): installs the compilers and emulators, about 2.6 GB
set -eu
if [ "${1:-}" = "--install" ]; then
  shift
  apt-get -q install -y --no-install-recommends clang libomp-dev g++-aarch64-linux-gnu qemu-user-static emscripten \
    g++-mingw-w64-x86-64-posix wine64
fi
here=$(cd "$(dirname "$0")" && pwd)
build=$(cd "$1" && pwd)
shift
[ $# -gt 0 ] || set -- "$build/fixtures/tiny.fbk"
export OMP_WAIT_POLICY=PASSIVE NODE_PATH=/usr/share/nodejs PATH="$PATH:/usr/lib/wine"
platforms=$(cd "$here/../../capi/platforms" && pwd)
poses=${FB_POSES:-50}

work=$build/determinism
export WINEPREFIX="$work/wine" WINEDEBUG=-all
mkdir -p "$work/xxhash"
for header in /usr/include/xxhash.h /usr/include/xxh3.h; do
  [ ! -e "$header" ] || cp "$header" "$work/xxhash"
done
dumps="" archives=$* number=0
for archive in "$@"; do
  number=$((number + 1))
  dump=$work/$number-$(basename "$archive").dump # those of several folders may have one name
  "$build/bin/dump_model" "$archive" "$poses" "$dump"
  dumps="$dumps $dump"
done

expected=""
# pose NAME RUNNER PROGRAM
pose() {
  # shellcheck disable=SC2086
  found=$($2 "$3" $dumps) || { echo "$1: $found"; exit 1; }
  found=$(echo "$found" | tr -d '\r')
  printf '%-24s %s\n' "$1" "$(echo "$found" | tr '\n' ' ')"
  [ -n "$expected" ] || expected=$found
  [ "$found" = "$expected" ] || { echo "$1 gives other bits"; exit 1; }
}
# with NAME RUNNER PROGRAM CMAKE_COMMAND CMAKE_OPTION...: builds hash_poses in its own folder, and poses with it
with() {
  name=$1 runner=$2 program=$3
  shift 3
  "$@" -S "$here" -B "$work/$name" -DFB_XXHASH="$work/xxhash" >"$work/$name.log" 2>&1 &&
    cmake --build "$work/$name" --target hash_poses >>"$work/$name.log" 2>&1 ||
    { echo "$name: does not build, see $work/$name.log"; exit 1; }
  pose "$name" "$runner" "$work/$name/$program"
}
# whole NAME RUNNER SUFFIX TARGET CMAKE_OPTION...: the same with the whole runtime for a target of capi/platforms; then
# poses from the archives on
whole() {
  name=$1 runner=$2 suffix=$3 target=$4
  shift 4
  "$platforms/build_dependencies.sh" "$target" >"$work/$name.log" 2>&1 ||
    { echo "$name: its libraries do not build, see $work/$name.log"; exit 1; }
  with "$name" "$runner" "hash_poses$suffix" cmake -DCMAKE_TOOLCHAIN_FILE="$platforms/$target.cmake" \
    -DCMAKE_BUILD_TYPE=Release -DFB_WHOLE=ON "$@"
  cmake --build "$work/$name" --target hash_archive >>"$work/$name.log" 2>&1 ||
    { echo "$name: does not build, see $work/$name.log"; exit 1; }
  from_archives "$name" "$runner" "$work/$name/hash_archive$suffix"
}
# from_archives NAME RUNNER PROGRAM
from_archives() {
  # shellcheck disable=SC2086
  found=$($2 "$3" "$poses" $archives) || { echo "$1, from the archives: $found"; exit 1; }
  found=$(echo "$found" | tr -d '\r')
  printf '%-24s %s\n' "" "from the archives"
  [ "$found" = "$expected" ] || { echo "$1, from the archives, gives other bits: $found"; exit 1; }
}
# has NAME COMMAND...
has() {
  name=$1
  shift
  for command in "$@"; do
    command -v "$command" >/dev/null || { echo "$name: skipped, $command is not installed"; return 1; }
  done
}

pose "build tree" "" "$build/bin/hash_poses"
from_archives "build tree" "" "$build/bin/hash_archive"
for level in 0 2 3; do
  with "gcc-O$level" "" hash_poses cmake -DCMAKE_CXX_COMPILER=g++ -DCMAKE_CXX_FLAGS="-O$level"
done
! has clang clang++ || with clang "" hash_poses cmake -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_CXX_FLAGS=-O2
! has windows x86_64-w64-mingw32-g++-posix wine64 ||
  whole windows wine64 .exe windows-x64 -DFB_OPENMP=OFF
! has aarch64 aarch64-linux-gnu-g++ qemu-aarch64-static ||
  whole aarch64 "qemu-aarch64-static -cpu max -L /usr/aarch64-linux-gnu" "" aarch64
# Node has a fetch, which older Emscriptens take for a browser's.
! has wasm em++ node ||
  whole wasm "node --no-experimental-fetch" .js wasm -DFB_OPENMP=OFF -DCMAKE_C_FLAGS=-fwasm-exceptions \
    -DCMAKE_CXX_FLAGS="-fwasm-exceptions -msimd128"
echo "all the same"
